//! The planner on robots: the identity of its parts, its bounds, its guarantee, and the baselines.

use super::*;
use crate::safety::Strategy;
use crate::safety::decomposition::dot;
use crate::safety::testing::{rng, robots};
use crate::safety::{Body, Chi, DeviationKind, Direction, HumanPoint, Over, towards};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use robot::{Data, LinkId, Model};
use solver::{ActiveSet, HierarchicalSolver, LevelShape, Problem, Solution, Status};

const PERIOD: f64 = 0.005;

fn position_deviation(row: usize, direction: Direction) -> Deviation {
    Deviation {
        kind: DeviationKind::Position,
        row,
        stiffness: 2.0,
        speed: [-0.4, 0.4],
        reach: Some(0.15),
        direction,
        weight: 1.0,
    }
}

/// The settings of thesis Table 4.1.
fn settings(dofs: usize, deviations: Vec<Deviation>, strategy: Strategy) -> PlannerSettings {
    PlannerSettings {
        period: PERIOD,
        gain: 10.0,
        internal_gain: 1.0,
        internal_speed: vec![2.0; dofs],
        weights: Weights::default(),
        deviations,
        damping: Damping::default(),
        strategy,
    }
}

/// Robot that tracks the pose of its last link, as a controller does around the planner.
struct Scene {
    model: Model,
    data: Data,
    q: Vec<f64>,
    tip: LinkId,
    field: Field,
    jacobian: Vec<f64>,
    above: Vec<Level>,
}

impl Scene {
    fn new(model: Model, q: Vec<f64>, over: Over) -> Scene {
        let links: Vec<LinkId> = (0..model.links.len() as u32).map(LinkId).collect();
        let Ok(body) = Body::of_links(&model, &links) else { panic!("{model:?}") };
        let Ok(field) = Field::new(&model, body, Chi::Distance, over, 3) else { panic!("{over:?}") };
        let tip = LinkId(model.links.len() as u32 - 1);
        let (data, n) = (Data::new(&model), model.nv());
        let mut scene = Scene { model, data, q, tip, field, jacobian: vec![0.0; 6 * n], above: Vec::new() };
        scene.see(&[]);
        scene
    }

    fn see(&mut self, people: &[HumanPoint]) {
        self.model.forward(&self.q, &mut self.data);
        let mut j = DMatrix::zeros(6, self.model.nv());
        self.data.jacobian(&self.model, self.tip, self.data.position(self.tip), &mut j);
        self.jacobian.copy_from_slice(j.transpose().as_slice());
        assert_eq!(self.field.update(&self.model, &self.data, people), Ok(()));
    }

    fn decide(
        &self,
        planner: &mut SafetyPlanner,
        eta: &[f64],
        feedback: &[f64],
        threshold: f64,
        direction: Vector3<f64>,
    ) {
        let n = self.model.nv();
        let task = TaskRows { jacobian: &self.jacobian, stride: n, eta, feedback };
        let frames = [Frame { direction, ..Frame::default() }; 2];
        let frames = &frames[..planner.courses.len()];
        let above = &self.above;
        let tick = Tick { field: &self.field, threshold, threshold_rate: 0.0, task, frames, above };
        assert_eq!(planner.decide(&tick), Ok(()));
    }
}

