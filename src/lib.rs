//! Hierarq: a declarative language and compiler for task hierarchies of robots that work beside people.
//!
//! This library is the facade over the crates that do the work, and holds what the command line needs beside them:
//! reading files, the report of a run, the pages of the documentation.
//!
//! | crate | is |
//! |---|---|
//! | [`dsl`] | the language: two spellings, one tree |
//! | [`compiler`] | names, types, units, checks, lowering |
//! | [`stdlib_tasks`] | the task types |
//! | [`robot`] | URDF, kinematics, distances |
//! | [`solver`] | the hierarchical quadratic program |
//! | [`runtime`] | programs, the controller, the simulated robot |
//! | [`mission`] | planners of missions, and their execution |

pub use compiler;
pub use dsl;
pub use mission;
pub use robot;
pub use runtime;
pub use solver;
pub use stdlib_tasks;

pub mod catalogue;
pub mod gantt;
pub mod graph;
pub mod init;
pub mod keys;
pub mod lsp;
pub mod outputs;
pub mod plan_data;
pub mod planned;
pub mod project;
pub mod report;
pub mod schema;
#[cfg(feature = "serve")]
pub mod serve;
pub mod sweep;
pub mod trial;
pub mod xml;
