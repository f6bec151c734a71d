//! Expressions of the points of people: values against brute force, rows and rates against central differences while
//! the robot and the points move.

use hierarq_stdlib_tasks::bound::Geometry;
use hierarq_stdlib_tasks::closest_points::SeparationError;
use hierarq_stdlib_tasks::dimension::LENGTH;
use hierarq_stdlib_tasks::expression::{Evaluation, Expression, Leaf, Op, PointDistance};
use hierarq_stdlib_tasks::field::{DistanceProgram, FieldProgram, Over};
use nalgebra::Vector3;
use proptest::prelude::*;
use robot::{LinkId, Model, Shape};

use crate::common::*;
use crate::limits::shaped;

/// The square of a leaf that reads the points whose numbers stand first in the table of values: a derivative that comes
/// from above the leaf has to pass through it.
fn squared(model: &Model, leaf: Leaf, points: usize) -> Evaluation {
    let n = 3 * points;
    let mut ops: Vec<Op> = (0..n).map(Op::Input).collect();
    ops.extend([Op::State(0), Op::Mul(n, n)]);
    let e = Expression { ops, inputs: (0..n).collect(), leaves: vec![leaf], outputs: vec![n + 1], dimension: LENGTH };
    assert_eq!(e.check(model, n), Ok(()));
    Evaluation::new(&e, model)
}

/// The value at `t` seconds from now, of a robot that moves with `v` and points that move with `rates`.
fn later(e: &mut Evaluation, place: &Place, v: &[f64], (values, rates): (&[f64], &[f64]), t: f64) -> f64 {
    let values: Vec<f64> = values.iter().zip(rates).map(|(x, r)| x + t * r).collect();
    e.forward(&place.moved(v, t).state(&values, rates)).unwrap();
    e.value(0)
}

/// The rate that the row and the points' motion give, and that of central differences.
fn rates(e: &mut Evaluation, place: &Place, v: &[f64], (values, rates): (&[f64], &[f64])) -> [f64; 2] {
    let state = place.state(values, rates);
    e.forward(&state).unwrap();
    let mut row = vec![0.0; place.model.nv()];
    let still = e.add_row(&state, &[1.0], &mut row);
    let given = row.iter().zip(v).map(|(j, v)| j * v).sum::<f64>() + still;
    let h = 1e-6;
    let at = |e: &mut Evaluation, t: f64| later(e, place, v, (values, rates), t);
    [given, (at(e, h) - at(e, -h)) / (2.0 * h)]
}

fn numbers(rng: &mut impl FnMut() -> f64, count: usize, reach: f64) -> Vec<f64> {
    (0..count).map(|_| reach * (2.0 * rng() - 1.0)).collect()
}

