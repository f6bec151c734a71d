//! Values of signals in messages.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3 as Vector};
use ros::messages::{
    Bool, Float32, Header, Odometry, Pose, PoseStamped, Quaternion, Twist, Vector3, Vector3Stamped, Wrench,
    WrenchStamped,
};
use ros::readings::{Reading, Wanted};

fn vector(v: &Vector<f64>) -> Vector3 {
    Vector3 { x: v.x, y: v.y, z: v.z }
}

fn pose(of: &Isometry3<f64>) -> Pose {
    let q = of.rotation.quaternion();
    Pose { position: vector(&of.translation.vector), orientation: Quaternion { x: q.i, y: q.j, z: q.k, w: q.w } }
}

fn some_pose() -> Isometry3<f64> {
    let turn = UnitQuaternion::from_scaled_axis(Vector::new(0.4, -1.1, 0.3));
    Isometry3::from_parts(Translation3::new(0.5, -0.2, 1.4), turn)
}

#[test]
fn velocities_of_odometry_are_those_of_the_world() {
    // A step along the twist in the frame of the child, against the velocity that a controller is told.
    let at = some_pose();
    let (v, w) = (Vector::new(0.3, -0.1, 0.2), Vector::new(-0.5, 0.8, 0.1));
    let message =
        Odometry { pose: pose(&at), twist: Twist { linear: vector(&v), angular: vector(&w) }, ..Odometry::default() };
    let told = message.numbers(Wanted::MovingPose).unwrap();
    let told = told.as_slice();
    let h = 1e-6;
    let step = |h: f64| at * Isometry3::from_parts((v * h).into(), UnitQuaternion::from_scaled_axis(w * h));
    let (ahead, behind) = (step(h), step(-h));
    let linear = (ahead.translation.vector - behind.translation.vector) / (2.0 * h);
    let angular = (ahead.rotation * behind.rotation.inverse()).scaled_axis() / (2.0 * h);
    assert!((Vector::from_column_slice(&told[7..10]) - linear).norm() < 1e-8, "{told:?} {linear}");
    assert!((Vector::from_column_slice(&told[10..13]) - angular).norm() < 1e-8, "{told:?} {angular}");
    let point = message.numbers(Wanted::MovingPoint).unwrap();
    assert_eq!(point.as_slice()[..3], told[..3]);
    assert_eq!(point.as_slice()[3..], told[7..10]);
}

#[test]
fn quaternions_have_their_real_part_first() {
    let at = some_pose();
    let numbers = PoseStamped { pose: pose(&at), ..PoseStamped::default() }.numbers(Wanted::Pose).unwrap();
    let q = at.rotation.quaternion();
    assert_eq!(numbers.as_slice(), [0.5, -0.2, 1.4, q.w, q.i, q.j, q.k]);
}

#[test]
fn values_that_a_message_does_not_contain_are_none() {
    let point = Vector3Stamped::default();
    assert!(point.numbers(Wanted::Point).is_some() && point.numbers(Wanted::Vector).is_some());
    assert!(point.numbers(Wanted::Pose).is_none() && point.numbers(Wanted::Wrench).is_none());
    assert!(WrenchStamped::default().numbers(Wanted::Point).is_none());
}

#[test]
fn flags_numbers_and_wrenches() {
    let numbers = |n: Option<ros::readings::Numbers>| n.unwrap().as_slice().to_vec();
    assert_eq!(numbers(Bool { data: true }.numbers(Wanted::Number)), [1.0]);
    assert_eq!(numbers(Bool { data: false }.numbers(Wanted::Number)), [-1.0]);
    assert_eq!(numbers(Float32 { data: 0.5 }.numbers(Wanted::Number)), [0.5]);
    let wrench = Wrench { force: Vector3 { x: 1.0, y: 2.0, z: 3.0 }, torque: Vector3 { x: 4.0, y: 5.0, z: 6.0 } };
    let header = Header { frame_id: "tool0".into(), ..Header::default() };
    let message = WrenchStamped { header, wrench };
    assert_eq!(message.frame(), "tool0");
    assert_eq!(numbers(message.numbers(Wanted::Wrench)), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
}
