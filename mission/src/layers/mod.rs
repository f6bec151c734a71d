//! Layered task plans: who of a team performs which task, with which object, when and how fast, thesis chapter 6.
//!
//! [`problem::Problem`] says who and what there is, [`check`] what cannot be planned, [`choose::plan`] plans,
//! [`validate::validate`] checks a plan from the problem alone, [`execute`] carries one out and plans anew where it must.
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
pub mod execute;
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
