//! Steps on the manifold: against many small steps, and there and back.

use std::f64::consts::{PI, TAU};

use hierarq_robot::{Base, Data, Limits, LinkId, Model, nearest_turn};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;

use crate::common::{base, load, rng, tree};

fn root(model: &Model, q: &[f64]) -> Isometry3<f64> {
    let mut data = Data::new(model);
    model.forward(q, &mut data);
    *data.pose(model.root())
}

/// Body twist of the base.
fn twist(base: Base, v: &[f64]) -> (Vector3<f64>, Vector3<f64>) {
    let z = Vector3::zeros();
    match base {
        Base::Fixed => (z, z),
        Base::Planar => (Vector3::new(v[0], v[1], 0.0), Vector3::new(0.0, 0.0, v[2])),
        Base::Unicycle => (Vector3::new(v[0], 0.0, 0.0), Vector3::new(0.0, 0.0, v[1])),
        Base::Floating => (Vector3::new(v[0], v[1], v[2]), Vector3::new(v[3], v[4], v[5])),
    }
}

/// Midpoint steps of p' = R v, R' = R [ω]: second order.
fn many_small_steps(X: Isometry3<f64>, (v, w): (Vector3<f64>, Vector3<f64>)) -> Isometry3<f64> {
    let n = 2000;
    let dt = 1.0 / n as f64;
    let half = UnitQuaternion::from_scaled_axis(w * (0.5 * dt));
    let mut X = X;
    for _ in 0..n {
        let middle = X.rotation * half;
        let p = X.translation.vector + middle * v * dt;
        X = Isometry3::from_parts(Translation3::from(p), middle * half);
    }
    X
}

fn apart(a: &Isometry3<f64>, b: &Isometry3<f64>) -> f64 {
    (a.translation.vector - b.translation.vector).norm() + a.rotation.angle_to(&b.rotation)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn a_step_is_many_small_steps(base in base(), seed in any::<u64>(), size in -3i32..1) {
        let model = load("<robot name='r'><link name='l'/></robot>", base);
        let mut rng = rng(seed);
        let mut q = model.random_configuration(&mut rng);
        let v: Vec<f64> =
            (0..model.nv()).map(|_| 10f64.powi(size) * 4.0 * (rng() - 0.5)).collect();
        let expected = many_small_steps(root(&model, &q), twist(base, &v));
        // 0.5 s twice the speed is 1 s.
        let double: Vec<f64> = v.iter().map(|x| 2.0 * x).collect();
        model.integrate(&mut q, &double, 0.5);
        prop_assert!(apart(&root(&model, &q), &expected) < 2e-6);
    }

    #[test]
    fn two_half_steps_are_one(base in base(), seed in any::<u64>()) {
        let model = load("<robot name='r'><link name='l'/></robot>", base);
        let mut rng = rng(seed);
        let q0 = model.random_configuration(&mut rng);
        let v: Vec<f64> = (0..model.nv()).map(|_| 6.0 * (rng() - 0.5)).collect();
        let (mut once, mut twice) = (q0.clone(), q0);
        model.integrate(&mut once, &v, 0.2);
        model.integrate(&mut twice, &v, 0.1);
        model.integrate(&mut twice, &v, 0.1);
        prop_assert!(apart(&root(&model, &once), &root(&model, &twice)) < 1e-12);
    }

    #[test]
    fn there_and_back(text in tree(), base in base(), seed in any::<u64>()) {
        let model = load(&text, base);
        let mut rng = rng(seed);
        let (q0, mut q1) = (model.random_configuration(&mut rng), model.random_configuration(&mut rng));
        let nv = model.nv();
        if base == Base::Unicycle {
            // Only what it can reach comes back.
            let v: Vec<f64> = (0..nv).map(|_| 3.0 * (rng() - 0.5)).collect();
            q1 = q0.clone();
            model.integrate(&mut q1, &v, 1.0);
        }
        let mut v = vec![f64::NAN; nv];
        model.difference(&q0, &q1, &mut v);
        let mut reached = q0.clone();
        model.integrate(&mut reached, &v, 1.0);
        prop_assert!(apart(&root(&model, &reached), &root(&model, &q1)) < 1e-9);
        for (dof, i) in model.dofs.iter().enumerate().filter_map(|(dof, d)| Some((dof, d.q_index?))) {
            let (a, b) = (reached[i], q1[i]);
            let turns = if model.is_on_circle(dof) { ((a - b) / TAU).round() } else { 0.0 };
            prop_assert!((a - b - turns * TAU).abs() < 1e-12);
        }
        // And from a velocity: under half a turn it is found again.
        let v: Vec<f64> = (0..nv).map(|_| 2.0 * (rng() - 0.5)).collect();
        let mut q1 = q0.clone();
        model.integrate(&mut q1, &v, 1.0);
        let mut found = vec![0.0; nv];
        model.difference(&q0, &q1, &mut found);
        for (a, b) in v.iter().zip(&found) {
            prop_assert!((a - b).abs() < 1e-9, "{v:?} {found:?}");
        }
    }
}

