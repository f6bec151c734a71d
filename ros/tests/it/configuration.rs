//! Configurations from messages.

use robot::Base;
use ros::joints::{Configuration, Mistake, Order};
use ros::messages::{JointState, Odometry, Pose, Quaternion, Vector3};

use crate::specs::{arm, program};

fn states(all: &[(&str, f64)]) -> JointState {
    JointState {
        name: all.iter().map(|(name, _)| (*name).to_string()).collect(),
        position: all.iter().map(|(_, position)| *position).collect(),
        ..JointState::default()
    }
}

fn model() -> robot::Model {
    program(&arm("} stack s { level l hard { joint_velocity_limits } }")).robot.model
}

#[test]
fn joints_are_found_by_their_names_in_any_order_and_in_parts() {
    let model = model();
    let names: Vec<&str> = model.dofs.iter().map(|d| d.name.as_str()).collect();
    let mut q = Configuration::new(&model, 0.1);
    assert_eq!(q.unknown(), names);
    let mut orders = [Order::default(), Order::default()];
    let first: Vec<(&str, f64)> = names.iter().enumerate().skip(3).rev().map(|(i, n)| (*n, i as f64)).collect();
    q.joints(&states(&first), "", &mut orders[0], 1.0).unwrap();
    assert!(!q.is_known());
    assert_eq!(q.unknown(), &names[..3]);
    let second: Vec<(&str, f64)> =
        names.iter().enumerate().take(3).map(|(i, n)| (*n, i as f64)).chain([("gripper", 7.0)]).collect();
    q.joints(&states(&second), "", &mut orders[1], 1.05).unwrap();
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
    let mut order = Order::default();
    let forth: Vec<(&str, f64)> = names.iter().enumerate().map(|(i, n)| (*n, i as f64)).collect();
    let back: Vec<(&str, f64)> = forth.iter().rev().copied().collect();
    for message in [&forth, &back, &forth] {
        q.joints(&states(message), "", &mut order, 0.0).unwrap();
        assert_eq!(q.at(0.0), (0..names.len()).map(|i| i as f64).collect::<Vec<_>>());
    }
}

#[test]
fn a_message_that_contradicts_itself_is_not_taken() {
    let model = model();
    let mut q = Configuration::new(&model, 0.1);
    let mut message = states(&[(model.dofs[0].name.as_str(), 1.0)]);
    message.position.push(2.0);
    let refused = q.joints(&message, "", &mut Order::default(), 0.0);
    assert_eq!(refused, Err(Mistake::Lengths { names: 1, positions: 2 }));
    assert_eq!(q.unknown().len(), model.nq());
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
    q.joints(&states(&[(&name, 0.5)]), "right_", &mut Order::default(), 0.0).unwrap();
    let known: Vec<usize> = (0..model.nq()).filter(|i| q.last()[*i] == 0.5).collect();
    assert_eq!(known.len(), 1);
    assert_eq!(model.dofs[known[0]].name, format!("right_{name}"));
    let refused = q.joints(&states(&[(&name, 0.5)]), "", &mut Order::default(), 0.0);
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
        assert_eq!(q.odometry(&elsewhere, "world", 0.0), Err(Mistake::OtherFrame { frame: "odom".into() }));
        assert_eq!(q.unknown()[0], "the base");
        q.odometry(&message, "world", 0.0).unwrap();
        // The pose of the root by the kinematics of the model.
        let mut whole = q.last().to_vec();
        whole[base.nq()..].fill(0.0);
        let mut data = robot::Data::new(&model);
        model.forward(&whole, &mut data);
        let root = data.pose(model.root());
        let z = if base == Base::Floating { 0.3 } else { 0.0 };
        assert!((root.translation.vector - nalgebra::Vector3::new(1.0, -2.0, z)).norm() < 1e-12, "{root}");
        assert!((root.rotation.scaled_axis() - nalgebra::Vector3::z() * yaw).norm() < 1e-12, "{root}");
    }
}
