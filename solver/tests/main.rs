//! The hierarchical solver against independent ones, and its invariants: one file a subject.

mod active_set;
mod brute_force;
mod certified;
mod common;
mod contradiction;
mod deadline;
mod degenerate;
mod equalities;
mod invariants;
mod large;
mod smooth;
mod structure;
mod ticks;
