//! Layered task plans: assignment of tasks to the agents of a team, with objects, times and speeds, thesis chapter 6.
//!
//! [`problem::Problem`] describes the team and its tasks, [`check`] reports mistakes, [`choose::plan`] plans,
//! [`validate::validate`] checks a plan against the problem alone, [`execution`] simulates the world in which a plan is
//! executed and replans after events. [`json`] imports and exports layers.

mod ability;
mod assignment;
mod batches;
pub mod blocks;
mod branch;
mod build;
pub mod chart;
pub mod check;
pub mod choose;
pub mod cost;
mod describe;
mod dual;
mod event;
pub mod execution;
mod feasible;
pub mod generation;
mod improve;
mod instance;
pub mod json;
mod magnitudes;
pub mod map;
pub mod matching;
mod mission;
mod mixed;
mod pages;
pub mod plan;
pub mod planned;
pub mod problem;
pub mod reason;
mod refusals;
mod run;
pub mod scales;
mod speeds;
pub mod steps;
mod text;
mod timeline;
pub mod validate;
mod warnings;
pub mod words;

pub use self::mission::{KIND, Layers};
