//! Equality rows of every target: `J v` is the derivative of the task's own value along the robot's motion, and the
//! right side is the target's rate plus the gain times the error, both computed another way.

use hierarq_stdlib_tasks::bound::Bound;
use hierarq_stdlib_tasks::task::{CurrentValue, CurrentValueType, Task};
use nalgebra::{UnitQuaternion, Vector3};
use robot::{LinkId, Model};

use crate::common::*;

const H: f64 = 1e-6;

/// Target tasks whose values are poses, with random moving targets.
fn pose_cases(model: &Model, rng: &mut impl FnMut() -> f64) -> Vec<Case> {
    let [left, right] = arms(model);
    let frame = |l: LinkId| Bound::Frame("tip".to_string(), l);
    let pose = |rng: &mut dyn FnMut() -> f64| {
        let mut rng = || rng();
        let (p, q) = (vector(&mut rng, 1.0), rotation(&mut rng));
        ([p.x, p.y, p.z], [q.w, q.i, q.j, q.k])
    };
    let mut all = Vec::new();
    let (p, q) = pose(rng);
    let (dp, dq) = ([0.1, -0.2, 0.3], [0.2, 0.1, -0.3, 0.4]);
    all.push(
        Case::new("frame_pose")
            .with("frame", frame(left.tip))
            .moving("position", &p, &dp)
            .moving("orientation", &q, &dq)
            .number("gain", &[2.0, 3.0]),
    );
    all.push(
        Case::new("frame_position").with("frame", frame(left.tip)).moving("position", &p, &dp).number("gain", &[2.0]),
    );
    all.push(
        Case::new("frame_orientation")
            .with("frame", frame(right.tip))
            .moving("orientation", &q, &dq)
            .number("gain", &[3.0]),
    );
    all.push(
        Case::new("uncooperative_motion")
            .with("left_arm", Bound::Arm(left.clone()))
            .with("right_arm", Bound::Arm(right.clone()))
            .pose("left", rng)
            .pose("right", rng)
            .number("gain", &[2.0, 3.0]),
    );
    for alpha in [0.0, 0.3, 0.5, 1.0] {
        for (beta, to) in [(1.0, "left"), (1.0, "world"), (0.0, "left")] {
            for rate in [0.0, 0.7] {
                all.push(cooperative(model, alpha, rate, beta, to, rng));
            }
        }
    }
    all
}

/// `cooperative_motion` with random moving targets.
pub fn cooperative(
    model: &Model,
    alpha: f64,
    alpha_rate: f64,
    beta: f64,
    relative_to: &str,
    rng: &mut impl FnMut() -> f64,
) -> Case {
    let [left, right] = arms(model);
    Case::new("cooperative_motion")
        .with("left_arm", Bound::Arm(left))
        .with("right_arm", Bound::Arm(right))
        .moving("alpha", &[alpha], &[alpha_rate])
        .number("beta", &[beta])
        .with("relative_to", Bound::Choice(relative_to.to_string()))
        .pose("absolute", rng)
        .pose("relative", rng)
        .number("gain", &[2.0, 3.0])
}

/// Angular velocity between two orientations `2 dt` apart, in the axes that they are expressed in.
fn spin(before: &[f64], after: &[f64], dt: f64) -> Vector3<f64> {
    (quaternion(after) * quaternion(before).inverse()).scaled_axis() / (2.0 * dt)
}

/// The derivative of one actual value along `v`, by central differences.
fn derivative(place: &Place, task: &dyn Task, case: &Case, a: &CurrentValue, v: &[f64]) -> Vector3<f64> {
    let value = |s: f64| place.moved(v, s).current_value(task, case, s, a.name, a.ty.len());
    let (before, after) = (value(-H), value(H));
    match a.ty {
        CurrentValueType::Rotation => spin(&before, &after, H),
        _ => (Vector3::from_row_slice(&after) - Vector3::from_row_slice(&before)) / (2.0 * H),
    }
}

/// Rate and error of the target that belongs to an actual value, from the numbers of the case.
fn target(case: &Case, a: &CurrentValue, now: &[f64]) -> (Vector3<f64>, Vector3<f64>) {
    let slot = case.place(a.name);
    let at = |t: f64| case.values_at(t)[slot.at..slot.at + slot.len].to_vec();
    match a.ty {
        CurrentValueType::Rotation => {
            (spin(&at(-H), &at(H), H), (quaternion(&at(0.0)) * quaternion(now).inverse()).scaled_axis())
        }
        _ => {
            let rate = (Vector3::from_row_slice(&at(H)) - Vector3::from_row_slice(&at(-H))) / (2.0 * H);
            (rate, Vector3::from_row_slice(&at(0.0)) - Vector3::from_row_slice(now))
        }
    }
}

