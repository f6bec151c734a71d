//! A tick of the safety field and its planner allocates nothing: a counting allocator proves it.

#[path = "../../tests/common/allocations.rs"]
mod allocations;

use hierarq_runtime::safety::{
    Body, Chi, Damping, Deviation, DeviationKind, Direction, DistanceFunction, Field, Frame, HumanPoint, Over,
    PlannerSettings, SafetyPlanner, Strategy, TaskRows, Tick, Weights,
};
use nalgebra::{UnitQuaternion, Vector3};
use robot::{Base, Data, LinkId, Model, Options};
use solver::{LevelShape, Problem};

struct Power;

impl DistanceFunction for Power {
    fn evaluate(&self, d: f64) -> (f64, f64) {
        (d * d / (1.0 + d), d * (2.0 + d) / (1.0 + d).powi(2))
    }
}

fn deviation(kind: DeviationKind, row: usize, direction: Direction) -> Deviation {
    Deviation { kind, row, stiffness: 2.0, speed: [-0.4, 0.4], reach: Some(0.2), direction, weight: 1.0 }
}

// One test only: another one beside it would be counted too.
#[test]
fn a_tick_allocates_nothing() {
    allocations::are_counted();

    let options = Options { base: Base::Unicycle, ..Options::default() };
    let Ok((model, _)) = Model::from_urdf(include_str!("../../examples/robots/canopies.urdf"), &options) else {
        panic!("the robot is read")
    };
    let links: Vec<LinkId> = (0..model.links.len() as u32).map(LinkId).collect();
    let n = model.nv();
    let data = Data::new(&model);
    // Speeds within bounds, some of which act, and a row that always holds.
    let shape = LevelShape { rows: n + 1, hard: true, damping: 0.0 };
    let mut above = Problem::new(n, &[shape]).levels;
    let still = vec![0.0; n];
    for i in 0..n {
        above[0].row_mut(i)[i] = 1.0;
        (above[0].lower[i], above[0].upper[i]) = (-0.05, 0.05);
    }
    above[0].set(n, &vec![0.3; n], 0.0, 0.0);
    let jacobian: Vec<f64> = (0..12 * n).map(|i| (0.7 * i as f64).sin()).collect();
    let chis: [fn() -> Chi; 4] = [
        || Chi::Distance,
        || Chi::Clamped { reach: 1.0 },
        || Chi::Saturating { reach: 1.0 },
        || Chi::Given(std::sync::Arc::new(Power)),
    ];
    for (chi, over) in chis.iter().zip([Over::Mean, Over::Least, Over::SoftLeast { sharpness: 10.0 }, Over::Mean]) {
        for strategy in [Strategy::Program, Strategy::Evasive { band: 0.2 }, Strategy::Stop] {
            let Ok(body) = Body::of_links(&model, &links) else { panic!("links of the robot") };
            let Ok(mut field) = Field::new(&model, body, chi(), over, 3) else { panic!("{over:?}") };
            let deviations = vec![
                deviation(DeviationKind::Position, 0, Direction::Given),
                deviation(DeviationKind::Orientation, 3, Direction::Gradient),
                deviation(DeviationKind::Position, 6, Direction::Fixed(Vector3::z())),
            ];
            let settings = PlannerSettings {
                period: 0.005,
                gain: 10.0,
                internal_gain: 1.0,
                internal_speed: vec![1.0; n],
                weights: Weights::default(),
                deviations,
                damping: Damping::default(),
                strategy,
            };
            let Ok(mut planner) = SafetyPlanner::new(settings, 12, n, &[shape]) else { panic!("settings") };
            let before = allocations::so_far();
            let (mut decided, mut limited) = (true, 0);
            for k in 0..200 {
                let t = 0.05 * f64::from(k);
                let person = |i: f64| HumanPoint {
                    position: Vector3::new(1.5 * (t + i).cos(), t.sin() - 0.3 * i, 0.9 + 0.2 * i),
                    velocity: Vector3::new(-0.3, 0.1, 0.0),
                };
                decided &= field.update(&model, &data, &[person(0.0), person(1.0), person(2.0)]).is_ok();
                let (eta, feedback) = ([0.1; 12], [0.02; 12]);
                let task = TaskRows { jacobian: &jacobian, stride: n, eta: &eta, feedback: &feedback };
                let frame = Frame { rotation: UnitQuaternion::identity(), direction: Vector3::new(t.sin(), 1.0, 0.2) };
                let threshold = field.value() + 0.02 * (3.0 * t).sin();
                let frames = &[frame; 3];
                let tick = Tick { field: &field, threshold, threshold_rate: 0.01, task, frames, above: &above };
                decided &= planner.decide(&tick).is_ok();
                // The hierarchy gives nothing at all.
                let again = planner.reconsider(&tick, &still);
                decided &= again.is_ok();
                limited += usize::from(again == Ok(true));
                planner.advance(1.0);
                // An error allocates no more than an answer.
                let _ = planner.decide(&Tick { threshold: f64::NAN, ..tick });
            }
            assert_eq!(allocations::so_far(), before, "{over:?} {strategy:?} allocates");
            assert!(limited > 20 || strategy != Strategy::Program, "bounds act");
            assert!(decided && planner.plan().u_n.iter().all(|u| u.is_finite()));
        }
    }
}
