//! The experiments of thesis chapter 3 meet their bounds. The test computes poses from the recorded joints itself, and
//! compares them with the printed trajectories, not with values of the controller.

use crate::common;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use robot::{Data, LinkId, Model};
use runtime::record::summary::MARGIN_TOLERANCE;
use std::f64::consts::PI;

struct Poses {
    model: Model,
    data: Data,
    left: LinkId,
    right: LinkId,
}

impl Poses {
    fn new(program: &runtime::Program) -> Self {
        let model = program.robot.model.clone();
        let link = |n: &str| model.link(n).expect("the robot has tools");
        Poses { data: Data::new(&model), left: link("left_tool"), right: link("right_tool"), model }
    }

    fn at(&mut self, q: &[f64]) -> (Isometry3<f64>, Isometry3<f64>) {
        self.model.forward(q, &mut self.data);
        (*self.data.pose(self.left), *self.data.pose(self.right))
    }
}

fn turn(a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>) -> f64 {
    (a.inverse() * b).angle()
}

const MILLIMETRE: f64 = 1e-3;
const TENTH_OF_A_DEGREE: f64 = 0.1 * PI / 180.0;

#[test]
fn a_safety_tasks_hold_for_fifty_seconds() {
    let program = common::program("safety_tasks.hq");
    let evaluator = common::evaluator(&program);
    // The thesis has no acceleration limits.
    let of_thesis = evaluator.members().iter().filter(|m| m.kind != "joint_acceleration_limits");
    let rows: usize = of_thesis.map(|m| m.margins.len()).sum();
    assert_eq!(rows, 86, "thesis 3.5.1.1: 86 constraints");

    let run = common::run(&program);
    assert_eq!(run.len(), 5000);
    let dofs = &program.robot.model.dofs;
    let all: usize = evaluator.members().iter().map(|m| m.margins.len()).sum();
    let mut closest = vec![f64::INFINITY; all];
    for s in &run {
        assert!(s.fault.is_none(), "a fault at {} s: {:?}", s.time, s.fault);
        for (c, m) in closest.iter_mut().zip(&s.margins) {
            *c = c.min(*m);
        }
        for d in dofs {
            let Some(i) = d.q_index else { continue };
            assert!(
                s.q[i] >= d.lower - MARGIN_TOLERANCE && s.q[i] <= d.upper + MARGIN_TOLERANCE,
                "{} at {} s",
                d.name,
                s.time
            );
        }
        for (d, v) in dofs.iter().zip(&s.command) {
            let limit = if d.name.starts_with("arm_") { 0.5 } else { d.velocity };
            assert!(v.abs() <= limit + MARGIN_TOLERANCE, "{} at {} s: {v}", d.name, s.time);
        }
    }
    for m in evaluator.members() {
        let worst = closest[m.margins.clone()].iter().copied().fold(f64::INFINITY, f64::min);
        assert!(worst >= -MARGIN_TOLERANCE, "{} was passed by {worst}", m.name);
    }
    // The purpose of the experiment: the motion reaches every kind of limit.
    for (name, near) in [
        ("position_limits", 1e-3),
        ("velocity_limits", 1e-6),
        ("deck", 0.05),
        ("head_clear", 0.05),
        ("arms_apart", 0.1),
    ] {
        let m = evaluator.members().iter().find(|m| m.name == name).expect("declared");
        let worst = closest[m.margins.clone()].iter().copied().fold(f64::INFINITY, f64::min);
        assert!(worst < near, "{name} never came into play: {worst}");
    }
}

#[test]
fn b_uncooperative_motion_follows_both_trajectories() {
    let program = common::program("uncooperative_motion.hq");
    let mut poses = Poses::new(&program);
    let (left0, right0) = poses.at(&program.robot.home);
    let run = common::run(&program);
    for s in &run {
        assert!(s.fault.is_none());
        assert!(s.margins.iter().all(|h| *h >= -MARGIN_TOLERANCE));
        let t = s.time;
        let c = 1.0 - (PI * t / 4.0).cos();
        let p_l = left0.translation.vector + Vector3::new(0.1, 0.2, 0.05) * c; // (3.44)
        let r_l = left0.rotation * UnitQuaternion::from_euler_angles(0.0, -PI / 8.0 * c, 0.0); // (3.45), (3.46)
        let p_r = right0.translation.vector + Vector3::new(0.1, 0.4, -0.05) * c; // (3.47), corrected
        let r_r = right0.rotation * UnitQuaternion::from_euler_angles(0.0, 0.0, -PI / 8.0 * c); // (3.48), (3.49)
        if t < 1.0 {
            continue;
        }
        let (left, right) = poses.at(&s.q);
        assert!((left.translation.vector - p_l).norm() < MILLIMETRE, "left position at {t} s");
        assert!((right.translation.vector - p_r).norm() < MILLIMETRE, "right position at {t} s");
        assert!(turn(&left.rotation, &r_l) < TENTH_OF_A_DEGREE, "left orientation at {t} s");
        assert!(turn(&right.rotation, &r_r) < TENTH_OF_A_DEGREE, "right orientation at {t} s");
    }
}

/// Absolute and relative pose with alpha = 0.5, thesis (3.27), (3.28), relative pose in the left tool's frame.
fn cooperative(left: &Isometry3<f64>, right: &Isometry3<f64>) -> (Isometry3<f64>, Isometry3<f64>) {
    let half = left.rotation.slerp(&right.rotation, 0.5);
    let middle = (left.translation.vector + right.translation.vector) * 0.5;
    (Isometry3::from_parts(middle.into(), half), left.inverse() * right)
}

