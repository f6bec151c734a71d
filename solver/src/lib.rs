//! Hierarchical quadratic programs: problem, solution, solvers.
//!
//! # Problem
//!
//! A [`Problem`] is a list of levels, from the highest priority to the lowest, each a set of
//! two-sided rows `lower_i <= a_i x <= upper_i` with weights `w_i` (thesis (2.21)-(2.23)). With
//! `dist` the distance of a number from an interval, level `k` minimises
//!
//! ```text
//! sum_i w_i dist(a_i x, [lower_i, upper_i])^2  (+ damping |x|^2)
//! ```
//!
//! among the minimisers of all levels above it: no gain on a level, however large, is bought with any loss on a higher
//! one. Equalities are rows with `lower == upper`. The freedom that the last level leaves is settled by the point
//! nearest to `reference` (the smallest `x` by default). The optimum is therefore unique.
//!
//! This is not the cascade as the thesis prints it. (2.23) adds `1/2 v^T Q v` to the cost of EVERY level, so that each
//! level trades its own error against the size of `v`, and its minimiser moves away from the task even if nothing
//! opposes it. Here each level minimises only its own slack; the size of `x` matters only after the last level. The
//! trade is available as [`Level::damping`] of a single level: a damped level has a unique minimiser, and so leaves
//! nothing to the levels below.
//!
//! A [`Level::hard`] level has no slack. If it cannot be met within the set that the levels above leave, the solve
//! stops there with [`Status::Infeasible`], `x` is the optimum of the levels above, and the violated rows of that
//! [`LevelSolution`] are the conflicting ones.
//!
//! # Exactness
//!
//! The slacks of a level at its optimum are unique. A level is therefore passed on to those below as equalities (its
//! equality rows and violated rows, at the value they reached) and inequalities (the rest), never as a penalty or a
//! tolerance. The active set is found in finitely many steps, and the point is computed from it by orthogonal
//! factorisation, in double precision: about 1e-12, times the condition of the active rows. Two thresholds remain, both
//! relative to the size of each row. A row of which no more than 3e-11 is independent of the fixed rows counts as
//! dependent, so that a direction that moves a task by less than that is left to the levels below. A value up to 1e-11
//! beyond a bound is within it. [`certificate()`] proves the optimality of any point without solving anything; if the
//! decision of a threshold was close, an answer is called optimal only with that proof.
//!
//! # Solvers
//!
//! [`ActiveSet`] is the recommended solver: a dual active-set method over the whole hierarchy, warm-started from the
//! last tick, without allocation while it solves. [`ClarabelCascade`] is the reference: it solves level by level, is
//! slower, and searches independently. Any implementation of [`HierarchicalSolver`] can replace them. A [`Projection`] is for the nearest point
//! that meets some rows, without levels.
//!
//! # Example
//!
//! ```
//! use hierarq_solver::{ActiveSet, HierarchicalSolver, LevelShape, Problem, Solution, Status};
//!
//! // A speed limit, a target that it restricts, and a target on a third level that gets the rest.
//! let shape = |rows| LevelShape { rows, hard: false, damping: 0.0 };
//! let mut problem = Problem::new(2, &[shape(1), shape(1), shape(1)]);
//! problem.levels[0].set(0, &[1.0, 0.0], -1.0, 1.0); // |x| <= 1
//! problem.levels[1].set(0, &[1.0, 1.0], 3.0, 3.0); // x + y = 3
//! problem.levels[2].set(0, &[1.0, 0.0], 5.0, 5.0); // x = 5, as far as that goes
//! let mut solution = Solution::new(&problem);
//! ActiveSet::new(&problem).solve(&problem, &mut solution);
//! assert_eq!(solution.status, Status::Optimal);
//! assert!((solution.x[0] - 1.0).abs() < 1e-12 && (solution.x[1] - 2.0).abs() < 1e-12);
//! assert!((solution.levels[2].slack[0] + 4.0).abs() < 1e-12); // 4 short
//! ```

pub mod active_set;
mod backend;
pub mod cascade;
pub mod certificate;
mod conic;
pub mod contradiction;
mod dense;
mod descent;
mod distance;
mod factor;
mod feasible_set;
mod nnls;
pub mod problem;
pub mod projection;
mod reduced_level;
pub mod smooth;
pub mod solution;
pub mod structure;

pub use active_set::{ActiveSet, Effort};
pub use backend::Backend;
pub use cascade::{ClarabelCascade, Statistics};
pub use certificate::certificate;
pub use contradiction::contradiction;
pub use problem::{Level, LevelShape, Problem, ProblemError, check};
pub use projection::{Bounded, Projected, Projection};
pub use smooth::Smooth;
pub use solution::{Active, Blocking, HierarchicalSolver, LevelSolution, LevelStatus, Solution, Status};
pub use structure::Structure;
