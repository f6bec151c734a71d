//! Schedules: service robots assist agents at the end of each of their operations, thesis chapter 5.
//!
//! [`problem::Problem`] describes the team, [`choose::plan`] plans, [`validate::validate`] checks a plan against the
//! problem alone. During execution, [`adapt`] applies feedback of people, [`reschedule`] repairs the plan and
//! [`reallocate`] replans.

pub mod adapt;
pub mod adaptation_index;
pub mod assistance;
pub mod batches;
pub mod blocks;
mod bounds;
mod build;
pub mod chart;
pub mod check;
mod check_begun;
pub mod choose;
mod constraint;
mod construct;
pub mod cost;
mod cost_function;
pub mod duration_quantile;
pub mod event;
mod exact;
pub mod execution;
pub(crate) mod instance;
mod lagrangian_bound;
mod magnitudes;
pub mod map;
mod mission;
mod orders;
mod pages;
pub mod plan;
pub mod planned;
mod position;
pub mod problem;
pub mod reallocate;
mod refusals;
mod relaxation;
pub mod reschedule;
mod retime;
mod robot_tours;
mod run;
mod subsets;
mod text;
mod timing;
pub mod validate;
mod warnings;
pub mod words;

pub use self::mission::{KIND, Schedule};
