//! Normalised trees: in the order of the YAML sections, so that a spec can be compared with its translation.

use crate::tree::{BlockKind, Item, ItemKind, MissionMember, MissionRepeat, Spec};
use crate::vocabulary::ROLES;

impl Spec {
    /// Returns the spec with its declarations sorted by kind, as YAML groups them: imports, allowed warnings, params, lets, robots,
    /// tasks, stacks, signals, variables, named blocks such as humans, machines, missions, scenarios, repetitions, coverage, run. The
    /// order within a kind is preserved.
    pub fn normalised(mut self) -> Spec {
        sort(&mut self.items);
        self
    }
}

fn sort(items: &mut [Item]) {
    const LAST: usize = 9 + BlockKind::ALL.len();
    items.sort_by_key(|item| match &item.kind {
        ItemKind::Import(_) => 0,
        ItemKind::Allow(_) => 1,
        ItemKind::Param(_) => 2,
        ItemKind::Let(_) => 3,
        ItemKind::Robot(_) => 4,
        ItemKind::Task(_) => 5,
        ItemKind::Stack(_) => 6,
        ItemKind::Signal(_) => 7,
        ItemKind::Variable(_) => 8,
        ItemKind::Block(block) => 9 + block.kind as usize,
        ItemKind::Machine(_) => LAST,
        ItemKind::Mission(_) => LAST + 1,
        ItemKind::Scenario(_) => LAST + 2,
        ItemKind::For(_) => LAST + 3,
        ItemKind::Coverage(_) => LAST + 4,
        ItemKind::Run(_) => LAST + 5,
    });
    for item in items {
        match &mut item.kind {
            ItemKind::For(repeat) => sort(&mut repeat.body),
            ItemKind::Mission(mission) => sort_members(&mut mission.members, &mut mission.repeats),
            _ => {}
        }
    }
}

/// Sorts members by role, in the order of the roles.
fn sort_members(members: &mut [MissionMember], repeats: &mut [MissionRepeat]) {
    members.sort_by_key(|member| ROLES.iter().position(|role| **role == *member.role));
    for member in members {
        sort_members(&mut member.members, &mut member.repeats);
    }
    for repeat in repeats {
        sort_members(&mut repeat.members, &mut repeat.repeats);
    }
}
