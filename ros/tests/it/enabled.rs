//! Signals that enable a robot: latched by a driver that speaks when something changes, or sent again and again.

use ros::Remark;
use runs::project::{Settings, load};
use runtime::Program;
use serde_json::{Value, json};

use crate::peers::{Run, interpreter, run};
use crate::specs::{arm, program};

/// An arm whose first joint turns by 0.2 rad/s while a flag is true.
fn turning(timeout: &str, form: &str, latched: bool) -> Program {
    program(
        &(format!("signal drives_on : flag {timeout}\n")
            + &arm("enabled drives_on } ")
            + &format!(
                "task turn = joint_velocity {{ velocity {{ shoulder_pan_joint 0.2 rad/s }} }}
                 stack s {{ level limits hard {{ joint_velocity_limits  joint_acceleration_limits }}  level move {{ turn }} }}
                 run {{ stack s  duration 1 s  ros {{ stale_after 3 s
                   commands {{ arm {{ topic \"~/commands\"  form {form} }} }}
                   signals {{ drives_on {{ topic \"/robot_program_running\"  latched {latched} }} }} }} }}"
            )),
    )
}

/// Mean velocity of the first joint (rad/s) in a time (s).
fn speed(seen: &Value, from: f64, to: f64) -> f64 {
    let way: Vec<[f64; 2]> = serde_json::from_value(seen["way"].clone()).expect("times and angles");
    let within: Vec<&[f64; 2]> = way.iter().filter(|[t, _]| (from..=to).contains(t)).collect();
    let [first, last] = [within.first().expect("a time"), within.last().expect("a time")];
    (last[1] - first[1]) / (last[0] - first[0])
}

/// Checks that the joint turns in some times (s), stands in others, and is nowhere faster than it is told.
fn check(run: &Run, turns: &[[f64; 2]], stands: &[[f64; 2]]) {
    let Run { ended, remarks, seen } = run;
    assert!(!ended.is_halted, "{ended:?} {remarks:?}");
    for [from, to] in turns {
        let v = speed(seen, *from, *to);
        assert!((v - 0.2).abs() < 0.03, "{v} rad/s from {from} to {to} s: {remarks:?} {}", seen["answers"]);
    }
    for [from, to] in stands {
        let v = speed(seen, *from, *to);
        assert!(v.abs() < 1e-3, "{v} rad/s from {from} to {to} s: {remarks:?} {}", seen["answers"]);
    }
}

/// Answers of services: true if they did what was asked.
fn answers(run: &Run) -> Vec<bool> {
    let all: Vec<(bool, String)> = serde_json::from_value(run.seen["answers"].clone()).expect("answers");
    all.iter().map(|(done, _)| *done).collect()
}

#[test]
fn a_latched_signal_that_is_sent_once_enables_the_robot() {
    let Some(python) = interpreter() else { return };
    let program = turning("", "velocity", true);
    // The first message is sent before the node can be known; at the end the publisher goes and another one comes.
    let on = json!([[0.0, true], [4.0, false], [5.0, true], [7.5, null], [8.5, true]]);
    let resume = "/hierarq/motion/resume";
    let to_do = json!({
        "seconds": 11.0, "traces": true, "latched": { "/robot_program_running": on }, "pushes": [[4.5, 0.3]],
        "calls": [[4.6, resume], [6.0, resume], [9.5, resume]],
    });
    let run = run(&program, &python, to_do);
    check(&run, &[[3.0, 3.9], [6.5, 7.4], [10.0, 10.9]], &[[4.3, 4.45], [4.6, 5.9], [7.9, 9.4]]);
    assert_eq!(answers(&run), [false, true, true], "{}", run.seen["answers"]);
    assert!(
        run.seen["largest"].as_f64() < Some(0.25),
        "nothing drives back to the place before: {}",
        run.seen["largest"]
    );
}

#[test]
fn a_signal_that_is_sent_again_and_again_enables_the_robot_until_it_is_old() {
    let Some(python) = interpreter() else { return };
    let program = turning("timeout 0.3 s", "position", false);
    let to_do = json!({
        "seconds": 7.5, "traces": true, "form": "position", "mute": [4.0, 5.0], "calls": [[6.0, "/hierarq/motion/resume"]],
        "flags": { "on": "/robot_program_running" }, "values": { "on": true },
    });
    let run = run(&program, &python, to_do);
    check(&run, &[[3.0, 3.9], [6.5, 7.4]], &[[4.45, 4.55], [4.7, 5.9]]);
    assert_eq!(answers(&run), [true]);
}

#[test]
fn publishers_that_latch_where_nobody_expects_it_are_told() {
    let Some(python) = interpreter() else { return };
    let told = |latched: bool, more: Value| {
        let mut to_do = json!({ "seconds": 4.5 });
        to_do.as_object_mut().expect("an object").extend(more.as_object().expect("an object").clone());
        run(&turning("", "velocity", latched), &python, to_do).remarks
    };
    let topic = String::from("/robot_program_running");
    let flags = json!({ "flags": { "on": topic }, "values": { "on": true } });
    let remark = Remark::NotLatched { topic: topic.clone() };
    assert!(told(true, flags).contains(&remark), "a reader of latched messages reads no others");
    let remark = Remark::Latched { topic };
    assert!(told(false, json!({ "latched": { "/robot_program_running": [[0.0, true]] } })).contains(&remark));
}

#[test]
fn both_spellings_say_that_a_topic_is_latched() {
    let native = turning("", "velocity", true).run.ros.expect("a connection");
    let urdf = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/robots/ur5.urdf");
    let file = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("latched-{}.yaml", std::process::id()));
    let text = format!(
        "hierarq: 1
signals: {{ drives_on: {{ type: flag }} }}
robots: {{ arm: {{ urdf: \"{urdf}\", rate: 100 Hz, enabled: drives_on }} }}
stacks: {{ s: {{ levels: [{{ name: limits, hard: true, tasks: [joint_velocity_limits] }}] }} }}
run: {{ stack: s, duration: 1 s, ros: {{ signals: {{ drives_on: {{ topic: /robot_program_running, latched: true }} }} }} }}
"
    );
    std::fs::write(&file, text).expect("a folder that can be written");
    let compiled = load(&file, &Settings::default());
    let program = compiled.program.unwrap_or_else(|| panic!("{}", compiled.report.render(compiler::Style::Plain, 100)));
    let other = program.run.ros.expect("a connection");
    assert!(native.signals[0].latched && native.signals == other.signals, "{native:?} {other:?}");
}
