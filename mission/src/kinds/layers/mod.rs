//! Layered task plans: who of a team performs which task, with which object, when and how fast, thesis chapter 6.
//!
//! [`problem::Problem`] says who and what there is, [`check`] what cannot be planned, [`choose::plan`] plans,
//! [`validate::validate`] checks a plan from the problem alone, [`execution`] is the world in which one is carried out, and the plan that follows what happens.
//! [`json`] reads layers and gives them out.

mod ability;
mod assignment;
mod batches;
mod branch;
pub mod check;
pub mod choose;
pub mod cost;
mod describe;
mod dual;
pub mod execution;
mod feasible;
mod improve;
mod instance;
pub mod json;
pub mod matching;
mod mixed;
pub mod problem;
pub mod reason;
pub mod scales;
mod speeds;
pub mod steps;
mod timeline;
pub mod validate;
