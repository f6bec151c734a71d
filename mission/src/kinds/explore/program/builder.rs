//! Building the program: columns and limits of the robots, obstacles, and the person.

use super::super::foresight::Foresight;
use super::super::motion::Dynamics;
use super::super::objective::{RESERVE_COST, reserve};
use super::super::polygon::{Point, dot};
use super::super::problem::Problem;
use super::reach::{Reach, reach};
use super::rows::{Place, Side};
use super::{Binary, Blocked, Columns, Group, Present, ROUNDING, TOLERANCE, free};
use crate::engine::Model;

pub(super) struct Builder<'p> {
    pub problem: &'p Problem,
    pub present: &'p Present,
    pub foresight: &'p Foresight,
    pub without: Option<Group>,
    pub model: Model,
    pub binaries: Vec<(Binary, usize)>,
    pub rows: Vec<Vec<Side>>,
    pub columns: Vec<Columns>,
    /// Positions that bound the motion in each period, by robot: its begin, its third point, its end.
    pub places: Vec<Vec<[Place; 3]>>,
    pub periods: usize,
}
impl Builder<'_> {
    pub(super) fn has(&self, group: Group) -> bool {
        self.without != Some(group)
    }

    /// Columns, dynamics (10c) to (10e), limits (10f), (10g) and effort of a robot.
    pub(super) fn robot(&mut self, robot: usize) -> Result<(), Blocked> {
        let who = &self.problem.robots[robot];
        let now = self.present.states[robot];
        let d = who.over(self.problem.period);
        let region = match self.has(Group::Limits) {
            true => self.problem.area.difference(&who.body).ok_or(Group::Limits)?,
            false => self.problem.area.sum(&self.problem.area.reflected()),
        };
        let [floor, ceiling] = region.bounds();
        let (moves, most) = (self.present.active[robot], who.most_input());
        let mut columns = Columns::default();
        let boxes = match moves {
            true => reach(who, now, self.problem.period, self.periods, [floor, ceiling]),
            false => vec![Reach::of(now); self.periods + 1],
        };
        for (step, reach) in boxes.iter().enumerate() {
            let pair = |model: &mut Model, low: Point, high: Point| [0, 1].map(|i| model.real(0.0, low[i], high[i]));
            columns.at.push(pair(&mut self.model, reach.low, reach.high));
            // A plan ends with robots that stand; a lost one stands now.
            let last = step == self.periods && step > 0;
            let (slow, fast) = if last { ([0.0; 2], [0.0; 2]) } else { (reach.slow, reach.fast) };
            columns.velocity.push(pair(&mut self.model, slow, fast));
        }
        for step in 0..self.periods {
            let limit = if moves { most } else { 0.0 };
            let effort = self.problem.effort;
            let input = [0, 1].map(|_| self.model.real(0.0, -limit, limit));
            for (axis, u) in input.into_iter().enumerate() {
                let (y, v) = (columns.at[step][axis], columns.velocity[step][axis]);
                let (y1, v1) = (columns.at[step + 1][axis], columns.velocity[step + 1][axis]);
                let model = &mut self.model;
                if moves {
                    model.row(0.0, [(y1, -1.0), (y, 1.0), (v, d.position_velocity), (u, d.position_input)], 0.0);
                    model.row(0.0, [(v1, -1.0), (v, d.velocity_velocity), (u, d.velocity_input)], 0.0);
                    // The 1-norm of the input.
                    let size = model.real(effort, 0.0, limit);
                    model.at_least(0.0, [(size, 1.0), (u, 1.0)]);
                    model.at_least(0.0, [(size, 1.0), (u, -1.0)]);
                    // The acceleration at the begin of the period, which is its greatest one.
                    let change = match who.dynamics {
                        Dynamics::Velocity => who.acceleration * self.problem.period,
                        Dynamics::Lag(constant) => who.acceleration * constant,
                        Dynamics::Acceleration => f64::INFINITY,
                    };
                    if change.is_finite() {
                        model.row(-change, [(u, 1.0), (v, -1.0)], change);
                    }
                }
            }
            columns.input.push(input);
        }
        let mut places = Vec::new();
        for step in 0..self.periods {
            let Reach { low, high, slow, fast } = boxes[step];
            let next = boxes[step + 1];
            let plain = |at: [usize; 2], low: Point, high: Point| Place { at, velocity: None, low, high };
            let third = Place {
                at: columns.at[step],
                velocity: (moves && d.middle > 0.0).then_some((columns.velocity[step], d.middle)),
                low: [0, 1].map(|i| f64::max(low[i] + d.middle * slow[i], floor[i].min(now.at[i]))),
                high: [0, 1].map(|i| f64::min(high[i] + d.middle * fast[i], ceiling[i].max(now.at[i]))),
            };
            places.push([plain(columns.at[step], low, high), third, plain(columns.at[step + 1], next.low, next.high)]);
        }
        if moves && self.has(Group::Limits) {
            for three in &places {
                for place in &three[1..] {
                    for face in region.faces() {
                        if place.most(face.normal) > face.bound {
                            let along = place.along(face.normal);
                            self.model.at_most(along, face.bound);
                        }
                    }
                }
            }
        }
        self.columns.push(columns);
        self.places.push(places);
        Ok(())
    }

    /// The rows of the three places of a motion in the first period, of which the first two are known: the end has to be far enough for
    /// the motion between them. A motion with a constant acceleration has the distances `b0 (1-s)^2 + 2 b1 s (1-s) + b2 s^2` from a line, which
    /// are not negative if `b1` is not, or else if `b2 >= b1^2 / b0`.
    pub(super) fn first(&self, robot: usize, [begin, third, mut end]: [Side; 3]) -> Vec<Side> {
        let quadratic = self.problem.robots[robot].dynamics == Dynamics::Acceleration;
        let (b0, b1) = (begin.least - begin.bound, third.least - third.bound);
        match b1 < 0.0 && quadratic && b0 > 0.0 {
            true => {
                end.bound += b1 * b1 / b0;
                vec![end]
            }
            // A robot that begins a little too near is not held to that for the begin.
            false => vec![third, end],
        }
    }

    /// A variable by which the reserve beyond a constraint may be less, and that costs.
    pub(super) fn shortfall(&mut self) -> usize {
        let reserve = reserve(self.problem);
        self.model.real(RESERVE_COST, 0.0, reserve)
    }

    /// One of the sides of a set is between it and all these places in a period. `sides` has, for each place, the bound of
    /// `normal . y` from below; a row is `along >= bound`.
    pub(super) fn pass(&mut self, sides: Vec<Vec<Side>>, binary: impl Fn(usize) -> Binary) -> Result<(), ()> {
        let is_clear = |side: &Vec<Side>| side.iter().all(|row| row.least >= row.bound - ROUNDING);
        if sides.iter().any(is_clear) {
            return Ok(());
        }
        let can = |side: &&(usize, Vec<Side>)| side.1.iter().all(|row| row.most >= row.bound - ROUNDING);
        let possible: Vec<(usize, Vec<Side>)> = sides.into_iter().enumerate().collect();
        let possible: Vec<&(usize, Vec<Side>)> = possible.iter().filter(can).collect();
        if let [(_, only)] = possible[..] {
            for row in only {
                self.model.at_least(row.bound, row.along.iter().copied());
            }
            return Ok(());
        }
        if possible.is_empty() {
            return Err(());
        }
        let mut one = Vec::new();
        for (index, rows) in possible {
            let z = self.model.binary(0.0);
            self.binaries.push((binary(*index), z));
            self.rows.push(rows.clone());
            one.push((z, 1.0));
            for row in rows.iter().filter(|row| row.least < row.bound) {
                // along >= bound - M (1 - z)
                let m = row.bound - row.least;
                let terms = row.along.iter().copied().chain([(z, -m)]);
                self.model.at_least(row.bound - m, terms);
            }
        }
        self.model.row(1.0, one, 1.0);
        Ok(())
    }

    /// (10h) with obstacles.
    pub(super) fn obstacles(&mut self) -> Result<(), Blocked> {
        if !self.has(Group::Obstacles) {
            return Ok(());
        }
        for robot in 0..self.problem.robots.len() {
            if !self.present.active[robot] {
                continue;
            }
            let parts = free(self.problem, robot);
            for step in 0..self.periods {
                let places = &self.places[robot][step];
                let sides = parts.iter().map(|part| {
                    let rows = part.faces().iter().flat_map(|face| {
                        let side = |k: usize| Side::of(&places[k], &face.opposite(), -face.bound + TOLERANCE);
                        match step {
                            0 => self.first(robot, [side(0), side(1), side(2)]),
                            _ => (0..3).map(side).collect(),
                        }
                    });
                    rows.collect()
                });
                let sides = sides.collect();
                let binary = |part: usize| Binary::Part([robot, step, part]);
                self.pass(sides, binary).map_err(|()| Group::Obstacles)?;
            }
        }
        Ok(())
    }

    /// (12): the safety region around the person.
    pub(super) fn person(&mut self) -> Result<(), Blocked> {
        if !self.has(Group::Person) {
            return Ok(());
        }
        let problem = self.problem;
        let strides = problem.strides(problem.period);
        for robot in 0..problem.robots.len() {
            if !self.present.active[robot] {
                continue;
            }
            let body = problem.robots[robot].body.reflected();
            let near = problem.person.body.sum(&body);
            let safe = near.sum_with_points(&strides);
            let ahead = problem.robots[robot].over(problem.period).middle / problem.period;
            for step in 0..self.periods {
                let from = self.foresight.positions[step];
                let places = self.places[robot][step].clone();
                let short = (step == 0).then(|| self.shortfall());
                let sides = safe.faces().iter().map(|face| {
                    let (own, whole) = (near.support(face.normal), face.bound);
                    // Until then the person can have walked this share of a stride.
                    let bounds: [f64; 3] = [own, own + ahead * (whole - own), whole];
                    let side = |k: usize| Side::of(&places[k], face, bounds[k] + dot(face.normal, from) + TOLERANCE);
                    match short {
                        None => (0..3).map(side).collect(),
                        Some(short) => {
                            let mut rows = self.first(robot, [side(0), side(1), side(2)]);
                            rows.push(side(2).with_reserve(short, reserve(problem)));
                            rows
                        }
                    }
                });
                let sides = sides.collect();
                let binary = |side: usize| Binary::Person([robot, step, side]);
                self.pass(sides, binary).map_err(|()| Group::Person)?;
            }
        }
        Ok(())
    }
}

/// The pairs of different numbers below `count`, the smaller one first.
pub(super) fn pairs(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(move |i| (i + 1..count).map(move |j| (i, j)))
}
