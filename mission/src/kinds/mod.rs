//! The kinds of mission, a folder each.
//!
//! - [`schedule`]: robots that serve agents at the end of their operations, thesis chapter 5.
//! - [`layers`]: tasks in ordered layers, each with an agent and an object, thesis chapter 6.

pub mod layers;
pub mod schedule;
