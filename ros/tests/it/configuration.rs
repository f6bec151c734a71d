//! Configurations from messages.

use robot::Base;
use ros::joints::{Configuration, Mistake, Publishers, Source};
use ros::messages::{JointState, Odometry, Pose, Quaternion, Vector3};

use crate::specs::{arm, program};

fn states(all: &[(&str, f64)]) -> JointState {
    JointState {
        name: all.iter().map(|(name, _)| (*name).to_string()).collect(),
        position: all.iter().map(|(_, position)| *position).collect(),
        ..JointState::default()
    }
}

const DRIVER: Source = [1; 16];
const OTHER: Source = [2; 16];

fn model() -> robot::Model {
    program(&arm("} stack s { level l hard { joint_velocity_limits } }")).robot.model
}

#[test]
fn joints_are_found_by_their_names_in_any_order_and_in_parts() {
    let model = model();
    let names: Vec<&str> = model.dofs.iter().map(|d| d.name.as_str()).collect();
    let mut q = Configuration::new(&model, 0.1);
    assert_eq!(q.unknown(), names);
    let mut publishers = Publishers::default();
    let first: Vec<(&str, f64)> = names.iter().enumerate().skip(3).rev().map(|(i, n)| (*n, i as f64)).collect();
    q.joints(&states(&first), "", &mut publishers, DRIVER, 1.0).unwrap();
    assert!(!q.is_known());
    assert_eq!(q.unknown(), &names[..3]);
    let second: Vec<(&str, f64)> =
        names.iter().enumerate().take(3).map(|(i, n)| (*n, i as f64)).chain([("gripper", 7.0)]).collect();
    q.joints(&states(&second), "", &mut publishers, OTHER, 1.05).unwrap();
    assert!(q.is_known());
    assert_eq!(q.at(1.06), (0..names.len()).map(|i| i as f64).collect::<Vec<_>>());
    assert_eq!(q.strangers(), ["gripper"]);
    // The first message is too old by then, the second one is not.
    let later = q.at(1.12).to_vec();
    assert!(later[..3].iter().all(|x| x.is_finite()) && later[3..].iter().all(|x| x.is_nan()), "{later:?}");
}

#[test]
fn a_publisher_may_change_its_order() {
    let model = model();
    let names: Vec<&str> = model.dofs.iter().map(|d| d.name.as_str()).collect();
    let mut q = Configuration::new(&model, 0.1);
    let mut publishers = Publishers::default();
    let forth: Vec<(&str, f64)> = names.iter().enumerate().map(|(i, n)| (*n, i as f64)).collect();
    let back: Vec<(&str, f64)> = forth.iter().rev().copied().collect();
    for message in [&forth, &back, &forth] {
        q.joints(&states(message), "", &mut publishers, DRIVER, 0.0).unwrap();
        assert_eq!(q.at(0.0), (0..names.len()).map(|i| i as f64).collect::<Vec<_>>());
    }
}

#[test]
fn a_message_that_contradicts_itself_is_not_taken() {
    let model = model();
    let mut q = Configuration::new(&model, 0.1);
    let mut message = states(&[(model.dofs[0].name.as_str(), 1.0)]);
    message.position.push(2.0);
    let refused = q.joints(&message, "", &mut Publishers::default(), DRIVER, 0.0);
    assert_eq!(refused, Err(Mistake::Lengths { names: 1, positions: 2 }));
    assert_eq!(q.unknown().len(), model.nq());
}

#[test]
fn a_joint_is_read_from_one_publisher_as_long_as_that_sends_it() {
    let model = model();
    let mut q = Configuration::new(&model, 0.1);
    let mut publishers = Publishers::default();
    let name = model.dofs[0].name.as_str();
    let mut send = |q: &mut Configuration, from, all: &[(&str, f64)], time| {
        let taken = q.joints(&states(all), "", &mut publishers, from, time);
        (taken.is_ok(), q.last()[0])
    };
    assert_eq!(send(&mut q, DRIVER, &[(name, 1.0)], 0.0), (true, 1.0));
    let refused = send(&mut q, OTHER, &[(name, 2.0), (&model.dofs[1].name, 3.0)], 0.1);
    assert_eq!(refused, (false, 1.0));
    // Its other joint is read.
    assert_eq!(q.last()[1], 3.0);
    // The first one has been silent for too long, and then it is the second.
    assert_eq!(send(&mut q, OTHER, &[(name, 2.0)], 0.11), (true, 2.0));
    assert_eq!(send(&mut q, DRIVER, &[(name, 1.0)], 0.15), (false, 2.0));
}

#[test]
fn joints_are_known_when_they_have_been_finite() {
    let model = model();
    let mut q = Configuration::new(&model, 0.1);
    let mut publishers = Publishers::default();
    for (position, is_known) in [(f64::NAN, false), (f64::INFINITY, false), (0.2, true), (f64::NAN, true)] {
        let all: Vec<(&str, f64)> = model.dofs.iter().map(|d| (d.name.as_str(), position)).collect();
        q.joints(&states(&all), "", &mut publishers, DRIVER, 0.0).unwrap();
        assert_eq!(q.is_known(), is_known, "{position}");
        assert_eq!(q.at(0.0).iter().all(|x| x.is_finite()), position == 0.2, "{position}");
    }
}

#[test]
fn the_names_of_a_publisher_may_change_and_many_may_come_and_go() {
    let model = model();
    let mut q = Configuration::new(&model, 0.1);
    let mut publishers = Publishers::default();
    for round in 0..100_u8 {
        let joint = usize::from(round) % model.nq();
        let all = [(model.dofs[joint].name.as_str(), f64::from(round))];
        q.joints(&states(&all), "", &mut publishers, [round / 2; 16], f64::from(round)).unwrap();
        assert_eq!(q.last()[joint], f64::from(round));
    }
}

