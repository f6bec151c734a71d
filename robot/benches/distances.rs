//! Closest points of pairs of shapes. `cargo bench -p hierarq-robot --bench distances`

#![allow(non_snake_case, reason = "frames stand in the names: X_WL, p_W")]

use divan::{Bencher, black_box};
use hierarq_robot::geometry::{CAPSULES_AT_ONCE, Capsule, closest_capsules};
use hierarq_robot::random::units;
use hierarq_robot::{Frontier, Hull, Shape, Soup, closest};
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

/// Nine capsules against 18, each placed once.
#[divan::bench]
fn capsules_162_of_27_parts(bencher: Bencher) {
    let parts: Vec<(Shape, Isometry3<f64>)> = pairs(14, capsule)
        .into_iter()
        .flat_map(|Pair { shapes: [a, b], poses: [X_a, X_b] }| [(a, X_a), (b, X_b)])
        .collect();
    let mut placed: Vec<Capsule> = Vec::with_capacity(parts.len());
    bencher.bench_local(|| {
        placed.clear();
        placed.extend(parts.iter().filter_map(|(shape, pose)| Capsule::of(shape, black_box(pose))));
        let (a, b) = placed.split_at(10);
        for i in (0..160).step_by(CAPSULES_AT_ONCE) {
            let (a, b): ([_; CAPSULES_AT_ONCE], [_; CAPSULES_AT_ONCE]) =
                (std::array::from_fn(|k| &a[(i + k) % 9]), std::array::from_fn(|k| &b[(i + k) / 9]));
            black_box(closest_capsules(&a, &b));
        }
    });
}

#[divan::bench]
fn cylinders_60(bencher: Bencher) {
    measure(bencher, &pairs(60, cylinder));
}

#[divan::bench]
fn hulls_60(bencher: Bencher) {
    measure(bencher, &pairs(60, hull));
}

/// Spots of ten capsules in a room of so many points: floor, walls and a pile of things, as a laser scanner sees them.
fn cloud(bencher: Bencher, count: usize, most: usize, range: f64) {
    let mut rng = units(11);
    let mut point = |i: usize| {
        let (u, v, noise) = (4.0 * rng() - 2.0, 4.0 * rng() - 2.0, 0.01 * rng());
        let p = match i % 8 {
            0 | 1 => Vector3::new(u, v, noise),
            2 => Vector3::new(u, 2.0 + noise, 1.0 + 0.5 * v),
            3 => Vector3::new(u, -2.0 - noise, 1.0 + 0.5 * v),
            4 => Vector3::new(2.0 + noise, u, 1.0 + 0.5 * v),
            _ => Vector3::new(1.0 + 0.2 * u, 0.4 * v, 0.4 + 0.2 * (3.0 * u).sin() * v + noise),
        };
        [p]
    };
    let points: Vec<[Vector3<f64>; 1]> = (0..count).map(&mut point).collect();
    let soup = Soup::new(&points, 0.01).expect("points");
    measure_soup(bencher, &soup, most, range);
}

fn measure_soup(bencher: Bencher, soup: &Soup, most: usize, range: f64) {
    let mut rng = units(12);
    let mut part = || {
        let shape = capsule(&mut rng);
        let turn = UnitQuaternion::new_normalize(Quaternion::new(rng() - 0.5, rng() - 0.5, rng() - 0.5, rng() - 0.5));
        let at = Vector3::new(0.8 * rng() - 0.4, rng() - 0.5, 0.3 + rng());
        (shape, Isometry3::from_parts(at.into(), turn))
    };
    let mut parts: Vec<_> = (0..10).map(|_| (part(), vec![None; most])).collect();
    let mut frontier = Frontier::default();
    frontier.reserve(soup);
    bencher.bench_local(|| {
        for ((shape, pose), spots) in &mut parts {
            black_box(soup.spots(shape, black_box(pose), &Isometry3::identity(), range, spots, &mut frontier));
        }
    });
}

#[divan::bench(args = [1, 4, 8])]
fn points_10000_capsules_10(bencher: Bencher, spots: usize) {
    cloud(bencher, 10_000, spots, f64::INFINITY);
}

/// Spots that count: at 5 /s, a part would have to approach at 3 m/s to feel one that is farther away.
#[divan::bench(args = [1, 4, 8])]
fn points_10000_capsules_10_within_60_cm(bencher: Bencher, spots: usize) {
    cloud(bencher, 10_000, spots, 0.6);
}

#[divan::bench(args = [1, 4])]
fn points_100000_capsules_10_within_60_cm(bencher: Bencher, spots: usize) {
    cloud(bencher, 100_000, spots, 0.6);
}
