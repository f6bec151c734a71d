//! Planners and executors of missions: one file per subject.

#![allow(clippy::unwrap_used, reason = "a test that cannot unwrap fails")]

mod bases;
mod brute_force;
mod common;
mod events;
mod execution;
mod explore;
mod explore_bound;
mod explore_driven;
mod explore_execution;
mod explore_lattice;
mod explore_safe;
mod explored;
mod layered;
mod layers;
mod layers_execution;
mod layers_refusals;
mod occupancy;
mod pages;
mod random;
mod refusals;
mod search;
mod search_driven;
mod search_execution;
mod search_hidden;
mod search_messages;
mod search_people;
mod search_rates;
mod searched;
mod thesis;
