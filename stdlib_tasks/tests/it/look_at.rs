//! `look_at`: the angle decays as its rows say, against central differences, with a moving point, a moving frame and a
//! point that the robot carries; the shortest way from anywhere, also from half a turn away.

use hierarq_stdlib_tasks::bound::Bound;
use hierarq_stdlib_tasks::dimension::LENGTH;
use hierarq_stdlib_tasks::expression::{Expression, Leaf, Op};
use nalgebra::{UnitQuaternion, Vector3};
use robot::{LinkId, Model};

use crate::common::*;

const H: f64 = 1e-6;
const GAIN: f64 = 1.3;

fn case(link: LinkId, axis: &Vector3<f64>, axis_rate: &Vector3<f64>) -> Case {
    Case::new("look_at")
        .with("frame", Bound::Frame("f".to_string(), link))
        .moving("axis", axis.as_slice(), axis_rate.as_slice())
        .number("gain", &[GAIN])
}

/// The axis and the direction in the world after `s` seconds of `v`; `carried` is the link at whose origin the point is.
fn sight(place: &Place, case: &Case, link: LinkId, carried: Option<LinkId>, v: &[f64], s: f64) -> [Vector3<f64>; 2] {
    let (there, values) = (place.moved(v, s), case.values_at(s));
    let axis = case.place("axis");
    let own = Vector3::from_row_slice(&values[axis.at..axis.at + 3]);
    let point = match carried {
        Some(link) => there.point(link),
        None => {
            let slot = case.place("target");
            Vector3::from_row_slice(&values[slot.at..slot.at + 3])
        }
    };
    [there.data.pose(link).rotation * own.normalize(), (point - there.point(link)).normalize()]
}

fn origin_of(link: LinkId) -> Bound {
    let ops = (0..3).map(Op::State).collect();
    let leaves = vec![Leaf::Point { link, offset: Vector3::zeros() }];
    Bound::Expression(Expression { ops, inputs: Vec::new(), leaves, outputs: vec![0, 1, 2], dimension: LENGTH })
}

fn frames(model: &Model) -> [LinkId; 2] {
    arms(model).map(|arm| arm.tip)
}

/// For any velocity, the rows hold what is left of `θ' = -K θ` and of the way along the great circle.
#[test]
fn rows_are_the_motion_of_the_axis_towards_the_direction() {
    let mut rng = rng(31);
    for model in robots() {
        let [left, right] = frames(&model);
        for q in configurations(&model, 6, &mut rng) {
            let place = Place::new(&model, &q);
            for carried in [None, Some(right)] {
                let axis = vector(&mut rng, 1.0);
                let mut case = case(left, &axis, &vector(&mut rng, 0.3));
                case = match carried {
                    Some(link) => case.with("target", origin_of(link)),
                    None => case.moving("target", vector(&mut rng, 1.5).as_slice(), vector(&mut rng, 0.4).as_slice()),
                };
                let v = velocity(&model, &mut rng, 1.0);
                let at = |s: f64| sight(&place, &case, left, carried, &v, s);
                let [[a0, d0], [a, d], [a1, d1]] = [at(-H), at(0.0), at(H)];
                let angle = |a: &Vector3<f64>, d: &Vector3<f64>| a.cross(d).norm().atan2(a.dot(d));
                let theta = angle(&a, &d);
                if (place.point(left) - place.point(right)).norm() < 0.05 || !(1e-3..3.1).contains(&theta) {
                    continue;
                }
                let w = place.write(&mut *case.build(&model), &case, 0.0).unwrap();
                assert!((w.measures[0] - theta).abs() < 1e-9);
                // Angular velocity of the axis without its own twist, minus that of the direction carried back to it.
                let (a_rate, d_rate) = ((a1 - a0) / (2.0 * H), (d1 - d0) / (2.0 * H));
                let back = UnitQuaternion::rotation_between(&d, &a).unwrap();
                let relative = a.cross(&a_rate) - back * d.cross(&d_rate);
                let error = a.cross(&d).normalize() * theta;
                let rotation = place.data.pose(left).rotation;
                let own = rotation.inverse() * a;
                let t1 = own.cross(&Vector3::ith(own.iamin(), 1.0)).normalize();
                for (i, t) in [t1, own.cross(&t1)].iter().enumerate() {
                    let t = rotation * t;
                    let (left_over, from_row) = (t.dot(&(relative - error * GAIN)), w.rate(i, &v) - w.lower[i]);
                    let scale = 1.0 + w.j.row(i).norm();
                    assert!((left_over - from_row).abs() < 1e-6 * scale, "{left_over} and {from_row}");
                }
                // And so the angle itself decays.
                let rate = (angle(&a1, &d1) - angle(&a0, &d0)) / (2.0 * H);
                let along = a.cross(&d).normalize().dot(&relative);
                assert!((rate + along).abs() < 1e-5, "{rate} and {along}");
            }
        }
    }
}

/// From half a turn away, and from anywhere, the axis comes to the point, at the rate of the gain.
#[test]
fn the_axis_comes_to_the_point() {
    let mut rng = rng(32);
    let model = canopies(robot::Base::Floating);
    let [left, _] = frames(&model);
    for behind in [true, false] {
        let mut place = Place::new(&model, &model.random_configuration(&mut rng));
        let pose = place.data.pose(left);
        let away = if behind { Vector3::new(0.0, 0.0, -1.0) } else { vector(&mut rng, 1.0) };
        let point = pose.translation.vector + pose.rotation * away;
        let case = case(left, &Vector3::z(), &Vector3::zeros()).number("target", point.as_slice());
        let mut task = case.build(&model);
        let (dt, steps) = (1e-3, 3000);
        let first = place.write(&mut *task, &case, 0.0).unwrap().measures[0];
        assert!(!behind || (first - std::f64::consts::PI).abs() < 1e-6);
        for _ in 0..steps {
            let w = place.write(&mut *task, &case, 0.0).unwrap();
            place = place.moved(&follow(&w), dt);
        }
        let last = place.write(&mut *task, &case, 0.0).unwrap().measures[0];
        let expected = first * (-GAIN * dt * f64::from(steps)).exp();
        assert!((last - expected).abs() < 0.02 * expected, "{first} became {last}, {expected} was due");
    }
}

#[test]
fn a_point_in_the_origin_has_no_direction() {
    let model = arm7();
    let [link, _] = frames(&model);
    let place = Place::new(&model, &model.neutral());
    let case = case(link, &Vector3::z(), &Vector3::zeros()).number("target", place.point(link).as_slice());
    let w = place.write(&mut *case.build(&model), &case, 0.0).unwrap();
    assert!(w.undefined && w.measures[0].is_nan() && w.j.iter().all(|x| *x == 0.0));
    assert_eq!((w.lower[0], w.upper[1]), (f64::NEG_INFINITY, f64::INFINITY));
}
