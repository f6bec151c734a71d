//! The compiler warns of stacks that move joints without a bound of their accelerations, and of no others.

use crate::common;

use common::{compile_text, examples, whole};
use dsl::{SourceId, Syntax};

/// Codes of the diagnostics of a spec, which must be equal in both syntaxes.
fn codes(body: &str) -> Vec<&'static str> {
    let hq = whole(body, Syntax::Native, true, false);
    let (spec, _) = dsl::parse(SourceId(0), &hq, Syntax::Native);
    let yaml = dsl::print(&spec, Syntax::Yaml);
    let [a, b] = [(hq, Syntax::Native), (yaml, Syntax::Yaml)].map(|(text, syntax)| {
        let report = compile_text(&text, syntax, &examples(), &[]).report;
        // These stacks bound accelerations alone, or nothing.
        let others = ["HQ0560", "HQ0561"];
        report.diagnostics.iter().map(|d| d.code).filter(|c| !others.contains(c)).collect::<Vec<_>>()
    });
    assert_eq!(a, b, "both syntaxes");
    a
}

const NONE: [&str; 0] = [];
const UNBOUNDED: [&str; 1] = ["HQ0525"];

const REACH: &str = "task reach = frame_position(tool) { position [0.5, 0.1, 0.5] m }\n";

#[test]
fn bounds_count_on_hard_levels_and_above_the_targets() {
    let stack = |levels: &str| codes(&format!("{REACH}stack s {{ {levels} }}\n"));
    assert_eq!(stack("level limits hard { joint_velocity_limits }  level motion { reach }"), UNBOUNDED);
    assert_eq!(stack("level limits hard { joint_acceleration_limits }  level motion { reach }"), NONE);
    assert_eq!(stack("level gentle { joint_acceleration_limits }  level motion { reach }"), NONE);
    assert_eq!(stack("level motion { reach  joint_acceleration_limits }"), UNBOUNDED);
    assert_eq!(stack("level motion { reach }  level gentle { joint_acceleration_limits }"), UNBOUNDED);
}

#[test]
fn what_stands_still_needs_no_bounds() {
    let stack = |tasks: &str| codes(&format!("{tasks}\nstack s {{ level one {{ one }} }}\n"));
    assert_eq!(stack("task one = hold(tool)"), NONE);
    assert_eq!(stack("task one = joint_velocity { velocity { all 0 rad/s } }"), NONE);
    assert_eq!(stack("task one = frame_position(tool) { position initial(position) }"), NONE);
    assert_eq!(stack("task one = track(frame(tool).position.z) { target initial(value) }"), NONE);
    assert_eq!(stack("task one = virtual_wall(elbow) { through [[0, 0, 0], [1, 0, 0], [0, 1, 0]] m }"), NONE);
}

#[test]
fn what_moves_does() {
    let stack = |tasks: &str| codes(&format!("{tasks}\nstack s {{ level one {{ one }} }}\n"));
    assert_eq!(stack("task one = joint_velocity { velocity { all 0.1 rad/s } }"), UNBOUNDED);
    assert_eq!(stack("task one = frame_position(tool) { position initial(position) + [0, 0, 0.1] m }"), UNBOUNDED);
    assert_eq!(
        stack("task one = frame_position(tool) { position initial(position) + [0, 0, 0.1] m * sin(1 rad/s * t) }"),
        UNBOUNDED
    );
    assert_eq!(
        stack("signal goal : point  timeout 0.2 s\ntask one = frame_position(tool) { position goal }"),
        UNBOUNDED
    );
    let people = "human operator { points [chest]  velocity measured }\n";
    let apart = "task one = keep(norm(frame(tool).position - operator.chest)) { min 0.4 m }";
    assert_eq!(stack(&format!("{people}{apart}")), NONE);
    let beside = "stack s { level people hard { apart }  level motion { stay } }";
    let stay = "task stay = hold(tool)\n";
    assert_eq!(codes(&format!("{people}{stay}{}\n{beside}\n", apart.replace("one =", "apart ="))), UNBOUNDED);
}

#[test]
fn only_joints_that_the_stack_moves_count() {
    let stack = |limits: &str, task: &str, lock: &str| {
        codes(&format!("{task}\nstack s {{ {lock}  level limits hard {{ {limits} }}  level motion {{ one }} }}\n"))
    };
    let first = "task one = joint_velocity { velocity { joint_1 0.2 rad/s } }";
    assert_eq!(stack("joint_acceleration_limits(joint_1)", first, ""), NONE);
    assert_eq!(stack("joint_acceleration_limits(joint_2)", first, ""), UNBOUNDED);
    let reach = "task one = track(frame(tool).position.z) { target 0.3 m }";
    assert_eq!(stack("joint_acceleration_limits(upper)", reach, ""), UNBOUNDED);
    let rest = "lock [joint_3, joint_4, joint_5, joint_6, joint_7]";
    assert_eq!(stack("joint_acceleration_limits(upper)", reach, rest), NONE);
}

#[test]
fn a_jump_between_stacks_is_told_once() {
    let machine = |first: &str, second: &str| {
        codes(&format!(
            "{REACH}stack a {{ level limits hard {{ joint_velocity_limits  {first} }}  level motion {{ hold(tool) }} }}
stack b {{ level limits hard {{ joint_velocity_limits  {second} }}  level motion {{ reach }} }}
machine m {{ initial one  on fault(any) -> stopped
  state one {{ stack a  after 1 s -> two }}
  state two {{ stack b  after 1 s -> three }}
  state three {{ stack a  after 1 s -> stopped }}
  final state stopped }}
"
        ))
    };
    let limits = "joint_acceleration_limits";
    assert_eq!(machine(limits, limits), NONE);
    // The transition back to stack `a` may jump; `a` itself only holds the tool and moves nothing.
    assert_eq!(machine("", ""), ["HQ0525", "HQ0709"]);
    assert_eq!(machine("joint_position_limits", "joint_position_limits  joint_acceleration_limits"), ["HQ0709"]);
}
