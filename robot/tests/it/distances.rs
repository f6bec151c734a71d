//! Distances: certified from both sides, against sampled points, and by their derivative.
//!
//! Two witness points bound a distance from above; a plane between the shapes bounds it from
//! below. If the two bounds are one, the distance is right, whoever computed it.

use hierarq_robot::geometry::{
    CAPSULES_AT_ONCE, Capsule, closest_box_box, closest_capsules, closest_plane, closest_point_box,
    closest_segment_segment,
};
use hierarq_robot::{Base, Closest, Data, Degenerate, Hull, LinkId, Shape, closest};
use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;

use crate::common::{load, pose, rng, vector};

fn shape(rng: &mut impl FnMut() -> f64) -> Shape {
    match (5.0 * rng()) as u32 {
        0 => Shape::Sphere { radius: 0.02 + 0.4 * rng() },
        1 => Shape::Capsule { radius: 0.02 + 0.3 * rng(), half_length: 0.6 * rng() },
        2 => Shape::Box { half: [0.05 + 0.5 * rng(), 0.05 + 0.5 * rng(), 0.05 + 0.5 * rng()] },
        3 => Shape::Cylinder { radius: 0.02 + 0.4 * rng(), half_length: 0.02 + 0.5 * rng() },
        _ => hull(rng),
    }
}

/// The hull of a few random points, or of points of a thin sheet.
fn hull(rng: &mut impl FnMut() -> f64) -> Shape {
    let count = 4 + (8.0 * rng()) as usize;
    let flat = if rng() < 0.2 { 0.0 } else { 0.6 };
    let points: Vec<Vector3<f64>> =
        (0..count).map(|_| vector(rng, 0.6).component_mul(&Vector3::new(1.0, 1.0, flat))).collect();
    Shape::Hull(Hull::around(&points).unwrap().1)
}

/// The distance of a point from a hull along the normal of one of its faces, found by trying all triples of corners.
fn outside_hull(hull: &Hull, p: &Vector3<f64>) -> f64 {
    let corners = hull.corners();
    let mut worst = f64::NEG_INFINITY;
    for i in 0..corners.len() {
        for j in 0..i {
            for k in 0..j {
                let n = (corners[j] - corners[i]).cross(&(corners[k] - corners[i]));
                let Some(n) = n.try_normalize(1e-9) else { continue };
                for n in [n, -n] {
                    let most = corners.iter().map(|c| c.dot(&n)).fold(f64::NEG_INFINITY, f64::max);
                    if most <= corners[i].dot(&n) + 1e-12 {
                        worst = worst.max(p.dot(&n) - most);
                    }
                }
            }
        }
    }
    worst
}

/// The distance of a point from the shape's core, for hulls along the normal of a face; zero inside.
fn outside(shape: &Shape, X: &Isometry3<f64>, p: &Vector3<f64>) -> f64 {
    let local = X.inverse_transform_point(&(*p).into()).coords;
    let near = match bare(shape).0 {
        Shape::Sphere { .. } => Vector3::zeros(),
        Shape::Capsule { half_length, .. } => Vector3::new(0.0, 0.0, local.z.clamp(-half_length, half_length)),
        Shape::Box { half } => Vector3::from_fn(|i, _| local[i].clamp(-half[i], half[i])),
        Shape::Cylinder { radius, half_length } => {
            let scale = (radius / local.xy().norm()).min(1.0);
            Vector3::new(local.x * scale, local.y * scale, local.z.clamp(-half_length, half_length))
        }
        Shape::Hull(hull) => return outside_hull(&hull, &local).max(0.0),
    };
    (local - near).norm()
}

/// The core of a shape: its radius taken off.
fn bare(shape: &Shape) -> (Shape, f64) {
    match *shape {
        Shape::Sphere { radius } => (Shape::Sphere { radius: 0.0 }, radius),
        Shape::Capsule { radius, half_length } => (Shape::Capsule { radius: 0.0, half_length }, radius),
        _ => (shape.clone(), 0.0),
    }
}

/// max of n·x over the shape.
fn support(shape: &Shape, X: &Isometry3<f64>, n: &Vector3<f64>) -> f64 {
    let local = X.rotation.inverse() * n;
    n.dot(&X.translation.vector)
        + match *shape {
            Shape::Sphere { radius } => radius * n.norm(),
            Shape::Capsule { radius, half_length } => radius * n.norm() + half_length * local.z.abs(),
            Shape::Box { half } => (0..3).map(|i| half[i] * local[i].abs()).sum(),
            Shape::Cylinder { radius, half_length } => radius * local.xy().norm() + half_length * local.z.abs(),
            Shape::Hull(ref hull) => hull.corners().iter().map(|c| c.dot(&local)).fold(f64::NEG_INFINITY, f64::max),
        }
}

