//! The dual active-set search over the whole hierarchy, described at the head of the module.
//!
//! Factorisations are kept: the frame holds the rows in the order of the stages, and a change at
//! a stage recomputes what comes after it only.

use super::kernels::{LANES, dot, norm};
use super::relaxed::Relaxed;
use super::rows::{Rows, tolerance};
use super::stages::Entry;
use crate::problem::Problem;
use crate::space::Kind;
use crate::structure::Structure;
use std::time::Instant;

/// How often a row may fall back to a lower stage in one solve, beyond once for each, before it stays where it is.
const RETURNS: usize = 8;

/// How often a row may be added in one solve: more is a circle.
const ADDS: u8 = 60;

/// With more changes than this to be expected, a solve starts from an empty working set.
const FEW: usize = 4;

/// A point that was this many times as far away as it is at the end is worked out anew, and no more than so often.
const LOST: f64 = 1e4;
const REPAIRS: usize = 3;

/// A coefficient in the combination of held rows below this is none.
const COMBINED: f64 = 1e-9;

/// What is left of a row of norm one below this is so little that held rows give way to it
/// before the point moves.
const NEAR: f64 = 1e-6;

/// Why a search ended without an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stopped {
    /// Too many changes.
    Circle,
    /// The deadline has passed.
    Late,
}

/// Which violated row is added first. Any order leads to the same optimum; where rounding leads
/// one in a circle, another does not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rule {
    /// The row that is violated most.
    Worst,
    /// The row that is violated most, of the highest level that has any.
    Level,
    /// The first row.
    First,
}

#[derive(Clone, Debug)]
pub(crate) struct Search {
    pub(crate) relaxed: Relaxed,
    /// Which violated row is added first.
    pub(crate) rule: Rule,
    /// Changes of the working set that are left before giving up.
    pub(crate) budget: usize,
    /// How often each row fell back, and how often it was added.
    returns: Vec<u8>,
    pub(super) adds: Vec<u8>,
    /// How many rows were seen violated at the last look.
    pub(super) violated: usize,
    /// How the row at hand combines the held ones.
    combination: Vec<f64>,
    /// The point at hand on the way from the last tick's optimum to this one's, and the values of all rows there.
    pub(super) point: Vec<f64>,
    pub(super) past: Vec<f64>,
    /// The number of levels whose optimum the point is; 0 if it is none.
    pub(super) known: usize,
    /// The number of levels that rows were being added to when the time was up; 0 if it was not.
    pub(super) adding: usize,
    /// When to give up.
    pub(super) until: Option<Instant>,
}

/// The worst row of those seen so far.
struct Worst {
    /// The first one is kept, however bad others are.
    first: bool,
    /// The size of the point.
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
    pub(crate) fn new(problem: &Problem) -> Self {
        let relaxed = Relaxed::new(problem);
        let total = relaxed.rows.norm.len();
        Search {
            relaxed,
            rule: Rule::Worst,
            budget: 0,
            returns: vec![0; total],
            adds: vec![0; total],
            violated: 0,
            combination: vec![0.0; problem.n + 1],
            point: vec![0.0; problem.n.div_ceil(LANES) * LANES],
            past: vec![0.0; total],
            known: 0,
            adding: 0,
            until: None,
        }
    }

    /// Begins a solve of the first `levels` levels from the working set at hand.
    pub(crate) fn begin(&mut self, problem: &Problem, levels: usize, rule: Rule) {
        self.relaxed.begin(problem, levels);
        self.returns.fill(0);
        self.adds.fill(0);
        self.rule = rule;
        self.budget = 400 + 40 * problem.n;
    }

    /// From the working set at hand to the optimum.
    ///
    /// # Errors
    /// When the budget of changes is spent, or the time.
    pub(crate) fn run(&mut self, problem: &Problem) -> Result<(), Stopped> {
        self.search(problem)?;
        // On the way the point may have been so far away that its digits are gone.
        for _ in 0..REPAIRS {
            if self.relaxed.frame.lost <= LOST * (1.0 + norm(&self.relaxed.frame.x)) {
                break;
            }
            self.relaxed.frame.lost = 0.0;
            self.relaxed.rewind(0, 0);
            self.relaxed.complete(problem);
            self.relaxed.accept(0);
            self.settle(problem)?;
            self.improve(problem)?;
        }
        Ok(())
    }

