//! The compiler: from a spec to a program, with diagnostics that say what, where, why and what to do.
//!
//! [`compile`] reads a text, binds its names to a robot and to the task library, checks types, units and safety, and
//! lowers it to a [`runtime::Program`]. It knows nothing of how a hierarchy is solved.

mod binding;
mod checks;
pub mod codes;
mod constants;
mod expand;
pub mod expr;
mod forms;
mod lowering;
mod named;
pub mod names;
mod paths;
pub mod report;
mod robot_binding;
mod spelling;
pub mod units;

pub use expand::{files, parameter_types};
pub use lowering::{Compiled, Input, compile};
pub use report::{Report, Style};