/// A random point of the shape.
fn sample(shape: &Shape, X: &Isometry3<f64>, rng: &mut impl FnMut() -> f64) -> Vector3<f64> {
    let (core, radius) = bare(shape);
    let inside = match core {
        Shape::Sphere { .. } => Vector3::zeros(),
        Shape::Capsule { half_length, .. } => Vector3::new(0.0, 0.0, half_length * (2.0 * rng() - 1.0)),
        Shape::Box { half } => Vector3::from(half).component_mul(&vector(rng, 1.0)),
        Shape::Cylinder { radius, half_length } => {
            let flat = vector(rng, 1.0);
            let scale = radius / flat.xy().norm().max(1.0);
            Vector3::new(flat.x * scale, flat.y * scale, flat.z * half_length)
        }
        Shape::Hull(ref hull) => {
            let weights: Vec<f64> = hull.corners().iter().map(|_| rng() + 1e-3).collect();
            let sum: f64 = weights.iter().sum();
            hull.corners().iter().zip(&weights).fold(Vector3::zeros(), |p, (c, w)| p + c * (w / sum))
        }
    };
    let mut around = vector(rng, 1.0);
    around *= radius / around.norm().max(1.0);
    X.transform_point(&(inside + around).into()).coords
}

/// The widest gap between the cores along the normals of their faces, the common normals of their
/// edges, and those of both: no gap means that they meet (the separating axis theorem).
fn gap(a: &Shape, X_Wa: &Isometry3<f64>, b: &Shape, X_Wb: &Isometry3<f64>) -> f64 {
    let ((core_a, _), (core_b, _)) = (bare(a), bare(b));
    let edges = |X: &Isometry3<f64>| (0..3).map(|i| X.rotation * Vector3::ith(i, 1.0)).collect::<Vec<_>>();
    let (u, v) = (edges(X_Wa), edges(X_Wb));
    let mut axes = [u.clone(), v.clone(), vec![X_Wa.translation.vector - X_Wb.translation.vector]].concat();
    for n in u.iter().flat_map(|u| v.iter().map(|v| u.cross(v))).collect::<Vec<_>>() {
        axes.push(n);
        axes.extend(u.iter().chain(&v).map(|e| n.cross(e)));
    }
    let along = |n: Vector3<f64>| -support(&core_a, X_Wa, &-n) - support(&core_b, X_Wb, &n);
    axes.iter()
        .filter_map(|n| n.try_normalize(1e-9))
        .flat_map(|n| [along(n), along(-n)])
        .fold(f64::NEG_INFINITY, f64::max)
}

/// True for a shape with an inside of its own, without a radius around it.
fn is_body(shape: &Shape) -> bool {
    matches!(shape, Shape::Box { .. } | Shape::Cylinder { .. } | Shape::Hull(_))
}

/// True for a pair whose distance has no closed form and is approached: a round body against one with corners or round.
fn is_iterative(a: &Shape, b: &Shape) -> bool {
    let round = |s: &Shape| matches!(s, Shape::Cylinder { .. });
    is_body(a) && is_body(b) && (round(a) || round(b))
}

