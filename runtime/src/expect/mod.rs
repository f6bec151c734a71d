//! Expectations: what a run must do, in signal temporal logic with a margin.
//!
//! A [`Formula`] is plain data over signals that are one number a tick, true where the number is zero or more.
//! [`offline::evaluate`] judges a whole log, straight from the definitions; a [`Monitor`] takes one tick at a time in
//! storage that was allocated before, and comes to the same [`Outcome`]. The two share the definition of a [`Value`] and
//! nothing else. The definitions stand in the book, "Expectations".

mod network;
pub mod offline;
pub mod online;
mod operator;
mod queue;
pub mod value;
pub mod verdict;
mod wedge;

pub use crate::program::{Formula, MAX_NODES, Node, Unit, Window, WindowError};
pub use network::MAX_KEPT;
pub use online::{Monitor, PushError};
pub use value::{Interval, Value};
pub use verdict::{Outcome, Verdict};
