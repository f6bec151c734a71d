//! Search: a team collects reward on a map, Dalmasso et al. 2023, "Shared Task Representation for Human-Robot Collaborative
//! Navigation" (`srs`).
//!
//! [`problem::Problem`] describes the map, the team, its sources of reward and what is hidden, [`check`] reports mistakes, [`choose::plan`]
//! plans: [`ways`] are the action sets, [`tree`] grows trees of ways, [`tree_search`] searches plans of the team, [`greedy`] is
//! a baseline. [`sight`] says which parts of the ground see one another, [`belief`] where hidden objects may be, [`lookouts`] from
//! where agents look for them. [`reward`] computes rewards, [`validate::validate`] checks a plan against the problem alone, [`execution`]
//! simulates the world in which a plan is executed and plans anew after events.

pub mod belief;
pub mod blocks;
mod build;
pub mod chart;
pub mod check;
mod check_objects;
mod check_people;
pub mod choose;
mod event;
pub mod execution;
pub mod geometry;
pub mod greedy;
pub mod ground;
pub mod habits;
pub mod habits_blocks;
mod horizon;
pub mod lookouts;
pub mod map;
mod map_file;
mod mission;
mod pages;
pub mod plan;
pub mod planned;
pub mod problem;
pub mod reward;
pub mod roads;
mod run;
pub mod sight;
mod source;
pub mod team;
mod text;
pub mod tree;
pub mod tree_search;
pub mod validate;
mod validate_looks;
mod validate_map;
pub mod ways;

pub use self::mission::{KIND, Search};
