//! The dual active-set search over the whole hierarchy, described at the head of the module.
//!
//! The rows that enter the working set are in `enter`, those that leave it in `leave`. Factorisations are kept: the frame holds the rows
//! in the order of the stages, and a change at a stage recomputes what comes after it only.

use super::kernels::{LANES, norm};
use super::relaxed::Relaxed;
use crate::problem::Problem;
use std::time::Instant;

/// With more changes than this to be expected, a solve starts from an empty working set.
const FEW: usize = 4;

/// A point that was this many times as far away as it is at the end is worked out anew, and no more than so often.
const LOST: f64 = 1e4;
const REPAIRS: usize = 3;

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
    pub(super) returns: Vec<u8>,
    pub(super) adds: Vec<u8>,
    /// How many rows were seen violated at the last look.
    pub(super) violated: usize,
    /// How the row at hand combines the held ones.
    pub(super) combination: Vec<f64>,
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
