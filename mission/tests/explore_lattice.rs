//! Plans of explorations on the lattice: a robot that goes ahead, ways out, and predictions that lead in a circle.

use hierarq_mission::kinds::explore::bound::{Ways, lower_bound};
use hierarq_mission::kinds::explore::execution::{ExploreExecution, Settings};
use hierarq_mission::kinds::explore::foresight::Foresight;
use hierarq_mission::kinds::explore::lattice::{Aim, Deadline, Ground, construct, way_out};
use hierarq_mission::kinds::explore::motion::State;
use hierarq_mission::kinds::explore::objective::Costs;
use hierarq_mission::kinds::explore::polygon::{Convex, Point};
use hierarq_mission::kinds::explore::problem::{Model, PolicyFile, Problem};
use hierarq_mission::kinds::explore::validate::validate;
use learning::grid::{Action, World};
use learning::network::{Activation, Network, Shape};
use learning::policy::{Method, Policy, Training};
use proptest::prelude::*;

use crate::explored::{present, rectangle, world};

/// No plan is good enough.
fn thorough(until: &Deadline) -> Aim<'_> {
    Aim { bound: f64::NEG_INFINITY, until }
}

fn standing(at: Point, periods: usize) -> Foresight {
    Foresight { positions: vec![at; periods + 1], visits: Vec::new(), arrives: false, spread: Vec::new() }
}

/// The target is farther from the person than one connection reaches, so that a robot can only take it if the other one comes
/// after it; neither gains anything by the first move alone.
#[test]
fn a_robot_goes_ahead_of_the_one_that_keeps_its_connection() {
    let mut problem = world();
    problem.obstacles.clear();
    problem.targets.truncate(1);
    problem.targets[0].shape = rectangle([6.5, 6.5], [0.6, 0.6]);
    problem.exit = rectangle([0.5, 6.5], [1.0, 1.0]);
    let foresight = standing([0.5, 0.5], 10);
    let start = present(&problem);
    problem.connection = Convex::regular(8, 6.0).unwrap();
    // One connection reaches 5.5 m less the stride of the person.
    assert!((6.2_f64).hypot(6.2) - 0.5 > 6.0);
    let ground = Ground::new(&problem).unwrap();
    let plan = construct(&problem, &ground, &start, &foresight, None, &thorough(&Deadline::never())).unwrap();
    assert_eq!(validate(&problem, &start, &foresight, &plan), []);
    assert_eq!(plan.visits.len(), 1, "{plan:?}");
    let cost = Costs::of(&problem, &start, &foresight, &plan).total();
    assert!(lower_bound(&problem, &Ways::new(&problem), &start, &foresight) <= cost);
    // Alone nobody gets there.
    let mut alone = start.clone();
    alone.active[1] = false;
    let plan = construct(&problem, &ground, &alone, &foresight, None, &thorough(&Deadline::never()));
    assert!(plan.is_none_or(|plan| plan.visits.is_empty()));
}

/// The most work between two looks at the end of a search: far less than a turn of a robot.
const BETWEEN: u64 = 100_000;

/// However early the search for a plan ends, it ends within a small share of the work of one turn, and a plan that it has is sound.
#[test]
fn a_search_that_is_cut_short_ends_at_once_with_a_sound_plan() {
    let problem = world();
    let (start, foresight) = ExploreExecution::start(&problem, &Settings::default()).unwrap();
    let ground = Ground::new(&problem).unwrap();
    let search = |until: &Deadline| construct(&problem, &ground, &start, &foresight, None, &thorough(until));
    let whole = Deadline::never();
    let best = search(&whole).unwrap();
    // Four starts with at least one turn each.
    assert!(whole.work() > 4 * 10 * BETWEEN, "{}", whole.work());
    let cost = |of: &_| Costs::of(&problem, &start, &foresight, of).total();
    let mut found = 0;
    for part in 0..=24 {
        let limit = whole.work() * part / 24;
        let until = Deadline::after(limit);
        let plan = search(&until);
        assert!(until.work() <= limit + BETWEEN, "{} after {limit}", until.work());
        if let Some(plan) = plan {
            found += usize::from(part < 24);
            assert_eq!(validate(&problem, &start, &foresight, &plan), []);
            assert!(cost(&best) <= cost(&plan) + 1e-9 || part == 24);
        } else {
            assert!(part < 24);
        }
    }
    assert!(found > 4, "{found}");
    assert_eq!(search(&Deadline::after(whole.work())), Some(best));
}

/// The same of ways out, which are looked for where there is no plan.
#[test]
fn a_search_for_a_way_out_that_is_cut_short_ends_at_once() {
    let problem = world();
    let (start, foresight) = ExploreExecution::start(&problem, &Settings::default()).unwrap();
    let whole = Deadline::never();
    let found = way_out(&problem, None, &start, &foresight, &whole);
    assert!(found.is_some());
    for part in 0..12 {
        let limit = whole.work() * part / 12;
        let until = Deadline::after(limit);
        assert_eq!(way_out(&problem, None, &start, &foresight, &until), None);
        assert!(until.work() <= limit + BETWEEN, "{} after {limit}", until.work());
    }
    assert_eq!(way_out(&problem, None, &start, &foresight, &Deadline::after(whole.work())), found);
}

