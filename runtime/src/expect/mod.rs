//! Expectations: requirements on a run, in signal temporal logic with a margin.
//!
//! A [`Formula`] is plain data over signals with one number per tick. A signal is true if its number is zero or more.
//! [`offline::evaluate`] judges a whole log, straight from the definitions. A [`Monitor`] takes one tick at a time in
//! storage that was allocated before, and reaches the same [`Outcome`]. The two share the definition of a [`Value`] and
//! nothing else. The definitions are in the book, "Expectations".

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
