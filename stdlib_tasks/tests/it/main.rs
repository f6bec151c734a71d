//! The task library from outside: rows against differences of the values that they speak of, closed loops, barriers
//! under attack, and the catalogue.

#![allow(clippy::unwrap_used, reason = "helpers of tests are tests too")]

mod accelerations;
mod axes;
mod barriers;
mod bound;
mod bounded_parts;
mod catalogue;
mod clearance;
mod common;
mod compliance;
mod cooperative;
mod curvature;
mod degenerate;
mod gradient_bound;
mod keep_clear;
mod limits;
mod look_at;
mod loops;
mod manipulability;
mod one_side;
mod people;
mod speed_separation;
mod stance;
mod targets;
