//! The hierarchical quadratic program: problem, solution, cascade.
//!
//! # What is solved
//!
//! A [`Problem`] is a list of levels, from the highest priority to the lowest, each a set of
//! two-sided rows `lower_i <= a_i x <= upper_i` with weights `w_i` (thesis (2.21)-(2.23)). With
//! `dist` the distance of a number from an interval, level `k` minimises
//!
//! ```text
//! sum_i w_i dist(a_i x, [lower_i, upper_i])^2  (+ damping |x|^2)
//! ```
//!
//! among the minimisers of all levels above it: no gain on a level, however large, is bought with
//! any loss on a higher one. Equalities are rows with `lower == upper`. What the last level
//! leaves open is settled by the point nearest to `reference` (the smallest `x` by default). The
//! optimum is therefore always one point.
//!
//! This is not the cascade as the thesis prints it. (2.23) adds `1/2 v^T Q v` to the cost of
//! EVERY level, so each level trades its own error against the size of `v`, and its minimiser
//! moves away from the task even where nothing opposes it. Here each level minimises only its own
//! slack; the size of `x` matters after the last level alone. Who wants the trade says so with
//! [`Level::damping`], and then it is that level's own: a damped level has one minimiser only,
//! and so leaves nothing to the levels below.
//!
//! A [`Level::hard`] level takes no slack. If it cannot be met within what the levels above leave,
//! the solve stops there with [`Status::Infeasible`], `x` is the optimum of the levels above, and
//! the rows that stand in the way are the violated ones of that [`LevelSolution`].
//!
//! # What "exact" means
//!
//! The slacks of a level at its optimum are unique, so a level is passed on to those below as
//! equalities (its equality rows and violated rows, at the value they reached) and inequalities
//! (the rest), never as a penalty or a tolerance. The active set is found in finitely many steps,
//! and the point is computed from it by orthogonal factorisation, in doubles: about 1e-12, times
//! the condition of the active rows. Two thresholds remain, both relative to the size of each
//! row: a row that is within 3e-11 of depending on what is fixed counts as dependent, so a
//! direction that moves a task by less than that is left to the levels below; and 1e-11 beyond a
//! bound is within it. [`certificate()`] proves optimality of any point without solving anything; an
//! answer is called optimal only if a close call of a threshold did not need that proof, or has it.
//!
//! # Solvers
//!
//! [`ActiveSet`] is the one to use: a dual active-set method over the whole hierarchy, warm from
//! the last tick, without allocation while it solves. [`ClarabelCascade`] is the reference, level
//! by level, slower, and shares nothing with it but the problem. Whatever implements
//! [`HierarchicalSolver`] can take their place.
//!
//! # Example
//!
//! ```
//! use hierarq_solver::{ActiveSet, HierarchicalSolver, LevelShape, Problem, Solution, Status};
//!
//! // A speed limit above a wish that it cuts short, and a wish below that gets the rest.
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
mod dense;
mod descent;
mod distance;
mod factor;
mod nnls;
pub mod problem;
pub mod smooth;
pub mod solution;
mod space;
mod stage;
pub mod structure;

pub use active_set::{ActiveSet, Effort};
pub use backend::Backend;
pub use cascade::{ClarabelCascade, Statistics};
pub use certificate::certificate;
pub use problem::{Level, LevelShape, Problem, ProblemError, check};
pub use smooth::Smooth;
pub use solution::{Active, Blocking, HierarchicalSolver, LevelSolution, LevelStatus, Solution, Status};
pub use structure::Structure;