fn shapes() -> [Shape; 3] {
    [
        Shape::Sphere { radius: 0.05 },
        Shape::Capsule { radius: 0.03, half_length: 0.1 },
        Shape::Box { half: [0.1, 0.06, 0.04] },
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn a_distance_moves_with_the_robot_and_with_the_person(seed in any::<u64>()) {
        let mut rng = rng(seed);
        for model in robots() {
            let [left, _] = arms(&model);
            for shape in shapes() {
                let part = shaped("part", left.tip, shape.clone(), &mut rng);
                let place = Place::new(&model, &model.random_configuration(&mut rng));
                let v = velocity(&model, &mut rng, 1.0);
                let (values, speeds) = (numbers(&mut rng, 6, 2.0), numbers(&mut rng, 6, 1.0));
                // A segment, and a point.
                for ends in [[[0, 1, 2], [3, 4, 5]], [[3, 4, 5]; 2]] {
                    let mut e = squared(&model, Leaf::PointDistance(Box::new(PointDistance { part: part.clone(), ends })), 2);
                    let first = e.forward(&place.state(&values, &speeds));
                    prop_assume!(first.is_ok() && e.value(0) > 1e-4);
                    // The nearest point of the segment to the middle of a ball.
                    if let Shape::Sphere { radius } = shape {
                        let centre = (place.data.pose(part.link) * part.center()).coords;
                        let [a, b] = ends.map(|i| Vector3::new(values[i[0]], values[i[1]], values[i[2]]));
                        let along = (centre - a).dot(&(b - a)) / (b - a).norm_squared();
                        let along = if along.is_finite() { along.clamp(0.0, 1.0) } else { 0.0 };
                        let least = (a * (1.0 - along) + b * along - centre).norm();
                        prop_assert!((e.value(0).sqrt() - (least - radius).abs()).abs() < 1e-9);
                    }
                    let [given, expected] = rates(&mut e, &place, &v, (&values, &speeds));
                    // A corner lies between the two places of the difference.
                    let h = 1e-7;
                    let finer = {
                        let at = |e: &mut Evaluation, t: f64| later(e, &place, &v, (&values, &speeds), t);
                        (at(&mut e, h) - at(&mut e, -h)) / (2.0 * h)
                    };
                    prop_assume!((finer - expected).abs() < 1e-5 * (1.0 + expected.abs()));
                    prop_assert!((given - expected).abs() < 1e-4 * (1.0 + expected.abs()), "{shape:?} {given} {expected}");
                }
            }
        }
    }

    #[test]
    fn a_field_moves_with_the_robot_and_with_people(seed in any::<u64>()) {
        let mut rng = rng(seed);
        for model in robots() {
            let place = Place::new(&model, &model.random_configuration(&mut rng));
            let v = velocity(&model, &mut rng, 1.0);
            let (values, speeds) = (numbers(&mut rng, 9, 1.5), numbers(&mut rng, 9, 1.0));
            let distances = [DistanceProgram::Identity, DistanceProgram::Clamped(1.1), DistanceProgram::Saturating(0.8)];
            for (distance, over) in distances.into_iter().zip([Over::Mean, Over::SoftLeast { sharpness: 7.0 }, Over::Mean]) {
                let field = FieldProgram {
                    name: "near".into(),
                    links: (0..model.links.len() as u32).map(LinkId).collect(),
                    distance,
                    over,
                    points: vec![[0, 1, 2], [3, 4, 5], [6, 7, 8]],
                    dimension: LENGTH,
                };
                let mut e = squared(&model, Leaf::Field(Box::new(field)), 3);
                let [given, expected] = rates(&mut e, &place, &v, (&values, &speeds));
                prop_assert!((given - expected).abs() < 1e-4 * (1.0 + expected.abs()), "{over:?} {given} {expected}");
            }
        }
    }
}

/// A person inside the part: the last way out still counts, and where there never was one, nothing is made up.
#[test]
fn a_person_inside_a_part() {
    let model = arm7();
    let link = model.link("tool").unwrap();
    let rod = Geometry {
        name: "rod".into(),
        link,
        origin: nalgebra::Isometry3::identity(),
        shape: Shape::Capsule { radius: 0.02, half_length: 0.1 },
    };
    let place = Place::new(&model, &model.neutral());
    let inside = place.point(link);
    let ends = [[0, 1, 2]; 2];
    let mut e = squared(&model, Leaf::PointDistance(Box::new(PointDistance { part: rod, ends })), 1);
    let zero = [0.0; 3];
    assert_eq!(e.forward(&place.state(inside.as_slice(), &zero)), Err(SeparationError::Overlap));
    let beside = inside + Vector3::new(0.3, 0.0, 0.0);
    let mut row = vec![0.0; model.nv()];
    e.forward(&place.state(beside.as_slice(), &zero)).unwrap();
    e.forward(&place.state(inside.as_slice(), &zero)).unwrap();
    assert!((e.value(0) - 0.02 * 0.02).abs() < 1e-12, "less by the radius");
    e.add_row(&place.state(inside.as_slice(), &zero), &[1.0], &mut row);
    assert!(row.iter().any(|x| *x != 0.0) && row.iter().all(|x| x.is_finite()));
    // The branch of an `if` that is not chosen may read a person who is absent.
    assert_eq!(e.forward(&place.state(&[f64::NAN, 0.0, 0.0], &zero)), Ok(()));
    assert!(e.value(0).is_nan());
    e.forget();
    assert_eq!(e.forward(&place.state(inside.as_slice(), &zero)), Err(SeparationError::Overlap));
}
