//! The urdf-rs crate as an independent reader, and plain 4×4 matrices as independent kinematics.

use std::collections::BTreeMap;

use hierarq_robot::{Base, Data, JointKind, Model, Options};
use nalgebra::{Matrix4, Rotation3, Unit, Vector3};
use proptest::prelude::*;

use crate::common::{load, rng, tree};

fn matrix(xyz: &[f64; 3], rpy: &[f64; 3]) -> Matrix4<f64> {
    let about = |i: usize, angle: f64| Rotation3::from_axis_angle(&Unit::new_unchecked(Vector3::ith(i, 1.0)), angle);
    // Fixed axes x, y, z in turn.
    let R = about(2, rpy[2]) * about(1, rpy[1]) * about(0, rpy[0]);
    Matrix4::new_translation(&Vector3::from(*xyz)) * R.to_homogeneous()
}

/// Positions by name: mimics resolved by repeated passes over what urdf-rs read.
fn positions(robot: &urdf_rs::Robot, free: &BTreeMap<String, f64>) -> BTreeMap<String, f64> {
    let mut known = free.clone();
    for _ in 0..robot.joints.len() {
        for joint in &robot.joints {
            if let Some(mimic) = &joint.mimic
                && let Some(leader) = known.get(&mimic.joint)
            {
                let x = mimic.multiplier.unwrap_or(1.0) * leader + mimic.offset.unwrap_or(0.0);
                known.insert(joint.name.clone(), x);
            }
        }
    }
    known
}

fn agree(text: &str, model: &Model, seed: u64) {
    let robot = urdf_rs::read_from_string(text).unwrap();
    assert_eq!((model.links.len(), model.joints.len()), (robot.links.len(), robot.joints.len()));
    for joint in &robot.joints {
        let ours = model.joint_ref(model.joint(&joint.name).unwrap());
        assert_eq!(model.link_ref(ours.parent).name, joint.parent.link);
        assert_eq!(model.link_ref(ours.child).name, joint.child.link);
        let origin = matrix(&joint.origin.xyz, &joint.origin.rpy);
        assert!((ours.origin.to_homogeneous() - origin).norm() < 1e-12, "{}", joint.name);
        let kind = match joint.joint_type {
            urdf_rs::JointType::Revolute => JointKind::Revolute,
            urdf_rs::JointType::Continuous => JointKind::Continuous,
            urdf_rs::JointType::Prismatic => JointKind::Prismatic,
            _ => JointKind::Fixed,
        };
        assert_eq!(ours.kind, kind);
        if matches!(kind, JointKind::Revolute | JointKind::Prismatic) {
            let limit = &joint.limit;
            assert_eq!((ours.lower, ours.upper), (limit.lower, limit.upper), "{}", joint.name);
            assert_eq!((ours.velocity, ours.effort), (limit.velocity, limit.effort));
        }
        if kind != JointKind::Fixed {
            let axis = Vector3::from(*joint.axis.xyz).normalize();
            assert!((ours.axis - axis).norm() < 1e-12);
        }
    }
    let q = model.random_configuration(&mut rng(seed));
    let free = model.dofs.iter().map(|d| (d.name.clone(), q[d.q_index.unwrap()])).collect();
    let positions = positions(&robot, &free);
    let mut data = Data::new(model);
    model.forward(&q, &mut data);
    let mut poses = BTreeMap::from([(model.links[0].name.clone(), Matrix4::identity())]);
    for _ in 0..robot.joints.len() {
        for joint in &robot.joints {
            let Some(parent) = poses.get(&joint.parent.link) else { continue };
            let x = positions.get(&joint.name).copied().unwrap_or(0.0);
            let axis = Unit::new_normalize(Vector3::from(*joint.axis.xyz));
            let motion = match joint.joint_type {
                urdf_rs::JointType::Fixed => Matrix4::identity(),
                urdf_rs::JointType::Prismatic => Matrix4::new_translation(&(*axis * x)),
                _ => Rotation3::from_axis_angle(&axis, x).to_homogeneous(),
            };
            let pose = parent * matrix(&joint.origin.xyz, &joint.origin.rpy) * motion;
            poses.insert(joint.child.link.clone(), pose);
        }
    }
    for (name, pose) in poses {
        let ours = data.pose(model.link(&name).unwrap()).to_homogeneous();
        assert!((ours - pose).norm() < 1e-11, "{name}: {ours} {pose}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn random_trees_read_the_same(text in tree(), seed in any::<u64>()) {
        agree(&text, &load(&text, Base::Fixed), seed);
    }
}

#[test]
fn the_arm_reads_the_same() {
    // urdf-rs knows no limits for a continuous joint and wants names in transmissions: all there.
    let text = include_str!("arm.urdf");
    agree(text, &load(text, Base::Fixed), 7);
}

#[test]
fn the_example_robots_read_the_same() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/robots");
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for path in entries.flatten().map(|e| e.path()) {
        if path.extension().is_some_and(|e| e == "urdf") {
            let text = std::fs::read_to_string(&path).unwrap();
            let options = Options { urdf_dir: path.parent().map(Into::into), ..Options::default() };
            let (model, _) = Model::from_urdf(&text, &options)
                .unwrap_or_else(|messages| panic!("{}: {messages:#?}", path.display()));
            agree(&text, &model, 11);
        }
    }
}
