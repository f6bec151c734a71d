//! The dual active-set search over the whole hierarchy, described in the documentation of the module.
//!
//! `enter` handles the rows that enter the working set, `leave` those that leave it. Factorisations are kept: the frame
//! contains the rows in the order of the stages, and a change at a stage recomputes only what comes after it.

use super::kernels::{LANES, norm};
use super::relaxed::Relaxed;
use crate::problem::Problem;
use std::time::Instant;

/// Maximum number of expected changes for which a solve keeps the working set of the last tick; otherwise it starts
/// from an empty one.
const FEW: usize = 4;

/// The point is recomputed if a step larger than this multiple of its size was taken back, at most `REPAIRS` times.
const LOST: f64 = 1e4;
const REPAIRS: usize = 3;

/// Reason why a search ended without an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stopped {
    /// Too many changes of the working set.
    Circle,
    /// The deadline has passed.
    Late,
}

/// Order in which violated rows are added. All orders lead to the same optimum; if rounding makes one of them cycle,
/// another one may not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rule {
    /// The row with the largest violation.
    Worst,
    /// The row with the largest violation in the highest level that has any.
    Level,
    /// The first violated row.
    First,
}

#[derive(Clone, Debug)]
pub(crate) struct Search {
    pub(crate) relaxed: Relaxed,
    /// Order in which violated rows are added.
    pub(crate) rule: Rule,
    /// Remaining number of changes of the working set before giving up.
    pub(crate) budget: usize,
    /// Number of times that each row moved to a lower stage, and that it was added.
    pub(super) returns: Vec<u8>,
    pub(super) adds: Vec<u8>,
    /// Number of violated rows at the last scan.
    pub(super) violated: usize,
    /// Coefficients of the current row in the active ones.
    pub(super) combination: Vec<f64>,
    /// Current point on the way from the last tick's optimum to this one's, and the values of all rows there.
    pub(super) point: Vec<f64>,
    pub(super) past: Vec<f64>,
    /// Number of levels whose optimum the point is; 0 if it is no optimum.
    pub(super) known: usize,
    /// Number of levels to which rows were being added when the deadline passed; 0 if it did not pass.
    pub(super) adding: usize,
    /// Deadline.
    pub(super) until: Option<Instant>,
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

    /// Begins a solve of the first `levels` levels from the current working set.
    pub(crate) fn begin(&mut self, problem: &Problem, levels: usize, rule: Rule) {
        self.relaxed.begin(problem, levels);
        self.returns.fill(0);
        self.adds.fill(0);
        self.rule = rule;
        self.budget = 400 + 40 * problem.n;
    }

    /// Searches for the optimum from the current working set.
    ///
    /// # Errors
    /// If the budget of changes or the time is used up.
    pub(crate) fn run(&mut self, problem: &Problem) -> Result<(), Stopped> {
        self.search(problem)?;
        // Intermediate points may have been so far away that the digits of the result are lost.
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

    /// Searches like [`run`](Search::run); the final point may be inexact.
    fn search(&mut self, problem: &Problem) -> Result<(), Stopped> {
        let all = self.relaxed.levels;
        let (known, adding) = (std::mem::take(&mut self.known), std::mem::take(&mut self.adding));
        let mut reached = all;
        if self.rule == Rule::Worst && (1..=all).contains(&adding) {
            // The last tick ran out of time while it added rows: this one continues.
            reached = adding;
            self.relaxed.levels = adding;
            self.add_level(problem)?;
        } else if !self.start(problem, known == all && self.rule == Rule::Worst)? {
            self.relaxed.rewind(0, 0);
            self.relaxed.working_set.clear(&mut self.relaxed.rows);
            reached = 0;
        }
        for l in reached + 1..=all {
            if l > 1 {
                self.relaxed.rewind(l - 1, 0);
                let (above, below) = self.relaxed.working_set.active.split_at_mut(l);
                below[0].append(&mut above[l - 1]);
            }
            self.relaxed.levels = l;
            self.add_level(problem)?;
        }
        Ok(())
    }

    /// Searches for the optimum from the current working set. Returns false if that is no usable start.
    fn start(&mut self, problem: &Problem, follows: bool) -> Result<bool, Stopped> {
        let before = self.relaxed.working_set.count();
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
        let changes = self.violated + before.saturating_sub(self.relaxed.working_set.count());
        if self.rule == Rule::Worst && (before == 0 || changes > FEW) {
            return Ok(false);
        }
        self.add(problem, entry)?;
        self.settle(problem)?;
        self.improve(problem)?;
        Ok(true)
    }

    /// Computes the optimum of the levels so far, of which the last is new.
    fn add_level(&mut self, problem: &Problem) -> Result<(), Stopped> {
        self.relaxed.complete(problem);
        self.relaxed.accept(0);
        self.settle(problem)?;
        self.improve(problem)
    }

    /// Counts a change of the working set against the budget.
    pub(super) fn count(&mut self) -> Result<(), Stopped> {
        self.budget = self.budget.checked_sub(1).ok_or(Stopped::Circle)?;
        Ok(())
    }

    /// Returns true if the deadline has passed.
    pub(super) fn is_late(&self) -> bool {
        self.until.is_some_and(|until| Instant::now() >= until)
    }

    /// Adds violated rows until there are none or the deadline has passed; one is added in any case.
    pub(super) fn improve(&mut self, problem: &Problem) -> Result<(), Stopped> {
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
}
