//! The hierarchical active-set solver: exact, warm-started, without allocation while it solves.
//!
//! At a tick it reads the rows once (`rows`), takes the working set of the last tick (`stages`),
//! and fixes its rows one after the other in an orthonormal frame, level by level (`frame`,
//! `group`, `closed`, `relaxed`). Multipliers tell which rows must leave, residuals which must enter
//! (`search`). When nothing is to change, which is most of the time, that is one factorisation
//! and one look at every row. Otherwise the optimum of the last tick is followed to that of this
//! one (`follow`).
//!
//! # How it finds the optimum
//!
//! The working set is read as a relaxed problem, in which only its rows exist. Its optimum is
//! known; rows outside it may be violated. A violated row is added by a growing force. At first
//! the force is infinitesimal against every level, so that only the choice among equals (the
//! nearest point) gives way. Where the row depends on rows that hold that choice already, these
//! and the force become as large as the level above it, and so on up to the row's own level,
//! where it may stay violated against the squares of the others. While the force grows, the
//! multipliers of all other rows change linearly; the first that reaches zero leaves. This is the
//! dual method of Goldfarb and Idnani (1983) for the cost `sum_k eps^k cost_k` with a symbolic
//! `eps`: the lexicographic value of the relaxed optimum only rises, so no working set returns,
//! and a start may be any working set whose multipliers have the right sign; wrong ones are
//! simply dropped. It settles what is left where the last tick was followed, and it begins with
//! nothing and adds levels one at a time where the last tick is no start.
//!
//! # Where rounding matters
//!
//! * Dependent rows never meet in the frame: a row that depends on rows held at its stage sends
//!   one of them away or rises with them.
//! * A level of any rank is eliminated with its largest remaining row first, so coefficients of
//!   dependent rows stay small; zero rows have no say.
//! * Every direction of the frame carries its error: one that is what little was left of a row is
//!   turned by rounding, and a row is dependent where no more of it is left than that error.
//! * Every multiplier carries the size of its rounding. Within it, a row is idle: it falls to the
//!   stage below, where it may still be needed. So does one whose level would not move by as much
//!   as an independent row has, if the row let go.
//! * A row that is added too often, a multiplier that falls where it must rise, or too many
//!   changes end the attempt; three more orders of adding rows follow. Each attempt has a bound
//!   on its changes, so each solve ends. [`Effort`] counts what it took.

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
mod stages;

use crate::certificate::Claim;
use crate::problem::Problem;
use crate::solution::{HierarchicalSolver, LevelStatus, Solution, Status, refusal};
use proof::Proof;
use search::{Rule, Search, Stopped};
use std::time::Instant;

/// Counters over all solves so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Number of solves.
    pub solves: u64,
    /// Changes of the working set, those of a trial included.
    pub changes: u64,
    /// New beginnings from an empty working set, after running in a circle.
    pub restarts: u64,
    /// Solves that gave up.
    pub failures: u64,
    /// Solves for which there was no time.
    pub late: u64,
    /// Answers that the certificate was asked about, because a rank, a sign or a residual was decided by a number near its threshold.
    pub doubts: u64,
    /// Solves whose answer was not proven in any order of adding rows.
    pub unproven: u64,
}

/// The hierarchical active-set least-squares solver.
///
/// Made for one shape of problem: number of variables, levels, rows. It accepts any other, and
/// then allocates once.
#[derive(Clone, Debug)]
pub struct ActiveSet {
    search: Search,
    proof: Proof,
    shape: Vec<usize>,
    warm: bool,
    effort: Effort,
}

impl ActiveSet {
    /// A solver with storage for problems of this shape.
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

    /// Whether the working set of one solve is the start of the next (the default).
    pub fn with_warm_start(mut self, warm: bool) -> Self {
        self.warm = warm;
        self
    }

    /// Forgets the working set, so that the next solve starts from none.
    pub fn forget(&mut self) {
        let relaxed = &mut self.search.relaxed;
        relaxed.stages.clear(&mut relaxed.rows);
        (self.search.known, self.search.adding) = (0, 0);
    }

    /// What the solves have cost so far.
    pub fn effort(&self) -> Effort {
        self.effort
    }

    /// Solves the first `levels` levels, and writes the answer: the first that is proven. Returns the hard level that cannot be met,
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

/// Why there is no answer, or none that is proven.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unsolved {
    /// There was no time.
    Late,
    /// Every order of adding rows ran in a circle.
    Circle,
    /// No answer of any order holds the certificate.
    Unproven {
        /// Where the last one is farthest from the optimum.
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
                    // What stands in the way is known; what the levels above want is still to be found.
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
