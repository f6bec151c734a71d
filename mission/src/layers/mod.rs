//! Layered task plans: who of a team performs which task, with which object, when and how fast, thesis chapter 6.
//!
//! [`problem::Problem`] says who and what there is, [`check`] what cannot be planned.

pub mod check;
mod feasible;
pub mod matching;
pub mod problem;
pub mod reason;
pub mod scales;