#[test]
fn one_of_several_robots_is_found_by_its_prefix() {
    let robot =
        |name: &str, at: &str| arm(&format!("at [{at}] m }}")).replacen("robot arm", &format!("robot {name}"), 1);
    let text =
        robot("left", "0, 0, 0") + &robot("right", "0, 2, 0") + "stack s { level l hard { joint_velocity_limits } }";
    let model = program(&text).robot.model;
    let name = model.dofs[0].name.strip_prefix("left_").unwrap().to_string();
    let mut q = Configuration::new(&model, 1.0);
    q.joints(&states(&[(&name, 0.5)]), "right_", &mut Publishers::default(), DRIVER, 0.0).unwrap();
    let known: Vec<usize> = (0..model.nq()).filter(|i| q.last()[*i] == 0.5).collect();
    assert_eq!(known.len(), 1);
    assert_eq!(model.dofs[known[0]].name, format!("right_{name}"));
    let refused = q.joints(&states(&[(&name, 0.5)]), "", &mut Publishers::default(), DRIVER, 0.0);
    assert_eq!(refused, Ok(()));
    assert_eq!(q.strangers(), [name]);
}

#[test]
fn the_pose_of_a_base_is_that_of_its_odometry() {
    let yaw = 0.7_f64;
    let message = Odometry {
        pose: Pose {
            position: Vector3 { x: 1.0, y: -2.0, z: 0.3 },
            orientation: Quaternion { z: (yaw / 2.0).sin(), w: (yaw / 2.0).cos(), ..Quaternion::default() },
        },
        ..Odometry::default()
    };
    for (base, word) in [(Base::Unicycle, "unicycle"), (Base::Planar, "planar"), (Base::Floating, "floating")] {
        let text = arm(&format!("base {word} }} stack s {{ level l hard {{ joint_velocity_limits }} }}"));
        let model = program(&text).robot.model;
        let mut q = Configuration::new(&model, 1.0);
        assert_eq!(q.unknown()[0], "the base");
        let mut elsewhere = message.clone();
        elsewhere.header.frame_id = "/odom".into();
        assert_eq!(q.odometry(0, &elsewhere, "world", 0.0), Err(Mistake::OtherFrame { frame: "odom".into() }));
        assert_eq!(q.unknown()[0], "the base");
        let mut nowhere = message.clone();
        nowhere.pose.orientation = Quaternion::default();
        q.odometry(0, &nowhere, "world", 0.0).unwrap();
        assert_eq!(q.unknown()[0], "the base");
        assert_eq!(q.odometry(0, &message, "world", 0.0), Ok(false));
        // The pose of the root by the kinematics of the model.
        let mut whole = q.last().to_vec();
        whole[base.nq()..].fill(0.0);
        let mut data = robot::Data::new(&model);
        model.forward(&whole, &mut data);
        let root = data.pose(model.root());
        let z = if base == Base::Floating { 0.3 } else { 0.0 };
        assert!((root.translation.vector - nalgebra::Vector3::new(1.0, -2.0, z)).norm() < 1e-12, "{root}");
        assert!((root.rotation.scaled_axis() - nalgebra::Vector3::z() * yaw).norm() < 1e-12, "{root}");
        for (x, jumps) in [(1.02, false), (1.52, true)] {
            let mut elsewhere = message.clone();
            elsewhere.pose.position.x = x;
            assert_eq!(q.odometry(0, &elsewhere, "world", 0.0), Ok(jumps));
        }
    }
}

#[test]
fn the_pose_of_each_base_is_one_in_the_world_wherever_its_robot_stands() {
    let robot = |name: &str, more: &str| arm(&format!("{more} }}")).replacen("robot arm", &format!("robot {name}"), 1);
    let text = robot("left", "base floating  at pose([0.5, 1, 0.2] m, rpy(0.1, 0.2, 0.3))")
        + &robot("right", "base unicycle  at pose([3, 0, 0] m, rpy(0, 0, 90 deg))")
        + "stack s { level l hard { joint_velocity_limits } }";
    let model = program(&text).robot.model;
    let mut q = Configuration::new(&model, 1.0);
    let links = ["left_base_link", "right_base_link"];
    assert_eq!(q.unknown()[..2], links.map(|link| format!("the base `{link}`")));
    let (turn, level) = ([0.8, 0.1, -0.3, 0.5], [0.8, 0.0, 0.0, 0.6]);
    let poses = [([1.0, -2.0, 0.3], turn), ([2.0, 1.5, 0.0], level)];
    for (base, (p, [w, x, y, z])) in poses.iter().enumerate() {
        let pose = Pose {
            position: Vector3 { x: p[0], y: p[1], z: p[2] },
            orientation: Quaternion { w: *w, x: *x, y: *y, z: *z },
        };
        q.odometry(base, &Odometry { pose, ..Odometry::default() }, "world", 0.0).unwrap();
    }
    let whole: Vec<f64> = q.last().iter().map(|x| if x.is_nan() { 0.0 } else { *x }).collect();
    let mut data = robot::Data::new(&model);
    model.forward(&whole, &mut data);
    for (link, (p, [w, x, y, z])) in links.iter().zip(poses) {
        let pose = data.pose(model.link(link).unwrap());
        let turn = nalgebra::UnitQuaternion::new_normalize(nalgebra::Quaternion::new(w, x, y, z));
        assert!((pose.translation.vector - nalgebra::Vector3::from(p)).norm() < 1e-12, "{link} {pose}");
        assert!(pose.rotation.angle_to(&turn) < 1e-7, "{link} {pose}");
    }
}
