//! Layered task plans: who of a team performs which task, with which object, when and how fast, thesis chapter 6.
//!
//! [`problem::Problem`] says who and what there is, [`check`] what cannot be planned.

mod assignment;
mod batches;
mod branch;
pub mod check;
pub mod choose;
pub mod cost;
mod describe;
mod dual;
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
