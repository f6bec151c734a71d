//! The hierarchical active-set solver: exact, warm-started, without allocation while it solves.
//!
//! At each tick the solver reads the rows once (`rows`), takes the working set of the last tick (`working_set`), and fixes
//! its rows one after the other in an orthonormal frame, level by level (`frame`, `group`, `closed`, `relaxed`).
//! Multipliers show which rows must leave, residuals which must enter (`search`). If nothing changes, the usual case,
//! this costs one factorisation and one scan of all rows. Otherwise the optimum of the last tick is followed to that of
//! this one (`follow`).
//!
//! # Algorithm
//!
//! The working set defines a relaxed problem, in which only its rows exist. Its optimum is known; rows outside it may
//! be violated. A violated row is added by a growing force. At first the force is infinitesimal against every level, so
//! that only the choice among equals (the nearest point) gives way. If the row depends on rows that hold that choice
//! already, these and the force become as large as the level above it, and so on up to the row's own level, where it
//! may stay violated against the squares of the others. While the force grows, the multipliers of all other rows change
//! linearly; the first that reaches zero leaves. This is the dual method of Goldfarb and Idnani (1983) for the cost
//! `sum_k eps^k cost_k` with a symbolic `eps`: the lexicographic value of the relaxed optimum only rises, so that no
//! working set repeats. Any working set whose multipliers have the right sign is a start; rows with the wrong sign are
//! dropped. The method completes a solve that has followed the last tick. If the last tick is no usable start, it
//! begins with an empty working set and adds levels one at a time.
//!
//! # Rounding
//!
//! * Dependent rows never meet in the frame: a row that depends on rows held at its stage replaces one of them or moves
//!   up with them.
//! * A level of any rank is eliminated with its largest remaining row first, so that coefficients of dependent rows
//!   stay small; zero rows have no effect.
//! * Every direction of the frame carries its error, because rounding turns the direction of a small remainder. A row
//!   is dependent if its remainder is not clearly larger than that error.
//! * Every multiplier carries the size of its rounding. Within it, a row is idle: it moves to the stage below, where it
//!   may still be needed. A row is also idle if its release would move its level by less than the threshold of an
//!   independent row.
//! * A row that is added too often, a multiplier that falls although it must rise, or too many changes end the attempt.
//!   Three more attempts follow from an empty working set, the last two with other orders of adding rows. Each attempt
//!   has a bound on its changes, so that each solve ends. [`Effort`] counts them.

mod closed;
mod enter;
mod follow;
mod frame;
mod group;
mod kernels;
mod leave;
mod proof;
mod relaxed;
mod report;
mod rows;
mod search;
mod working_set;

use crate::certificate::Claim;
use crate::problem::Problem;
use crate::solution::{HierarchicalSolver, LevelStatus, Solution, Status, refusal};
use proof::Proof;
use search::{Rule, Search, Stopped};
use std::time::Instant;

/// Counters over all solves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Number of solves.
    pub solves: u64,
    /// Changes of the working set, those of a trial included.
    pub changes: u64,
    /// Restarts from an empty working set, after a cycle or an unproven answer.
    pub restarts: u64,
    /// Solves that failed, because every attempt ran into a cycle.
    pub failures: u64,
    /// Solves that reached the deadline.
    pub late: u64,
    /// Answers that needed the certificate, because a rank, a sign or a residual was decided by a number near its
    /// threshold, or because the balance of a level failed.
    pub doubts: u64,
    /// Solves without a proven answer in any order of adding rows.
    pub unproven: u64,
}

/// The hierarchical active-set least-squares solver.
///
/// Created for one shape of problem: number of variables, levels, rows. It accepts any other shape, and then allocates
/// once.
#[derive(Clone, Debug)]
pub struct ActiveSet {
    search: Search,
    proof: Proof,
    shape: Vec<usize>,
    warm: bool,
    effort: Effort,
}

impl ActiveSet {
    /// Creates a solver with storage for problems of this shape.
    pub fn new(problem: &Problem) -> Self {
        let search = Search::new(problem);
        ActiveSet {
            proof: Proof::new(problem, search.relaxed.stride),
            search,
            shape: shape(problem).collect(),
            warm: true,
            effort: Effort::default(),
        }
    }

    /// With `true` (the default), the working set of one solve is the start of the next.
    pub fn with_warm_start(mut self, warm: bool) -> Self {
        self.warm = warm;
        self
    }

    /// Clears the working set, so that the next solve starts from an empty one.
    pub fn forget(&mut self) {
        let relaxed = &mut self.search.relaxed;
        relaxed.working_set.clear(&mut relaxed.rows);
        (self.search.known, self.search.adding) = (0, 0);
    }

