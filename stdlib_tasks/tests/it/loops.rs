//! Closing the loop: errors decay as `exp(-K t)`, and the feed-forward follows a moving target.

use hierarq_stdlib_tasks::bound::Bound;
use hierarq_stdlib_tasks::task::CurrentValueType;
use robot::{Base, Model};

use crate::common::*;
use crate::targets::cooperative;

/// Every target type on the dual-arm robot, resting, with gains `k` and `k`; positions and orientations apart.
fn cases(model: &Model, k: f64, rng: &mut impl FnMut() -> f64) -> Vec<Case> {
    let [left, right] = arms(model);
    let frame = Bound::Frame("tip".to_string(), left.tip);
    let mut all = vec![
        Case::new("frame_pose")
            .with("frame", frame.clone())
            .number("position", &[0.0; 3])
            .number("orientation", &[1.0, 0.0, 0.0, 0.0])
            .number("gain", &[k, k]),
        Case::new("frame_position").with("frame", frame.clone()).number("position", &[0.0; 3]).number("gain", &[k]),
        Case::new("frame_orientation")
            .with("frame", frame)
            .number("orientation", &[1.0, 0.0, 0.0, 0.0])
            .number("gain", &[k]),
        Case::new("uncooperative_motion")
            .with("left_arm", Bound::Arm(left.clone()))
            .with("right_arm", Bound::Arm(right.clone()))
            .pose("left", rng)
            .pose("right", rng)
            .number("gain", &[k, k]),
    ];
    let mut swivel = Case::new("swivel_angle").number("gain", &[k]);
    let (a, b) = (swivel.slot(&[0.0], &[0.0]), swivel.slot(&[0.0], &[0.0]));
    all.push(swivel.with("angle", Bound::PerArm(vec![(left, a), (right, b)])));
    for (beta, to) in [(1.0, "left"), (1.0, "world"), (0.0, "left")] {
        let mut case = cooperative(model, 0.3, 0.0, beta, to, rng);
        case.set("gain", &[k, k]);
        all.push(case);
    }
    for case in &mut all {
        case.rates.fill(0.0);
    }
    all
}

/// The names and types of the values that targets belong to.
fn values_of(case: &Case) -> Vec<(String, CurrentValueType)> {
    let kind = hierarq_stdlib_tasks::find(case.name).unwrap();
    let all = kind.current_values.iter();
    if case.name == "swivel_angle" {
        return ["angle.left", "angle.right"].iter().map(|n| ((*n).to_string(), kind.current_values[0].ty)).collect();
    }
    all.map(|a| (a.name.to_string(), a.ty)).collect()
}

/// Sets every target to the task's value at a place.
fn aim(case: &mut Case, model: &Model, at: &Place) {
    let task = case.build(model);
    for (name, ty) in values_of(case) {
        let value = at.current_value(&*task, case, 0.0, &name, ty.len());
        case.set(&name, &value);
    }
}

/// A configuration with bent arms, tools apart by less than half a turn.
fn bent(model: &Model) -> Vec<f64> {
    let mut q = model.neutral();
    for (name, x) in [("1", 0.3), ("2", -0.4), ("3", 0.5), ("4", -1.2), ("5", 0.4), ("6", 0.7), ("7", -0.5)] {
        for side in ["left", "right"] {
            let dof = model.dof(&format!("arm_{side}_{name}")).unwrap();
            q[model.dofs[dof].q_index.unwrap()] = if side == "left" { x } else { 0.8 * x - 0.1 };
        }
    }
    q
}

#[test]
fn errors_decay_at_the_gain() {
    let mut rng = rng(31);
    let (k, period, steps) = (4.0, 1e-3, 250);
    for base in [Base::Unicycle, Base::Floating] {
        let model = canopies(base);
        let start = Place::new(&model, &bent(&model));
        for mut case in cases(&model, k, &mut rng) {
            aim(&mut case, &model, &start.moved(&velocity(&model, &mut rng, 0.25), 1.0));
            let mut task = case.build(&model);
            let mut place = Place::new(&model, &start.q);
            let first = place.write(&mut *task, &case, 0.0).unwrap();
            for _ in 0..steps {
                let w = place.write(&mut *task, &case, 0.0).unwrap();
                assert!(!w.undefined);
                place = place.moved(&follow(&w), period);
            }
            let last = place.write(&mut *task, &case, 0.0).unwrap();
            let expected = (-k * period * f64::from(steps)).exp();
            for (i, (a, b)) in first.measures.iter().zip(&last.measures).enumerate() {
                assert!(*a > 0.02, "{} starts {i} at its target", case.name);
                let decay = b / a;
                assert!((decay / expected - 1.0).abs() < 0.02, "{} {i}: {decay} and {expected}", case.name);
            }
        }
    }
}

