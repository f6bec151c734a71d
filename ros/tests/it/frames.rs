//! Poses of frames, against products of matrices, and values in other frames, against what does not depend on the frame.

use nalgebra::{Isometry3, Matrix4, Point3, Translation3, UnitQuaternion, Vector3 as Vector};
use ros::frames::Frames;
use ros::messages::{Header, Quaternion, Transform, TransformStamped, Vector3, Wrench};
use ros::readings::{Numbers, Reading, Wanted};

use crate::specs::{arm, program};

fn model() -> robot::Model {
    program(&arm("} stack s { level l hard { joint_velocity_limits } }")).robot.model
}

/// Poses that have nothing in common.
fn pose(i: usize) -> Isometry3<f64> {
    let x = |k: usize| (1.7 * (i * 6 + k) as f64 + 0.3).sin();
    let turn = UnitQuaternion::from_scaled_axis(2.5 * Vector::new(x(0), x(1), x(2)));
    Isometry3::from_parts(Translation3::new(x(3), x(4), x(5)), turn)
}

fn transform(parent: &str, child: &str, pose: &Isometry3<f64>) -> TransformStamped {
    let (p, q) = (pose.translation.vector, pose.rotation.quaternion());
    TransformStamped {
        header: Header { frame_id: parent.into(), ..Header::default() },
        child_frame_id: child.into(),
        transform: Transform {
            translation: Vector3 { x: p.x, y: p.y, z: p.z },
            rotation: Quaternion { x: q.i, y: q.j, z: q.k, w: q.w },
        },
    }
}

#[test]
fn poses_of_fixed_frames_are_products_of_those_between_them() {
    let model = model();
    let mut frames = Frames::new(&model, "/map");
    let q = vec![f64::NAN; model.nq()];
    // room is in map; camera and table are in room; lens is in camera.
    let tree = [("map", "room"), ("room", "camera"), ("/room", "table"), ("camera", "lens")];
    for (i, (parent, child)) in tree.iter().enumerate() {
        frames.place(&transform(parent, child, &pose(i)));
    }
    let m = |i: usize| pose(i).to_homogeneous();
    let inverse = |i: usize| m(i).try_inverse().expect("a pose");
    let cases: [(&str, &str, Matrix4<f64>); 5] = [
        ("lens", "map", m(0) * m(1) * m(3)),
        ("lens", "table", inverse(2) * m(1) * m(3)),
        ("map", "lens", inverse(3) * inverse(1) * inverse(0)),
        ("/camera", "room", m(1)),
        ("table", "table", Matrix4::identity()),
    ];
    for (frame, needed, expected) in cases {
        let found = frames.find(frame, needed, &q).expect("a way");
        assert!((found.pose.to_homogeneous() - expected).norm() < 1e-12, "{frame} in {needed}");
        assert!(!found.moves, "{frame} in {needed}");
    }
    assert_eq!(frames.find("lens", "elsewhere", &q), None);
    assert_eq!(frames.find("elsewhere", "map", &q), None);
    // A frame may be placed anew.
    frames.place(&transform("map", "lens", &pose(7)));
    assert!((frames.find("lens", "map", &q).expect("a way").pose.to_homogeneous() - m(7)).norm() < 1e-12);
}

#[test]
fn links_are_where_the_robot_is() {
    let model = model();
    let mut frames = Frames::new(&model, "world");
    frames.place(&transform("tool0", "gripper", &pose(1)));
    frames.place(&transform("world", "table", &pose(2)));
    // Others publish the fixed joints of the robot too.
    frames.place(&transform("wrist_3_link", "tool0", &pose(3)));
    let mut data = robot::Data::new(&model);
    for round in 0..3 {
        let q: Vec<f64> = (0..model.nq()).map(|i| (i + 2 * round) as f64 * 0.3 - 0.8).collect();
        model.forward(&q, &mut data);
        let tool = data.pose(model.link("tool0").expect("a link")).to_homogeneous();
        let expected = pose(2).to_homogeneous().try_inverse().expect("a pose") * tool * pose(1).to_homogeneous();
        frames.moved();
        let found = frames.find("gripper", "table", &q).expect("a way");
        assert!((found.pose.to_homogeneous() - expected).norm() < 1e-12);
        assert!(found.moves);
        // On the robot itself it does not: both are on the same link.
        let held = frames.find("gripper", "tool0", &q).expect("a way");
        assert!((held.pose.to_homogeneous() - pose(1).to_homogeneous()).norm() < 1e-12 && !held.moves);
    }
    frames.moved();
    assert_eq!(frames.find("gripper", "table", &vec![f64::NAN; model.nq()]), None);
}

