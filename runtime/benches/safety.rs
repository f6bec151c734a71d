//! Time of a tick of the safety field, of its decomposition and of the planner: 14 links, 3 points, 12 rows.

use divan::{Bencher, black_box};
use hierarq_runtime::safety::{
    Body, Chi, Damping, Deviation, DeviationKind, Direction, Field, Frame, HumanPoint, Over, PlannerSettings,
    SafetyPlanner, Strategy, TaskRows, Tick, Weights,
};
use nalgebra::{DMatrix, Vector3};
use robot::{Base, Data, LinkId, Model, Options};
use solver::{LevelShape, Problem};

fn main() {
    divan::main();
}

/// The vineyard robot, both arms, its kinematics at a bent posture, and people around.
struct Scene {
    model: Model,
    data: Data,
    links: Vec<LinkId>,
    people: [HumanPoint; 3],
    jacobian: Vec<f64>,
}

fn scene() -> Scene {
    let options = Options { base: Base::Unicycle, ..Options::default() };
    let Ok((model, _)) = Model::from_urdf(include_str!("../../examples/robots/canopies.urdf"), &options) else {
        panic!("the robot is read")
    };
    let mut data = Data::new(&model);
    let q: Vec<f64> = model.neutral().iter().enumerate().map(|(i, q)| q + 0.2 * (i as f64).sin()).collect();
    model.forward(&q, &mut data);
    let named = |side: &str| (1..=7).filter_map(|k| model.link(&format!("arm_{side}_{k}_link"))).collect::<Vec<_>>();
    let links: Vec<LinkId> = ["left", "right"].iter().flat_map(|s| named(s)).collect();
    assert_eq!(links.len(), 14);
    let mut jacobian = Vec::new();
    for name in ["left_tool", "right_tool"] {
        let Some(tool) = model.link(name) else { panic!("{name}") };
        let mut j = DMatrix::zeros(6, model.nv());
        data.jacobian(&model, tool, data.position(tool), &mut j);
        jacobian.extend(j.transpose().iter());
    }
    let person = |x, y, z| HumanPoint { position: Vector3::new(x, y, z), velocity: Vector3::new(-0.2, 0.1, 0.0) };
    let people = [person(1.2, 0.1, 1.3), person(0.9, 0.4, 1.1), person(0.9, -0.4, 1.1)];
    Scene { model, data, links, people, jacobian }
}

fn field(scene: &Scene, chi: Chi) -> Field {
    let body = match Body::of_links(&scene.model, &scene.links) {
        Ok(body) => body,
        Err(e) => panic!("{e}"),
    };
    match Field::new(&scene.model, body, chi, Over::Mean, 3) {
        Ok(field) => field,
        Err(e) => panic!("{e}"),
    }
}

/// The field and its derivatives alone.
#[divan::bench(args = ["distance", "clamped", "saturating"])]
fn update(bencher: Bencher, chi: &str) {
    let scene = scene();
    let chi = match chi {
        "distance" => Chi::Distance,
        "clamped" => Chi::Clamped { reach: 1.0 },
        _ => Chi::Saturating { reach: 1.0 },
    };
    let mut field = field(&scene, chi);
    bencher.bench_local(|| field.update(&scene.model, &scene.data, black_box(&scene.people)));
}

/// All of a tick, with the row active, below speed limits of all joints, of which none, some, or many act.
#[divan::bench(args = [f64::INFINITY, 0.4, 0.2, 0.05])]
fn tick(bencher: Bencher, fastest: f64) {
    let scene = scene();
    let mut field = field(&scene, Chi::Distance);
    let n = scene.model.nv();
    let deviation = |kind, row, direction| Deviation {
        kind,
        row,
        stiffness: 2.0,
        speed: [-0.4, 0.4],
        reach: Some(0.2),
        direction,
        weight: 1.0,
    };
    let settings = PlannerSettings {
        period: 0.005,
        gain: 10.0,
        internal_gain: 1.0,
        internal_speed: vec![1.0; n],
        weights: Weights::default(),
        deviations: vec![
            deviation(DeviationKind::Position, 0, Direction::Gradient),
            deviation(DeviationKind::Orientation, 3, Direction::Gradient),
            deviation(DeviationKind::Position, 6, Direction::Gradient),
            deviation(DeviationKind::Orientation, 9, Direction::Gradient),
        ],
        damping: Damping::default(),
        strategy: Strategy::Program,
    };
    let shape = LevelShape { rows: n, hard: true, damping: 0.0 };
    let mut planner = match SafetyPlanner::new(settings, 12, n, &[shape]) {
        Ok(planner) => planner,
        Err(e) => panic!("{e}"),
    };
    let mut problem = Problem::new(n, &[shape]);
    for i in 0..n {
        problem.levels[0].row_mut(i)[i] = 1.0;
        (problem.levels[0].lower[i], problem.levels[0].upper[i]) = (-fastest, fastest);
    }
    let (eta, feedback) = ([0.1; 12], [0.02; 12]);
    let (above, still) = (problem.levels, vec![0.0; n]);
    bencher.bench_local(|| {
        let seen = field.update(&scene.model, &scene.data, black_box(&scene.people));
        let task = TaskRows { jacobian: &scene.jacobian, stride: n, eta: &eta, feedback: &feedback };
        let frames = [Frame::default(); 4];
        let threshold = field.value();
        let tick = Tick { field: &field, threshold, threshold_rate: 0.0, task, frames: &frames, above: &above };
        let decided = planner.decide(black_box(&tick));
        // The hierarchy gives nothing at all: where there are limits, the planner decides once more.
        let again = planner.reconsider(black_box(&tick), &still);
        planner.advance(1.0);
        (seen, decided, again)
    });
}
