//! Stacks whose hard levels can always be met from a safe state, and the tasks that break this proof.

use crate::common;

use common::cli::{hierarq, text};
use runtime::feasibility::{Feasibility, Why, of_stacks};
use serde_json::Value;

/// The result for a stack with these levels.
fn of(levels: &str) -> Option<Feasibility> {
    let program = common::program_of(&format!(
        "hierarq 1
         robot arm {{ urdf \"robots/arm7.urdf\"  rate 100 Hz  points {{ tip tool }}  home {{ all [0, 0.4, 0, 1.6, 0, 1.14, 0] rad }} }}
         task still = virtual_wall(tip) {{ through [[0, 0, 0], [1, 0, 0], [0, 1, 0]] m }}
         task rising = virtual_wall(tip) {{ through [[0, 0, 0], [1, 0, 0], [0, 1, 0]] m  d_min 1 cm * sin(t/(1 s)) }}
         task reserved = virtual_wall(tip) {{ through [[0, 0, 0], [1, 0, 0], [0, 1, 0]] m  sampled_margin 1 cm }}
         task near = keep(frame(tool).position.x) {{ max 0.9 m }}
         task stay = hold(tool)
         stack s {{ {levels} }}
         run {{ stack s  duration 1 s }}\n"
    ));
    of_stacks(&program).pop()
}

/// Names and reasons of the tasks that break the proof.
fn obstacles(levels: &str) -> Vec<(String, Why)> {
    let found = of(levels).expect("hard levels");
    assert_eq!(found.never_infeasible, found.obstacles.is_empty());
    found.obstacles.into_iter().map(|o| (o.task, o.why)).collect()
}

#[test]
fn limits_that_stand_still_are_always_met() {
    let standing =
        "level limits hard { joint_position_limits  joint_velocity_limits }  level walls hard { still  near }";
    assert_eq!(obstacles(&format!("{standing}  level motion {{ stay }}")), []);
    assert_eq!(of("level motion { stay }"), None);
}

#[test]
fn what_breaks_the_proof_is_named() {
    let one = |name: &str, why| vec![(name.to_string(), why)];
    for (levels, name, why) in [
        ("level walls hard { rising }", "rising", Why::Moves),
        ("level walls hard { still  reserved }", "reserved", Why::Reserve),
        ("level walls hard { still }  level motion hard { stay }", "stay", Why::Target),
        ("level motion { stay }  level walls hard { still }", "stay", Why::SoftAbove),
        ("level limits hard { joint_acceleration_limits  still }", "joint_acceleration_limits", Why::Accelerations),
    ] {
        assert_eq!(obstacles(levels), one(name, why), "{levels}");
    }
}

#[test]
fn the_command_line_says_so() {
    let out = hierarq(&["compile", "examples/hello.hq"]);
    assert!(text(&out.stdout).contains("v = 0 meets every hard row"), "{}", text(&out.stdout));
    let out = hierarq(&["check", "--json", "examples/hello.hq"]);
    let report: Value = serde_json::from_slice(&out.stdout).expect("JSON");
    assert!(report["feasibility"][0]["never_infeasible"].is_boolean(), "{report:#}");
}
