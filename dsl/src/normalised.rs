//! Trees in the order of the YAML sections, so that a spec can be compared with its translation.

use crate::tree::{ItemKind, Spec};

impl Spec {
    /// The same spec with its declarations sorted by kind as YAML groups them: params, robots, tasks, stacks, run.
    /// Within a kind the order stays.
    pub fn normalised(mut self) -> Spec {
        self.items.sort_by_key(|item| match item.kind {
            ItemKind::Param(_) => 0,
            ItemKind::Robot(_) => 1,
            ItemKind::Task(_) => 2,
            ItemKind::Stack(_) => 3,
            ItemKind::Run(_) => 4,
        });
        self
    }
}