#[test]
fn small_and_large_turns_meet() {
    // Either side of every place where a series takes over.
    let model = load("<robot name='r'><link name='l'/></robot>", Base::Floating);
    let q0 = model.neutral();
    for angle in [0.0, 1e-12, 1.9e-8, 2.1e-8, 1.9e-4, 2.1e-4, 0.0099, 0.0101, 1.0, 3.1] {
        let w = Vector3::new(0.6, -0.8, 0.0) * angle;
        let v = [0.3, -0.2, 0.9, w.x, w.y, w.z];
        let mut q1 = q0.clone();
        model.integrate(&mut q1, &v, 1.0);
        let mut found = [0.0; 6];
        model.difference(&q0, &q1, &mut found);
        for (a, b) in v.iter().zip(&found) {
            assert!((a - b).abs() < 1e-11, "{angle}: {v:?} {found:?}");
        }
    }
}

#[test]
fn a_unicycle_drives_an_arc() {
    let model = load("<robot name='r'><link name='l'/></robot>", Base::Unicycle);
    let mut q = vec![1.0, 2.0, 0.0];
    // A quarter of a circle of radius 2 to the left.
    let quarter = std::f64::consts::FRAC_PI_2;
    model.integrate(&mut q, &[2.0 * quarter, quarter], 1.0);
    for (a, b) in q.iter().zip([3.0, 4.0, quarter]) {
        assert!((a - b).abs() < 1e-14, "{q:?}");
    }
    // Straight sideways it cannot go at all.
    let mut v = [1.0; 2];
    model.difference(&[0.0; 3], &[0.0, 1.0, 0.0], &mut v);
    assert_eq!(v, [0.0, 0.0]);
}

#[test]
fn the_quaternion_stays_of_unit_length() {
    let model = load("<robot name='r'><link name='l'/></robot>", Base::Floating);
    let mut q = model.neutral();
    for _ in 0..10_000 {
        model.integrate(&mut q, &[0.1, 0.0, 0.2, 3.0, -2.0, 1.0], 0.01);
    }
    let norm = q[3..].iter().map(|x| x * x).sum::<f64>().sqrt();
    assert!((norm - 1.0).abs() < 1e-14, "{norm}");
}

/// A wheel without limits, a joint with limits of two turns, and a wheel whose follower turns `ratio` times as far.
fn wheels(ratio: f64) -> Model {
    let joint = |name: &str, kind: &str, more: &str| {
        format!(
            "<link name='l_{name}'/><joint name='{name}' type='{kind}'><parent link='base'/><child link='l_{name}'/>\
             <origin xyz='0.1 0 0'/><axis xyz='0 0 1'/>{more}</joint>"
        )
    };
    let text = format!(
        "<robot name='r'><link name='base'/>{}{}{}{}</robot>",
        joint("free", "continuous", ""),
        joint("bounded", "revolute", "<limit lower='-12' upper='12' velocity='1' effort='1'/>"),
        joint("geared", "continuous", ""),
        joint("gear", "continuous", &format!("<mimic joint='geared' multiplier='{ratio}'/>"))
    );
    load(&text, Base::Fixed)
}

#[test]
fn joints_on_the_circle_are_compared_modulo_a_turn() {
    let model = wheels(-2.0);
    let on_circle = |model: &Model| (0..model.nv()).map(|dof| model.is_on_circle(dof)).collect::<Vec<_>>();
    assert_eq!(on_circle(&model), [true, false, true]);
    assert_eq!(on_circle(&wheels(0.5)), [true, false, false], "half a turn of the follower is another place");
    let mut v = [0.0; 3];
    model.difference(&[3.0, 3.0, -3.0], &[-3.0, -3.0, 3.0], &mut v);
    for (found, expected) in v.iter().zip([TAU - 6.0, -6.0, 6.0 - TAU]) {
        assert!((found - expected).abs() < 1e-15, "{v:?}");
    }
    // Limits of the spec make the joint one of so many turns.
    let mut bounded = model.clone();
    let free = bounded.joint("free").unwrap();
    bounded.set_limits(free, Limits { lower: -20.0, upper: 20.0, ..Limits::NONE });
    assert_eq!(on_circle(&bounded), [false, false, true]);
    // Half a turn keeps its sign, and what is nearer keeps every bit.
    assert_eq!([PI, -PI, 0.1, -0.3].map(nearest_turn), [PI, -PI, 0.1, -0.3]);
}

proptest! {
    #[test]
    fn unwound_positions_are_the_same_places_near_the_reference(
        q in prop::array::uniform3(-40.0..40.0_f64),
        reference in prop::array::uniform3(-40.0..40.0_f64),
    ) {
        let model = wheels(3.0);
        let mut unwound = q;
        model.unwind(&mut unwound, &reference);
        let poses = |q: &[f64]| {
            let mut data = Data::new(&model);
            model.forward(q, &mut data);
            (0..model.links.len()).map(|l| *data.pose(LinkId(l as u32))).collect::<Vec<_>>()
        };
        for (a, b) in poses(&q).iter().zip(&poses(&unwound)) {
            prop_assert!(apart(a, b) < 1e-12);
        }
        prop_assert_eq!(unwound[1], q[1]);
        prop_assert!((unwound[0] - reference[0]).abs() <= PI + 1e-12 && (unwound[2] - reference[2]).abs() <= PI + 1e-12);
    }
}
