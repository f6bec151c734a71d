//! The output of a solver: the point, the outcome of each level, and the status of the solve.

use crate::problem::{Problem, ProblemError};
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// A row is violated if it is further than this from its interval, relative to its own size and bound. The threshold is
/// wider than the internal feasibility tolerance, so that rounding never makes a level "relaxed".
pub(crate) const MET: f64 = 1e-9;

/// Outcome of one solve, for the whole problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Status {
    /// `x` is the lexicographic optimum.
    Optimal,
    /// A hard level cannot be met together with all levels above it. `x` is the optimum of the levels above alone (the
    /// reference, if there is none); the levels below were not solved.
    Infeasible {
        /// The hard level, from 0.
        level: usize,
    },
    /// A coefficient, bound, weight or damping is not a usable number. `x` must not be used. A reference that is not
    /// finite is reported with `level` = number of levels.
    NotFinite {
        /// The level, from 0.
        level: usize,
        /// The row in it, from 0.
        row: usize,
    },
    /// The deadline passed before the answer was found ([`HierarchicalSolver::set_deadline`]).
    OutOfTime {
        /// True if `x` lies on the way from the last answer to this one: it is the optimum of a problem between the
        /// two, and may violate any row of this one. Otherwise `x` must not be used.
        on_the_way: bool,
    },
    /// `x` meets the conditions of an optimum only in part: rounding decides a rank or a sign of the problem, and no
    /// order of solving found an answer with a certificate. `x` must not be used if the optimum is needed.
    Unproven {
        /// The level that is farthest from its optimum, from 0; the number of levels for the choice of the nearest point.
        level: usize,
    },
    /// Numerical failure, or an ill-formed level (`lower > upper`, negative weight, wrong sizes; [`crate::check`]
    /// reports which). `x` must not be used.
    Failed {
        /// The level at which it happened; the number of levels if after the last one.
        level: usize,
    },
}

/// Position of a row relative to its interval at the solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Active {
    /// Strictly inside its interval.
    Free,
    /// At its lower bound.
    Lower,
    /// At its upper bound.
    Upper,
    /// An equality row that is met.
    Equality,
    /// Outside its interval; the sign of the slack shows the side.
    Violated,
}

/// Outcome of a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum LevelStatus {
    /// Every row lies in its interval (to 1e-9 of the row's size).
    Met,
    /// The rows are met as well as the levels above allow, some not completely.
    Relaxed,
    /// A hard level that cannot be met. Its `slack`, `active` and `violation` are those of the best compromise, not
    /// those at `x`: the violated rows are the conflicting ones.
    Infeasible,
    /// Not reached; the numbers of this level are meaningless.
    NotSolved,
}

/// The result of one level. All vectors are as long as the level has rows.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelSolution {
    /// `sqrt(sum_i w_i slack_i^2)`, without the damping term.
    pub violation: f64,
    /// Signed: `a x` minus its projection on `[lower, upper]`; negative = too low.
    pub slack: Vec<f64>,
    /// Position of each row.
    pub active: Vec<Active>,
    /// `w_i slack_i`, half the derivative of the level's cost with respect to the row's value; 0 if a backend computes
    /// none.
    pub multipliers: Vec<f64>,
    /// Dimension that is left by the rows that this level and those above have fixed: equalities, violated rows, and
    /// rows held at a bound by a conflict. Inequality rows that are merely met do not count.
    pub freedom: usize,
    /// Outcome of the level.
    pub status: LevelStatus,
}

/// A row at its bound that keeps a level from coming closer to its targets.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Blocking {
    /// The level that is held back, from 0.
    pub level: usize,
    /// The level of the row that holds it back; higher than `level`.
    pub by_level: usize,
    /// The row in that level, from 0.
    pub by_row: usize,
    /// True if the row is at its upper bound, false if at its lower.
    pub at_upper: bool,
    /// Half the derivative of the held level's cost with respect to this bound, > 0: the gain of a wider bound, to
    /// first order.
    pub multiplier: f64,
}

/// A solution with its storage, created once for a problem and overwritten by every solve.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// The point, `n` long.
    pub x: Vec<f64>,
    /// Status of the solve: it decides whether `x` may be used.
    pub status: Status,
    /// One entry per level.
    pub levels: Vec<LevelSolution>,
    /// Inequality rows that hold levels back: in the order of the levels, at most `n` rows in all. Together with the
    /// equality rows and violated rows of higher levels (any sign), they balance the gradient of the level's cost.
    /// Empty if a backend computes none.
    pub blocking: Vec<Blocking>,
}