fn certify(a: &Shape, X_Wa: &Isometry3<f64>, b: &Shape, X_Wb: &Isometry3<f64>, c: &Closest) {
    assert!((c.normal.norm() - 1.0).abs() < 1e-9, "{c:?}");
    assert!((c.normal.dot(&(c.on_a - c.on_b)) - c.distance).abs() < 1e-9, "{c:?}");
    assert!((c.on_a - c.on_b - c.normal * c.distance).norm() < 1e-9, "{c:?}");
    let ((core_a, ra), (core_b, rb)) = (bare(a), bare(b));
    let (p, q) = (c.on_a + c.normal * ra, c.on_b - c.normal * rb);
    // The witnesses of the cores are points of the cores.
    assert!(outside(a, X_Wa, &p) < 1e-9, "not on a: {c:?} {a:?}");
    assert!(outside(b, X_Wb, &q) < 1e-9, "not on b: {c:?} {b:?}");
    // No direction separates the cores by more, this one separates them by as much.
    let low_a = -support(&core_a, X_Wa, &-c.normal);
    let high_b = support(&core_b, X_Wb, &c.normal);
    assert!((low_a - high_b - (c.distance + ra + rb)).abs() < 1e-9, "no separating plane: {c:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn every_distance_is_certified(seed in any::<u64>(), near in 0.2f64..1.6) {
        let mut rng = rng(seed);
        let (a, b) = (shape(&mut rng), shape(&mut rng));
        let (X_Wa, X_Wb) = (pose(&mut rng, near), pose(&mut rng, near));
        match closest(&a, &X_Wa, &b, &X_Wb) {
            Ok(c) => {
                let back = closest(&b, &X_Wb, &a, &X_Wa).unwrap();
                let accuracy = if is_iterative(&a, &b) { 1e-10 } else { 1e-12 };
                prop_assert!((back.distance - c.distance).abs() < accuracy);
                // An angle is as accurate as the root of the distance's accuracy.
                let accuracy = if is_iterative(&a, &b) { 1e-4 } else { 1e-9 };
                prop_assert!((back.normal + c.normal).norm() < accuracy);
                let cores_apart = c.distance + bare(&a).1 + bare(&b).1 > 0.0;
                if cores_apart {
                    certify(&a, &X_Wa, &b, &X_Wb, &c);
                } else {
                    // A centre inside a body: nothing shorter leads out.
                    prop_assert!([&a, &b].iter().any(|s| is_body(s)));
                }
                for _ in 0..20 {
                    let (p, q) = (sample(&a, &X_Wa, &mut rng), sample(&b, &X_Wb, &mut rng));
                    prop_assert!((p - q).norm() >= c.distance - 1e-9);
                }
            }
            Err(Degenerate::Touching) => {
                let gap = gap(&a, &X_Wa, &b, &X_Wb);
                prop_assert!(gap < 1e-9, "{a:?} {b:?} are {gap} apart");
            }
        }
    }

    /// Pairs of capsules at once are the pairs one by one, to the last bit.
    #[test]
    fn capsules_at_once_are_those_one_by_one(seed in any::<u64>(), near in 0.1f64..1.6, odd in 0u32..6) {
        let mut rng = rng(seed);
        let mut capsule = || Shape::Capsule { radius: 0.3 * rng(), half_length: 0.01 + 0.6 * rng() };
        let shapes: [[Shape; 2]; CAPSULES_AT_ONCE] = std::array::from_fn(|_| [capsule(), capsule()]);
        let mut poses: [[Isometry3<f64>; 2]; CAPSULES_AT_ONCE] =
            std::array::from_fn(|_| [pose(&mut rng, near), pose(&mut rng, near)]);
        match odd {
            // Parallel, the same, and not finite.
            0 => poses[1][1].rotation = poses[1][0].rotation,
            1 => poses[2][1] = poses[2][0],
            2 => poses[3][0].translation.vector.x = [f64::NAN, f64::INFINITY, 1e200][(3.0 * rng()) as usize],
            _ => {}
        }
        let side = |k: usize| -> [Capsule; CAPSULES_AT_ONCE] {
            std::array::from_fn(|i| Capsule::of(&shapes[i][k], &poses[i][k]).unwrap())
        };
        let (a, b) = (side(0), side(1));
        let at_once = closest_capsules(&a.each_ref(), &b.each_ref());
        for (i, found) in at_once.into_iter().enumerate() {
            let alone = closest(&shapes[i][0], &poses[i][0], &shapes[i][1], &poses[i][1]);
            match found {
                Some(c) => prop_assert_eq!(Ok(c), alone),
                None => prop_assert!(odd < 3, "{:?}", alone),
            }
        }
    }

    #[test]
    fn what_meets_has_no_normal(seed in any::<u64>()) {
        let mut rng = rng(seed);
        let (a, b) = (shape(&mut rng), shape(&mut rng));
        let (X_Wa, mut X_Wb) = (pose(&mut rng, 1.0), pose(&mut rng, 1.0));
        // Move b so that the cores share a point.
        let shared = |rng: &mut _, s: &Shape, X: &_| sample(&bare(s).0, X, rng);
        let (p, q) = (shared(&mut rng, &a, &X_Wa), shared(&mut rng, &b, &X_Wb));
        X_Wb.translation.vector += p - q;
        match (closest(&a, &X_Wa, &b, &X_Wb), &a, &b) {
            (Err(Degenerate::Touching), ..) => {}
            // A point inside a body is the one case with a way out.
            (Ok(c), Shape::Sphere { radius }, body) | (Ok(c), body, Shape::Sphere { radius }) if is_body(body) => {
                prop_assert!(c.distance <= 1e-9 - radius);
            }
            // Bodies that share a single point, up to rounding.
            (Ok(c), ..) => prop_assert!(c.distance + bare(&a).1 + bare(&b).1 <= 1e-9, "{a:?} {b:?} meet, yet {c:?}"),
        }
    }

    #[test]
    fn a_point_in_a_box_leaves_by_the_nearest_face(seed in any::<u64>()) {
        let mut rng = rng(seed);
        let half = [0.1 + rng(), 0.1 + rng(), 0.1 + rng()];
        let p = Vector3::from(half).component_mul(&vector(&mut rng, 1.0));
        let near = closest_point_box(&p, &half);
        let depth = (0..3)
            .flat_map(|i| [half[i] - p[i], half[i] + p[i]])
            .fold(f64::INFINITY, f64::min);
        prop_assert!((near.distance + depth).abs() < 1e-12);
        prop_assert!((near.on_box - p - near.normal * depth).norm() < 1e-12);
    }

    #[test]
    fn a_plane_touches_the_deepest_point(seed in any::<u64>()) {
        let mut rng = rng(seed);
        let (s, X) = (shape(&mut rng), pose(&mut rng, 1.0));
        let n = vector(&mut rng, 1.0).normalize();
        let offset = rng() - 0.5;
        let c = closest_plane(&s, &X, &n, offset);
        prop_assert!((c.distance + support(&s, &X, &-n) + offset).abs() < 1e-12);
        prop_assert!((n.dot(&c.on_b) - offset).abs() < 1e-12);
        let (_, radius) = bare(&s);
        let core = c.on_a + n * radius;
        prop_assert!(outside(&s, &X, &core) < 1e-12);
    }

    #[test]
    fn nearly_parallel_segments(seed in any::<u64>(), tilt in -16i32..-2) {
        let mut rng = rng(seed);
        let d = vector(&mut rng, 1.0);
        let tilt = 10f64.powi(tilt);
        let (a0, b0) = (vector(&mut rng, 1.0), vector(&mut rng, 1.0));
        let (a1, b1) = (a0 + d, b0 + d * (0.3 + rng()) + vector(&mut rng, tilt));
        let (p, q) = closest_segment_segment(&a0, &a1, &b0, &b1);
        let found = (p - q).norm();
        // A grid over one segment, exact on the other.
        let grid = (0..=400).map(|i| {
            let s = a0 + d * (i as f64 / 400.0);
            let t = ((s - b0).dot(&(b1 - b0)) / (b1 - b0).norm_squared()).clamp(0.0, 1.0);
            (s - b0 - (b1 - b0) * t).norm()
        });
        let best = grid.fold(f64::INFINITY, f64::min);
        prop_assert!(found <= best + 1e-9, "{found} > {best}");
        // And the witnesses are on the segments.
        for (x, s0, s1) in [(p, a0, a1), (q, b0, b1)] {
            let t = (x - s0).dot(&(s1 - s0)) / (s1 - s0).norm_squared();
            prop_assert!((-1e-9..=1.0 + 1e-9).contains(&t) && (s0 + (s1 - s0) * t - x).norm() < 1e-9);
        }
    }

    #[test]
    fn no_nan_comes_out(
        // Sizes are sound in every model; poses are measured, and may be anything.
        sizes in prop::collection::vec(prop::sample::select(vec![0.0, 1.0, 1e-300, 1e300]), 6),
        places in prop::collection::vec(
            prop::sample::select(vec![0.0, -0.0, 1.0, 1e-300, 1e300, f64::NAN, f64::INFINITY]), 6),
        kinds in (0u8..5, 0u8..5),
    ) {
        let make = |kind: u8, x: &[f64]| match kind {
            0 => Shape::Sphere { radius: x[0] },
            1 => Shape::Capsule { radius: x[0], half_length: x[1] },
            2 => Shape::Box { half: [x[0], x[1], x[2]] },
            3 => Shape::Cylinder { radius: x[0], half_length: x[1] },
            // The points of a hull are within some kilometres.
            _ => Shape::Hull(
                Hull::around(&[0, 1, 2, 3].map(|i| Vector3::new(x[i % 3], x[(i + 1) % 3], x[i / 2]).map(|x| x.min(1e3))))
                    .unwrap()
                    .1,
            ),
        };
        let (a, b) = (make(kinds.0, &sizes[..3]), make(kinds.1, &sizes[3..]));
        let at = |x: &[f64]| Isometry3::translation(x[0], x[1], x[2]);
        if let Ok(c) = closest(&a, &at(&places[..3]), &b, &at(&places[3..])) {
            prop_assert!(!c.distance.is_nan());
            prop_assert!(c.normal.iter().chain(c.on_a.iter()).chain(c.on_b.iter()).all(|x| !x.is_nan()));
        }
    }
}

