//! Vectors and orientations in other axes, compared with explicit products of transforms.

use crate::common;

use common::state::{ARM7, Bench, CANOPIES, program, rng};
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use robot::Data;

type Expected = fn(&Isometry3<f64>, &Isometry3<f64>) -> Vec<f64>;

fn point(p: Point3<f64>) -> Vec<f64> {
    p.coords.iter().copied().collect()
}

fn at(x: &Isometry3<f64>) -> Point3<f64> {
    Point3::from(x.translation.vector)
}

fn vector(v: Vector3<f64>) -> Vec<f64> {
    v.iter().copied().collect()
}

fn pose(x: Isometry3<f64>) -> Vec<f64> {
    [vector(x.translation.vector), turn(x.rotation)].concat()
}

/// Value of `pose([0.1, 0.2, 0.3] m, rpy(0.1 rad, 0.2 rad, 0.3 rad))`.
fn written() -> Isometry3<f64> {
    Isometry3::from_parts(Vector3::new(0.1, 0.2, 0.3).into(), UnitQuaternion::from_euler_angles(0.1, 0.2, 0.3))
}

fn turn(q: UnitQuaternion<f64>) -> Vec<f64> {
    vec![q.w, q.i, q.j, q.k]
}

/// Expressions of two frames, with their expected values.
const CASES: &[(&str, Expected)] = &[
    ("frame(@A).position in @B", |a, b| point(b.inverse() * at(a))),
    ("(frame(@A).position - frame(@B).position) in @B", |a, b| vector(b.rotation.inverse() * (at(a) - at(b)))),
    ("frame(@A).position + (([0.1, 0.2, 0.3] m in @A) in world)", |a, _| point(a * Point3::new(0.1, 0.2, 0.3))),
    ("point(@A, [0.1, 0.2, 0.3] m in @A) in @B", |a, b| point(b.inverse() * a * Point3::new(0.1, 0.2, 0.3))),
    ("((frame(@A).position + frame(@B).position)/2) in @A", |a, b| {
        point(a.inverse() * nalgebra::center(&at(a), &at(b)))
    }),
    ("lerp(frame(@A).position, frame(@B).position, 0.25) in @A", |a, b| {
        point(a.inverse() * Point3::from(at(a).coords.lerp(&at(b).coords, 0.25)))
    }),
    ("([1, 2, 3] m in @A) in @B + [0, 0, 0] m * norm(frame(@A).position)/(1 m)", |a, b| {
        vector(b.rotation.inverse() * (a.rotation * Vector3::new(1.0, 2.0, 3.0)))
    }),
    ("frame(@A).orientation*([0, 0, 1] in @A)", |a, _| vector(a.rotation * Vector3::z())),
    ("inverse(frame(@A).orientation)*(frame(@B).position - frame(@A).position)", |a, b| point(a.inverse() * at(b))),
    ("frame(@B).position in @A in world", |_, b| point(at(b))),
    ("axis_angle([0, 0, 1] in @B, 0.5 rad)*(frame(@A).position in @B)", |a, b| {
        vector(UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.5) * (b.inverse() * at(a)).coords)
    }),
    ("frame(@A).orientation in @B", |a, b| turn(b.rotation.inverse() * a.rotation)),
    ("(rpy(0.1 rad, 0.2 rad, 0.3 rad)*frame(@A).orientation) in @B", |a, b| {
        turn(b.rotation.inverse() * UnitQuaternion::from_euler_angles(0.1, 0.2, 0.3) * a.rotation)
    }),
    ("(rpy(0.1 rad, 0.2 rad, 0.3 rad) in @A) in @B", |a, b| {
        turn(b.rotation.inverse() * a.rotation * UnitQuaternion::from_euler_angles(0.1, 0.2, 0.3))
    }),
    ("frame(@A).pose", |a, _| pose(*a)),
    ("frame(@A).pose in @B", |a, b| pose(b.inverse() * a)),
    ("inverse(frame(@B).pose)*frame(@A).pose", |a, b| pose(b.inverse() * a)),
    ("inverse(frame(@A).pose in @B)", |a, b| pose(a.inverse() * b)),
    ("(pose([0.1, 0.2, 0.3] m, rpy(0.1 rad, 0.2 rad, 0.3 rad)) in @A) in @B", |a, b| pose(b.inverse() * a * written())),
    ("frame(@A).pose*pose([0.1, 0.2, 0.3] m, rpy(0.1 rad, 0.2 rad, 0.3 rad))", |a, _| pose(a * written())),
    ("pose([0.1, 0.2, 0.3] m, rpy(0.1 rad, 0.2 rad, 0.3 rad))*frame(@A).pose", |a, _| pose(written() * a)),
    ("pose(frame(@A).position, frame(@B).orientation)", |a, b| pose(Isometry3::from_parts(a.translation, b.rotation))),
    ("frame(@A).pose*[0.1, 0.2, 0.3] m", |a, _| point(a * Point3::new(0.1, 0.2, 0.3))),
    ("(frame(@A).pose*[0.1, 0.2, 0.3] m) in @B", |a, b| point(b.inverse() * a * Point3::new(0.1, 0.2, 0.3))),
    ("(frame(@A).pose in @B).position in @A", |_, _| vec![0.0; 3]),
    ("lerp(frame(@A).pose, frame(@B).pose, 0.25).position", |a, b| vector(at(a).coords.lerp(&at(b).coords, 0.25))),
    ("lerp(frame(@A).pose, frame(@B).pose, 0.25).orientation", |a, b| turn(a.rotation.slerp(&b.rotation, 0.25))),
];

#[test]
fn values_are_those_of_transforms() {
    for robot in [ARM7, CANOPIES] {
        let tasks: Vec<String> =
            CASES.iter().map(|(text, _)| format!("track({text}) {{ target initial(value) }}")).collect();
        let program = program(robot, &tasks);
        let bench = Bench { program: &program, inputs: vec![0.0; program.values.tape.inputs] };
        let model = bench.model();
        let names = if robot == ARM7 { ["tool", "link_4"] } else { ["left_tool", "right_tool"] };
        let links = names.map(|n| model.link(n).expect("the robot has it"));
        let mut rng = rng(3);
        for _ in 0..20 {
            let q = model.random_configuration(&mut rng);
            let mut data = Data::new(model);
            model.forward(&q, &mut data);
            let [a, b] = links.map(|l| *data.pose(l));
            for (i, (text, expected)) in CASES.iter().enumerate() {
                let wanted = expected(&a, &b);
                let found = bench.value(bench.task(i).as_ref(), &q, 0.0, wanted.len());
                // The quaternions q and -q are the same rotation.
                let turned = if wanted.len() == 3 { 3 } else { wanted.len() - 4 };
                let product: f64 = wanted[turned..].iter().zip(&found[turned..]).map(|(a, b)| a * b).sum();
                let sign = if product < 0.0 { -1.0 } else { 1.0 };
                for (i, (x, y)) in wanted.iter().zip(&found).enumerate() {
                    let y = if i < turned { *y } else { sign * y };
                    assert!((x - y).abs() < 1e-12, "{text}: {wanted:?} and {found:?}");
                }
            }
        }
    }
}
