//! A node and an independent participant: a robot on CycloneDDS, in Python.

use ros::Remark;
use serde_json::json;

use crate::peers::{Run, at, interpreter, posture, run, run_with, texts};
use crate::specs::{arm, program};

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
    assert_eq!(ended.intervals.count as usize, ended.ticks - 1, "each but the first has one before it: {ended:?}");
    assert!((at(&program, &seen, "shoulder_pan_joint") - 0.4).abs() < 5e-3, "{seen}");
    assert!((at(&program, &seen, "elbow_joint") - 1.2).abs() < 5e-3, "{seen}");
    assert_eq!(texts(&seen, "state").last().expect("a value"), "go", "{seen}");
    assert!(texts(&seen, "fault").iter().all(String::is_empty), "{seen}");
}

#[test]
fn a_driver_that_falls_silent_leaves_a_robot_that_stands() {
    let Some(python) = interpreter() else { return };
    // Without an answer to the fault, the robot is halted.
    let program = posture();
    let to_do = json!({
        "seconds": 6.0, "manners": [[3.0, "silent"], [5.0, null]],
        "numbers": { "goal": "/hierarq/goal" }, "values": { "goal": 2.5 },
    });
    let Run { ended, remarks, seen } = run(&program, &python, to_do);
    assert!(ended.is_halted, "{ended:?} {remarks:?} {seen}");
    let missing = |text: &String| text.starts_with("not_finite");
    assert!(texts(&seen, "fault").iter().any(missing), "{seen}");
    assert!(seen["largest"].as_f64().expect("a value") > 0.1, "it had moved: {seen}");
    let last = seen["last"].as_array().expect("a value");
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
    let missing = program.robot.model.dofs.last().expect("a value").name.clone();
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
               run { stack s  duration 1 s  ros { world_frame \"map\"  stale_after 3 s  signals { far { topic \"/far\"  frame_id \"odom\" } } } }"),
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
               run { machine m  duration 1 s  ros { namespace \"/cell\"  node \"elbow\"  stale_after 0.5 s  } }"),
    );
    // The driver is silent for a while, which halts the controller; then it is restarted.
    let to_do = json!({
        "seconds": 9.0, "manners": [[4.5, "silent"], [5.5, null]], "node": "/cell/elbow",
        "calls": [[3.0, "/cell/elbow/go"], [6.0, "/cell/elbow/go"], [6.5, "/cell/elbow/restart"], [7.0, "/cell/elbow/go"]],
    });
    let Run { ended, remarks, seen } = run(&program, &python, to_do);
    assert!(!ended.is_halted, "{ended:?} {remarks:?} {seen}");
    let answers: Vec<(bool, String)> = serde_json::from_value(seen["answers"].clone()).expect("a value");
    let done: Vec<bool> = answers.iter().map(|a| a.0).collect();
    assert_eq!(done, [true, false, true, true], "{answers:?}");
    assert!(answers[1].1.contains("restart"), "{answers:?}");
    let states = texts(&seen, "state");
    assert_eq!(states, ["wait", "move", "wait", "move"], "{seen}");
}

#[test]
fn a_base_that_is_localised_anew_is_announced_or_a_jump() {
    let Some(python) = interpreter() else { return };
    let program = program(
        &(arm(
            "base planar  limits { base_x { velocity 1 m/s }  base_y { velocity 1 m/s }  base_yaw { velocity 1 rad/s } } } ",
        ) + "task turn = joint_velocity { velocity { elbow_joint 0.1 rad/s } }
               stack s { level limits hard { joint_velocity_limits }  level move { turn } }
               run { stack s  duration 1 s  ros { stale_after 1 s } }"),
    );
    let joints: Vec<usize> = (3..program.robot.model.nv()).collect();
    for is_told in [true, false] {
        let mut to_do = json!({ "seconds": 6.0, "order": joints, "base": [[0.0, 0.0], [4.5, 0.5]] });
        if is_told {
            to_do["calls"] = json!([[4.2, "/hierarq/motion/relocated"]]);
        }
        let Run { ended, remarks, seen } = run(&program, &python, to_do);
        let jumps = texts(&seen, "fault").iter().any(|f| f.starts_with("jump"));
        assert_eq!((jumps, ended.is_halted), (!is_told, !is_told), "{ended:?} {remarks:?} {seen}");
        assert!(seen["largest_twist"].as_f64() < Some(0.05), "the base stays where it is: {seen}");
    }
}

#[test]
fn values_in_other_frames_are_carried_over_fixed_transforms() {
    let Some(python) = interpreter() else { return };
    // A camera over a table, turned by a quarter about z, and one on the wrist, which stands at the zero of its joints.
    let program = program(
        &(arm("} ")
            + "signal seen : point? { timeout 1 s }\nsignal held : point? { timeout 1 s }
               task still = joint_velocity { velocity 0 rad/s }
               stack s { level limits hard { joint_velocity_limits }  level move { still } }
               machine m { initial wait
                 state wait { when present(seen) and norm(seen - [1.8, 1.1, 2.8] m) < 1 mm -> near }
                 state near { when present(held) and norm(held - frame(tool0).position) < 1 mm -> both }
                 state both { stack s } }
               run { machine m  duration 1 s  ros { stale_after 3 s  signals { held { topic \"/held\" } } } }"),
    );
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let table = json!({
        "seconds": 8.0, "frame": "camera", "points": { "seen": "/hierarq/seen" }, "values": { "seen": [0.1, 0.2, -0.2] },
        "fixed": [["table", "camera", [0.0, 0.0, 3.0, 0.0, 0.0, half, half]], ["world", "table", [2.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]]],
    });
    let wrist = json!({
        "robot": false, "seconds": 7.0, "frame": "gripper", "points": { "held": "/held" }, "values": { "held": [0.0, 0.0, -0.1] },
        "fixed": [["tool0", "gripper", [0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 1.0]]],
    });
    let Run { ended, remarks, seen } = run_with(&program, &python, vec![table, wrist]);
    assert!(!ended.is_halted, "{ended:?} {remarks:?} {seen}");
    assert_eq!(texts(&seen, "state").last().map(String::as_str), Some("both"), "{remarks:?} {seen}");
    assert!(!remarks.iter().any(|r| matches!(r, Remark::OtherFrame { .. })), "{remarks:?}");
}
