//! The kinds of mission, a folder each.
//!
//! - [`schedule`]: robots that serve agents at the end of their operations, thesis chapter 5.
//! - [`layers`]: tasks in ordered layers, each with an agent and an object, thesis chapter 6.

pub mod layers;
pub mod schedule;

use std::ops::Deref;

use serde::{Deserialize, Serialize};

use crate::kind;

/// The entries of all kinds.
pub static KINDS: &[&kind::Kind] = &[&schedule::KIND, &layers::KIND];

/// The entry of this name.
pub fn find(name: &str) -> Option<&'static kind::Kind> {
    KINDS.iter().find(|kind| kind.name == name).copied()
}

/// A mission of one of the kinds: the list of them, which is the only place outside their folders that names them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mission {
    /// Robots that serve agents at the end of their operations.
    Schedule(schedule::Schedule),
    /// A team that does layers of tasks.
    Layers(layers::Layers),
}

impl Deref for Mission {
    type Target = dyn kind::Mission;

    fn deref(&self) -> &Self::Target {
        match self {
            Mission::Schedule(schedule) => schedule,
            Mission::Layers(layers) => layers,
        }
    }
}
