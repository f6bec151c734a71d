//! Planner below limits: the hierarchy reaches a revised decision, and nothing near it is cheaper.

use super::*;

/// Two levels: joint speeds up to `fastest`, with a row through all of them that may not grow; and one equality.
fn limits(n: usize, fastest: f64, rng: &mut impl FnMut() -> f64) -> Vec<Level> {
    let shape = |rows| LevelShape { rows, hard: true, damping: 0.0 };
    let mut levels = Problem::new(n, &[shape(n + 1), shape(1)]).levels;
    let mut row = || (0..n).map(|_| 2.0 * rng() - 1.0).collect::<Vec<f64>>();
    for i in 0..n {
        let unit: Vec<f64> = (0..n).map(|k| f64::from(u8::from(k == i))).collect();
        levels[0].set(i, &unit, -fastest, fastest);
    }
    levels[0].set(n, &row(), f64::NEG_INFINITY, 0.0);
    levels[1].set(0, &row(), 0.01, 0.01);
    levels
}

/// Runs a planner below limits on a random robot. Returns the shortfall of the hierarchy from the demand with the first
/// plan and, if there is one, with the second plan, together with the distance of its velocity from that of the plan.
fn below_limits(model: Model, slowest: f64, rng: &mut impl FnMut() -> f64) -> (f64, Option<(f64, f64)>) {
    let (q, n) = (model.random_configuration(&mut *rng), model.nv());
    let mut scene = Scene::new(model, q, Over::Mean);
    scene.see(&[HumanPoint { position: Vector3::new(0.7, 0.3, 0.8), velocity: Vector3::new(-0.4, 0.1, 0.0) }]);
    let feedback = [0.1 * rng(), 0.1, -0.1 * rng()];
    let eta = [0.2, 0.1 * rng(), 0.0];
    let threshold = scene.field.value() + 0.01 * rng();
    scene.above = limits(n, slowest + 0.3 * rng(), rng);
    let shapes = scene.above.iter().map(Level::shape).collect::<Vec<_>>();
    let deviations = vec![position_deviation(0, Direction::Gradient)];
    let Ok(mut planner) = SafetyPlanner::new(settings(n, deviations, Strategy::Program), 3, n, &shapes) else {
        panic!()
    };
    scene.decide(&mut planner, &eta, &feedback, threshold, Vector3::zeros());
    let x = cascade(&scene, &scene.above, planner.plan(), &feedback).x;
    let first = planner.plan().need - scene.field.rate(&x);
    let task = TaskRows { jacobian: &scene.jacobian, stride: n, eta: &eta, feedback: &feedback };
    let frames = &[Frame::default()];
    let tick = Tick { field: &scene.field, threshold, threshold_rate: 0.0, task, frames, above: &scene.above };
    let second = planner.reconsider(&tick, &x);
    assert!(second.is_ok(), "{second:?}");
    let second = (second == Ok(true)).then(|| {
        let plan = planner.plan();
        assert!((0.0..=1.0).contains(&plan.u_c) && plan.u_alpha.iter().all(|u| u.abs() <= 0.4));
        let x = cascade(&scene, &scene.above, plan, &feedback).x;
        let apart = x.iter().zip(&plan.velocity).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        nothing_near_is_cheaper(&scene, &planner, &eta, &feedback, rng);
        (plan.need - scene.field.rate(&x), apart)
    });
    (first, second)
}