#[test]
fn c_cooperative_motion_follows_absolute_and_relative_frame() {
    let program = common::program("cooperative_motion.hq");
    let mut poses = Poses::new(&program);
    let (left0, right0) = poses.at(&program.robot.home);
    let (absolute0, relative0) = cooperative(&left0, &right0);
    let run = common::run(&program);
    for s in &run {
        assert!(s.fault.is_none());
        assert!(s.margins.iter().all(|h| *h >= -MARGIN_TOLERANCE));
        let t = s.time;
        if t < 1.0 {
            continue;
        }
        let c = 1.0 - (PI * t / 2.0).cos();
        let p_a = absolute0.translation.vector + Vector3::new(0.05, 0.1, 0.0) * c; // (3.50)
        let p_r = relative0.translation.vector + Vector3::new(0.1, 0.0, 0.1) * c; // (3.51)
        let r_r = relative0.rotation * UnitQuaternion::from_euler_angles(0.0, 0.0, -PI / 8.0 * c); // (3.52), (3.53)
        let (left, right) = poses.at(&s.q);
        let (absolute, relative) = cooperative(&left, &right);
        assert!((absolute.translation.vector - p_a).norm() < MILLIMETRE, "absolute position at {t} s");
        assert!(turn(&absolute.rotation, &absolute0.rotation) < TENTH_OF_A_DEGREE, "absolute orientation at {t} s");
        assert!((relative.translation.vector - p_r).norm() < MILLIMETRE, "relative position at {t} s");
        assert!(turn(&relative.rotation, &r_r) < TENTH_OF_A_DEGREE, "relative orientation at {t} s");
    }
}

/// Computes thesis (3.39), literally.
fn swivel(s: Vector3<f64>, e: Vector3<f64>, w: Vector3<f64>) -> f64 {
    let (a, b, c, d) = (Vector3::z(), s - e, s - w, e - w);
    let (ac, bd) = (a.cross(&c), b.cross(&d));
    a.cross(&b).dot(&c).signum() * (ac.dot(&bd) / (ac.norm() * bd.norm())).clamp(-1.0, 1.0).acos()
}

#[test]
fn d_swivel_angles_reach_their_target_while_the_hands_stay() {
    let program = common::program("swivel_angle.hq");
    let mut poses = Poses::new(&program);
    let (left0, right0) = poses.at(&program.robot.home);
    let run = common::run(&program);
    for s in &run {
        assert!(s.fault.is_none());
        assert!(s.margins.iter().all(|h| *h >= -MARGIN_TOLERANCE));
        let (left, right) = poses.at(&s.q);
        for (now, before) in [(left, left0), (right, right0)] {
            assert!(
                (now.translation.vector - before.translation.vector).norm() < 0.5 * MILLIMETRE,
                "a hand moved at {} s",
                s.time
            );
        }
    }
    let last = run.last().expect("ticks");
    poses.at(&last.q);
    for side in ["left", "right"] {
        let at = |k: usize| {
            let link = program.robot.model.link(&format!("arm_{side}_{k}_link")).expect("named so");
            *poses.data.position(link)
        };
        let error = (swivel(at(2), at(4), at(6)) - PI / 4.0).abs();
        assert!(error < 0.5_f64.to_radians(), "{side}: {error} rad");
    }
}

/// Computes the centre of mass at the joint positions of a tick (m).
fn center_of_mass(poses: &mut Poses, q: &[f64]) -> Vector3<f64> {
    poses.at(q);
    let links = poses.model.links.iter().enumerate();
    let moments = links.map(|(i, l)| {
        let center = poses.data.pose(LinkId(i as u32)) * nalgebra::Point3::from(l.center_of_mass);
        (l.mass, center.coords * l.mass)
    });
    let (mass, moment) = moments.fold((0.0, Vector3::zeros()), |(m, p), (mass, moment)| (m + mass, p + moment));
    moment / mass
}

#[test]
fn the_robot_keeps_its_balance() {
    let program = common::program("balance.hq");
    let mut poses = Poses::new(&program);
    let home = &program.robot.home;
    let start = center_of_mass(&mut poses, home);
    let (left0, right0) = poses.at(home);
    let run = common::run(&program);
    let mut most = Vector3::zeros();
    for s in &run {
        assert!(s.fault.is_none(), "a fault at {} s: {:?}", s.time, s.fault);
        assert!(s.margins.iter().all(|h| *h >= -MARGIN_TOLERANCE), "at {} s", s.time);
        most = most.sup(&(center_of_mass(&mut poses, &s.q) - start).abs());
    }
    assert!(most.x < MILLIMETRE && most.y < MILLIMETRE, "{most}");
    assert!(most.y > 0.9 * MILLIMETRE, "the limit was never felt: {most}");
    let last = run.last().expect("ticks");
    let (left, right) = poses.at(&last.q);
    let way = right.translation.vector - right0.translation.vector;
    assert!((way - Vector3::new(0.2, -0.3, -0.2)).norm() < MILLIMETRE, "{way}");
    let apart = |l: &Isometry3<f64>, r: &Isometry3<f64>| (l.translation.vector - r.translation.vector).norm();
    assert!((apart(&left, &right) - 1.5 * apart(&left0, &right0)).abs() < MILLIMETRE);

    // Without the limit the centre of mass moves further.
    let text = std::fs::read_to_string(common::example("balance.hq")).expect("an example");
    let free = common::program_of(&text.replace("hard { balance  above_table", "hard { above_table"));
    let further = common::run(&free)
        .iter()
        .fold(Vector3::zeros(), |m: Vector3<f64>, s| m.sup(&(center_of_mass(&mut poses, &s.q) - start).abs()));
    assert!(further.y > 2.0 * most.y, "{further}");
}