/// Relative turn of the two tips; near pi the shortest way changes and nothing has a derivative.
pub fn relative_turn(place: &Place) -> f64 {
    let [left, right] = arms(place.model);
    (place.data.pose(left.tip).rotation.inverse() * place.data.pose(right.tip).rotation).angle()
}

#[test]
fn rows_are_the_derivative_of_the_value_and_right_sides_lead_to_the_target() {
    let mut rng = rng(1);
    let mut largest = 0.0_f64;
    for model in robots() {
        for q in configurations(&model, 5, &mut rng) {
            let place = Place::new(&model, &q);
            let turn = relative_turn(&place);
            for case in pose_cases(&model, &mut rng) {
                if case.name == "cooperative_motion" && turn > 3.1 {
                    continue;
                }
                largest = largest.max(turn);
                let mut task = case.build(&model);
                let w = place.write(&mut *task, &case, 0.0).unwrap();
                let kind = hierarq_stdlib_tasks::find(case.name).unwrap();
                let v = velocity(&model, &mut rng, 1.0);
                assert_eq!(w.lower, w.upper, "{}", case.name);
                for (k, a) in kind.current_values.iter().enumerate() {
                    let now = place.current_value(&*task, &case, 0.0, a.name, a.ty.len());
                    let (rate, error) = target(&case, a, &now);
                    let gain = match (a.ty, case.values[case.place("gain").at..].len()) {
                        (CurrentValueType::Rotation, _) => 3.0,
                        _ => 2.0,
                    };
                    // value' = J v + drift, and the row asks for value' = rate + gain error
                    let moved = derivative(&place, &*task, &case, a, &v);
                    let still = derivative(&place, &*task, &case, a, &vec![0.0; v.len()]);
                    let rows: Vector3<f64> = Vector3::from_fn(|i, _| w.rate(3 * k + i, &v));
                    assert!((moved - still - rows).norm() < 1e-7, "{} {}: {moved} and {rows}", case.name, a.name);
                    // Half a turn off, both ways round are right.
                    if error.norm() < 3.1 {
                        let right: Vector3<f64> = Vector3::from_fn(|i, _| w.lower[3 * k + i]);
                        let expected = rate + error * gain - still;
                        assert!((right - expected).norm() < 1e-7, "{} {}: {right} and {expected}", case.name, a.name);
                    }
                    assert!((w.measures[k] - error.norm()).abs() < 1e-12, "{} {}", case.name, a.name);
                }
            }
        }
    }
    assert!(largest > 2.5, "no large relative turn was met: {largest}");
}

#[test]
fn the_values_are_those_of_the_definitions() {
    let mut rng = rng(2);
    for model in robots() {
        let [left, right] = arms(&model);
        for q in configurations(&model, 5, &mut rng) {
            let place = Place::new(&model, &q);
            let (l, r) = (place.data.pose(left.tip), place.data.pose(right.tip));
            for case in pose_cases(&model, &mut rng) {
                let task = case.build(&model);
                let (alpha, beta) = match case.name {
                    "cooperative_motion" => (case.values[case.place("alpha").at], case.values[case.place("beta").at]),
                    _ => (0.0, 0.0),
                };
                let in_left = matches!(case.params.get("relative_to"), Some(Bound::Choice(c)) if c == "left");
                for a in hierarq_stdlib_tasks::find(case.name).unwrap().current_values {
                    let now = place.current_value(&*task, &case, 0.0, a.name, a.ty.len());
                    let tip = if case.name == "frame_orientation" { r } else { l };
                    let position = match a.name {
                        "position" | "left.position" => tip.translation.vector,
                        "right.position" => r.translation.vector,
                        "absolute.position" => l.translation.vector.lerp(&r.translation.vector, 1.0 - alpha),
                        "relative.position" if beta == 0.0 => r.translation.vector,
                        "relative.position" if in_left => l.inv_mul(r).translation.vector,
                        "relative.position" => r.translation.vector - l.translation.vector,
                        _ => Vector3::zeros(),
                    };
                    let turn: UnitQuaternion<f64> = match a.name {
                        "orientation" | "left.orientation" => tip.rotation,
                        "right.orientation" => r.rotation,
                        "absolute.orientation" if l.rotation.angle_to(&r.rotation) > 3.1 => continue,
                        "absolute.orientation" => l.rotation.slerp(&r.rotation, 1.0 - alpha),
                        "relative.orientation" if beta == 0.0 => r.rotation,
                        "relative.orientation" => l.inv_mul(r).rotation,
                        _ => UnitQuaternion::identity(),
                    };
                    let wrong = match a.ty {
                        CurrentValueType::Rotation => turn.angle_to(&quaternion(&now)),
                        _ => (position - Vector3::from_row_slice(&now)).norm(),
                    };
                    assert!(wrong < 1e-7, "{} {}: {wrong}", case.name, a.name);
                }
            }
        }
    }
}

