//! The kinds of mission, a folder each.
//!
//! - [`schedule`]: robots that serve agents at the end of their operations, thesis chapter 5.
//! - [`layers`]: tasks in ordered layers, each with an agent and an object, thesis chapter 6.
//! - [`search`]: a team that collects reward on a map, Dalmasso et al. 2023.
//! - [`explore`]: robots that take over the targets which a person leaves, Caregnato-Neto et al. 2025.

pub mod explore;
pub mod layers;
pub mod schedule;
pub mod search;

use blocks::BlockSchema;

use crate::kind::Kind;

/// Lists the kinds: the only list that names them outside their folders.
macro_rules! kinds {
    ($($kind:ident),*) => {
        /// The entries of all kinds.
        pub static KINDS: &[&Kind] = &[$(&$kind::KIND),*];

        /// A mission: the keys that name its kind.
        pub static MISSION: BlockSchema = BlockSchema { name: "a mission", keys: &[$($kind::KIND.key()),*] };
    };
}

kinds!(schedule, layers, search, explore);

/// The entry of this name.
pub fn find(name: &str) -> Option<&'static Kind> {
    KINDS.iter().find(|kind| kind.name == name).copied()
}

/// The JSON Schema of the plans of all kinds.
pub fn plan_schema() -> serde_json::Value {
    let forms: Vec<_> = KINDS.iter().map(|kind| kind.plan_form()).collect();
    crate::plan_data::schema(&forms)
}
