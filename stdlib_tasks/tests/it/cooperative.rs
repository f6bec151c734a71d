//! Cooperative motion: the exact rate of the absolute frame, and its special cases.

use std::f64::consts::PI;

use hierarq_stdlib_tasks::bound::Bound;
use hierarq_stdlib_tasks::so3;
use hierarq_stdlib_tasks::task::Task;
use nalgebra::{UnitQuaternion, Vector3};
use proptest::prelude::*;
use robot::{Base, Model};

use crate::common::*;
use crate::targets::{cooperative, relative_turn};

/// Spatial angular velocity of `slerp(left, right, s)` while both turn at constant rates, by central differences.
fn measured(
    left: UnitQuaternion<f64>,
    right: UnitQuaternion<f64>,
    w_l: Vector3<f64>,
    w_r: Vector3<f64>,
    s: f64,
) -> Vector3<f64> {
    let h = 1e-6;
    let at = |t: f64| {
        let l = UnitQuaternion::from_scaled_axis(w_l * t) * left;
        let r = UnitQuaternion::from_scaled_axis(w_r * t) * right;
        l.slerp(&r, s)
    };
    (at(h) * at(-h).inverse()).scaled_axis() / (2.0 * h)
}

fn direction() -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-1.0..1.0f64).prop_map(Vector3::from).prop_filter("a direction", |v| v.norm() > 0.1)
}

proptest! {
    #[test]
    fn the_absolute_rate_is_exact_at_large_relative_turns(
        start in direction(), axis in direction(), turn in 0.0..3.0f64, s in 0.0..1.0f64,
        w_l in direction(), w_r in direction(),
    ) {
        let left = UnitQuaternion::from_scaled_axis(start * 2.0);
        let phi = axis.normalize() * turn;
        let right = left * UnitQuaternion::from_scaled_axis(phi);
        let r = left.to_rotation_matrix().into_inner();
        let rate = w_l + r * so3::interpolation_rate(&phi, s) * r.transpose() * (w_r - w_l);
        let expected = measured(left, right, w_l, w_r, s);
        prop_assert!((rate - expected).norm() < 1e-6, "{rate} and {expected}");
    }
}

#[test]
fn the_printed_rate_is_right_only_about_the_relative_axis() {
    let phi = Vector3::new(0.0, 0.0, 3.0);
    let (left, right) = (UnitQuaternion::identity(), UnitQuaternion::from_scaled_axis(phi));
    let s = 0.4;
    // thesis (3.32): ω_a = α ω_l + (1 - α) ω_r, that is `s I` in place of the matrix M.
    let printed = |w_l: Vector3<f64>, w_r: Vector3<f64>| w_l + (w_r - w_l) * s;
    let exact = |w_l: Vector3<f64>, w_r: Vector3<f64>| w_l + so3::interpolation_rate(&phi, s) * (w_r - w_l);
    let along = (Vector3::z() * 0.3, Vector3::z() * -0.8);
    let across = (Vector3::zeros(), Vector3::x());
    let truth = measured(left, right, along.0, along.1, s);
    assert!((printed(along.0, along.1) - truth).norm() < 1e-7);
    assert!((exact(along.0, along.1) - truth).norm() < 1e-7);
    let truth = measured(left, right, across.0, across.1, s);
    assert!((exact(across.0, across.1) - truth).norm() < 1e-7);
    assert!((printed(across.0, across.1) - truth).norm() > 0.4, "the printed rate is off by 0.4 of the turn");
}