#[test]
fn swivel_rows_follow_the_angle() {
    let mut rng = rng(3);
    let mut defined = 0;
    for model in robots() {
        let [left, right] = arms(&model);
        for q in configurations(&model, 20, &mut rng) {
            let place = Place::new(&model, &q);
            let mut case = Case::new("swivel_angle").number("gain", &[1.5]);
            let slots = [case.slot(&[2.0], &[0.3]), case.slot(&[-2.5], &[-0.2])];
            let case = case.with("angle", Bound::PerArm(vec![(left.clone(), slots[0]), (right.clone(), slots[1])]));
            let mut task = case.build(&model);
            let w = place.write(&mut *task, &case, 0.0).unwrap();
            for (i, (arm, slot)) in [(&left, slots[0]), (&right, slots[1])].into_iter().enumerate() {
                let name = format!("angle.{}", arm.name);
                let now = place.current_value(&*task, &case, 0.0, &name, 1)[0];
                if now.is_nan() {
                    assert!(w.undefined && w.measures[i].is_nan());
                    assert_eq!((w.lower[i], w.upper[i]), (f64::NEG_INFINITY, f64::INFINITY));
                    assert!(w.j.row(i).iter().all(|&x| x == 0.0));
                    continue;
                }
                defined += 1;
                let v = velocity(&model, &mut rng, 1.0);
                let h = 1e-6 / (1.0 + w.j.row(i).norm());
                let at = |s: f64| place.moved(&v, s).current_value(&*task, &case, s, &name, 1)[0];
                let step = at(h) - at(-h);
                let numeric = step.sin().atan2(step.cos()) / (2.0 * h);
                let scale = 1.0 + w.j.row(i).norm();
                assert!((numeric - w.rate(i, &v)).abs() < 1e-5 * scale, "{numeric} and {}", w.rate(i, &v));
                let wanted = case.values[slot.at] - now;
                let error = UnitQuaternion::from_euler_angles(wanted, 0.0, 0.0).scaled_axis().x;
                assert!((w.lower[i] - case.rates[slot.at] - 1.5 * error).abs() < 1e-9);
                assert!((w.measures[i] - error.abs()).abs() < 1e-9);
                assert_eq!(w.lower[i], w.upper[i]);
            }
        }
    }
    assert!(defined > 100, "only {defined} angles were defined");
}

#[test]
fn joints_are_pulled_and_driven() {
    let mut rng = rng(4);
    for model in robots() {
        let joints = || (0..model.nv()).filter(|dof| model.dofs[*dof].joint.is_some());
        for q in configurations(&model, 3, &mut rng) {
            let place = Place::new(&model, &q);
            let mut case = Case::new("joint_position").with("turns", nearest()).number("gain", &[2.5]);
            let target: Vec<_> = joints().map(|dof| (dof, case.slot(&[rng()], &[rng()]))).collect();
            let case = case.with("target", Bound::PerJoint(target.clone()));
            let mut task = case.build(&model);
            let w = place.write(&mut *task, &case, 0.0).unwrap();
            let mut squares = 0.0;
            for (i, (dof, slot)) in target.iter().enumerate() {
                let mut unit = vec![0.0; model.nv()];
                unit[*dof] = 1.0;
                // The whole robot moves, and the joint's position changes by the row.
                let v = velocity(&model, &mut rng, 1.0);
                let joint = model.dofs[*dof].joint.unwrap();
                let value = |s: f64| model.joint_position(joint, &place.moved(&v, s).q);
                assert!(((value(H) - value(-H)) / (2.0 * H) - w.rate(i, &v)).abs() < 1e-8);
                let error = case.values[slot.at] - model.joint_position(joint, &q);
                squares += error * error;
                assert!((w.lower[i] - case.rates[slot.at] - 2.5 * error).abs() < 1e-12);
                assert_eq!(w.lower[i], w.upper[i]);
            }
            assert!((w.measures[0] - f64::sqrt(squares)).abs() < 1e-12);

            let mut case = Case::new("joint_velocity");
            let wanted: Vec<_> = (0..model.nv()).map(|dof| (dof, case.slot(&[rng()], &[0.0]))).collect();
            let case = case.with("velocity", Bound::PerJoint(wanted));
            let mut task = case.build(&model);
            let w = place.write(&mut *task, &case, 0.0).unwrap();
            assert_eq!(w.j, nalgebra::DMatrix::identity(model.nv(), model.nv()));
            assert_eq!(w.lower.as_slice(), &case.values[..]);
            assert_eq!(w.lower, w.upper);
            let v = velocity(&model, &mut rng, 1.0);
            let mut measures = [0.0];
            task.observe(&place.state(&case.values, &case.rates), &v, &mut [], &mut measures);
            let off = nalgebra::DVector::from_vec(v) - w.lower;
            assert!((measures[0] - off.norm()).abs() < 1e-12);
        }
    }
}
