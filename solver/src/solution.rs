//! What a solver gives back: the point, how each level fared, and whether it may be used.

use crate::problem::{Problem, ProblemError};
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// A row further than this from its interval is violated, relative to its own size and bound.
/// Wider than what counts as feasible inside, so that rounding never makes a level "relaxed".
pub(crate) const MET: f64 = 1e-9;

/// Outcome of one solve, for the whole problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Status {
    /// `x` is the lexicographic optimum.
    Optimal,
    /// A hard level cannot be met together with all levels above it. `x` is the optimum of the
    /// levels above alone (the reference, if there is none); nothing below was looked at.
    Infeasible {
        /// The hard level, from 0.
        level: usize,
    },
    /// A coefficient, bound, weight or damping is not a usable number. `x` is not to be used.
    /// A reference that is not finite is reported with `level` = number of levels.
    NotFinite {
        /// The level, from 0.
        level: usize,
        /// The row in it, from 0.
        row: usize,
    },
    /// The deadline passed before the answer was found ([`HierarchicalSolver::set_deadline`]).
    OutOfTime {
        /// `x` lies on the way from the last answer to this one: it is the optimum of a problem between the two, and need meet no row of
        /// this one. Otherwise `x` is not to be used.
        on_the_way: bool,
    },
    /// `x` meets the conditions of an optimum only in part: numbers of the problem lie where a rank or a sign is decided by rounding,
    /// and no order of solving gave an answer that holds the certificate. Not to be used where the optimum is needed.
    Unproven {
        /// The level that is farthest from its optimum, from 0; the number of levels for the choice of the nearest point.
        level: usize,
    },
    /// Numerical trouble, or an ill-formed level (`lower > upper`, negative weight, wrong sizes;
    /// [`crate::check`] says which). `x` is not to be used.
    Failed {
        /// The level at which it happened; the number of levels if after the last one.
        level: usize,
    },
}

/// Where a row stands at the solution.
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
    /// Outside its interval; the sign of the slack tells the side.
    Violated,
}

/// How a level came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum LevelStatus {
    /// Every row lies in its interval (to 1e-9 of the row's size).
    Met,
    /// The rows were met as well as the levels above allow, some not wholly.
    Relaxed,
    /// A hard level that cannot be met. Its `slack`, `active` and `violation` are those of the
    /// best compromise, not those at `x`: the violated rows are the ones that stand in the way.
    Infeasible,
    /// Not reached; the numbers of this level mean nothing.
    NotSolved,
}

/// The result of one level. All vectors are as long as the level has rows.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelSolution {
    /// `sqrt(sum_i w_i slack_i^2)`, without the damping term.
    pub violation: f64,
    /// Signed: `a x` minus its projection on `[lower, upper]`; negative = too low.
    pub slack: Vec<f64>,
    /// Where each row stands.
    pub active: Vec<Active>,
    /// `w_i slack_i`, half the derivative of the level's cost by the row's value; 0 where a backend gives none.
    pub multipliers: Vec<f64>,
    /// Dimension of what is left after the rows that this level and those above have fixed:
    /// equalities, violated rows, and rows held at a bound by a conflict. Inequality rows that
    /// are merely met do not count.
    pub freedom: usize,
    /// How the level came out.
    pub status: LevelStatus,
}

/// A row at its bound that keeps a level from coming closer to what it asks for.
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
    /// Half the derivative of the held level's cost by this bound, > 0: so much would a wider
    /// bound gain, to first order.
    pub multiplier: f64,
}

/// A solution with its storage, made once for a problem and overwritten by every solve.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// The point, `n` long.
    pub x: Vec<f64>,
    /// Whether and how `x` may be used.
    pub status: Status,
    /// One entry per level.
    pub levels: Vec<LevelSolution>,
    /// Which inequality rows hold which level back: the levels in order, at most `n` rows in
    /// all. With the equality rows and violated rows of higher levels (any sign), these balance
    /// the gradient of the level's cost. Empty where a backend gives none.
    pub blocking: Vec<Blocking>,
}

impl Solution {
    /// Storage for solutions of this problem and of all others of the same shape.
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

    /// Makes each level what `x` makes of it, whichever way it was found: slacks, where rows stand, whether the level is met. What only a
    /// solver knows is left: status, freedoms and which rows hold others back.
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

    /// Everything back to "not solved", with `x` at the reference. Allocates nothing when the
    /// shapes agree; a solution made for another shape is made anew.
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

/// The status for a problem that cannot be looked at.
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

/// Anything that solves hierarchical problems.
pub trait HierarchicalSolver {
    /// A short name for logs and tables.
    fn name(&self) -> &'static str;

    /// Solves `problem` into `solution`. Never panics; what went wrong is in the status. A solver
    /// may remember the last tick to be faster on the next, but the result does not depend on it
    /// beyond rounding.
    fn solve(&mut self, problem: &Problem, solution: &mut Solution) {
        self.solve_first(problem, problem.levels.len(), solution);
    }

    /// Solves from now on end with [`Status::OutOfTime`] where more is to be done than there was time for until then: looked at between two
    /// changes of the working set, so that one that needs none is never late, and one change is the most that it takes
    /// longer. The next solve goes on from what was reached. A solver may pay no heed: the reference does not.
    fn set_deadline(&mut self, _until: Option<Instant>) {}

    /// The same for the first `levels` levels, as if there were no others: in the answer those are not solved. Panics with more than
    /// the problem has, as slices do.
    fn solve_first(&mut self, problem: &Problem, levels: usize, solution: &mut Solution);
}