impl Solution {
    /// Creates storage for solutions of this problem and of all others of the same shape.
    pub fn new(problem: &Problem) -> Self {
        let levels = problem
            .levels
            .iter()
            .map(|level| LevelSolution {
                violation: 0.0,
                slack: vec![0.0; level.rows()],
                active: vec![Active::Free; level.rows()],
                multipliers: vec![0.0; level.rows()],
                freedom: problem.n,
                status: LevelStatus::NotSolved,
            })
            .collect();
        Solution {
            x: vec![0.0; problem.n],
            status: Status::Failed { level: 0 },
            levels,
            blocking: Vec::with_capacity(problem.n + 1),
        }
    }

    /// Recomputes the result of each level from `x`: slacks, positions of the rows, and whether the level is met.
    /// Multipliers become 0. The status of the solve, the freedoms and the blocking rows, which only a solver knows,
    /// are unchanged.
    pub fn measure(&mut self, problem: &Problem) {
        for (level, out) in problem.levels.iter().zip(&mut self.levels) {
            let (mut sum, mut met) = (0.0, true);
            for i in 0..level.rows() {
                let slack = level.slack(i, &self.x);
                let size = level.row(i).iter().map(|a| a * a).sum::<f64>().sqrt();
                let (lower, upper, weight) = (level.lower[i], level.upper[i], level.weight[i]);
                let value: f64 = level.row(i).iter().zip(&self.x).map(|(a, x)| a * x).sum();
                let near = |bound: f64| MET * (size + bound.abs());
                let violated = slack.abs() > near(if slack > 0.0 { upper } else { lower });
                met &= !violated || (weight == 0.0 && !level.hard);
                out.active[i] = if violated {
                    Active::Violated
                } else if lower == upper {
                    Active::Equality
                } else if value <= lower + near(lower) {
                    Active::Lower
                } else if value >= upper - near(upper) {
                    Active::Upper
                } else {
                    Active::Free
                };
                out.slack[i] = slack;
                out.multipliers[i] = 0.0;
                sum += weight * slack * slack;
            }
            out.violation = sum.sqrt();
            out.status = if met { LevelStatus::Met } else { LevelStatus::Relaxed };
        }
    }

    /// Resets everything to "not solved", with `x` at the reference. Does not allocate if the shapes agree; a solution
    /// of another shape is created anew.
    pub fn reset(&mut self, problem: &Problem) {
        let fits = self.x.len() == problem.n
            && self.levels.len() == problem.levels.len()
            && (self.levels.iter().zip(&problem.levels)).all(|(s, l)| s.slack.len() == l.rows());
        if !fits {
            *self = Solution::new(problem);
        }
        for level in &mut self.levels {
            level.violation = 0.0;
            level.slack.fill(0.0);
            level.active.fill(Active::Free);
            level.multipliers.fill(0.0);
            level.freedom = problem.n;
            level.status = LevelStatus::NotSolved;
        }
        self.blocking.clear();
        self.x.fill(0.0);
        for (x, r) in self.x.iter_mut().zip(&problem.reference) {
            *x = *r;
        }
        self.status = Status::Failed { level: 0 };
    }
}

/// Returns the status for a problem that [`crate::check`] rejects.
pub(crate) fn refusal(error: ProblemError, problem: &Problem) -> Status {
    match error {
        ProblemError::NotFinite { level, row } => Status::NotFinite { level, row },
        ProblemError::BadReference => Status::NotFinite { level: problem.levels.len(), row: 0 },
        ProblemError::EmptyInterval { level, .. }
        | ProblemError::NegativeWeight { level, .. }
        | ProblemError::BadDamping { level }
        | ProblemError::WrongSize { level } => Status::Failed { level },
    }
}

/// A solver of hierarchical problems.
pub trait HierarchicalSolver {
    /// Returns a short name for logs and tables.
    fn name(&self) -> &'static str;

    /// Solves `problem` into `solution`. Never panics; the status reports errors. A solver may use the last tick to be
    /// faster on the next, but the result does not depend on it beyond rounding.
    fn solve(&mut self, problem: &Problem, solution: &mut Solution) {
        self.solve_first(problem, problem.levels.len(), solution);
    }

    /// Sets the deadline of the solves that follow: a solve that would take longer ends with [`Status::OutOfTime`]. The
    /// deadline is checked between two changes of the working set, so that a solve without changes is never late, and
    /// the delay is at most one change. The next solve continues from there. A solver may ignore the deadline: the
    /// reference does.
    fn set_deadline(&mut self, _until: Option<Instant>) {}

    /// Solves the first `levels` levels, as if there were no others; in the answer the others are not solved. Panics if
    /// the problem has fewer levels, as slices do.
    fn solve_first(&mut self, problem: &Problem, levels: usize, solution: &mut Solution);
}
