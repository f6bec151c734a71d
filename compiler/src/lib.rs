//! The compiler: from a spec to a program, with diagnostics that say what, where, why and what to do.
//!
//! [`compile`] reads a text, binds its names to a robot and to the task library, checks types, units and safety, and
//! lowers it to a [`runtime::Program`]. It knows nothing of how a hierarchy is solved.
//!
//! The stages stand one above the other, and each knows only those below it: `compile` is the driver, `checks` look at the finished
//! program with `analysis`, `lowering` makes it of what `binding` and `robot_binding` bind, `expand` writes out imports, repetitions and
//! parameters, `expr` types expressions, `sections` declare the keys of all blocks, `diagnostics` make the report.

mod analysis;
mod binding;
mod checks;
mod cli_overrides;
mod compile;
mod diagnostics;
mod expand;
pub mod expr;
mod forms;
mod input;
mod lowering;
mod named;
mod paths;
pub mod quantities;
mod recording;
mod robot_binding;
pub mod sections;
mod source_map;
pub mod units;

pub use ::names;
pub use analysis::idle_rows::leave_out;
pub use compile::{compile, compile_among, params};
pub use diagnostics::report::{Report, Style};
pub use diagnostics::{codes, report};
pub use expand::{files, parameter_types};
pub use input::{Compiled, Input, Texts};
pub use lowering::{ParamValue, VERBS, Verb, signal_types};
