//! Limits of a state are checked at its entry: at home for the first states of a run, and not at all for later ones.

use crate::common;

use common::{compile_text, examples, whole};
use dsl::{Severity, SourceId, Syntax};

/// Diagnostics of a spec, equal in both syntaxes: `HQ0502 error`.
fn said(body: &str) -> Vec<String> {
    let hq = whole(body, Syntax::Native, true, false);
    let (spec, _) = dsl::parse(SourceId(0), &hq, Syntax::Native);
    let yaml = dsl::print(&spec, Syntax::Yaml);
    let [a, b] = [(hq, Syntax::Native), (yaml, Syntax::Yaml)].map(|(text, syntax)| {
        let compiled = compile_text(&text, syntax, &examples(), &[]);
        let word = |s: Severity| if s == Severity::Error { "error" } else { "warning" };
        let mut said: Vec<String> =
            compiled.report.diagnostics.iter().map(|d| format!("{} {}", d.code, word(d.severity))).collect();
        said.sort();
        said
    });
    assert_eq!(a, b, "both syntaxes");
    a
}

/// A machine with two states, the second one with a limit that is violated at home.
fn spec(level: &str, first: &str, way: &str) -> String {
    format!(
        "task here = hold(tool)
task above = keep(frame(tool).position.z) {{ min 5 m }}
stack still {{ level limits hard {{ joint_position_limits  joint_velocity_limits }}  level motion {{ here }} }}
stack later {{ level limits hard {{ joint_position_limits  joint_velocity_limits }}  level bin {level} {{ above }}  level motion {{ here }} }}
machine m {{ initial a  blend 0.2 s  on fault(any) -> done
  state a {{ stack {first}  {way} }}
  state b {{ stack later  after 1 s -> done }}
  final state done }}
"
    )
    .replace("min 5 m", "min 0.9 m")
}

#[test]
fn a_limit_of_a_later_state_is_not_judged_at_home() {
    let none: [&str; 0] = [];
    assert_eq!(said(&spec("", "still", "after 1 s -> b")), none);
    let dropped = ["HQ0708 warning"];
    assert_eq!(said(&spec("hard", "still", "after 1 s -> b")), dropped);
}

#[test]
fn a_limit_of_the_initial_state_is() {
    assert!(said(&spec("hard", "later", "after 1 s -> b")).contains(&"HQ0502 error".to_string()));
    // The stack also runs in a later state, but it is entered at home nevertheless.
    let soft = said(&spec("", "later", "after 1 s -> b"));
    assert!(soft.contains(&"HQ0502 warning".to_string()), "{soft:?}");
    assert!(!soft.iter().any(|s| s.ends_with("error")), "{soft:?}");
}

#[test]
fn so_is_that_of_a_state_that_is_entered_before_the_robot_moves() {
    for way in ["after 0 s -> b", "after 10 ms -> b"] {
        assert!(said(&spec("hard", "still", way)).contains(&"HQ0502 error".to_string()), "{way}");
    }
    assert!(!said(&spec("hard", "still", "after 50 ms -> b")).iter().any(|s| s.starts_with("HQ0502")));
}

#[test]
fn a_stack_that_is_run_by_itself_is_judged_at_home() {
    let by_itself = format!("{}run {{ stack later  duration 2 s }}\n", spec("hard", "still", "after 1 s -> b"));
    assert!(said(&by_itself).contains(&"HQ0502 error".to_string()));
    let in_a_scenario =
        format!("{}scenario alone {{ stack later  duration 2 s }}\n", spec("hard", "still", "after 1 s -> b"));
    let said = said(&in_a_scenario);
    assert!(said.contains(&"HQ0806 warning".to_string()), "{said:?}");
    assert!(!said.iter().any(|s| s.ends_with("error")), "{said:?}");
}

#[test]
fn hard_levels_of_a_later_state_are_judged_as_far_as_the_place_does_not_matter() {
    let with = |task: &str| {
        format!(
            "{task}
task here = hold(tool)
stack still {{ level limits hard {{ joint_velocity_limits }}  level motion {{ here }} }}
stack later {{ level limits hard {{ joint_velocity_limits }}  level second hard {{ push }} }}
machine m {{ initial a  blend 0.2 s  on fault(any) -> done
  state a {{ stack still  after 1 s -> b }}
  state b {{ stack later  after 1 s -> done }}
  final state done }}
"
        )
    };
    let error = "HQ0504 error".to_string();
    // Faster than the joint's limit, at every configuration.
    assert!(said(&with("task push = joint_velocity { velocity { joint_1 5 rad/s } }")).contains(&error));
    // Far from home, but close to other configurations.
    let far = "task push = joint_position { target { joint_1 2 rad }  gain 5 /s }";
    assert!(!said(&with(far)).iter().any(|s| s.ends_with("error")));
    // The root of a negative number at every configuration; and one that depends on the configuration.
    let root =
        |of: &str| with(&format!("task push = joint_velocity {{ velocity {{ joint_1 1 rad/s * sqrt({of}) }} }}"));
    assert!(said(&root("t/(1 s)")).contains(&"HQ0502 error".to_string()));
    let place = said(&root("initial(frame(tool).position.z)/(1 m) - 0.99"));
    assert!(!place.iter().any(|s| s.ends_with("error")), "{place:?}");
}

#[test]
fn what_needs_no_signal_is_judged_at_home_in_a_stack_that_needs_one() {
    let with = |level: &str, limit: &str| {
        format!(
            "signal goal : point {{ timeout 0.5 s }}
task above = {limit}
task follow = frame_position(tool) {{ position goal  gain 1 /s }}
stack s {{ level limits hard {{ joint_position_limits  joint_velocity_limits }}  level bin {level} {{ above }}  level motion {{ follow }} }}
run {{ stack s  duration 2 s }}
"
        )
    };
    let too_high = "keep(frame(tool).position.z) { min 0.9 m }";
    let said = |level: &str, limit: &str| -> Vec<String> {
        said(&with(level, limit)).into_iter().filter(|s| s.starts_with("HQ050")).collect()
    };
    assert_eq!(said("hard", too_high), ["HQ0502 error"]);
    assert_eq!(said("", too_high), ["HQ0502 warning"]);
    let none: [&str; 0] = [];
    assert_eq!(said("hard", "keep(frame(tool).position.z) { min 0.1 m }"), none);
    // The distance from a signal is unknown.
    assert_eq!(said("hard", "keep(norm(frame(tool).position - goal)) { min 5 m }"), none);
    // Too fast for a joint, whatever the signal is.
    let fast = "joint_velocity { velocity { joint_1 5 rad/s } }";
    assert_eq!(said("hard", fast), ["HQ0504 error"]);
}