    /// The same; the point at the end may be inexact.
    fn search(&mut self, problem: &Problem) -> Result<(), Stopped> {
        let all = self.relaxed.levels;
        let (known, adding) = (std::mem::take(&mut self.known), std::mem::take(&mut self.adding));
        let mut reached = all;
        if self.rule == Rule::Worst && (1..=all).contains(&adding) {
            // The last tick had no time for more: this one goes on.
            reached = adding;
            self.relaxed.levels = adding;
            self.add_level(problem)?;
        } else if !self.start(problem, known == all && self.rule == Rule::Worst)? {
            self.relaxed.rewind(0, 0);
            self.relaxed.stages.clear(&mut self.relaxed.rows);
            reached = 0;
        }
        for l in reached + 1..=all {
            if l > 1 {
                self.relaxed.rewind(l - 1, 0);
                let (above, below) = self.relaxed.stages.held.split_at_mut(l);
                below[0].append(&mut above[l - 1]);
            }
            self.relaxed.levels = l;
            self.add_level(problem)?;
        }
        Ok(())
    }

    /// From the working set at hand to the optimum, if it is a start.
    fn start(&mut self, problem: &Problem, follows: bool) -> Result<bool, Stopped> {
        let before = self.relaxed.stages.count();
        self.relaxed.complete(problem);
        if follows {
            if self.first_to_leave(0, None).is_none() && self.next_violated(problem).is_none() {
                self.relaxed.accept(0);
                if !self.settle(problem)? {
                    return Ok(true);
                }
            } else if self.follow(problem)? {
                if self.settle(problem)? {
                    self.improve(problem)?;
                }
                return Ok(true);
            } else {
                self.adds.fill(0);
                return Ok(false);
            }
            self.adds.fill(0);
        }
        self.relaxed.accept(0);
        self.settle(problem)?;
        let Some(entry) = self.next_violated(problem) else { return Ok(true) };
        let changes = self.violated + before.saturating_sub(self.relaxed.stages.count());
        if self.rule == Rule::Worst && (before == 0 || changes > FEW) {
            return Ok(false);
        }
        self.add(problem, entry)?;
        self.settle(problem)?;
        self.improve(problem)?;
        Ok(true)
    }

    /// The optimum of the levels so far, the last of which is new.
    fn add_level(&mut self, problem: &Problem) -> Result<(), Stopped> {
        self.relaxed.complete(problem);
        self.relaxed.accept(0);
        self.settle(problem)?;
        self.improve(problem)
    }

    /// Counts a change.
    pub(super) fn count(&mut self) -> Result<(), Stopped> {
        self.budget = self.budget.checked_sub(1).ok_or(Stopped::Circle)?;
        Ok(())
    }

    /// Whether the time is up.
    pub(super) fn is_late(&self) -> bool {
        self.until.is_some_and(|until| Instant::now() >= until)
    }

    /// Adds violated rows until there is none, or no time; one is added at any rate.
    fn improve(&mut self, problem: &Problem) -> Result<(), Stopped> {
        let mut first = true;
        while let Some(entry) = self.next_violated(problem) {
            if !std::mem::take(&mut first) && self.is_late() {
                self.adding = self.relaxed.levels;
                return Err(Stopped::Late);
            }
            self.add(problem, entry)?;
            self.settle(problem)?;
        }
        Ok(())
    }

    /// Makes the working set fit to be the relaxed problem's: rows with a negative multiplier
    /// leave it, and those without a multiplier fall back to the stage below, where they may be
    /// needed.
    ///
    /// Returns whether anything changed.
    fn settle(&mut self, problem: &Problem) -> Result<bool, Stopped> {
        let mut changed = false;
        while let Some((s, keep)) = self.first_idle() {
            self.count()?;
            self.relaxed.rewind(s, keep);
            self.relaxed.complete(problem);
            self.relaxed.accept(s);
            changed = true;
        }
        Ok(changed)
    }