/// Tries other inputs and internal velocities about a plan that was made below limits: those with which the hierarchy
/// keeps the task and internal speeds cost no less.
fn nothing_near_is_cheaper(
    scene: &Scene,
    planner: &SafetyPlanner,
    eta: &[f64],
    feedback: &[f64],
    rng: &mut impl FnMut() -> f64,
) {
    let (n, plan, w) = (scene.model.nv(), planner.plan(), &planner.settings.weights);
    let j = DMatrix::from_row_slice(3, n, &scene.jacobian[..3 * n]);
    let Some(inverse) = (&j * j.transpose() + DMatrix::identity(3, 3) * planner.parts().damped).try_inverse() else {
        return;
    };
    let null = DMatrix::identity(n, n) - j.transpose() * inverse * &j;
    let along = planner.pushes[0].along;
    let missed = |v: &DVector<f64>, rate: &[f64]| {
        (0..3).map(|i| (j.row(i).transpose().dot(v) - rate[i] - feedback[i]).powi(2)).sum::<f64>()
    };
    let cost = |v: &DVector<f64>, u_c: f64, u_a: f64| {
        let internal =
            &null * (v - DVector::from_column_slice(scene.field.gradient()) * planner.settings.internal_gain);
        let slack = (plan.need - scene.field.rate(v.as_slice())).max(0.0);
        (slack, w.clock * (u_c - 1.0).powi(2) + u_a * u_a + w.internal * internal.norm_squared())
    };
    let own = DVector::from_column_slice(&plan.velocity);
    let ((short, least), residual) = (cost(&own, plan.u_c, plan.u_alpha[0]), missed(&own, &plan.rate));
    for _ in 0..20 {
        let mut near = plan.clone();
        near.u_c = (plan.u_c + 0.1 * (rng() - 0.5)).clamp(0.0, 1.0);
        near.u_alpha[0] = (plan.u_alpha[0] + 0.1 * (rng() - 0.5)).clamp(-0.4, 0.4);
        near.rate = (0..3).map(|i| eta[i] * near.u_c + along[i] * near.u_alpha[0]).collect();
        near.u_n.iter_mut().for_each(|u| *u += 0.1 * (rng() - 0.5));
        let v = DVector::from_vec(cascade(scene, &scene.above, &near, feedback).x);
        let slow = (&null * &v).iter().all(|u| u.abs() <= 2.0);
        if slow && missed(&v, &near.rate) <= residual + 1e-12 {
            // The field has priority over the cost, except for the shortfall that the weights leave anyway.
            let (slack, other) = cost(&v, near.u_c, near.u_alpha[0]);
            assert!(slack > short + 1e-9 || other >= least - 1e-6 * (1.0 + least), "{other} {least}");
            let weighed = |slack: f64, cost: f64| cost + w.slack * slack * slack;
            assert!(weighed(slack, other) >= weighed(short, least) - 1e-3 * (1.0 + least), "{slack} {short}");
        } else {
            assert!(!slow || missed(&v, &near.rate) >= residual - 1e-9, "the task is met better by other inputs");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// The hierarchy reaches a plan that is made below limits, which is better than the plan that ignored them.
    #[test]
    fn a_plan_below_limits_is_what_the_hierarchy_gives(seed in any::<u64>(), slowest in 0.05..0.5f64) {
        let mut rng = rng(seed);
        for model in robots() {
            let (first, second) = below_limits(model, slowest, &mut rng);
            if let Some((second, apart)) = second {
                prop_assert!(apart < 1e-7, "{apart}");
                prop_assert!(second < first, "{second} {first}");
            }
        }
    }
}

/// Contradictory levels above leave the plan as it is: the hierarchy reports them itself.
#[test]
fn limits_that_cannot_be_met_change_nothing() {
    let model = robots().swap_remove(0);
    let (q, n) = (model.neutral(), model.nv());
    let mut scene = Scene::new(model, q, Over::Mean);
    scene.see(&[HumanPoint::at_rest(Vector3::new(0.5, 0.2, 0.6))]);
    let shape = LevelShape { rows: 2, hard: true, damping: 0.0 };
    scene.above = Problem::new(n, &[shape]).levels;
    let mut planner = match SafetyPlanner::new(settings(n, Vec::new(), Strategy::Program), 3, n, &[shape]) {
        Ok(planner) => planner,
        Err(e) => panic!("{e}"),
    };
    let (eta, feedback, unit) =
        ([0.1; 3], [0.0; 3], |k: usize| (0..n).map(|i| f64::from(u8::from(i == k))).collect::<Vec<_>>());
    scene.above[0].set(0, &unit(0), 1.0, 1.0);
    scene.above[0].set(1, &unit(0), 2.0, 2.0);
    scene.decide(&mut planner, &eta, &feedback, scene.field.value() + 0.1, Vector3::zeros());
    let before = planner.plan().clone();
    let task = TaskRows { jacobian: &scene.jacobian, stride: n, eta: &eta, feedback: &feedback };
    let threshold = scene.field.value() + 0.1;
    let tick = Tick { field: &scene.field, threshold, threshold_rate: 0.0, task, frames: &[], above: &scene.above };
    assert_eq!(planner.reconsider(&tick, &vec![0.0; n]), Ok(false));
    let told = Outcome { slack: before.need - scene.field.rate(&vec![0.0; n]), ..before.outcome };
    assert!(told.slack > before.outcome.slack, "what is missing is told");
    let kept = Plan { outcome: told, ..before };
    assert_eq!(planner.plan(), &kept);
    // Levels of a shape that it was not made for change nothing either.
    let other = Problem::new(n, &[LevelShape { rows: 3, ..shape }]).levels;
    assert_eq!(planner.reconsider(&Tick { above: &other, ..tick }, &vec![0.0; n]), Ok(false));
    assert_eq!(planner.plan(), &kept);
}

/// A second plan makes up for most of what limits withhold; in the other cases the robot has no freedom for it.
#[test]
fn what_limits_withhold_is_made_up_for() {
    let (mut short, mut made_up) = (0, 0);
    for seed in 0..60 {
        let mut rng = rng(seed);
        for model in robots() {
            let (first, second) = below_limits(model, 0.3, &mut rng);
            short += usize::from(first > 1e-4);
            made_up += usize::from(first > 1e-4 && second.is_some_and(|(second, _)| second < 1e-5));
        }
    }
    assert!(short > 100 && made_up * 2 > short, "{made_up} of {short}");
}
