//! Trees in the order of the YAML sections, so that a spec can be compared with its translation.

use crate::tree::{Item, ItemKind, Spec};

impl Spec {
    /// The same spec with its declarations sorted by kind as YAML groups them: imports, params, lets, robots, tasks,
    /// stacks, signals, variables, humans, safety fields, machines, scenarios, repetitions, run. Within a kind the order stays.
    pub fn normalised(mut self) -> Spec {
        sort(&mut self.items);
        self
    }
}

fn sort(items: &mut [Item]) {
    items.sort_by_key(|item| match item.kind {
        ItemKind::Import(_) => 0,
        ItemKind::Param(_) => 1,
        ItemKind::Let(_) => 2,
        ItemKind::Robot(_) => 3,
        ItemKind::Task(_) => 4,
        ItemKind::Stack(_) => 5,
        ItemKind::Signal(_) => 6,
        ItemKind::Variable(_) => 7,
        ItemKind::Human(_) => 8,
        ItemKind::SafetyField(_) => 9,
        ItemKind::Machine(_) => 10,
        ItemKind::Scenario(_) => 11,
        ItemKind::For(_) => 12,
        ItemKind::Run(_) => 13,
    });
    for item in items {
        if let ItemKind::For(repeat) = &mut item.kind {
            sort(&mut repeat.body);
        }
    }
}