/// Solves a hierarchy for a plan: the levels above, the rows of the task, the internal motion.
fn cascade(scene: &Scene, above: &[Level], plan: &Plan, feedback: &[f64]) -> Solution {
    let n = scene.model.nv();
    let shape = |rows| LevelShape { rows, hard: false, damping: 0.0 };
    let mut problem = Problem::new(n, &[shape(feedback.len()), shape(n)]);
    for (i, feedback) in feedback.iter().enumerate() {
        let b = plan.rate[i] + feedback;
        problem.levels[0].set(i, &scene.jacobian[i * n..(i + 1) * n], b, b);
    }
    for i in 0..n {
        let unit: Vec<f64> = (0..n).map(|k| f64::from(u8::from(k == i))).collect();
        problem.levels[1].set(i, &unit, plan.u_n[i], plan.u_n[i]);
    }
    problem.levels.splice(0..0, above.iter().cloned());
    let mut solution = Solution::new(&problem);
    ActiveSet::new(&problem).solve(&problem, &mut solution);
    assert_eq!(solution.status, Status::Optimal);
    solution
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    /// On random robots, states, tasks and people: the parts add up to the rate of the resulting velocity, the row is
    /// met up to its slack, and inputs are in their boxes. By differences, the rate is that of the field along that
    /// motion.
    #[test]
    fn the_parts_add_up_and_the_bounds_hold(seed in any::<u64>(), rows in prop::sample::select(vec![3usize, 6])) {
        let mut rng = rng(seed);
        for model in robots() {
            let q = model.random_configuration(&mut rng);
            let n = model.nv();
            let mut scene = Scene::new(model, q, Over::Mean);
            let people: Vec<HumanPoint> = (0..3).map(|_| HumanPoint {
                position: Vector3::from_fn(|_, _| 3.0 * rng() - 1.5),
                velocity: Vector3::from_fn(|_, _| rng() - 0.5),
            }).collect();
            scene.see(&people);
            let mut deviations = vec![position_deviation(0, Direction::Gradient)];
            if rows == 6 {
                deviations.push(Deviation { kind: DeviationKind::Orientation, direction: Direction::Given, ..position_deviation(3, Direction::Given) });
            }
            let Ok(mut planner) = SafetyPlanner::new(settings(n, deviations, Strategy::Program), rows, n, &[]) else { panic!() };
            let mut draw = |scale: f64| -> Vec<f64> { (0..rows).map(|_| scale * (2.0 * rng() - 1.0)).collect() };
            let (eta, feedback) = (draw(0.3), draw(0.1));
            let threshold = scene.field.value() * 0.98;
            for _ in 0..3 {
                scene.decide(&mut planner, &eta, &feedback, threshold, Vector3::new(0.3, -0.5, 0.8));
                let (plan, parts) = (planner.plan().clone(), planner.parts());
                let sum = parts.mu_1 * plan.u_c + dot(&parts.mu_2, &plan.u_alpha) + dot(&parts.mu_3, &plan.u_n) + parts.mu_4;
                prop_assert!((sum - plan.field_rate).abs() < 1e-10 * (1.0 + sum.abs()), "{sum} {}", plan.field_rate);
                let need = -10.0 * plan.margin;
                prop_assert!(plan.field_rate + plan.outcome.slack >= need - 1e-9);
                prop_assert!((0.0..=1.0).contains(&plan.u_c) && plan.outcome.slack >= 0.0);
                prop_assert!(plan.u_alpha.iter().all(|u| u.abs() <= 0.4) && plan.u_n.iter().all(|u| u.abs() <= 2.0));
                let e = 1e-6;
                let mut at = |t: f64| {
                    let mut q = scene.q.clone();
                    scene.model.integrate(&mut q, &plan.velocity, t);
                    scene.model.forward(&q, &mut scene.data);
                    let moved: Vec<_> = people.iter().map(|p| HumanPoint { position: p.position + p.velocity * t, ..*p }).collect();
                    assert_eq!(scene.field.update(&scene.model, &scene.data, &moved), Ok(()));
                    scene.field.value()
                };
                let rate = (at(e) - at(-e)) / (2.0 * e);
                prop_assert!((rate - plan.field_rate).abs() < 1e-4 * (1.0 + rate.abs()), "{rate} {}", plan.field_rate);
                scene.see(&people);
                planner.advance(1.0);
                prop_assert!(planner.offset(0).norm() <= 0.15 + 1e-9);
                let angle = planner.turn(1).angle();
                prop_assert!(angle <= 0.15 + 1e-9);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    /// The statement of the book, tick by tick, for a robot that follows the law and people who walk straight on at the
    /// measured speed: the margin shrinks to `(1 - k_f P) h` less slack and curvature, never further. If the slack was
    /// almost zero all the time, a threshold raised by the loss was kept.
    #[test]
    fn the_margin_in_sampled_time(seed in any::<u64>(), gain in 1.0..200.0f64) {
        let mut rng = rng(seed);
        for model in robots().into_iter().take(2) {
            let (q, n) = (model.random_configuration(&mut rng), model.nv());
            let inside = |model: &Model, q: &[f64]| {
                model.dofs.iter().all(|d| d.q_index.is_none_or(|i| (d.lower..=d.upper).contains(&q[i])))
            };
            let mut scene = Scene::new(model, q, Over::Mean);
            let mut people: Vec<HumanPoint> = (0..3).map(|_| HumanPoint {
                position: Vector3::from_fn(|_, _| 4.0 * rng() - 2.0),
                velocity: Vector3::from_fn(|_, _| 0.6 * rng() - 0.3),
            }).collect();
            scene.see(&people);
            let threshold = scene.field.value() - 0.02;
            let all = PlannerSettings { gain, ..settings(n, vec![position_deviation(0, Direction::Gradient)], Strategy::Program) };
            let Ok(mut planner) = SafetyPlanner::new(all, 3, n, &[]) else { panic!() };
            let eta = [0.2 * rng(), -0.2 * rng(), 0.1];
            let (mut slack, mut loss, mut least) = (0.0f64, 0.0f64, f64::INFINITY);
            for _ in 0..300 {
                scene.decide(&mut planner, &eta, &[0.0; 3], threshold, Vector3::zeros());
                let plan = planner.plan();
                let speed: Vec<f64> = plan.velocity.iter().map(|v| v.abs()).collect();
                let bend = scene.field.curvature_bound(&scene.model, &speed, 0.0);
                let (margin, w) = (plan.margin, plan.outcome.slack);
                scene.model.integrate(&mut scene.q, &plan.velocity, PERIOD);
                planner.advance(1.0);
                if !inside(&scene.model, &scene.q) {
                    break;
                }
                people.iter_mut().for_each(|p| p.position += p.velocity * PERIOD);
                scene.see(&people);
                let next = scene.field.value() - threshold;
                let promised = (1.0 - gain * PERIOD) * margin - PERIOD * w - 0.5 * bend * PERIOD * PERIOD;
                prop_assert!(next >= promised - 1e-9, "{next} {promised}");
                slack = slack.max(w);
                loss = loss.max(0.5 * bend * PERIOD / gain);
                least = least.min(next);
            }
            prop_assert!(least >= -loss - slack / gain - 1e-9, "{least} {loss} {slack}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    /// The controller's hierarchy for a plan contains the task's rows with `rate + feedback` above a level `v = u_n`.
    /// Its solution is the law's velocity if the task is far from singular.
    #[test]
    fn the_hierarchy_follows_the_law(seed in any::<u64>()) {
        let mut rng = rng(seed);
        for model in robots() {
            let (q, n) = (model.random_configuration(&mut rng), model.nv());
            let mut scene = Scene::new(model, q, Over::Mean);
            scene.see(&[HumanPoint { position: Vector3::new(0.7, 0.3, 0.8), velocity: Vector3::new(-0.4, 0.1, 0.0) }]);
            let deviations = vec![position_deviation(0, Direction::Gradient)];
            let Ok(mut planner) = SafetyPlanner::new(settings(n, deviations, Strategy::Program), 3, n, &[]) else { panic!() };
            let feedback = [0.1 * rng(), 0.1, -0.1 * rng()];
            let threshold = scene.field.value() + 0.01;
            scene.decide(&mut planner, &[0.2, 0.1 * rng(), 0.0], &feedback, threshold, Vector3::zeros());
            if planner.parts().damped > 0.0 {
                continue;
            }
            let plan = planner.plan();
            for (a, b) in cascade(&scene, &[], plan, &feedback).x.iter().zip(&plan.velocity) {
                prop_assert!((a - b).abs() < 1e-8, "{a} {b}");
            }
        }
    }
}

/// Results of a run: smallest field, time that the clock lost, largest and mean distance from the path.
struct Run {
    least: f64,
    idle: f64,
    furthest: f64,
    greatest_slack: f64,
}

/// An arm moves to and fro while a person comes near, stays, and leaves; 12 s.
fn run(strategy: Strategy, weights: Weights, threshold: f64) -> Run {
    let model = robots().swap_remove(0);
    let n = model.nv();
    let mut q = model.neutral();
    for (q, x) in q.iter_mut().zip([0.2, 0.7, 0.1, -1.1, 0.1, 0.6, 0.0]) {
        *q = x;
    }
    let mut scene = Scene::new(model, q, Over::Mean);
    let deviations = vec![position_deviation(0, Direction::Given)];
    let Ok(mut planner) =
        SafetyPlanner::new(PlannerSettings { weights, ..settings(n, deviations, strategy) }, 3, n, &[])
    else {
        panic!()
    };
    let start = *scene.data.position(scene.tip);
    let nominal = |c: f64| (start + Vector3::y() * (0.1 * (1.0 - c.cos())), Vector3::y() * (0.1 * c.sin()));
    let mut result = Run { least: f64::INFINITY, idle: 0.0, furthest: 0.0, greatest_slack: 0.0 };
    for k in 0..2400 {
        let t = f64::from(k) * PERIOD;
        // From 1.5 m away to 0.55 m in front of the start, and back.
        let phase = std::f64::consts::PI * (t / 12.0);
        let (near, rate) = (phase.sin().powi(2), std::f64::consts::PI / 12.0 * (2.0 * phase).sin());
        let (away, aside) = (Vector3::new(1.0, 1.2, 0.0), Vector3::new(0.35, 0.3, 0.0));
        let person = HumanPoint { position: start + away + (aside - away) * near, velocity: (aside - away) * rate };
        scene.see(&[person]);
        result.least = result.least.min(scene.field.value());
        let (target, eta) = nominal(planner.clock());
        let tip = *scene.data.position(scene.tip);
        let feedback = (target + planner.offset(0) - tip) * 20.0;
        scene.decide(&mut planner, eta.as_slice(), feedback.as_slice(), threshold, towards(&tip, &person.position));
        let plan = planner.plan();
        result.idle += (1.0 - plan.u_c) * PERIOD;
        result.greatest_slack = result.greatest_slack.max(plan.outcome.slack);
        scene.model.integrate(&mut scene.q, &plan.velocity, PERIOD);
        planner.advance(1.0);
        result.furthest = result.furthest.max((tip - target).norm());
    }
    result
}

/// The guarantee, and the comparison of thesis 4.4.1.3 with the columns of Table 4.2 corrected (correction 10): the
/// planner keeps the field above its threshold; the stop does not, and loses most time but stays on the path; evasion
/// leaves the path.
#[test]
fn the_planner_keeps_the_field_and_the_baselines_do_not() {
    let free = run(Strategy::Program, Weights::default(), 0.0);
    assert!(free.furthest < 0.01 && free.idle == 0.0, "without a threshold nothing is changed");
    let threshold = free.least + 0.06;
    let deviating = run(Strategy::Program, Weights { clock: 1e3, ..Weights::default() }, threshold);
    let slowing = run(Strategy::Program, Weights { clock: 1e-3, ..Weights::default() }, threshold);
    let evading = run(Strategy::Evasive { band: 0.1 }, Weights::default(), threshold);
    let stopping = run(Strategy::Stop, Weights::default(), threshold);
    for planned in [&deviating, &slowing] {
        assert!(planned.least > threshold - 1e-3, "{} {threshold}", planned.least);
    }
    assert!(stopping.least < threshold - 1e-3, "{} {threshold}", stopping.least);
    assert!(stopping.idle > slowing.idle && slowing.idle > deviating.idle);
    assert!(stopping.furthest < 0.01);
    assert!(evading.furthest > stopping.furthest);
    assert_eq!(evading.idle, 0.0);
}

#[test]
fn a_demand_beyond_all_bounds_is_slack_and_nothing_else() {
    let result = run(Strategy::Program, Weights::default(), 50.0);
    assert!(result.greatest_slack > 1.0 && result.least.is_finite());
    assert!(result.furthest <= 0.15 + 0.05, "the deviation is bounded, the task tracks it");
}

#[test]
fn nobody_changes_nothing_and_nonsense_is_an_error() {
    let model = robots().swap_remove(0);
    let n = model.nv();
    let q = model.neutral();
    let mut scene = Scene::new(model, q, Over::Mean);
    let deviations = vec![position_deviation(0, Direction::Given)];
    for strategy in [Strategy::Program, Strategy::Evasive { band: 0.2 }, Strategy::Stop] {
        let Ok(mut planner) = SafetyPlanner::new(settings(n, deviations.clone(), strategy), 3, n, &[]) else {
            panic!()
        };
        scene.see(&[]);
        scene.decide(&mut planner, &[0.1, 0.0, 0.0], &[0.0; 3], 0.8, Vector3::x());
        let plan = planner.plan();
        assert_eq!((plan.u_c, plan.task_share, plan.u_alpha[0]), (1.0, 1.0, 0.0));
        assert_eq!(plan.rate, [0.1, 0.0, 0.0]);
        assert!(plan.u_n.iter().all(|u| *u == 0.0));
        planner.advance(1.0);
        assert_eq!(planner.clock(), PERIOD);

        let j = vec![0.1; 3 * n];
        let task = TaskRows { jacobian: &j, stride: n, eta: &[0.1; 3], feedback: &[0.0; 3] };
        let frames = [Frame::default()];
        let good = Tick { field: &scene.field, threshold: 0.5, threshold_rate: 0.0, task, frames: &frames, above: &[] };
        assert_eq!(planner.decide(&good), Ok(()));
        let nan = [f64::NAN; 3];
        let bad_frame = [Frame { direction: Vector3::repeat(f64::NAN), ..Frame::default() }];
        for bad in [
            Tick { threshold: f64::NAN, ..good },
            Tick { threshold_rate: f64::INFINITY, ..good },
            Tick { frames: &[], ..good },
            Tick { frames: &bad_frame, ..good },
            Tick { task: TaskRows { eta: &nan, ..task }, ..good },
            Tick { task: TaskRows { feedback: &nan, ..task }, ..good },
        ] {
            assert!(planner.decide(&bad).is_err(), "{bad:?}");
        }
        // A field whose update failed is rejected.
        let human = HumanPoint::at_rest(Vector3::repeat(f64::NAN));
        assert!(scene.field.update(&scene.model, &scene.data, &[human]).is_err());
        let bad = Tick { field: &scene.field, threshold: 0.5, threshold_rate: 0.0, task, frames: &frames, above: &[] };
        assert_eq!(planner.decide(&bad), Err(SafetyError::NotFinite { name: "safety field" }));
        assert_eq!(planner.clock(), PERIOD, "errors move nothing");
    }
}

#[test]
fn gains_that_overshoot_and_settings_that_mean_nothing_are_refused() {
    let good = settings(7, vec![position_deviation(0, Direction::Gradient)], Strategy::Program);
    let new = |s: &PlannerSettings| SafetyPlanner::new(s.clone(), 6, 7, &[]).err();
    assert_eq!(new(&good), None);
    type Change = fn(&mut PlannerSettings);
    let bad: [(&str, Change); 9] = [
        ("gain", |s| s.gain = 201.0),
        ("stiffness", |s| s.deviations[0].stiffness = 201.0),
        ("period", |s| s.period = f64::NAN),
        ("internal gain", |s| s.internal_gain = -1.0),
        ("weight", |s| s.weights.slack = 0.0),
        ("speeds", |s| s.internal_speed.truncate(6)),
        ("speed", |s| s.internal_speed[3] = f64::NAN),
        ("band", |s| s.strategy = Strategy::Evasive { band: 1.0 }),
        ("rows", |s| s.deviations.push(position_deviation(2, Direction::Gradient))),
    ];
    for (what, change) in bad {
        let mut s = good.clone();
        change(&mut s);
        assert!(new(&s).is_some(), "{what}");
    }
    let mut s = good.clone();
    s.gain = 1.0 / s.period;
    assert_eq!(new(&s), None, "exactly one is allowed");
}

#[path = "limited_tests.rs"]
mod limited;
