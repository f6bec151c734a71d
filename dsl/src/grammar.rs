//! The pest grammar as a Rust type, private to this crate.

// The derive writes an enum without doc comments.
#![allow(missing_docs)]

/// Parser generated from `grammar.pest`, `machines.pest` and `missions.pest`.
#[derive(pest_derive::Parser)]
#[grammar = "grammar.pest"]
#[grammar = "machines.pest"]
#[grammar = "missions.pest"]
pub(crate) struct Grammar;

/// One node of a pest parse.
pub(crate) type Pair<'t> = pest::iterators::Pair<'t, Rule>;
