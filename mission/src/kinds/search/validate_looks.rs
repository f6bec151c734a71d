//! The validator's own account of hidden objects: cells, lines of sight and beliefs straight from the definitions of srs section 5,
//! cell by cell. It shares only data with the planner.

use std::collections::BTreeMap;

use super::geometry::{Point, edges, inside, segments};
use super::problem::{Detection, Problem};
use super::validate_map::hides;

/// Row and column of a cell.
type Key = (i64, i64);

/// Difference of two distances below which they are the same (m).
const TIE: f64 = 1e-6;

/// Positions from which an agent sees in an interval, step by step, with the times (s) of each step.
pub(super) type Steps = Vec<(Point, [f64; 2])>;

/// The ground as seen, with what is expected to be undetected.
pub(super) struct Looks<'p> {
    problem: &'p Problem,
    cells: BTreeMap<Key, Point>,
    /// Expected worth of what is hidden in each cell.
    left: BTreeMap<Key, f64>,
    /// Cells in sight of a cell, with their distances (m).
    known: BTreeMap<Key, Vec<(Key, f64)>>,
    low: Point,
}

impl<'p> Looks<'p> {
    pub fn new(problem: &'p Problem) -> Looks<'p> {
        let least = |axis: usize| problem.area.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min);
        let most = |axis: usize| problem.area.iter().map(|p| p[axis]).fold(f64::NEG_INFINITY, f64::max);
        let low = [least(0), least(1)];
        let count = [0, 1].map(|axis| ((most(axis) - low[axis]) / problem.cell - 1e-9).ceil().max(1.0) as i64);
        let mut cells = BTreeMap::new();
        // Rows come first, as exposures are given.
        for key in (0..count[1]).flat_map(|row| (0..count[0]).map(move |column| (row, column))) {
            let at = [low[0] + (key.1 as f64 + 0.5) * problem.cell, low[1] + (key.0 as f64 + 0.5) * problem.cell];
            let walled = problem.walls.iter().any(|wall| wall.solid && inside(at, &wall.points));
            let blocked = problem.occupancy.as_ref().is_some_and(|map| map.is_blocked(map.index(at)));
            if inside(at, &problem.area) && !walled && !blocked {
                cells.insert(key, at);
            }
        }
        let mut left: BTreeMap<Key, f64> = cells.keys().map(|key| (*key, 0.0)).collect();
        for object in problem.objects.iter().filter(|object| object.count > object.found) {
            // (26): the prior times the probability that nobody has detected the object there, divided by the sum over all places.
            let mut terms: Vec<(Key, f64)> = Vec::new();
            for (number, (key, at)) in cells.iter().enumerate() {
                if object.region.is_empty() || inside(*at, &object.region) {
                    terms.push((*key, (-problem.exposure.get(number).copied().unwrap_or_default()).exp()));
                }
            }
            let sum: f64 = terms.iter().map(|(_, term)| term).sum();
            for (key, term) in terms.into_iter().filter(|_| sum > 0.0) {
                *left.entry(key).or_default() += object.worth * (object.count - object.found) as f64 * term / sum;
            }
        }
        Looks { problem, cells, left, known: BTreeMap::new(), low }
    }

    fn is_clear(&self, a: Point, b: Point) -> bool {
        let hits = |[c, d]: [Point; 2]| segments(a, b, c, d) <= 0.0;
        let opaque = self.problem.walls.iter().filter(|wall| !wall.transparent);
        let mut walls = opaque.map(|wall| match wall.solid {
            true => edges(&wall.points).any(hits),
            false => wall.points.windows(2).any(|two| hits([two[0], two[1]])),
        });
        let map = self.problem.occupancy.as_ref();
        !edges(&self.problem.area).any(hits) && !walls.any(|hit| hit) && map.is_none_or(|map| !hides(map, a, b))
    }

    /// The cell from which an agent sees at a point.
    pub fn seat(&self, at: Point) -> Option<Key> {
        let index = |axis: usize| ((at[axis] - self.low[axis]) / self.problem.cell).floor() as i64;
        let (column, row) = (index(0), index(1));
        let mut best: Option<(f64, Key)> = None;
        for key in (row - 1..=row + 1).flat_map(|r| (column - 1..=column + 1).map(move |c| (r, c))) {
            let Some(middle) = self.cells.get(&key) else { continue };
            let far = f64::hypot(middle[0] - at[0], middle[1] - at[1]);
            // Of places that are as near the first one counts, whatever rounding says.
            if best.is_none_or(|(least, _)| far < least - TIE) && (far <= 1e-9 || self.is_clear(at, *middle)) {
                best = Some((far, key));
            }
        }
        best.map(|(_, key)| key)
    }

    /// Expected worth of what an agent detects who sees from a cell between two times (s).
    fn detect(&mut self, seat: Key, sees: Detection, [from, to]: [f64; 2]) -> f64 {
        if !self.known.contains_key(&seat) {
            let at = self.cells[&seat];
            let reach = self.problem.agents.iter().filter_map(|agent| agent.sees).map(|sees| sees.within);
            let reach = reach.fold(0.0, f64::max);
            let far = |p: &Point| f64::hypot(p[0] - at[0], p[1] - at[1]);
            let near = self.cells.iter().filter(|(key, middle)| **key == seat || far(middle) <= reach);
            let seen = near.filter(|(key, middle)| **key == seat || self.is_clear(at, **middle));
            let row = seen.map(|(key, middle)| (*key, far(middle))).collect();
            self.known.insert(seat, row);
        }
        let undetected = (-sees.rate * (to - from)).exp();
        let mut sum = 0.0;
        for (key, far) in &self.known[&seat] {
            if *far <= sees.within
                && let Some(left) = self.left.get_mut(key)
            {
                sum += *left * (1.0 - undetected);
                *left *= undetected;
            }
        }
        // The worth falls evenly from the begin of the mission to the horizon.
        sum * (1.0 - 0.5 * (from + to) / self.problem.horizon).clamp(0.0, 1.0)
    }

    /// Expected worth of what an agent detects in steps. Steps one after the other from the same cell are one.
    pub fn total(&mut self, sees: Detection, steps: &Steps) -> f64 {
        let mut joined: Vec<(Key, [f64; 2])> = Vec::new();
        for (at, [from, to]) in steps {
            let Some(seat) = self.seat(*at) else { continue };
            match joined.last_mut().filter(|(key, times)| *key == seat && (times[1] - from).abs() < 1e-9) {
                Some((_, times)) => times[1] = *to,
                None => joined.push((seat, [*from, *to])),
            }
        }
        joined.into_iter().map(|(seat, times)| self.detect(seat, sees, times)).sum()
    }
}
