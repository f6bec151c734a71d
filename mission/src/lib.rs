//! Planners of missions: who of a team does what, when, how fast.
//!
//! Each planner is a pure function: a problem goes in, a plan or a reasoned refusal comes out, and the same input gives the
//! same answer. The crate knows no language, no robot's joints and no clock but the budget that a caller
//! gives; a solver from outside is found at run time and may be absent.
//!
//! - [`kinds`]: the kinds of mission, each with its problem, its planner, its validator and its execution.
//! - [`kind`]: the interface between a kind and everything that runs, judges, logs and shows missions.
//! - [`kind::pages`]: web pages for the people of a mission, as data.
//! - [`declare`]: missions as a spec declares them, with the places of their texts.
//! - [`execution`]: the parts of an execution that all kinds share.

pub mod any_mission;
pub mod characters;
pub mod chart;
pub mod check;
pub mod declare;
pub mod engine;
mod executed;
pub mod execution;
pub mod kind;
pub mod kinds;
pub mod labels;
pub mod map;
pub mod numbers;
pub mod occupancy;
pub mod parallel;
pub mod plan;
pub mod plan_data;
pub mod planned;
mod random;
pub mod validate;