#[test]
fn the_derivative_is_the_row_of_the_normal() {
    let model = load(include_str!("arm.urdf"), Base::Floating);
    let mut rng = rng(99);
    let (a, b) = (model.link("tool").unwrap(), model.link("stand").unwrap());
    let (mut data, mut moved) = (Data::new(&model), Data::new(&model));
    let mut checked = 0;
    while checked < 200 {
        let (shape_a, shape_b) = (shape(&mut rng), shape(&mut rng));
        let (X_La, X_Lb) = (pose(&mut rng, 0.3), pose(&mut rng, 0.3));
        let q = model.random_configuration(&mut rng);
        let measure = |data: &Data| {
            let X = |link: LinkId, X: &Isometry3<f64>| data.pose(link) * X;
            closest(&shape_a, &X(a, &X_La), &shape_b, &X(b, &X_Lb))
        };
        model.forward(&q, &mut data);
        // If cores are close, the distance is curved more than differences can follow.
        let Ok(c) = measure(&data) else { continue };
        if c.distance + bare(&shape_a).1 + bare(&shape_b).1 < 0.05 {
            continue;
        }
        let mut row = vec![0.0; model.nv()];
        data.add_point(&model, a, &c.on_a, &c.normal, &mut row);
        data.add_point(&model, b, &c.on_b, &-c.normal, &mut row);
        for (dof, derivative) in row.iter().enumerate() {
            let mut v = vec![0.0; model.nv()];
            v[dof] = 1.0;
            let mut at = |step: f64| {
                let mut q = q.clone();
                model.integrate(&mut q, &v, step);
                model.forward(&q, &mut moved);
                measure(&moved).unwrap().distance
            };
            let step = if is_iterative(&shape_a, &shape_b) { 3e-5 } else { 1e-6 };
            let expected = (at(step) - at(-step)) / (2.0 * step);
            assert!((derivative - expected).abs() < 1e-5, "{derivative} {expected} {shape_a:?} {shape_b:?}");
        }
        checked += 1;
    }
}

