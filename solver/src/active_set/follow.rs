//! Warm start: follows the optimum of the last tick to that of this one along a straight line of problems.
//!
//! With the matrices of this tick, the working set, the point and the multipliers of the last tick are the optimum of a
//! problem that differs from this one only in its right-hand sides: bounds at the values of the rows, targets and
//! forces that balance the multipliers. While these numbers move to those of this tick, the point and all multipliers
//! move linearly to the values that the working set has for this tick (`Relaxed::complete`). The first multiplier that
//! reaches zero on the line leaves the working set, the first row that reaches its bound enters it, and the motion
//! continues towards the values of the new working set. The number of changes is therefore about the number of rows
//! that differ between the two ticks, however far apart these are: the idea of qpOASES (Ferreau, Bock and Diehl 2008),
//! here over all levels at once.
//!
//! A row that depends on the rows held at a stage replaces one of them or moves up with them, as in [`super::search`];
//! its force is zero when it enters. Rows whose multiplier is zero at the end are settled by the dual method, which
//! also takes over if many rows enter and leave at one point of the line.

use super::kernels::{dot, norm};
use super::rows::tolerance;
use super::search::{Search, Stopped};
use super::working_set::Entry;
use crate::feasible_set::Kind;
use crate::problem::Problem;
use crate::structure::Structure;

/// Maximum number of wrong signs and violated rows, in addition to a third of the working set, for which the last tick
/// is used as a start.
const FAR: usize = 3;

/// After this many changes, or a third of the working set if that is more, the changes of the whole line are
/// extrapolated: if they would exceed [`WHOLE`], or 1.5 times the working set if that is more, following is given up.
const TRIAL: f64 = 9.0;
const WHOLE: f64 = 40.0;

/// Maximum number of entries of one row along the line: more are a cycle.
const ENTRIES: u8 = 3;

/// Two events closer than this, relative to the rest of the line, happen at the same point.
const AT_ONCE: f64 = 1e-12;

/// The next change of the working set along the line.
enum Event {
    /// A multiplier reaches zero: stage, true for a violated row of its level, index in the list.
    Leaves(usize, bool, usize),
    /// A row reaches its bound.
    Enters(Entry),
}

impl Search {
    /// Moves from the current point and multipliers, those of the last tick, to those of this tick. The frame must be
    /// complete, with trial multipliers. Returns false if it was given up on the way.
    pub(super) fn follow(&mut self, problem: &Problem) -> Result<bool, Stopped> {
        let count = self.relaxed.working_set.count();
        if self.locate(problem) + self.wrong() > FAR + count / 3 {
            return Ok(false);
        }
        let (trial, whole) = (TRIAL.max(count as f64 / 3.0), WHOLE.max(1.5 * count as f64));
        let from = self.budget;
        // Fraction of the line that is left.
        let mut rest = 1.0;
        loop {
            if self.budget < from && self.is_late() {
                // The current point is the optimum of a problem on the line: the next tick continues from there.
                self.known = self.relaxed.levels;
                return Err(Stopped::Late);
            }
            let Some((part, event)) = self.next_event(problem) else {
                self.relaxed.accept(0);
                let Some((stage, keep)) = self.first_idle() else { return Ok(true) };
                // A row that no longer holds its stage back may hold the next one back: the line continues with its
                // force there.
                self.count()?;
                self.approach(1.0);
                rest = 0.0;
                self.relaxed.rewind(stage, keep);
                self.relaxed.complete(problem);
                continue;
            };
            let spent = (from - self.budget) as f64;
            if spent > trial && spent > whole * (1.0 - rest) {
                return Ok(false);
            }
            rest *= 1.0 - part;
            self.count()?;
            self.go_part(0, part);
            self.approach(part);
            match event {
                Event::Leaves(stage, true, j) => {
                    let gone = self.relaxed.working_set.own[stage].remove(j);
                    let at = self.relaxed.rows.at(gone.level, gone.row);
                    self.relaxed.rows.side[at] = 0;
                    let active = self.relaxed.working_set.active[stage].len();
                    self.relaxed.rewind(stage, active);
                }
                Event::Leaves(stage, false, j) => self.relaxed.release(stage, j),
                Event::Enters(entry) => {
                    let at = self.relaxed.rows.at(entry.level, entry.row);
                    self.adds[at] += 1;
                    if self.adds[at] > ENTRIES {
                        return Ok(false);
                    }
                    self.enter(problem, entry)?;
                }
            }
            self.relaxed.complete(problem);
        }
    }