#[test]
fn transforms_that_are_none_and_circles_lead_nowhere() {
    let model = model();
    let mut frames = Frames::new(&model, "world");
    let q = vec![0.0; model.nq()];
    frames.place(&transform("b", "a", &pose(0)));
    frames.place(&transform("a", "b", &pose(1)));
    frames.place(&transform("c", "c", &pose(2)));
    assert_eq!(frames.find("a", "world", &q), None);
    assert_eq!(frames.find("world", "a", &q), None);
    assert_eq!(frames.find("c", "world", &q), None);
    let mut none = transform("world", "d", &pose(3));
    none.transform.rotation = Quaternion::default();
    frames.place(&none);
    let mut nowhere = transform("world", "e", &pose(3));
    nowhere.transform.translation.y = f64::INFINITY;
    frames.place(&nowhere);
    assert_eq!((frames.find("d", "world", &q), frames.find("e", "world", &q)), (None, None));
}

fn numbers(of: Option<Numbers>) -> Vec<f64> {
    of.expect("a value").as_slice().to_vec()
}

#[test]
fn the_power_of_a_wrench_does_not_depend_on_its_frame() {
    let at = pose(4);
    let wrench = Wrench { force: Vector3 { x: 1.0, y: -2.0, z: 0.5 }, torque: Vector3 { x: 0.3, y: 0.7, z: -1.1 } };
    let here = numbers(wrench.numbers(Wanted::Wrench));
    let there = numbers(wrench.numbers(Wanted::Wrench).and_then(|w| w.in_frame(Wanted::Wrench, &at)));
    let part = |of: &[f64], i: usize| Vector::from_column_slice(&of[3 * i..3 * i + 3]);
    // The velocity of a rigid body at the origins of both frames, each along its own axes.
    let (v, w) = (Vector::new(0.2, 0.9, -0.4), Vector::new(1.3, -0.6, 0.8));
    let v_there = at.rotation * v - (at.rotation * w).cross(&at.translation.vector);
    let power = part(&here, 0).dot(&v) + part(&here, 1).dot(&w);
    let other = part(&there, 0).dot(&v_there) + part(&there, 1).dot(&(at.rotation * w));
    assert!((power - other).abs() < 1e-12, "{power} {other}");
}

#[test]
fn points_and_poses_are_those_of_the_same_place() {
    let (at, held) = (pose(5), pose(6));
    let (p, q) = (held.translation.vector, held.rotation.quaternion());
    let message = ros::messages::Pose {
        position: Vector3 { x: p.x, y: p.y, z: p.z },
        orientation: Quaternion { x: q.i, y: q.j, z: q.k, w: q.w },
    };
    let there = |wanted: Wanted| numbers(message.numbers(wanted).and_then(|n| n.in_frame(wanted, &at)));
    let expected = at * held;
    let moved = at * Point3::from(p);
    assert!((Vector::from_column_slice(&there(Wanted::Point)) - moved.coords).norm() < 1e-12);
    let pose = there(Wanted::Pose);
    let turn = UnitQuaternion::new_normalize(nalgebra::Quaternion::new(pose[3], pose[4], pose[5], pose[6]));
    assert!((Vector::from_column_slice(&pose[..3]) - expected.translation.vector).norm() < 1e-12);
    assert!(turn.angle_to(&expected.rotation) < 1e-12);
    assert_eq!(there(Wanted::Orientation), pose[3..]);
    // A quaternion that is none stays so, and is refused as in the frame of the signal.
    let none = Reading::numbers(&ros::messages::Quaternion::default(), Wanted::Orientation);
    assert_eq!(numbers(none.and_then(|n| n.in_frame(Wanted::Orientation, &at))), [0.0; 4]);
}