    /// Returns the counters of all solves so far.
    pub fn effort(&self) -> Effort {
        self.effort
    }

    /// Solves the first `levels` levels and writes the first proven answer. Returns the hard level that cannot be met,
    /// if there is one.
    fn search(&mut self, problem: &Problem, levels: usize, solution: &mut Solution) -> Result<Option<usize>, Unsolved> {
        let rules = [Rule::Worst, Rule::Worst, Rule::Level, Rule::First];
        let mut unsolved = Unsolved::Circle;
        for (attempt, rule) in rules.into_iter().enumerate() {
            if attempt > 0 {
                self.forget();
                self.effort.restarts += 1;
            }
            self.search.begin(problem, levels, rule);
            let budget = self.search.budget;
            let done = self.search.run(problem);
            self.effort.changes += (budget - self.search.budget) as u64;
            match done {
                Ok(()) => {}
                Err(Stopped::Late) => return Err(Unsolved::Late),
                Err(Stopped::Circle) => continue,
            }
            let relaxed = &self.search.relaxed;
            report::write(relaxed, problem, solution);
            solution.x.copy_from_slice(&relaxed.frame.x[..problem.n]);
            let missed = |l: &usize| problem.levels[*l].hard && solution.levels[*l].status != LevelStatus::Met;
            let unmet = (0..levels).find(missed);
            let claim = unmet.map_or(Claim::Optimum(levels), Claim::Compromise);
            if self.proof.holds(relaxed, problem, solution, claim) {
                return Ok(unmet);
            }
            unsolved = Unsolved::Unproven { level: self.proof.missed };
        }
        Err(unsolved)
    }
}

/// Reason why there is no answer, or no proven one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unsolved {
    /// The deadline has passed.
    Late,
    /// Every attempt ran into a cycle.
    Circle,
    /// No answer passed the certificate.
    Unproven {
        /// Level at which the last answer is farthest from the optimum.
        level: usize,
    },
}

fn shape(problem: &Problem) -> impl Iterator<Item = usize> + '_ {
    std::iter::once(problem.n).chain(problem.levels.iter().map(crate::Level::rows))
}

impl HierarchicalSolver for ActiveSet {
    fn name(&self) -> &'static str {
        "active-set"
    }

    fn set_deadline(&mut self, until: Option<Instant>) {
        self.search.until = until;
    }

    fn solve_first(&mut self, problem: &Problem, levels: usize, solution: &mut Solution) {
        self.effort.solves += 1;
        if !shape(problem).eq(self.shape.iter().copied()) {
            let until = self.search.until;
            self.search = Search::new(problem);
            self.search.until = until;
            self.proof = Proof::new(problem, self.search.relaxed.stride);
            self.shape = shape(problem).collect();
        }
        solution.reset(problem);
        if let Err(error) = self.search.relaxed.rows.read(problem) {
            solution.status = refusal(error, problem);
            return;
        }
        if !self.warm {
            self.forget();
        }
        let mut levels = levels;
        let mut status = Status::Optimal;
        loop {
            let found = self.search(problem, levels, solution);
            self.effort.doubts = self.proof.asked;
            match found {
                Ok(None) => break,
                Ok(Some(l)) => {
                    // The conflicting rows are known; the optimum of the levels above is still to be computed.
                    solution.levels[l].status = LevelStatus::Infeasible;
                    solution.levels[l + 1..].iter_mut().for_each(|below| below.status = LevelStatus::NotSolved);
                    status = Status::Infeasible { level: l };
                    levels = l;
                }
                Err(Unsolved::Late) => {
                    self.effort.late += 1;
                    let on_the_way = self.search.known > 0;
                    if on_the_way {
                        solution.x.copy_from_slice(&self.search.point[..problem.n]);
                    }
                    solution.status = Status::OutOfTime { on_the_way };
                    return;
                }
                Err(Unsolved::Circle) => {
                    self.effort.failures += 1;
                    self.forget();
                    solution.status = Status::Failed { level: levels };
                    return;
                }
                Err(Unsolved::Unproven { level }) => {
                    self.effort.unproven += 1;
                    self.forget();
                    solution.status = Status::Unproven { level };
                    return;
                }
            }
        }
        solution.status =
            if solution.x.iter().all(|x| x.is_finite()) { status } else { Status::Failed { level: levels } };
        if solution.status != status {
            self.forget();
        } else if self.warm {
            self.search.point.copy_from_slice(&self.search.relaxed.frame.x);
            self.search.known = levels;
        }
    }
}