    /// Returns the number of multipliers of the wrong sign at the frame's point.
    fn wrong(&self) -> usize {
        let stages = &self.relaxed.working_set;
        stages.own.iter().chain(&stages.active).flatten().filter(|e| e.trial < -e.noise).count()
    }

    /// Computes the values of all rows at the current point. Returns the number of violated rows outside the working
    /// set.
    fn locate(&mut self, problem: &Problem) -> usize {
        let stride = self.relaxed.stride.max(1);
        let far = norm(&self.point);
        let mut violated = 0;
        for (l, level) in problem.levels.iter().enumerate().take(self.relaxed.levels) {
            let first = self.relaxed.rows.first[l];
            let rows = level.padded().chunks_exact(stride).zip(level.structure());
            for (i, (row, structure)) in rows.enumerate() {
                let (at, read) = (first + i, &self.relaxed.rows);
                let value = match *structure {
                    Structure::Bound { column, coefficient } => coefficient * self.point[column],
                    Structure::Absent => 0.0,
                    Structure::Open | Structure::Constant { .. } => dot(row, &self.point),
                };
                self.past[at] = value;
                let (lower, upper) = (level.lower[i], level.upper[i]);
                let (beyond, bound) = if value > upper { (value - upper, upper) } else { (lower - value, lower) };
                violated += usize::from(
                    read.kind[at] == Kind::Inequality
                        && read.side[at] == 0
                        && beyond / read.norm[at] > tolerance(bound / read.norm[at], far),
                );
            }
        }
        violated
    }

    /// Moves the current point, and the values of the rows there, by the fraction `part` towards the frame's point.
    fn approach(&mut self, part: f64) {
        if part == 0.0 {
            return;
        }
        for (x, end) in self.point.iter_mut().zip(&self.relaxed.frame.x) {
            *x += part * (end - *x);
        }
        for (past, end) in self.past.iter_mut().zip(&self.relaxed.rows.value) {
            *past += part * (end - *past);
        }
    }

    /// Returns the first event on the way to the frame's point, and the fraction of the way at which it happens. None
    /// if there is no event.
    fn next_event(&mut self, problem: &Problem) -> Option<(f64, Event)> {
        let leaves = self.first_to_leave(0, None).map(|(s, own, j, part)| (part, Event::Leaves(s, own, j)));
        let (mut part, mut excess, mut enters) = (leaves.as_ref().map_or(1.0, |l| l.0), 0.0, None);
        let Search { relaxed, past, .. } = self;
        let (x, rows) = (&relaxed.frame.x, &mut relaxed.rows);
        let far = norm(x);
        for (l, level) in problem.levels.iter().enumerate().take(relaxed.levels) {
            let first = rows.first[l];
            let numbers = level.padded().chunks_exact(relaxed.stride.max(1)).zip(level.structure());
            for (i, (row, structure)) in numbers.enumerate() {
                let at = first + i;
                let value = match *structure {
                    Structure::Bound { column, coefficient } => coefficient * x[column],
                    Structure::Absent => continue,
                    Structure::Open | Structure::Constant { .. } => dot(row, x),
                };
                rows.value[at] = value;
                if rows.side[at] != 0 || rows.kind[at] != Kind::Inequality {
                    continue;
                }
                let (lower, upper, size) = (level.lower[i], level.upper[i], rows.norm[at]);
                let (side, bound) = if value > upper { (1.0, upper) } else { (-1.0, lower) };
                let beyond = side * (value - bound) / size;
                if beyond <= tolerance(bound / size, far) {
                    continue;
                }
                let room = (side * (bound - past[at]) / size).max(0.0);
                let reached = room / (room + beyond);
                if reached < part - AT_ONCE || (reached <= part + AT_ONCE && beyond > excess) {
                    (part, excess, enters) = (reached.min(part), beyond, Some(Entry::new(l, i, side)));
                }
            }
        }
        enters.map(|e| (part, Event::Enters(e))).or(leaves)
    }

    /// Adds a row to the working set at its bound, with zero force.
    fn enter(&mut self, problem: &Problem, mut entry: Entry) -> Result<(), Stopped> {
        let at = self.relaxed.rows.at(entry.level, entry.row);
        self.relaxed.rows.side[at] = if entry.side > 0.0 { 1 } else { -1 };
        let mut s = self.relaxed.levels;
        loop {
            if s == entry.level {
                let active = self.relaxed.working_set.active[s].len();
                self.relaxed.rewind(s, active);
                self.relaxed.working_set.own[s].push(entry);
                return Ok(());
            }
            match self.hold(problem, s, &mut entry) {
                None => return Ok(()),
                Some(next) => s = next,
            }
            self.count()?;
        }
    }
}
