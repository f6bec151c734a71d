//! The compiler: from a spec to a program, with diagnostics that say what, where, why and what to do.
//!
//! [`compile`] reads a text, binds its names to a robot and to the task library, checks types, units and safety, and
//! lowers it to a [`runtime::Program`]. It knows nothing of how a hierarchy is solved.

mod accelerations;
mod binding;
mod bounds;
mod braking;
mod checks;
pub mod codes;
mod constants;
mod entries;
mod expand;
pub mod expr;
mod fitting;
mod follow_ons;
mod forms;
mod idle;
mod jumps;
mod known;
mod lowering;
mod machine;
mod named;
pub mod names;
mod one_place;
mod overridden;
mod paths;
mod planners;
mod pointless;
pub mod quantities;
mod ranges;
mod reach;
mod recording;
mod refused;
pub mod report;
mod robot_binding;
pub mod sections;
mod snippets;
mod spelling;
mod standing;
mod starts;
pub mod units;
mod window;

pub use expand::{Texts, files, parameter_types};
pub use idle::leave_out;
pub use lowering::{Compiled, Input, ParamValue, VERBS, Verb, compile, compile_among, params, signal_types};
pub use report::{Report, Style};
