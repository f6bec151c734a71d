//! Rows that enter the working set: the violated row to add next, and its path up the stages as its force grows, see
//! the documentation of the module.

use super::kernels::{dot, norm};
use super::rows::{Rows, tolerance};
use super::search::{Rule, Search, Stopped};
use super::working_set::Entry;
use crate::feasible_set::Kind;
use crate::problem::Problem;
use crate::structure::Structure;

/// Maximum number of times that a row is added in one solve: more are a cycle.
const ADDS: u8 = 60;

/// A coefficient in the combination of active rows below this counts as zero.
const COMBINED: f64 = 1e-9;

/// If the remainder of a row of norm one is below this, active rows give way to it before the point moves.
const NEAR: f64 = 1e-6;

/// The worst row seen so far.
struct Worst {
    /// Keep the first row, even if others are worse.
    first: bool,
    /// Norm of the point.
    far: f64,
    excess: f64,
    found: Option<Entry>,
    violated: usize,
}

impl Worst {
    #[inline(always)]
    fn look(&mut self, rows: &Rows, l: usize, i: usize, value: f64, lower: f64, upper: f64) {
        let at = rows.first[l] + i;
        let beyond = (value - upper).max(lower - value);
        if beyond > 0.0 && rows.side[at] == 0 && rows.kind[at] == Kind::Inequality {
            let size = rows.norm[at];
            let (side, bound) = if value > upper { (1.0, upper) } else { (-1.0, lower) };
            let excess = beyond / size - tolerance(bound / size, self.far);
            self.violated += usize::from(excess > 0.0);
            if excess > self.excess && !(self.first && self.found.is_some()) {
                self.excess = excess;
                self.found = Some(Entry::new(l, i, side));
            }
        }
    }
}

impl Search {
    /// Returns the row outside the working set to add next, by the rule; none at the optimum. The values of all rows
    /// that it evaluates are stored in `rows.value`; bounds of one variable are skipped while the point is within all
    /// of them.
    pub(super) fn next_violated(&mut self, problem: &Problem) -> Option<Entry> {
        let x = &self.relaxed.frame.x;
        let stride = self.relaxed.stride;
        let mut worst = Worst { first: self.rule == Rule::First, far: norm(x), excess: 0.0, found: None, violated: 0 };
        for (l, level) in problem.levels.iter().enumerate().take(self.relaxed.levels) {
            let first = self.relaxed.rows.first[l];
            let rows = level.padded().chunks_exact(stride.max(1)).zip(level.lower.iter().zip(&level.upper));
            if level.is_open() {
                for (i, (row, (&lower, &upper))) in rows.enumerate() {
                    let value = dot(row, x);
                    self.relaxed.rows.value[first + i] = value;
                    worst.look(&self.relaxed.rows, l, i, value, lower, upper);
                }
            } else {
                let within = self.relaxed.rows.within(l, x);
                for ((i, (row, (&lower, &upper))), structure) in rows.enumerate().zip(level.structure()) {
                    let value = match *structure {
                        Structure::Bound { .. } if within => continue,
                        Structure::Bound { column, coefficient } => coefficient * x[column],
                        Structure::Absent => continue,
                        Structure::Open | Structure::Constant { .. } => dot(row, x),
                    };
                    self.relaxed.rows.value[first + i] = value;
                    worst.look(&self.relaxed.rows, l, i, value, lower, upper);
                }
            }
            if self.rule != Rule::Worst && worst.found.is_some() {
                break;
            }
        }
        self.violated = worst.violated;
        worst.found
    }