#[test]
fn the_rows_of_a_robot_are_exact_where_the_printed_ones_are_not() {
    let mut rng = rng(11);
    let model = canopies(Base::Planar);
    let [left, right] = arms(&model);
    let mut seen = 0;
    while seen < 10 {
        let place = Place::new(&model, &model.random_configuration(&mut rng));
        let turn = relative_turn(&place);
        if !(2.5..3.0).contains(&turn) {
            continue;
        }
        seen += 1;
        let case = cooperative(&model, 0.5, 0.0, 1.0, "left", &mut rng);
        let mut task = case.build(&model);
        let w = place.write(&mut *task, &case, 0.0).unwrap();
        let v = velocity(&model, &mut rng, 1.0);
        let orientation =
            |t: f64| quaternion(&place.moved(&v, t).current_value(&*task, &case, 0.0, "absolute.orientation", 4));
        let truth = (orientation(1e-6) * orientation(-1e-6).inverse()).scaled_axis() / 2e-6;
        let rows = Vector3::from_fn(|i, _| w.rate(3 + i, &v));
        let omega = |l| place.data.angular_velocity(&model, l, &v);
        let printed = (omega(left.tip) + omega(right.tip)) * 0.5;
        assert!((rows - truth).norm() < 1e-7);
        assert!((printed - truth).norm() > 1e-2, "at {turn} rad: {printed} and {truth}");
    }
}

#[test]
fn beta_zero_and_alpha_one_are_independent_arms() {
    let mut rng = rng(12);
    for model in robots() {
        let [left, right] = arms(&model);
        for q in configurations(&model, 4, &mut rng) {
            let place = Place::new(&model, &q);
            let together = cooperative(&model, 1.0, 0.0, 0.0, "left", &mut rng);
            let mut apart = Case::new("uncooperative_motion")
                .with("left_arm", Bound::Arm(left.clone()))
                .with("right_arm", Bound::Arm(right.clone()))
                .with("left", together.params["absolute"].clone())
                .with("right", together.params["relative"].clone())
                .with("gain", together.params["gain"].clone());
            (apart.values, apart.rates) = (together.values.clone(), together.rates.clone());
            let a = place.write(&mut *together.build(&model), &together, 0.0).unwrap();
            let b = place.write(&mut *apart.build(&model), &apart, 0.0).unwrap();
            assert!((a.j - b.j).amax() < 1e-12);
            assert!((a.lower - b.lower).amax() < 1e-12);
        }
    }
}

#[test]
fn a_turning_base_is_relative_motion_in_the_world_and_none_in_the_left_tool() {
    let mut rng = rng(13);
    let model = canopies(Base::Planar);
    let mut v = vec![0.0; model.nv()];
    v[model.dof("base_yaw").unwrap()] = 1.0;
    let place = Place::new(&model, &model.random_configuration(&mut rng));
    let [left, right] = arms(&model);
    let between = place.point(right.tip) - place.point(left.tip);
    for (to, expected) in [("left", Vector3::zeros()), ("world", Vector3::z().cross(&between))] {
        let case = cooperative(&model, 0.5, 0.0, 1.0, to, &mut rng);
        let w = place.write(&mut *case.build(&model), &case, 0.0).unwrap();
        let rate = Vector3::from_fn(|i, _| w.rate(6 + i, &v));
        assert!((rate - expected).norm() < 1e-12, "{to}: {rate}");
    }
    assert!(between.xy().norm() > 0.1);
}

/// Velocity that turns the right tip relative to the left one about an axis of the left one, at 1 rad/s.
fn relative_spin(model: &Model, at: &Written, axis: Vector3<f64>) -> Vec<f64> {
    let turning = at.j.rows(9, 3).into_owned().pseudo_inverse(1e-9).unwrap();
    (turning * axis).iter().copied().take(model.nv()).collect()
}

/// Absolute orientation from the rows of a task with unit angular gain and targets at rest: `exp(-e) R_d`.
fn absolute_orientation(case: &Case, w: &Written) -> UnitQuaternion<f64> {
    let error = Vector3::from_fn(|i, _| w.lower[3 + i]);
    let at = case.place("absolute.orientation").at;
    UnitQuaternion::from_scaled_axis(-error) * quaternion(&case.values[at..at + 4])
}