    /// Frees or lowers the idle rows of the first stage that has any; returns the stage and how
    /// many of its held rows come before the first of them.
    pub(super) fn first_idle(&mut self) -> Option<(usize, usize)> {
        for s in 0..=self.relaxed.levels {
            let mut keep = self.relaxed.stages.held[s].len();
            let mut changed = false;
            for j in (0..self.relaxed.stages.held[s].len()).rev() {
                let e = self.relaxed.stages.held[s][j];
                if e.value <= e.noise && self.retire(e, s) {
                    // A row that falls back stays in the working set.
                    let side = self.relaxed.rows.side[self.relaxed.rows.at(e.level, e.row)];
                    self.relaxed.release(s, j);
                    let at = self.relaxed.rows.at(e.level, e.row);
                    self.relaxed.rows.side[at] = side;
                    keep = if s < self.relaxed.levels { j } else { keep - 1 };
                    changed = true;
                }
            }
            if s < self.relaxed.levels {
                for j in (0..self.relaxed.stages.own[s].len()).rev() {
                    let e = self.relaxed.stages.own[s][j];
                    if e.value <= e.noise && self.retire(e, s) {
                        self.relaxed.stages.own[s].remove(j);
                        changed = true;
                        keep = keep.min(self.relaxed.stages.held[s].len());
                    }
                }
            }
            if changed {
                return Some((s, keep));
            }
        }
        None
    }

    /// Frees an idle row of stage `s`, or lowers it by one stage; false if it has to stay.
    fn retire(&mut self, e: Entry, s: usize) -> bool {
        let at = self.relaxed.rows.at(e.level, e.row);
        if usize::from(self.returns[at]) >= RETURNS + self.relaxed.levels && e.value >= -e.noise {
            return false;
        }
        self.returns[at] = self.returns[at].saturating_add(1);
        if e.value >= -e.noise && s < self.relaxed.levels {
            self.relaxed.stages.held[s + 1].push(Entry::new(e.level, e.row, e.side));
        } else {
            self.relaxed.rows.side[at] = 0;
        }
        true
    }

    /// The row outside the working set to add next, by the rule; none at the optimum. The values
    /// of all rows that it looks at, bounds of one variable apart, go to `rows.value`.
    fn next_violated(&mut self, problem: &Problem) -> Option<Entry> {
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

    /// Adds a violated row; see the head of the file.
    fn add(&mut self, problem: &Problem, mut entry: Entry) -> Result<(), Stopped> {
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
            let held = self.relaxed.stages.held[s].len();
            if own {
                self.relaxed.rewind(s, held);
                self.relaxed.stages.own[s].push(entry);
            } else if let Some(next) = self.hold(problem, s, &mut entry) {
                s = next;
                continue;
            }
            self.relaxed.complete(problem);
            let list = if own { &self.relaxed.stages.own[s] } else { &self.relaxed.stages.held[s] };
            if list.last().is_some_and(|e| e.trial < -e.noise) {
                // The multiplier of a violated row rises; where it falls, the working set is so
                // nearly dependent that rounding has taken over. Another order avoids it.
                return Err(Stopped::Circle);
            }
            let Some((stage, is_own, j, part)) = self.first_to_leave(s, Some(own)) else {
                self.relaxed.accept(s);
                return Ok(());
            };
            self.go_part(s, part);
            let list = if own { &mut self.relaxed.stages.own[s] } else { &mut self.relaxed.stages.held[s] };
            entry = list.pop().unwrap_or(entry);
            self.relaxed.rewind(s, self.relaxed.stages.held[s].len());
            if is_own {
                let gone = self.relaxed.stages.own[stage].remove(j);
                let at = self.relaxed.rows.at(gone.level, gone.row);
                self.relaxed.rows.side[at] = 0;
            } else {
                self.relaxed.release(stage, j);
            }
        }
    }