    /// Adds a violated row; see the documentation of the module.
    pub(super) fn add(&mut self, problem: &Problem, mut entry: Entry) -> Result<(), Stopped> {
        let at = self.relaxed.rows.at(entry.level, entry.row);
        self.relaxed.rows.side[at] = if entry.side > 0.0 { 1 } else { -1 };
        self.adds[at] = self.adds[at].saturating_add(1);
        if self.adds[at] > ADDS {
            return Err(Stopped::Circle);
        }
        let mut s = self.relaxed.levels;
        loop {
            self.count()?;
            let own = s == entry.level;
            let active = self.relaxed.working_set.active[s].len();
            if own {
                self.relaxed.rewind(s, active);
                self.relaxed.working_set.own[s].push(entry);
            } else if let Some(next) = self.hold(problem, s, &mut entry) {
                s = next;
                continue;
            }
            self.relaxed.complete(problem);
            let list = if own { &self.relaxed.working_set.own[s] } else { &self.relaxed.working_set.active[s] };
            if list.last().is_some_and(|e| e.trial < -e.noise) {
                // The multiplier of an added row rises. If it falls, the working set is so nearly dependent that
                // rounding dominates. Another order avoids it.
                return Err(Stopped::Circle);
            }
            let Some((stage, is_own, j, part)) = self.first_to_leave(s, Some(own)) else {
                self.relaxed.accept(s);
                return Ok(());
            };
            self.go_part(s, part);
            let list = if own { &mut self.relaxed.working_set.own[s] } else { &mut self.relaxed.working_set.active[s] };
            entry = list.pop().unwrap_or(entry);
            self.relaxed.rewind(s, self.relaxed.working_set.active[s].len());
            if is_own {
                let gone = self.relaxed.working_set.own[stage].remove(j);
                let at = self.relaxed.rows.at(gone.level, gone.row);
                self.relaxed.rows.side[at] = 0;
            } else {
                self.relaxed.release(stage, j);
            }
        }
    }

    /// Adds a row to those held at stage `s`, and to the frame. If it depends on them, one of them gives way to it, or
    /// those that it presses against move to the stage above; the stage to try next is then returned.
    pub(super) fn hold(&mut self, problem: &Problem, s: usize, entry: &mut Entry) -> Option<usize> {
        let active = self.relaxed.working_set.active[s].len();
        self.relaxed.rewind(s, active);
        self.relaxed.advance(problem, s);
        let room = self.relaxed.outward(problem, entry);
        let left = self.relaxed.project();
        let leaving = if left < NEAR { self.combine(s) } else { None };
        if left == 0.0 || leaving.is_some() {
            return Some(self.oppose(s, leaving, entry));
        }
        self.relaxed.fix(left, room);
        self.relaxed.working_set.active[s].push(*entry);
        None
    }

    /// Computes the combination of the rows held at stage `s` that the last projection removed from a row at that
    /// stage, into `combination`. Returns the active row whose multiplier reaches zero first if a growing force pushes
    /// the row back.
    fn combine(&mut self, s: usize) -> Option<usize> {
        let (n, from) = (self.relaxed.n, self.relaxed.mark[s]);
        let active = &self.relaxed.working_set.active[s];
        let w = active.len();
        let mut least = f64::INFINITY;
        let mut leaving = None;
        for j in (0..w).rev() {
            let mut sum = self.relaxed.frame.coefficient[from + j];
            for i in j + 1..w {
                sum -= self.relaxed.lower[(from + i) * n + from + j] * self.combination[i];
            }
            let c = sum / self.relaxed.lower[(from + j) * n + from + j];
            self.combination[j] = c;
            if c > COMBINED && active[j].value.max(0.0) / c < least {
                least = active[j].value.max(0.0) / c;
                leaving = Some(j);
            }
        }
        leaving
    }

    /// Handles a row that is to join the rows held at stage `s` but depends on them, by `combination`. Either `leaving`
    /// gives way to it, or the active rows that it presses against move with it to the stage above. Returns the stage to
    /// try next.
    fn oppose(&mut self, s: usize, leaving: Option<usize>, entry: &mut Entry) -> usize {
        let active = &mut self.relaxed.working_set.active[s];
        let w = active.len();
        if let Some(leaving) = leaving {
            let least = active[leaving].value.max(0.0) / self.combination[leaving];
            for (e, c) in active.iter_mut().zip(&self.combination) {
                e.value -= least * c;
            }
            entry.value += least;
            self.relaxed.release(s, leaving);
            return s;
        }
        let above = s - 1;
        let kept = self.relaxed.working_set.active[above].len();
        for j in (0..w).rev() {
            if self.combination[j] < -COMBINED {
                let mut e = self.relaxed.working_set.active[s].remove(j);
                e.value = 0.0;
                if e.level == above {
                    self.relaxed.working_set.own[above].push(e);
                } else {
                    self.relaxed.working_set.active[above].push(e);
                }
            }
        }
        entry.value = 0.0;
        self.relaxed.rewind(above, kept);
        above
    }
}
