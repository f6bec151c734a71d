//! The task library of Hierarq: one file per task type, with its parameters, equations, rows and tests.
//!
//! A task type is an entry of [`kinds::KINDS`]. The compiler binds the parameters of a spec as [`bound::BoundParams`];
//! the type's `build` turns them into a [`task::Task`]; the controller computes the task's rows at every tick. This
//! crate depends on robots, but not on the language, solvers or state machines.

pub mod axis_rows;
pub mod bound;
pub mod build;
pub mod clearance;
pub mod clik;
pub mod closest_points;
pub mod compliance;
pub mod curvature;
pub mod expression;
pub mod expression_tasks;
pub mod field;
pub mod geometry;
pub mod gradient_bound;
pub mod kinds;
pub mod numbers;
pub mod obstacle;
mod obstacle_pair;
pub mod params;
mod part_pairs;
pub mod protection;
mod sampled_margin;
pub mod slot;
pub mod so3;
pub mod state;
mod support_polygon;
pub mod task;
pub mod turns;

pub use quantities::dimension;

pub use kinds::{KINDS, find};
pub use task::{Task, TaskKind};
