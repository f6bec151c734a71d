//! A node and an independent participant: a robot on CycloneDDS, in Python.
//!
//! The tests run where `HIERARQ_PYTHON` names an interpreter with the package `cyclonedds`. Each has a domain of its own.

use std::io::Read;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU16, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use ros::{Ended, Remark, ServiceMapping, Settings};
use runtime::Program;
use runtime::record::All;
use serde_json::{Value, json};

use crate::specs::{arm, program};

/// An interpreter with CycloneDDS, if there is one.
fn interpreter() -> Option<String> {
    let python = std::env::var("HIERARQ_PYTHON").ok()?;
    let found = Command::new(&python).args(["-c", "import cyclonedds"]).stderr(Stdio::null()).status();
    found.is_ok_and(|status| status.success()).then_some(python)
}

/// A domain that no other test uses.
fn domain() -> u16 {
    static NEXT: AtomicU16 = AtomicU16::new(0);
    100 + (std::process::id() % 12) as u16 * 8 + NEXT.fetch_add(1, Ordering::Relaxed) % 8
}

/// A robot in another process.
struct Peer {
    child: Child,
}

impl Peer {
    fn start(python: &str, to_do: &Value) -> Peer {
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/peer.py");
        let child = Command::new(python)
            .arg(script)
            .arg(to_do.to_string())
            .stdout(Stdio::piped())
            .spawn()
            .expect("a peer that answers");
        Peer { child }
    }

    /// Everything that it saw.
    fn end(mut self) -> Value {
        let mut text = String::new();
        self.child.stdout.take().expect("a peer that answers").read_to_string(&mut text).expect("a peer that answers");
        assert!(self.child.wait().expect("a peer that answers").success(), "{text}");
        serde_json::from_str(text.lines().last().expect("a peer that answers")).expect("a peer that answers")
    }
}

/// A run beside a peer.
struct Run {
    ended: Ended,
    remarks: Vec<Remark>,
    seen: Value,
}

fn run(program: &Program, python: &str, mut to_do: Value) -> Run {
    let domain = domain();
    to_do["domain"] = json!(domain);
    to_do["period"] = json!(program.robot.period);
    let names: Vec<&str> = program.robot.model.dofs.iter().map(|d| d.name.as_str()).collect();
    to_do["names"] = json!(names);
    if to_do.get("position").is_none() {
        to_do["position"] = json!(program.robot.home);
    }
    let settings =
        Settings { domain, mapping: ServiceMapping::Cyclone, parameters: Default::default(), duration: None };
    let remarks: Arc<Mutex<Vec<Remark>>> = Arc::default();
    let heard = Arc::clone(&remarks);
    let tell: ros::Tell =
        Arc::new(move |remark: &Remark| heard.lock().expect("a peer that answers").push(remark.clone()));
    let end = Arc::new(AtomicBool::new(false));
    let ending = Arc::clone(&end);
    let peer = Peer::start(python, &to_do);
    let (ended, seen) = std::thread::scope(|scope| {
        let node = scope.spawn(move || {
            let began = Instant::now();
            let mut go_on = || !ending.load(Ordering::Relaxed) && began.elapsed() < Duration::from_secs(60);
            ros::run(program, &settings, &mut All(Vec::new()), &mut go_on, &tell).expect("a peer that answers")
        });
        let seen = peer.end();
        end.store(true, Ordering::Relaxed);
        (node.join().expect("a peer that answers"), seen)
    });
    let remarks = remarks.lock().expect("a peer that answers").clone();
    Run { ended, remarks, seen }
}

fn position(seen: &Value) -> Vec<f64> {
    seen["position"]
        .as_array()
        .expect("a peer that answers")
        .iter()
        .map(|x| x.as_f64().expect("a peer that answers"))
        .collect()
}

fn texts(seen: &Value, key: &str) -> Vec<String> {
    seen[key]
        .as_array()
        .expect("a peer that answers")
        .iter()
        .map(|x| x.as_str().expect("a peer that answers").to_string())
        .collect()
}