#[test]
fn the_branch_at_entry_is_followed_through_half_a_turn() {
    let mut rng = rng(14);
    let model = canopies(Base::Planar);
    let [left, right] = arms(&model);
    let mut followed = 0;
    while followed < 4 {
        let mut place = Place::new(&model, &model.random_configuration(&mut rng));
        if !(2.0..3.0).contains(&relative_turn(&place)) {
            continue;
        }
        let mut case = cooperative(&model, 0.5, 0.0, 1.0, "left", &mut rng);
        case.rates.fill(0.0);
        let gain = case.place("gain").at;
        case.values[gain..gain + 2].fill(1.0);
        let mut task = case.build(&model);
        task.enter(&place.state(&case.values, &case.rates));
        let write = |place: &Place, task: &mut dyn Task| place.write(task, &case, 0.0).unwrap();
        let mut w = write(&place, &mut *task);
        let relative = |p: &Place| p.data.pose(left.tip).rotation.inverse() * p.data.pose(right.tip).rotation;
        let mut phi = so3::log(&relative(&place));
        // About its own axis the relative rotation grows from less than half a turn to more than three quarters of one.
        let (mut last, mut beyond) = (absolute_orientation(&case, &w), 0);
        for _ in 0..400 {
            let v = relative_spin(&model, &w, phi.normalize());
            if v.iter().any(|v| v.abs() > 50.0) {
                break; // near a posture at which the wrists are singular
            }
            place = place.moved(&v, 0.005);
            w = write(&place, &mut *task);
            let now = absolute_orientation(&case, &w);
            assert!(now.angle_to(&last) < 0.1, "it jumps by {} rad at {}", now.angle_to(&last), phi.norm());
            (last, phi) = (now, so3::log_near(&relative(&place), &phi));
            // R_a = R_l exp(phi/2), with phi on the branch of the entry.
            let expected = place.data.pose(left.tip).rotation * UnitQuaternion::from_scaled_axis(phi * 0.5);
            assert!(expected.angle_to(&now) < 1e-7);
            let v = velocity(&model, &mut rng, 1.0);
            let h = 1e-6;
            let mut side = |h: f64| absolute_orientation(&case, &write(&place.moved(&v, h), &mut *task));
            let truth = (side(h) * side(-h).inverse()).scaled_axis() / (2.0 * h);
            let rows = Vector3::from_fn(|i, _| w.rate(3 + i, &v));
            assert!((rows - truth).norm() < 1e-6 * (1.0 + truth.norm()), "at {}: {rows} and {truth}", phi.norm());
            beyond += usize::from(phi.norm() > 3.3);
            if phi.norm() > 4.8 {
                break;
            }
        }
        followed += usize::from(beyond > 20);
    }
}

#[test]
fn noise_does_not_choose_the_way_at_half_a_turn() {
    let mut rng = rng(15);
    let model = canopies(Base::Planar);
    let case = {
        let mut case = cooperative(&model, 0.5, 0.0, 1.0, "left", &mut rng);
        case.rates.fill(0.0);
        let gain = case.place("gain").at;
        case.values[gain..gain + 2].fill(1.0);
        case
    };
    let mut task = case.build(&model);
    // A posture with the palms half a turn apart, by Newton's method along the axis.
    let mut place = Place::new(&model, &model.random_configuration(&mut rng));
    let mut tries = 0;
    while PI - relative_turn(&place) > 1e-9 {
        tries += 1;
        if tries % 60 == 0 {
            place = Place::new(&model, &model.random_configuration(&mut rng));
        }
        let [left, right] = arms(&model);
        let phi = so3::log(&(place.data.pose(left.tip).rotation.inverse() * place.data.pose(right.tip).rotation));
        let w = place.write(&mut *task, &case, 0.0).unwrap();
        let way = PI - phi.norm();
        place = place.moved(&relative_spin(&model, &w, phi.normalize()), way.min(0.05));
    }
    let entered = |place: &Place, task: &mut dyn Task| {
        task.enter(&place.state(&case.values, &case.rates));
        absolute_orientation(&case, &place.write(task, &case, 0.0).unwrap())
    };
    let first = entered(&place, &mut *task);
    for _ in 0..50 {
        let noise = velocity(&model, &mut rng, 1.0);
        let other = entered(&place.moved(&noise, 1e-3), &mut *task);
        assert!(first.angle_to(&other) < 0.05, "the way has changed: {}", first.angle_to(&other));
        // `initial(absolute.orientation)` is that of the same way.
        let captured = place.current_value(&*task, &case, 0.0, "absolute.orientation", 4);
        assert!(first.angle_to(&quaternion(&captured)) < 1e-7);
    }
}
