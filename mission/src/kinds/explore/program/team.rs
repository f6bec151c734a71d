//! Building the program: what concerns several members, that is distances among robots, connections, and targets.

use super::super::objective::{gain, reserve};
use super::super::polygon::dot;
use super::builder::{Builder, pairs};
use super::rows::{Place, Side};
use super::{Binary, Blocked, Group, ROUNDING, TOLERANCE};

impl Builder<'_> {
    /// (10h) among robots.
    pub(super) fn robots(&mut self) -> Result<(), Blocked> {
        if !self.has(Group::Robots) {
            return Ok(());
        }
        for (i, j) in pairs(self.problem.robots.len()) {
            if !self.present.active[i] && !self.present.active[j] {
                continue;
            }
            let (one, other) = (&self.problem.robots[i], &self.problem.robots[j]);
            let set = other.body.sum(&one.body.reflected());
            for step in 0..self.periods {
                let sides = set.faces().iter().map(|face| {
                    let side = |(a, b): (&Place, &Place)| Side::between(a, b, face, TOLERANCE);
                    self.of_both(i, j, step, side)
                });
                let sides = sides.collect();
                let binary = |side: usize| Binary::Robots([i, j, step, side]);
                self.pass(sides, binary).map_err(|()| Group::Robots)?;
            }
        }
        Ok(())
    }

    /// The rows of the difference of two motions in a period.
    pub(super) fn of_both(&self, i: usize, j: usize, step: usize, row: impl Fn((&Place, &Place)) -> Side) -> Vec<Side> {
        let rows = |first: usize| self.both(i, j, step, first).into_iter().map(&row).collect::<Vec<Side>>();
        if step > 0 {
            return rows(0);
        }
        // The difference of two motions with constant accelerations is one too.
        match <[Side; 3]>::try_from(rows(0)) {
            Ok(three) if self.present.active[i] && self.present.active[j] => self.first(i, three),
            _ => rows(1),
        }
    }

    /// Pairs of places whose differences bound the difference of both motions in a period.
    pub(super) fn both(&self, i: usize, j: usize, step: usize, first: usize) -> Vec<(&Place, &Place)> {
        let (a, b) = (&self.places[i][step], &self.places[j][step]);
        let alike = self.problem.robots[i].dynamics == self.problem.robots[j].dynamics
            || !self.present.active[i]
            || !self.present.active[j];
        match alike {
            // The difference of two motions of the same dynamics is a motion of them.
            true => (first..3).map(|place| (&a[place], &b[place])).collect(),
            false => (0..9).map(|k| (&a[k / 3], &b[k % 3])).skip(first).collect(),
        }
    }

    /// (10k) to (10n) with (14).
    pub(super) fn connection(&mut self) -> Result<(), Blocked> {
        if !self.has(Group::Connection) {
            return Ok(());
        }
        let problem = self.problem;
        let count = problem.robots.len();
        let active: Vec<usize> = (0..count).filter(|robot| self.present.active[*robot]).collect();
        let strides = problem.strides(problem.period);
        for step in 0..self.periods {
            let mut links: Vec<((usize, usize), usize)> = Vec::new();
            for (i, j) in pairs(count) {
                if !active.contains(&i) || !active.contains(&j) {
                    continue;
                }
                let rows: Vec<Side> = problem
                    .connection
                    .faces()
                    .iter()
                    .flat_map(|face| {
                        let row = |(a, b): (&Place, &Place)| Side::within(a, b, face, TOLERANCE);
                        self.of_both(i, j, step, row)
                    })
                    .collect();
                if let Some(link) = self.link(rows, Binary::Link([i, j, step])) {
                    links.push(((i, j), link));
                }
            }
            // (10m): degrees of each pair of robots.
            for (i, j) in pairs(active.len()) {
                let pair = [active[i], active[j]];
                let terms = pair.iter().flat_map(|robot| {
                    let own = links.iter().filter(move |((a, b), _)| a == robot || b == robot);
                    own.map(|(_, link)| (*link, 1.0))
                });
                let terms: Vec<(usize, f64)> = terms.collect();
                if terms.is_empty() {
                    return Err(Group::Connection);
                }
                self.model.at_least(active.len() as f64, terms);
            }
            // (10n): somebody is connected to the person.
            let from = self.foresight.positions[step];
            let mut any = Vec::new();
            for &robot in &active {
                let ahead = problem.robots[robot].over(problem.period).middle / problem.period;
                let places = self.places[robot][step].clone();
                let short = (step == 0).then(|| self.shortfall());
                let rows: Vec<Side> = problem
                    .connection
                    .faces()
                    .iter()
                    .flat_map(|face| {
                        let stride = strides.iter().map(|s| dot(face.normal, *s)).fold(0.0, f64::max);
                        let less = [0.0, ahead * stride, stride];
                        let side = |k: usize| {
                            let most = face.bound - less[k] + dot(face.normal, from);
                            Side::of(&places[k], &face.opposite(), -most + TOLERANCE)
                        };
                        match short {
                            None => (0..3).map(side).collect(),
                            Some(short) => {
                                let mut rows = self.first(robot, [side(0), side(1), side(2)]);
                                rows.push(side(2).with_reserve(short, reserve(problem)));
                                rows
                            }
                        }
                    })
                    .collect();
                any.extend(self.link(rows, Binary::Link([robot, count, step])).map(|link| (link, 1.0)));
            }
            if active.is_empty() {
                continue;
            }
            if any.is_empty() {
                return Err(Group::Connection);
            }
            self.model.at_least(1.0, any);
        }
        Ok(())
    }

    /// A binary that implies these rows; none if they cannot hold.
    pub(super) fn link(&mut self, rows: Vec<Side>, binary: Binary) -> Option<usize> {
        if rows.iter().any(|row| row.most < row.bound - ROUNDING) {
            return None;
        }
        let z = self.model.binary(0.0);
        self.binaries.push((binary, z));
        self.rows.push(rows.clone());
        for row in rows.iter().filter(|row| row.least < row.bound) {
            let m = row.bound - row.least;
            self.model.at_least(row.bound - m, row.along.iter().copied().chain([(z, -m)]));
        }
        Some(z)
    }

    /// (10i), (10j) and the reward of (10a).
    pub(super) fn targets(&mut self) {
        let taken = |target: usize| self.foresight.visits.iter().any(|(of, _)| *of == target);
        for (target, of) in self.problem.targets.iter().enumerate() {
            if !self.present.open[target] || taken(target) {
                continue;
            }
            let mut once = Vec::new();
            for robot in 0..self.problem.robots.len() {
                if !self.present.active[robot] {
                    continue;
                }
                for step in 1..=self.periods {
                    let place = self.places[robot][step - 1][2].clone();
                    let rows: Vec<Side> = of
                        .shape
                        .faces()
                        .iter()
                        .map(|face| Side::of(&place, &face.opposite(), -face.bound + TOLERANCE))
                        .collect();
                    if let Some(z) = self.link(rows, Binary::Visit([robot, target, step])) {
                        self.model.columns[z].cost = -gain(of, step);
                        once.push((z, 1.0));
                    }
                }
            }
            if once.len() > 1 {
                self.model.at_most(once, 1.0);
            }
        }
    }
}
