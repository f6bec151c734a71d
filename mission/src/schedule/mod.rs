//! Schedules: service robots assist agents at the end of each of their operations, thesis chapter 5.
//!
//! [`problem::Problem`] says who there is; [`cost`] what a plan costs; [`validate`] whether a plan is one.

pub mod assistance;
pub mod chance;
pub mod check;
pub mod cost;
pub mod problem;
pub mod validate;
