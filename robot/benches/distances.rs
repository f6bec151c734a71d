//! Closest points of pairs of shapes. `cargo bench -p hierarq-robot --bench distances`

#![allow(non_snake_case, reason = "frames stand in the names: X_WL, p_W")]

use divan::{Bencher, black_box};
use hierarq_robot::random::units;
use hierarq_robot::{Hull, Shape, closest};
use nalgebra::{Isometry3, Quaternion, UnitQuaternion, Vector3};

fn main() {
    divan::main();
}

/// Two shapes at poses that keep them apart.
struct Pair {
    shapes: [Shape; 2],
    poses: [Isometry3<f64>; 2],
}

fn pairs(count: usize, make: fn(&mut dyn FnMut() -> f64) -> Shape) -> Vec<Pair> {
    let mut rng = units(7);
    let mut one = |x: f64| {
        let shape = make(&mut rng);
        let turn = UnitQuaternion::new_normalize(Quaternion::new(rng() - 0.5, rng() - 0.5, rng() - 0.5, rng() - 0.5));
        let at = Vector3::new(x + 0.2 * rng(), rng(), rng());
        (shape, Isometry3::from_parts(at.into(), turn))
    };
    let mut pair = |_| {
        let ((a, X_a), (b, X_b)) = (one(0.0), one(1.0));
        Pair { shapes: [a, b], poses: [X_a, X_b] }
    };
    (0..count).map(&mut pair).collect()
}

fn capsule(rng: &mut dyn FnMut() -> f64) -> Shape {
    Shape::Capsule { radius: 0.05 + 0.05 * rng(), half_length: 0.05 + 0.2 * rng() }
}

fn cylinder(rng: &mut dyn FnMut() -> f64) -> Shape {
    Shape::Cylinder { radius: 0.05 + 0.05 * rng(), half_length: 0.05 + 0.2 * rng() }
}

/// The hull of 200 points of a ball that is pressed out of shape.
fn hull(rng: &mut dyn FnMut() -> f64) -> Shape {
    let scale = Vector3::new(0.1 + 0.1 * rng(), 0.1 + 0.1 * rng(), 0.1 + 0.1 * rng());
    let mut point = || Vector3::new(rng() - 0.5, rng() - 0.5, rng() - 0.5).normalize().component_mul(&scale);
    let points: Vec<Vector3<f64>> = (0..200).map(|_| point()).collect();
    Shape::Hull(Hull::around(&points).expect("points").1)
}

fn measure(bencher: Bencher, pairs: &[Pair]) {
    bencher.bench(|| {
        for Pair { shapes: [a, b], poses: [X_a, X_b] } in pairs {
            black_box(closest(a, black_box(X_a), b, black_box(X_b)).expect("apart"));
        }
    });
}

#[divan::bench]
fn capsules_162(bencher: Bencher) {
    measure(bencher, &pairs(162, capsule));
}

#[divan::bench]
fn cylinders_60(bencher: Bencher) {
    measure(bencher, &pairs(60, cylinder));
}

#[divan::bench]
fn hulls_60(bencher: Bencher) {
    measure(bencher, &pairs(60, hull));
}
