//! Hierarq: a declarative language and compiler for task hierarchies of robots that work beside people.
//!
//! This library is the facade over the crates that do the work, and holds two parts that only the command line needs:
//! new projects and the kinds of files that it writes.
//!
//! | crate | is |
//! |---|---|
//! | [`dsl`] | the language: two syntaxes, one tree |
//! | [`compiler`] | names, types, units, checks, lowering |
//! | [`stdlib_tasks`] | the task types |
//! | [`robot`] | URDF, kinematics, distances |
//! | [`solver`] | the hierarchical quadratic program |
//! | [`runtime`] | programs, the controller, the simulated robot |
//! | [`mission`] | planners of missions, plans as data, execution |
//! | [`runs`] | specs read and compiled, scenarios, sweeps |
//! | [`views`] | reports, charts, drawings of machines |
//! | [`ide`] | the language server, the catalogue, the schema |
//! | `logs` | logs of runs in MCAP |
//! | `ros` | a node of ROS 2 |
//! | `serve` | web pages of a mission |

pub use compiler;
pub use dsl;
pub use ide;
#[cfg(feature = "mcap")]
pub use logs;
pub use mission;
pub use robot;
#[cfg(feature = "ros")]
pub use ros;
pub use runs;
pub use runtime;
#[cfg(feature = "serve")]
pub use serve;
pub use solver;
pub use stdlib_tasks;
pub use views;

#[cfg(feature = "lsp")]
pub use ide::lsp;
pub use ide::{catalogue, keys, schema};
#[cfg(feature = "sweep")]
pub use runs::sweep;
pub use runs::{diff, mend, project, qp_log, scenario_runner};
pub use views::{gantt, graph, report, xml};

pub mod init;
pub mod outputs;