#[test]
fn what_is_held_comes_back_at_the_gain() {
    let mut rng = rng(32);
    let model = canopies(Base::Planar);
    let [left, right] = arms(&model);
    let frames = vec![("left".to_string(), left.tip), ("right".to_string(), right.tip)];
    let case = Case::new("hold").with("frames", Bound::Frames(frames)).number("gain", &[3.0, 5.0]);
    let mut task = case.build(&model);
    let home = Place::new(&model, &bent(&model));
    task.enter(&home.state(&case.values, &case.rates));
    assert!(home.write(&mut *task, &case, 0.0).unwrap().lower.amax() < 1e-12);
    let mut place = home.moved(&velocity(&model, &mut rng, 0.2), 1.0);
    let first = place.write(&mut *task, &case, 0.0).unwrap();
    // The rows are those of a pose: the difference of the frames' own places.
    for (i, link) in [left.tip, right.tip].into_iter().enumerate() {
        let (a, b) = (home.data.pose(link), place.data.pose(link));
        assert!((first.measures[2 * i] - (a.translation.vector - b.translation.vector).norm()).abs() < 1e-12);
        assert!((first.measures[2 * i + 1] - a.rotation.angle_to(&b.rotation)).abs() < 1e-9);
        let v = velocity(&model, &mut rng, 1.0);
        let (p, m) = (place.moved(&v, 1e-6), place.moved(&v, -1e-6));
        let slope = (p.point(link) - m.point(link)) / 2e-6;
        let turn = (p.data.pose(link).rotation * m.data.pose(link).rotation.inverse()).scaled_axis() / 2e-6;
        for k in 0..3 {
            assert!((first.rate(6 * i + k, &v) - slope[k]).abs() < 1e-7);
            assert!((first.rate(6 * i + 3 + k, &v) - turn[k]).abs() < 1e-7);
        }
    }
    for _ in 0..200 {
        place = place.moved(&follow(&place.write(&mut *task, &case, 0.0).unwrap()), 1e-3);
    }
    let last = place.write(&mut *task, &case, 0.0).unwrap();
    for i in 0..4 {
        let expected = if i % 2 == 0 { f64::exp(-0.6) } else { f64::exp(-1.0) };
        assert!((last.measures[i] / first.measures[i] / expected - 1.0).abs() < 0.02);
    }
}

/// The error after one step of `h` seconds from a target that is met now and moves on, and the speed of the robot.
fn one_step(model: &Model, case: &Case, place: &Place, h: f64) -> (Vec<f64>, f64) {
    let mut task = case.build(model);
    let w = place.write(&mut *task, case, 0.0).unwrap();
    assert!(w.measures.iter().all(|e| *e < 1e-7), "{}: {:?}", case.name, w.measures);
    let v = follow(&w);
    let speed = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    (place.moved(&v, h).write(&mut *task, case, h).unwrap().measures, speed)
}

#[test]
fn feed_forward_follows_a_moving_target_to_second_order() {
    let mut rng = rng(33);
    for base in [Base::Unicycle, Base::Floating] {
        let model = canopies(base);
        let place = Place::new(&model, &bent(&model));
        for mut case in cases(&model, 2.0, &mut rng) {
            aim(&mut case, &model, &place);
            for (name, ty) in values_of(&case) {
                let slot = case.place(&name);
                for x in &mut case.rates[slot.at..slot.at + ty.len()] {
                    *x = 0.4 * (rng() - 0.5);
                }
            }
            if case.name == "cooperative_motion" {
                let slot = case.place("alpha");
                case.rates[slot.at] = 0.3;
            }
            let (coarse, speed) = one_step(&model, &case, &place, 4e-3);
            let (fine, _) = one_step(&model, &case, &place, 2e-3);
            let mut still = case.clone();
            for (name, ty) in values_of(&case) {
                let slot = case.place(&name);
                still.rates[slot.at..slot.at + ty.len()].fill(0.0);
            }
            for i in 0..coarse.len() {
                // Linear values are met exactly; curved ones lose a quarter as much in half the time.
                let exact = coarse[i] < 1e-8;
                assert!(exact || coarse[i] / fine[i] > 3.0, "{} {i}: {coarse:?} and {fine:?}", case.name);
                assert!(coarse[i] < (4e-3 * (1.0 + speed)).powi(2), "{} {i}: {} at {speed}", case.name, coarse[i]);
            }
            // Without the feed-forward the error is of the first order: the test above could fail.
            let mut task = still.build(&model);
            let w = place.write(&mut *task, &still, 0.0).unwrap();
            let late = place.moved(&follow(&w), 4e-3).write(&mut *task, &case, 4e-3).unwrap();
            assert!(late.measures.iter().any(|e| *e > 2e-4), "{}: {:?}", case.name, late.measures);
        }
    }
}
