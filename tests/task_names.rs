//! Outside of the library, task types are identified by their properties, not by their names. The remaining uses of
//! names are in a list that may only become shorter.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::common::sources;

/// Task type, and the file that contains its name in quotes. `hold` is also an option of a trajectory, of humans and of signals.
const NAMED: [(&str, &str); 31] = [
    ("frame_pose", "compiler/src/checks/conflicting_targets.rs"),
    ("frame_position", "compiler/src/checks/conflicting_targets.rs"),
    ("hold", "compiler/src/expr/trajectories.rs"),
    ("hold", "compiler/src/lowering/humans.rs"),
    ("hold", "compiler/src/sections/human.rs"),
    ("hold", "compiler/src/sections/machine.rs"),
    ("hold", "runs/src/sweep/digest.rs"),
    ("joint_acceleration_limits", "compiler/src/checks/braking.rs"),
    ("joint_acceleration_limits", "src/init/spec.rs"),
    ("joint_position", "compiler/src/checks/ineffective.rs"),
    ("joint_position_limits", "compiler/src/checks/accelerations.rs"),
    ("joint_position_limits", "compiler/src/checks/braking.rs"),
    ("joint_position_limits", "compiler/src/checks/wider_limits.rs"),
    ("joint_position_limits", "src/init/spec.rs"),
    ("joint_velocity", "compiler/src/checks/accelerations.rs"),
    ("joint_velocity", "compiler/src/checks/entries.rs"),
    ("joint_velocity_limits", "compiler/src/checks/accelerations.rs"),
    ("joint_velocity_limits", "compiler/src/checks/built_stacks.rs"),
    ("joint_velocity_limits", "compiler/src/checks/wider_limits.rs"),
    ("joint_velocity_limits", "compiler/src/checks/entries.rs"),
    ("joint_velocity_limits", "src/init/spec.rs"),
    ("keep", "compiler/src/binding/scope.rs"),
    ("keep", "compiler/src/checks/scenario_start.rs"),
    ("safety_planner", "compiler/src/checks/safety_planners.rs"),
    ("safety_planner", "runtime/src/planning/settings.rs"),
    ("self_collision", "compiler/src/checks/first_tick.rs"),
    ("self_collision", "views/src/report/scene.rs"),
    ("speed_separation", "compiler/src/checks/accelerations.rs"),
    ("track", "compiler/src/checks/ineffective.rs"),
    ("virtual_wall", "compiler/src/checks/first_tick.rs"),
    ("virtual_wall", "views/src/report/scene.rs"),
];

/// Returns the sources of all crates but the library of tasks without their tests, each with its path from the root.
fn program_sources() -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let files = sources::of_crates(|name| name != "stdlib_tasks");
    let read = |file: &PathBuf| {
        let name = file.strip_prefix(root).expect("below").to_string_lossy().replace('\\', "/");
        let text = std::fs::read_to_string(file).expect("text");
        (name, text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default().to_string())
    };
    files.iter().map(read).collect()
}

#[test]
fn task_types_are_named_in_the_library_alone() {
    let mut found = BTreeSet::new();
    for (name, text) in program_sources() {
        for kind in stdlib_tasks::KINDS {
            if text.contains(&format!("\"{}\"", kind.name)) {
                found.insert((kind.name, name.clone()));
            }
        }
    }
    let known: BTreeSet<(&str, String)> = NAMED.iter().map(|(kind, file)| (*kind, file.to_string())).collect();
    let new: Vec<_> = found.difference(&known).collect();
    assert!(new.is_empty(), "known by name, and not by a property of the type: {new:?}");
    let gone: Vec<_> = known.difference(&found).collect();
    assert!(gone.is_empty(), "no longer named there: {gone:?}");
}

/// Files outside the folders of the kinds of mission that still name a kind.
const NAMING_KINDS: &[&str] = &[];

/// Words that name a kind of mission.
const KINDS: [&str; 10] = [
    "kinds::schedule",
    "kinds::layers",
    "kinds::search",
    "kinds::explore",
    "Mission::Schedule",
    "Mission::Layers",
    "\"schedule\"",
    "\"layers\"",
    "\"search\"",
    "\"explore\"",
];

#[test]
fn kinds_of_missions_are_named_in_their_folders() {
    let mut found = BTreeSet::new();
    for (name, text) in program_sources() {
        let names = |line: &str| !line.trim_start().starts_with("//") && KINDS.iter().any(|word| line.contains(word));
        if !name.starts_with("mission/src/kinds/") && text.lines().any(names) {
            found.insert(name);
        }
    }
    let known: BTreeSet<String> = NAMING_KINDS.iter().map(|file| (*file).to_string()).collect();
    let new: Vec<_> = found.difference(&known).collect();
    assert!(new.is_empty(), "a kind of mission is known by name, and not by its entry: {new:#?}");
    let gone: Vec<_> = known.difference(&found).collect();
    assert!(gone.is_empty(), "these name no kind any more; take them out of the list: {gone:#?}");
}
