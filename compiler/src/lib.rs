//! The compiler: translates a spec to a program, with diagnostics that report the mistake, its place, its reason and a
//! fix.
//!
//! [`compile`] reads a text, binds its names to a robot and to the task library, checks types, units and safety, and
//! lowers it to a [`runtime::Program`]. It does not depend on how a hierarchy is solved.
//!
//! The stages form layers, each of which depends only on those below it: `compile` is the driver; `checks` examines the
//! finished program with `analysis`; `lowering` builds it from the results of `binding` and `robot_binding`; `expand`
//! resolves imports, repetitions and parameters; `block_binding` binds blocks by their schemas; `expr` types expressions; `sections` declares the keys of all blocks;
//! `diagnostics` builds the report. `resolve` gives editors the symbols and references of a spec, by the scopes of
//! `expand` and the tables of `sections`.

mod analysis;
mod binding;
mod block_binding;
mod checks;
mod cli_overrides;
mod compile;
mod demands;
mod diagnostics;
mod expand;
pub mod expr;
mod forms;
mod input;
mod let_bindings;
mod lowering;
mod mesh_facts;
mod paths;
mod recording;
pub mod resolve;
mod robot_binding;
mod robot_facts;
mod sampled;
pub mod sections;
mod source_map;
pub mod units;

pub use ::names;
pub use analysis::idle_rows::mark_idle_rows;
pub use checks::coverage;
pub use compile::{compile, compile_among, compile_deep, compile_unread, params};
pub use demands::JointQuantity;
pub use diagnostics::report::{Report, Style};
pub use diagnostics::{codes, report};
pub use expand::{files, parameter_types};
pub use input::{Compiled, Input, Texts};
pub use lowering::{ParamValue, VERBS, Verb, signal_types};
pub use mesh_facts::{MeshFacts, ShapeFacts, mesh_facts};
pub use robot_facts::{GroupFacts, PairFacts, PostureFacts, RobotFacts, robot_facts};
pub use sampled::{Contacts, Deep, Freedom, Sampled, SampledStack};