/// Positions of a robot by the inputs of a way out, a hundred to a period, with the time of each (s).
fn followed(problem: &Problem, from: State, period: f64, inputs: &[Point]) -> Vec<(f64, Point)> {
    let mut state = from;
    let mut points = Vec::new();
    for (step, input) in inputs.iter().enumerate() {
        for part in 1..=100 {
            let at = problem.robots[0].dynamics.after(state, *input, period * f64::from(part) / 100.0).at;
            points.push((period * (step as f64 + f64::from(part) / 100.0), at));
        }
        state = problem.robots[0].dynamics.after(state, *input, period);
    }
    points
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    /// Whoever stands where the person is about to walk gets out of the way, and hits nothing. The motion is followed by itself, and bodies
    /// are compared in small steps.
    #[test]
    fn ways_out_keep_out_of_the_way_of_the_person(
        cell in [0..7_usize, 0..7_usize],
        ahead in 1.0..3.0_f64,
        direction in 0..4_usize,
        velocity in [-1.0..1.0_f64, -1.0..1.0_f64],
    ) {
        let mut problem = world();
        problem.robots.truncate(1);
        let way: Point = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]][direction];
        let from: Point = [cell[0] as f64 + 0.5, cell[1] as f64 + 0.5];
        let at = |time: f64| [from[0] + way[0] * time, from[1] + way[1] * time];
        let inside = |at: Point| problem.area.contains(at, -0.4) && problem.obstacles.iter().all(|of| of.shape.outside(at) > 0.4);
        let foresight = Foresight {
            positions: (0..=4).map(|step| at(f64::from(step))).collect(),
            visits: Vec::new(),
            arrives: false,
            spread: Vec::new(),
        };
        let start = at(ahead);
        prop_assume!(inside(start) && problem.area.contains(from, 0.0));
        let mut present = present(&problem);
        present.states[0] = State { at: start, velocity };
        let Some(way_out) = way_out(&problem, None, &present, &foresight, &Deadline::never()) else { return Ok(()) };
        for (time, place) in followed(&problem, present.states[0], way_out.period, &way_out.inputs[0]) {
            let body = problem.robots[0].body.moved(place);
            prop_assert!(body.corners().iter().all(|corner| problem.area.contains(*corner, 1e-6)), "{time}: {place:?}");
            for obstacle in &problem.obstacles {
                prop_assert!(body.gap(&obstacle.shape) > -1e-6, "{time}: {place:?}");
            }
            let person = problem.person.body.moved(at(time.min(4.0)));
            prop_assert!(body.gap(&person) > -1e-6, "{time}: {place:?} {person:?}");
        }
    }
}

/// A robot in a dead end that the person enters flees around the corner, and not to its end.
#[test]
fn a_way_out_of_a_dead_end_leads_around_the_corner() {
    let mut problem = world();
    problem.robots.truncate(1);
    // A corridor along the left edge that is closed above, with a side way at 4 to 5 m.
    let wall = |name: &str, at, size| {
        let mut obstacle = problem.obstacles[0].clone();
        (obstacle.name, obstacle.shape) = (name.into(), rectangle(at, size));
        obstacle
    };
    problem.obstacles = vec![wall("low", [2.0, 2.0], [2.0, 4.0]), wall("high", [2.0, 6.0], [2.0, 2.0])];
    let mut present = present(&problem);
    present.states[0] = State { at: [0.5, 3.0], velocity: [0.0; 2] };
    // The person walks to the closed end.
    let positions: Vec<Point> = (0..=6).map(|step| [0.5, (1.5 + f64::from(step)).min(6.5)]).collect();
    let foresight = Foresight { positions, visits: Vec::new(), arrives: false, spread: Vec::new() };
    let found = way_out(&problem, None, &present, &foresight, &Deadline::never()).unwrap();
    let points = followed(&problem, present.states[0], found.period, &found.inputs[0]);
    let last = points[points.len() - 1].1;
    assert!(last[0] > 1.0 && (4.0..5.0).contains(&last[1]), "{last:?}");
}

/// A policy that finds the first action most likely everywhere walks into the wall for ever; the prediction goes on to the exit.
#[test]
fn predictions_that_lead_in_a_circle_go_on_to_the_exit() {
    let mut problem = world();
    let obstacles: Vec<usize> = [(2, 2), (4, 2), (2, 4), (4, 4)].map(|(x, y)| 7 * y + x).to_vec();
    let grid = World::new(7, 7, &obstacles, &[48], 2).unwrap();
    let network: Network<f32> = Network::zero(Shape::new(grid.inputs(), &[], Action::COUNT, Activation::Relu).unwrap());
    let training = Training { method: Method::Airl, seed: 0, steps: 0 };
    let policy = Policy::new(grid, network, training).unwrap();
    problem.person.predicted = Model::Policy(PolicyFile { path: "zero".into(), bytes: policy.to_bytes() });
    let (_, foresight) = ExploreExecution::start(&problem, &Settings::default()).unwrap();
    assert!(foresight.arrives);
    let last = foresight.positions[foresight.periods()];
    assert!(problem.exit.contains(last, 0.0), "{last:?}");
    // Steps of a cell, none of them through an obstacle.
    for two in foresight.positions.windows(2) {
        assert!((two[1][0] - two[0][0]).abs() + (two[1][1] - two[0][1]).abs() <= 1.0 + 1e-9);
        assert!(problem.obstacles.iter().all(|of| !of.shape.contains(two[1], -1e-3)), "{two:?}");
    }
}