/// The first joint follows a signal, and another one goes to a posture.
fn posture() -> Program {
    program(
        &(arm("} ")
            + "signal goal : angle { timeout 0.6 s }
               task there = joint_position { target { shoulder_pan_joint goal  elbow_joint 1.2 rad }  gain 3 /s }
               stack s { level limits hard { joint_velocity_limits }  level move { there } }
               machine m { initial wait  state wait { when present(goal) -> go }
                           state go { stack s  on fault(stale) -> stop }  state stop { when present(goal) -> go } }
               run { machine m  duration 1 s  ros { stale_after 0.6 s } }"),
    )
}

fn at(program: &Program, seen: &Value, joint: &str) -> f64 {
    position(seen)[program.robot.model.dof(joint).expect("a peer that answers")]
}

#[test]
fn a_robot_is_led_to_its_target_whatever_the_order_of_its_joints() {
    let Some(python) = interpreter() else { return };
    let program = posture();
    let order: Vec<usize> = (0..program.robot.model.nv()).rev().collect();
    let to_do = json!({
        "seconds": 7.0, "order": order,
        "numbers": { "goal": "/hierarq/goal" }, "values": { "goal": 0.4 },
    });
    let Run { ended, remarks, seen } = run(&program, &python, to_do);
    assert!(remarks.contains(&Remark::Running), "{remarks:?}");
    assert!(ended.ticks > 200 && !ended.is_halted, "{ended:?} {remarks:?} {seen}");
    assert!((at(&program, &seen, "shoulder_pan_joint") - 0.4).abs() < 5e-3, "{seen}");
    assert!((at(&program, &seen, "elbow_joint") - 1.2).abs() < 5e-3, "{seen}");
    assert_eq!(texts(&seen, "state").last().expect("a peer that answers"), "go", "{seen}");
    assert!(texts(&seen, "fault").iter().all(String::is_empty), "{seen}");
}

#[test]
fn a_driver_that_falls_silent_leaves_a_robot_that_stands() {
    let Some(python) = interpreter() else { return };
    // Without an answer to the fault, the robot is halted.
    let program = posture();
    let to_do = json!({
        "seconds": 6.0, "quiet": [3.0, 5.0],
        "numbers": { "goal": "/hierarq/goal" }, "values": { "goal": 2.5 },
    });
    let Run { ended, remarks, seen } = run(&program, &python, to_do);
    assert!(ended.is_halted, "{ended:?} {remarks:?} {seen}");
    let missing = |text: &String| text.starts_with("not_finite");
    assert!(texts(&seen, "fault").iter().any(missing), "{seen}");
    assert!(seen["largest"].as_f64().expect("a peer that answers") > 0.1, "it had moved: {seen}");
    let last = seen["last"].as_array().expect("a peer that answers");
    assert!(last.iter().all(|v| v.as_f64() == Some(0.0)), "{seen}");
}

#[test]
fn a_sensor_that_falls_silent_is_the_fault_stale_and_the_machine_answers() {
    let Some(python) = interpreter() else { return };
    let program = posture();
    let to_do = json!({
        "seconds": 7.0, "mute": [4.0, 5.5],
        "numbers": { "goal": "/hierarq/goal" }, "values": { "goal": 0.4 },
    });
    let Run { ended, remarks, seen } = run(&program, &python, to_do);
    assert!(!ended.is_halted, "{ended:?} {remarks:?} {seen}");
    let states = texts(&seen, "state");
    assert!(states.ends_with(&["go".into(), "stop".into(), "go".into()]), "{states:?}");
    assert!((at(&program, &seen, "shoulder_pan_joint") - 0.4).abs() < 5e-3, "{seen}");
}

#[test]
fn joints_that_nobody_publishes_are_named_and_nothing_is_commanded() {
    let Some(python) = interpreter() else { return };
    let program = posture();
    let order: Vec<usize> = (0..program.robot.model.nv() - 1).collect();
    let to_do = json!({ "seconds": 7.5, "order": order });
    let Run { ended, remarks, seen } = run(&program, &python, to_do);
    assert_eq!((ended.ticks, seen["commands"].as_u64()), (0, Some(0)), "{seen}");
    let missing = program.robot.model.dofs.last().expect("a peer that answers").name.clone();
    let strangers = vec!["a_gripper_joint".to_string()];
    let topics = vec!["/joint_states".to_string()];
    assert_eq!(remarks, [Remark::WaitingFor { joints: vec![missing], topics, strangers }]);
}

#[test]
fn messages_of_another_type_or_frame_are_told() {
    let Some(python) = interpreter() else { return };
    let program = program(
        &(arm("} ")
            + "signal goal : angle?\nsignal near : point?\nsignal far : point?\n
               stack s { level limits hard { joint_velocity_limits } }
               run { stack s  duration 1 s  ros { world_frame \"map\" signals { far { topic \"/far\"  frame_id \"odom\" } } } }"),
    );
    let to_do = json!({
        "seconds": 6.0, "wrong_type": "/hierarq/goal", "frame": "odom",
        "points": { "near": "/hierarq/near", "far": "/far" },
        "values": { "near": [1.0, 2.0, 3.0], "far": [1.0, 2.0, 3.0] },
    });
    let Run { ended, remarks, .. } = run(&program, &python, to_do);
    assert!(!ended.is_halted && ended.ticks > 100, "{ended:?}");
    let topic = |name: &str| format!("/hierarq/{name}");
    assert!(
        remarks.contains(&Remark::OtherType {
            topic: topic("goal"),
            found: "std_msgs/String".into(),
            needed: "std_msgs/Float64".into(),
        }),
        "{remarks:?}"
    );
    let frames: Vec<&Remark> = remarks.iter().filter(|r| matches!(r, Remark::OtherFrame { .. })).collect();
    assert_eq!(frames, [&Remark::OtherFrame { topic: topic("near"), frame: "odom".into(), needed: "map".into() }]);
}

#[test]
fn services_raise_events_and_restart_after_a_fault() {
    let Some(python) = interpreter() else { return };
    let program = program(
        &(arm("} ")
            + "signal go : event
               task turn = joint_velocity { velocity { elbow_joint 0.1 rad/s } }
               stack s { level limits hard { joint_velocity_limits }  level move { turn } }
               machine m { initial wait  state wait { on go -> move } state move { stack s } }
               run { machine m  duration 1 s  ros { namespace \"/cell\"  node \"elbow\"  commands { arm { topic \"/hierarq/commands\"  form velocity } } } }"),
    );
    // The driver is silent for a while, which halts the controller; then it is restarted.
    let to_do = json!({
        "seconds": 9.0, "quiet": [4.5, 5.5], "node": "/cell/elbow",
        "calls": [[3.0, "/cell/elbow/go"], [6.0, "/cell/elbow/go"], [6.5, "/cell/elbow/restart"], [7.0, "/cell/elbow/go"]],
    });
    let Run { ended, remarks, seen } = run(&program, &python, to_do);
    assert!(!ended.is_halted, "{ended:?} {remarks:?} {seen}");
    let answers: Vec<(bool, String)> = serde_json::from_value(seen["answers"].clone()).expect("a peer that answers");
    let done: Vec<bool> = answers.iter().map(|a| a.0).collect();
    assert_eq!(done, [true, false, true, true], "{answers:?}");
    assert!(answers[1].1.contains("restart"), "{answers:?}");
    let states = texts(&seen, "state");
    assert_eq!(states, ["wait", "move", "wait", "move"], "{seen}");
}
