//! Several participants in one domain: parts of a robot, the same topic twice, a listener that hangs, nodes with namespaces of their own.

use ros::Remark;
use serde_json::json;

use crate::peers::{Run, Scene, at, following, interpreter, play, posture, run_with, texts};

#[test]
fn joints_may_come_from_two_participants_on_one_topic() {
    let Some(python) = interpreter() else { return };
    let program = following("", "stale_after 3 s");
    // Each publishes half of the joints, and both move all of them.
    let lower = json!({
        "seconds": 7.0, "order": [2, 0, 1],
        "numbers": { "goal": "/hierarq/goal" }, "values": { "goal": 0.4 },
    });
    let upper = json!({ "seconds": 7.0, "order": [5, 3, 4] });
    let Scene { nodes, seen } = play(&python, &[&program], vec![lower, upper], &|_| ());
    assert!(!nodes[0].ended.is_halted, "{:?} {:?} {seen:?}", nodes[0].ended, nodes[0].remarks);
    assert!((at(&program, &seen[0], "shoulder_pan_joint") - 0.4).abs() < 5e-3, "{seen:?}");
    assert!((at(&program, &seen[0], "elbow_joint") - 1.2).abs() < 5e-3, "{seen:?}");
}

#[test]
fn a_second_driver_of_the_same_joints_is_told_and_not_listened_to() {
    let Some(python) = interpreter() else { return };
    let program = posture();
    let robot = json!({
        "seconds": 8.0,
        "numbers": { "goal": "/hierarq/goal" }, "values": { "goal": 0.4 },
    });
    // Another robot of this kind in the same domain, somewhere else. It begins when the first one is listened to.
    let other = json!({ "late": 2.5, "seconds": 3.0, "position": [1.5, -1.5, 0.2, -1.5, 0.0, 0.7] });
    let Run { ended, remarks, seen } = run_with(&program, &python, vec![robot, other]);
    assert!(!ended.is_halted, "{ended:?} {remarks:?} {seen}");
    let told = |r: &&Remark| matches!(r, Remark::TwoSources { topic, .. } if topic == "/joint_states");
    assert_eq!(remarks.iter().filter(told).count(), 1, "{remarks:?}");
    assert!((at(&program, &seen, "shoulder_pan_joint") - 0.4).abs() < 5e-3, "{seen}");
    assert!((at(&program, &seen, "elbow_joint") - 1.2).abs() < 5e-3, "{seen}");
    assert!(texts(&seen, "fault").iter().all(String::is_empty), "{seen}");
}

#[test]
fn the_last_message_of_a_signal_counts_whoever_sent_it() {
    let Some(python) = interpreter() else { return };
    let program = posture();
    let robot = json!({
        "seconds": 9.0,
        "numbers": { "goal": "/hierarq/goal" }, "values": { "goal": 0.4 },
    });
    let second = json!({
        "robot": false, "seconds": 5.0,
        "numbers": { "goal": "/hierarq/goal" }, "values": { "goal": 0.6 },
    });
    let Run { ended, remarks, seen } = run_with(&program, &python, vec![robot, second]);
    assert!(!ended.is_halted, "{ended:?} {remarks:?} {seen}");
    assert!(texts(&seen, "fault").iter().all(String::is_empty), "{seen}");
    // The second one has gone long before the end.
    assert!((at(&program, &seen, "shoulder_pan_joint") - 0.4).abs() < 5e-3, "{seen}");
}

#[test]
fn a_listener_that_hangs_keeps_no_command_from_the_robot() {
    let Some(python) = interpreter() else { return };
    let program = posture();
    let robot = json!({
        "seconds": 9.0,
        "numbers": { "goal": "/hierarq/goal" }, "values": { "goal": 0.4 }, "later": { "goal": [[5.0, -0.4]] },
    });
    // It has subscribed to the commands reliably, and acknowledges none from then on.
    let listener = json!({ "robot": false, "seconds": 60.0, "freezes": 3.0 });
    let Run { ended, remarks, seen } = run_with(&program, &python, vec![robot, listener]);
    assert!(!ended.is_halted, "{ended:?} {remarks:?} {seen}");
    assert!(!remarks.iter().any(|r| matches!(r, Remark::NotSent { .. })), "{remarks:?}");
    assert!((at(&program, &seen, "shoulder_pan_joint") + 0.4).abs() < 5e-3, "{seen}");
}

#[test]
fn two_nodes_in_one_domain_have_namespaces_of_their_own() {
    let Some(python) = interpreter() else { return };
    // The robots have joints of the same names, and both sensors are in the namespace of a third participant.
    let node = |side: &str| {
        let ros = format!(
            "namespace \"/{side}\"  node \"arm\"  stale_after 3 s  joint_states {{ own {{ topic \"joint_states\" }} }}
             signals {{ goal {{ topic \"/cell/camera/{side}\" }} }}"
        );
        following("", &ros)
    };
    let (left, right) = (node("left"), node("right"));
    let robot = |index: usize, side: &str| {
        json!({
            "seconds": 8.0, "node_index": index,
            "node": format!("/{side}/arm"), "joint_states": format!("/{side}/joint_states"),
        })
    };
    let camera = json!({
        "robot": false, "seconds": 9.0,
        "numbers": { "left": "/cell/camera/left", "right": "/cell/camera/right" }, "values": { "left": 0.4, "right": -0.7 },
    });
    let Scene { nodes, seen } =
        play(&python, &[&left, &right], vec![robot(0, "left"), robot(1, "right"), camera], &|_| ());
    for (i, goal) in [0.4, -0.7].into_iter().enumerate() {
        assert!(!nodes[i].ended.is_halted, "{:?} {:?} {seen:?}", nodes[i].ended, nodes[i].remarks);
        assert!((at(&left, &seen[i], "shoulder_pan_joint") - goal).abs() < 5e-3, "{seen:?}");
        assert_eq!(texts(&seen[i], "state").last().map(String::as_str), Some("go"), "{seen:?}");
        assert!(texts(&seen[i], "fault").iter().all(String::is_empty), "{seen:?}");
    }
}
