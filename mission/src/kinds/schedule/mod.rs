//! Schedules: service robots assist agents at the end of each of their operations, thesis chapter 5.
//!
//! [`problem::Problem`] says who there is, [`choose::plan`] plans, [`validate::validate`] checks a plan from the problem
//! alone. While a plan is executed, [`adapt`] takes what people say, [`reschedule`] repairs and [`reallocate`] plans anew.

pub mod adapt;
pub mod adaptation_index;
pub mod assistance;
pub mod batches;
mod bounds;
pub mod chance;
pub mod check;
mod check_begun;
pub mod choose;
mod constraint;
mod construct;
pub mod cost;
mod curve;
mod exact;
pub mod execution;
pub(crate) mod instance;
mod orders;
mod position;
mod prices;
pub mod problem;
pub mod reallocate;
mod relaxation;
pub mod reschedule;
mod retime;
mod routes;
mod subsets;
mod timing;
pub mod validate;
