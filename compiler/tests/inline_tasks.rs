//! Names of inline tasks: short, descriptive and unique.

use crate::common;

use common::state::ARM7;
use common::{compile_text, examples};
use dsl::Syntax;
use hierarq_compiler::Style;
use std::collections::BTreeSet;

/// Names of the tasks of some stacks.
fn names(stacks: &str) -> Vec<String> {
    let text = format!("hierarq 1\n{ARM7}{stacks}\nrun {{ stack s  duration 1 s }}\n");
    let compiled = compile_text(&text, Syntax::Native, &examples(), &[]);
    let program = compiled.program.unwrap_or_else(|| panic!("{}", compiled.report.render(Style::Plain, 100)));
    program.tasks.into_iter().map(|t| t.name).collect()
}

#[test]
fn the_only_one_of_its_type_is_called_after_it() {
    assert_eq!(names("stack s { level a { track(joint(joint_1)) { target 0 rad } } }"), ["track"]);
}

#[test]
fn several_are_called_after_what_they_are_about() {
    let stacks = "stack s {
        level a { track(joint(joint_1)) { target 0 rad }  track(joint(joint_2)) { target 0.1 rad } }
        level b { track(frame(tool).position.z) { target 0.4 m }  track(frame(tool).orientation) { target rpy(0, 0, 0) } }
        level c { keep(distance(finger, base_point)) { min 0 m }  keep(joint(joint_1)) { max 1 rad } }
        level d { track(joint(joint_1)) { target 0.2 rad }  track(joint(joint_1)) { target 0.3 rad }
                  track(joint(joint_1)) { target 0.4 rad }  track(joint(joint_1)) { target 0.5 rad } }
    }";
    let found = names(stacks);
    let expected = [
        "track.joint_1",
        "track.joint_2",
        "track.tool.z",
        "track.tool.orientation",
        "keep.finger.base_point",
        "keep.joint_1",
        "d.track.joint_1",
        "s.d.track.joint_1",
        "s.d.track.joint_1.2",
        "s.d.track.joint_1.3",
    ];
    assert_eq!(found, expected);
}

#[test]
fn the_same_in_two_stacks_is_told_apart_by_level_and_stack() {
    let stacks =
        "stack s { level a { joint_velocity_limits } }\nstack b from s { }\nstack c from b { }\nstack d from c { }";
    let found = names(stacks);
    assert_eq!(
        found,
        ["joint_velocity_limits", "a.joint_velocity_limits", "c.a.joint_velocity_limits", "d.a.joint_velocity_limits"]
    );
    assert_eq!(found.iter().collect::<BTreeSet<_>>().len(), found.len());
}