#[test]
fn boxes_face_to_face() {
    let (a, b) = ([0.5, 0.5, 0.5], [0.25, 2.0, 0.1]);
    let X_Wb = Isometry3::translation(1.0, 0.3, 0.2);
    let (p, q) = closest_box_box(&Isometry3::identity(), &a, &X_Wb, &b);
    assert!(((p - q).norm() - 0.25).abs() < 1e-15, "{p} {q}");
    // Inside one another.
    let (p, q) = closest_box_box(&Isometry3::identity(), &[3.0; 3], &X_Wb, &b);
    assert_eq!(p, q);
}

#[test]
fn parallel_capsules_meet_in_the_middle_of_their_overlap() {
    let a = Shape::Capsule { radius: 0.1, half_length: 1.0 };
    let b = Shape::Capsule { radius: 0.2, half_length: 0.5 };
    let c = closest(&a, &Isometry3::identity(), &b, &Isometry3::translation(1.0, 0.0, 1.0)).unwrap();
    assert!((c.distance - 0.7).abs() < 1e-15);
    // a spans -1..1, b 0.5..1.5: the overlap is 0.5..1.
    assert!((c.on_a - Vector3::new(0.1, 0.0, 0.75)).norm() < 1e-12, "{c:?}");
    assert!((c.on_b - Vector3::new(0.8, 0.0, 0.75)).norm() < 1e-12, "{c:?}");
}

#[test]
fn overlap_of_round_shapes_is_signed() {
    let ball = Shape::Sphere { radius: 1.0 };
    let c = closest(&ball, &Isometry3::identity(), &ball, &Isometry3::translation(0.5, 0.0, 0.0));
    let c = c.unwrap();
    assert!((c.distance + 1.5).abs() < 1e-15);
    assert!((c.normal + Vector3::x()).norm() < 1e-15);
    let same = closest(&ball, &Isometry3::identity(), &ball, &Isometry3::identity());
    assert_eq!(same, Err(Degenerate::Touching));
}