    /// Adds a row to those held at stage `s`, and to the frame. If it depends on them, one of them gives way to it, or those
    /// that it presses against rise to the stage above, and the stage to try next is returned.
    pub(super) fn hold(&mut self, problem: &Problem, s: usize, entry: &mut Entry) -> Option<usize> {
        let held = self.relaxed.stages.held[s].len();
        self.relaxed.rewind(s, held);
        self.relaxed.advance(problem, s);
        let room = self.relaxed.outward(problem, entry);
        let left = self.relaxed.project();
        let leaving = if left < NEAR { self.combine(s) } else { None };
        if left == 0.0 || leaving.is_some() {
            return Some(self.oppose(s, leaving, entry));
        }
        self.relaxed.fix(left, room);
        self.relaxed.stages.held[s].push(*entry);
        None
    }

    /// The combination of the rows held at stage `s` that the last projection took out of a row
    /// at that stage, into `combination`; returns the held row whose multiplier reaches zero
    /// first when the row is pushed back by a growing force.
    fn combine(&mut self, s: usize) -> Option<usize> {
        let (n, from) = (self.relaxed.n, self.relaxed.mark[s]);
        let held = &self.relaxed.stages.held[s];
        let w = held.len();
        let mut least = f64::INFINITY;
        let mut leaving = None;
        for j in (0..w).rev() {
            let mut sum = self.relaxed.frame.coefficient[from + j];
            for i in j + 1..w {
                sum -= self.relaxed.lower[(from + i) * n + from + j] * self.combination[i];
            }
            let c = sum / self.relaxed.lower[(from + j) * n + from + j];
            self.combination[j] = c;
            if c > COMBINED && held[j].value.max(0.0) / c < least {
                least = held[j].value.max(0.0) / c;
                leaving = Some(j);
            }
        }
        leaving
    }

    /// The row that is to join the rows held at stage `s` depends on them, by `combination`.
    /// Either `leaving` gives way to it, or the held rows that it presses against rise with it to
    /// the stage above. Returns the stage to try next.
    fn oppose(&mut self, s: usize, leaving: Option<usize>, entry: &mut Entry) -> usize {
        let held = &mut self.relaxed.stages.held[s];
        let w = held.len();
        if let Some(leaving) = leaving {
            let least = held[leaving].value.max(0.0) / self.combination[leaving];
            for (e, c) in held.iter_mut().zip(&self.combination) {
                e.value -= least * c;
            }
            entry.value += least;
            self.relaxed.release(s, leaving);
            return s;
        }
        let above = s - 1;
        let kept = self.relaxed.stages.held[above].len();
        for j in (0..w).rev() {
            if self.combination[j] < -COMBINED {
                let mut e = self.relaxed.stages.held[s].remove(j);
                e.value = 0.0;
                if e.level == above {
                    self.relaxed.stages.own[above].push(e);
                } else {
                    self.relaxed.stages.held[above].push(e);
                }
            }
        }
        entry.value = 0.0;
        self.relaxed.rewind(above, kept);
        above
    }

    /// Which multiplier from stage `s` on reaches zero first on the way to the trial: stage,
    /// whether it is a violated row of that level, place in its list, part of the way. The row
    /// that is being added, if any, last among the violated (`added`) or the held ones of `s`, does not
    /// count: its multiplier rises.
    pub(super) fn first_to_leave(&self, s: usize, added: Option<bool>) -> Option<(usize, bool, usize, f64)> {
        let mut first = None;
        let mut least = f64::INFINITY;
        for stage in s..=self.relaxed.levels {
            let violated = if stage < self.relaxed.levels { &self.relaxed.stages.own[stage][..] } else { &[] };
            for (is_own, list) in [(true, violated), (false, &self.relaxed.stages.held[stage][..])] {
                let added = usize::from(stage == s && added == Some(is_own));
                for (j, e) in list[..list.len() - added].iter().enumerate() {
                    if e.trial < -e.noise {
                        let part = e.value.max(0.0) / (e.value.max(0.0) - e.trial);
                        if part < least {
                            least = part;
                            first = Some((stage, is_own, j, part));
                        }
                    }
                }
            }
        }
        first
    }

    /// Goes part of the way to the trial multipliers from stage `s` on.
    pub(super) fn go_part(&mut self, s: usize, part: f64) {
        let own = self.relaxed.stages.own[s.min(self.relaxed.levels)..].iter_mut();
        for e in own.chain(&mut self.relaxed.stages.held[s..]).flatten() {
            e.value += part * (e.trial - e.value);
        }
    }
}
