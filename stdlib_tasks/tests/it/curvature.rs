//! Bounds of the curvature of expressions: no motion at constant speeds within the limits bends a value more.

use hierarq_stdlib_tasks::bound::Geometry;
use hierarq_stdlib_tasks::curvature::bends;
use hierarq_stdlib_tasks::dimension::LENGTH;
use hierarq_stdlib_tasks::expression::{Evaluation, Expression, Leaf, Op, Plane, PlaneDistance};
use nalgebra::Vector3;
use robot::{Base, Model, Shape};

use crate::common::*;
use crate::limits::shaped;

/// Step of the second differences, in s.
const H: f64 = 1e-4;

/// Expressions with all leaves and operations that have a bound.
fn expressions(model: &Model, rng: &mut impl FnMut() -> f64) -> Vec<Expression> {
    let [left, right] = arms(model);
    let point =
        |link, rng: &mut dyn FnMut() -> f64| Leaf::Point { link, offset: Vector3::new(0.1 * rng(), 0.1 * rng(), 0.1) };
    let of = |ops: Vec<Op>, leaves: Vec<Leaf>, outputs: Vec<usize>| Expression {
        ops,
        inputs: vec![],
        leaves,
        outputs,
        dimension: LENGTH,
    };
    let state = |n: usize| (0..n).map(Op::State).collect::<Vec<_>>();
    let with = |mut ops: Vec<Op>, more: &[Op]| {
        ops.extend_from_slice(more);
        ops
    };
    let norm = [Op::Sub(0, 3), Op::Sub(1, 4), Op::Sub(2, 5), Op::Powi(6, 2), Op::Mul(7, 7), Op::Powi(8, 2)];
    let norm = with(with(state(6), &norm), &[Op::Add(9, 10), Op::Add(12, 11), Op::Sqrt(13)]);
    let (a, b) = (point(left.tip, rng), point(right.tip, rng));
    let ball = shaped("ball", left.tip, Shape::Sphere { radius: 0.05 }, rng);
    let rod = shaped("rod", right.tip, Shape::Capsule { radius: 0.03, half_length: 0.1 }, rng);
    let plane = Plane { link: None, normal: Vector3::new(0.6, 0.0, 0.8), offset: 0.1 };
    let last = model.nv() - 1;
    let joints = vec![Leaf::Joint(last), Leaf::Joint(last - 1)];
    let mut all = vec![
        of(state(3), vec![a.clone()], vec![0, 1, 2]),
        of(norm, vec![a.clone(), b.clone()], vec![14]),
        // z of the x axis of a link, and the cosine of a turn.
        of(
            with(state(4), &[Op::Mul(1, 3), Op::Mul(0, 2), Op::Sub(4, 5), Op::Const(2.0), Op::Mul(6, 7), Op::Cos(8)]),
            vec![Leaf::Orientation(left.tip)],
            vec![9],
        ),
        of(with(state(2), &[Op::Mul(0, 1), Op::Sin(2), Op::Neg(3)]), joints.clone(), vec![4]),
        of(
            with(
                state(2),
                &[
                    Op::Const(20.0),
                    Op::Add(0, 2),
                    Op::Div(1, 3),
                    Op::Const(4.0),
                    Op::Div(4, 5),
                    Op::Sqrt(3),
                    Op::Max(6, 7),
                    Op::Abs(8),
                ],
            ),
            joints,
            vec![9],
        ),
        of(state(1), vec![Leaf::Distance(Box::new((ball.clone(), rod)))], vec![0]),
        of(state(1), vec![Leaf::PlaneDistance(Box::new(PlaneDistance { part: ball, plane }))], vec![0]),
        of(
            state(1),
            vec![Leaf::Distance(Box::new((
                Geometry::point("a", left.tip, Vector3::x()),
                Geometry::point("b", right.tip, Vector3::zeros()),
            )))],
            vec![0],
        ),
    ];
    if model.links.iter().any(|l| l.mass > 0.0) {
        all.push(of(state(3), vec![Leaf::Com], vec![0, 1, 2]));
    }
    all
}

#[test]
fn no_motion_bends_a_value_more_than_its_bound() {
    let mut rng = rng(301);
    let mut compared = 0;
    let mut nearest = 0.0_f64;
    for model in [arm7(), canopies(Base::Fixed), canopies(Base::Planar)] {
        let speed: Vec<f64> = (0..model.nv()).map(|_| 0.5 + rng()).collect();
        for e in expressions(&model, &mut rng) {
            let bounds = bends(&e, &model, &speed);
            let mut evaluation = Evaluation::new(&e, &model);
            for _ in 0..60 {
                // Joints stay inside their limits: a step is far shorter than what is left.
                let q = model.random_configuration(&mut rng);
                let v: Vec<f64> = speed
                    .iter()
                    .map(|s| s * if rng() < 0.5 { (2.0 * rng() - 1.0).signum() } else { 2.0 * rng() - 1.0 })
                    .collect();
                let mut at = |dt: f64| {
                    let place = Place::new(&model, &q).moved(&v, dt);
                    let found = evaluation.forward(&place.state(&[], &[])).is_ok();
                    found.then(|| (0..e.outputs.len()).map(|i| evaluation.value(i)).collect::<Vec<_>>())
                };
                let (Some(before), Some(now), Some(after)) = (at(-H), at(0.0), at(H)) else { continue };
                for (i, bound) in bounds.iter().enumerate() {
                    let second = (after[i] - 2.0 * now[i] + before[i]) / (H * H);
                    let noise = 1e-6 + 4e-16 / (H * H) * now[i].abs() * 4.0;
                    assert!(-second <= bound.down + noise, "{:?} bends by {second}, and {bound:?}", e.leaves);
                    assert!(second <= bound.up + noise, "{:?} bends by {second}, and {bound:?}", e.leaves);
                    if bound.down.is_finite() {
                        compared += 1;
                        nearest = nearest.max(-second / bound.down.max(1e-3));
                    }
                }
            }
        }
    }
    assert!(compared > 1500, "{compared}");
    assert!(nearest > 0.3, "no bound is near: {nearest}");
}

#[test]
fn what_has_a_corner_or_a_pole_has_no_bound() {
    let model = arm7();
    let speed = vec![1.0; model.nv()];
    let of = |ops: Vec<Op>| {
        let outputs = vec![ops.len() - 1];
        let leaves = vec![Leaf::Joint(0), Leaf::Joint(1)];
        bends(&Expression { ops, inputs: vec![], leaves, outputs, dimension: LENGTH }, &model, &speed)[0]
    };
    let both = [Op::State(0), Op::State(1)];
    let with = |op: Op| of(both.into_iter().chain([op]).collect());
    assert_eq!(with(Op::Min(0, 1)).down, f64::INFINITY);
    assert_eq!((with(Op::Max(0, 1)).down, with(Op::Max(0, 1)).up), (0.0, f64::INFINITY));
    assert_eq!((with(Op::Abs(0)).down, with(Op::Abs(0)).up), (0.0, f64::INFINITY));
    assert_eq!(with(Op::Div(0, 1)).down, f64::INFINITY);
    assert_eq!(with(Op::Sqrt(0)).down, f64::INFINITY);
    // Sums of joints are straight.
    assert_eq!((with(Op::Add(0, 1)).down, with(Op::Sub(0, 1)).up), (0.0, 0.0));
}
