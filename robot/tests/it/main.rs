//! Tests of the crate from outside, in one program.
#![allow(non_snake_case, reason = "frames stand in the names: X_WL, p_W")]
#![allow(clippy::unwrap_used, reason = "a test may fail that way")]

mod common;
mod contacts;
mod distances;
mod followers;
mod jacobians;
mod loading;
mod manifold;
mod merged;
mod meshes;
mod oddities;
mod oracle;
mod pieces;
mod pinocchio;
mod refusals;
mod soups;
mod srdf;
