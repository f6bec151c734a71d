//! Tests of the complete program from outside: one file per subject, linked once. Tests that count allocations have a
//! binary of their own, since they count in all threads.

mod baselines;
mod command_line;
mod common;
mod context;
mod corpus;
mod declared;
mod documentation;
mod examples;
mod experiments;
mod faults;
mod fields;
mod files;
mod gantt;
mod graph;
mod hard_limits;
mod hard_motion;
mod humans;
mod idle;
mod imports;
mod labels;
mod layers_scenarios;
mod lsp;
mod machine;
mod mission_scenarios;
mod mission_workers;
mod missions;
mod periods;
mod plan_data;
mod planner;
mod reserve;
mod same_bytes;
mod scenarios;
#[cfg(feature = "serve")]
mod serve;
mod shared_control;
mod smoothness;
mod solve;
mod solvers;
mod supply_chain;
mod sweep;
mod task_names;
mod tools;
mod trajectories;
