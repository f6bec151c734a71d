//! The world of a person as a Markov decision process (the paper, Section 3.1 and Appendix A): a grid of cells with obstacles
//! and exits, and targets of several types that the person collects.
//!
//! A cell is a number: cells are counted row by row from the lower left corner, so that north of cell `c` is `c + columns`.
//! Transitions are deterministic. A step into a wall or an obstacle leaves the person where it is, and counts as a collision.
//! An episode ends on an exit, or after `step_limit` steps; the paper names no limit.

mod action;
mod distances;
mod environments;
mod features;
mod rewards;
mod state;
mod world;

pub use action::Action;
pub(crate) use distances::distances;
pub use environments::{Environments, EnvironmentsError};
pub use rewards::{RewardError, Rewards};
pub use state::{MAX_TARGETS, State, StateError, Target};
pub use world::{MAX_CELLS, MAX_TYPES, Step, World, WorldError};

/// Number of a cell, row by row from the lower left corner.
pub type Cell = u16;
