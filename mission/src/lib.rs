//! Planners of missions: who of a team does what, when, how fast.
//!
//! Each planner is a pure function: a problem goes in, a [`plan::Plan`] or a reasoned refusal comes out, and the same
//! input gives the same answer. The crate knows no language, no robot's joints and no clock but the budget that a caller
//! gives; a solver from outside is found at run time and may be absent.
//!
//! - [`schedule`]: robots that serve agents at the end of their operations, thesis chapter 5.
//! - [`execution`]: the world in which a schedule is executed, and the plan that follows what happens.
//! - [`layers`]: tasks in ordered layers, each with an agent and an object, thesis chapter 6; and the world in which they
//!   are done.

pub mod characters;
pub mod engine;
pub mod execution;
pub mod labels;
pub mod layers;
pub mod plan;
pub mod schedule;
