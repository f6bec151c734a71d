//! Planning explorations: the program against a brute force, and every plan against the validator.

use std::time::Duration;

use hierarq_mission::kinds::explore::bound::{Ways, lower_bound};
use hierarq_mission::kinds::explore::foresight::Foresight;
use hierarq_mission::kinds::explore::motion::{Dynamics, State};
use hierarq_mission::kinds::explore::polygon::{Convex, Point, distance};
use hierarq_mission::kinds::explore::problem::{EngineChoice, Problem};
use hierarq_mission::kinds::explore::program::{Group, Present, Trajectories, Visit};
use hierarq_mission::kinds::explore::solve::{NoPlan, Solver};
use hierarq_mission::kinds::explore::validate::validate;
use proptest::prelude::*;

use crate::explored::{present, rectangle, world};

fn solver() -> Solver {
    Solver::find(EngineChoice::BuiltIn).unwrap()
}

/// A person who walks along the lower edge, to the right.
fn passer_by(periods: usize) -> Foresight {
    let position = |step: usize| [0.5 + step as f64, 0.5];
    Foresight {
        positions: (0..=periods).map(position).collect(),
        visits: Vec::new(),
        arrives: true,
        spread: Vec::new(),
    }
}

/// A small world in which the robot moves by a velocity that it takes at once: its positions are those of a lattice if its
/// inputs are.
fn lattice(targets: &[Point], obstacle: Option<Point>) -> Problem {
    let mut problem = world();
    problem.area = rectangle([2.5, 3.0], [5.0, 6.0]);
    problem.obstacles.truncate(usize::from(obstacle.is_some()));
    for (own, at) in problem.obstacles.iter_mut().zip(obstacle) {
        own.shape = rectangle(at, [0.4, 0.4]);
    }
    problem.targets.truncate(targets.len());
    for (target, at) in problem.targets.iter_mut().zip(targets) {
        target.shape = rectangle(*at, [0.3, 0.3]);
    }
    problem.robots.truncate(1);
    problem.robots[0].dynamics = Dynamics::Velocity;
    problem.robots[0].start = [1.5, 3.5];
    problem.robots[0].speed = 1.0;
    problem.robots[0].acceleration = 1e3;
    problem.robots[0].body = rectangle([0.0; 2], [0.2, 0.2]);
    problem.connection = rectangle([0.0; 2], [14.0, 14.0]);
    problem.person.speed = 0.2;
    problem
}

/// The best cost over all sequences of inputs along the lattice, with the validator as the judge of what is allowed.
fn brute_force(problem: &Problem, present: &Present, foresight: &Foresight) -> f64 {
    let inputs: Vec<Point> = (-1..=1).flat_map(|x| (-1..=1).map(move |y| [f64::from(x), f64::from(y)])).collect();
    let periods = foresight.periods();
    let mut best = f64::INFINITY;
    for code in 0..inputs.len().pow(periods as u32) {
        let sequence: Vec<Point> =
            (0..periods).map(|k| inputs[code / inputs.len().pow(k as u32) % inputs.len()]).collect();
        // A plan ends with robots that stand.
        if sequence.last() != Some(&[0.0; 2]) {
            continue;
        }
        let discrete = problem.robots[0].over(problem.period);
        let mut state = present.states[0];
        let (mut states, mut visits) = (vec![state], Vec::new());
        for (step, input) in sequence.iter().enumerate() {
            state = discrete.step(state, *input);
            states.push(state);
            for (target, of) in problem.targets.iter().enumerate() {
                let new = visits.iter().all(|visit: &Visit| visit.target != target);
                if new && of.shape.contains(state.at, -1e-3) {
                    visits.push(Visit { robot: 0, target, step: step + 1 });
                }
            }
        }
        let effort: f64 = sequence.iter().flatten().map(|u| u.abs()).sum();
        // A target loses 0.4 % of its worth with each period.
        let worth = |visit: &Visit| problem.targets[visit.target].worth * (1.0 - 0.004 * visit.step as f64);
        let reward: f64 = visits.iter().map(worth).sum();
        let cost = problem.effort * effort - reward;
        let of = Trajectories { states: vec![states], inputs: vec![sequence], visits };
        if cost < best && validate(problem, present, foresight, &of).is_empty() {
            best = cost;
        }
    }
    best
}

#[test]
fn plans_are_no_worse_than_the_best_on_a_lattice() {
    let cases: [(&[Point], Option<Point>); 4] = [
        (&[[2.5, 3.5]], None),
        (&[[1.5, 5.5], [3.5, 3.5]], None),
        (&[[3.5, 3.5]], Some([2.5, 3.5])),
        (&[[2.5, 4.5], [2.5, 2.5]], Some([1.5, 4.5])),
    ];
    for (targets, obstacle) in cases {
        let problem = lattice(targets, obstacle);
        let (present, foresight) = (present(&problem), passer_by(4));
        let best = solver().plan(&problem, &present, &foresight, Duration::from_secs(60)).unwrap();
        let broken = validate(&problem, &present, &foresight, &best.trajectories);
        assert!(broken.is_empty(), "{broken:?}");
        let brute = brute_force(&problem, &present, &foresight);
        assert!(brute < 0.0, "the lattice has a plan that takes something");
        let gap = problem.planner.gap * brute.abs();
        assert!(best.cost <= brute + gap + 1e-3, "{} against {brute}", best.cost);
        // The bound holds for every plan, also for those on the lattice.
        assert!(best.bound <= brute + 1e-6, "{} against {brute}", best.bound);
        let bound = lower_bound(&problem, &Ways::new(&problem), &present, &foresight);
        assert!(bound <= brute + 1e-6, "{bound} against {brute}");
        // Rewards are whole: what the lattice cannot take in time, nobody can at this speed along the axes.
        let worth = problem.targets[0].worth;
        assert_eq!((best.cost / worth).round(), (brute / worth).round());
    }
}

/// The refusal names the constraint that no motion meets.
#[test]
fn the_group_that_cannot_be_met_is_named() {
    let mut problem = lattice(&[[2.5, 3.5]], None);
    let mut start = present(&problem);
    start.states[0] = State { at: [0.6, 0.6], velocity: [0.0; 2] };
    problem.person.speed = 2.0;
    let caught = solver().plan(&problem, &start, &passer_by(3), Duration::from_secs(20)).unwrap_err();
    assert_eq!(caught, NoPlan::Infeasible(Some(Group::Person)));
    let mut problem = lattice(&[[2.5, 3.5]], None);
    problem.connection = rectangle([0.0; 2], [3.0, 3.0]);
    let caught = solver().plan(&problem, &present(&problem), &passer_by(3), Duration::from_secs(20)).unwrap_err();
    assert_eq!(caught, NoPlan::Infeasible(Some(Group::Connection)));
}

/// A target that the person is expected to take is left to the person.
#[test]
fn robots_leave_what_the_person_takes() {
    let problem = lattice(&[[2.5, 3.5], [1.5, 4.5]], None);
    let mut foresight = passer_by(4);
    foresight.visits = vec![(0, 3)];
    let best = solver().plan(&problem, &present(&problem), &foresight, Duration::from_secs(60)).unwrap();
    assert_eq!(best.trajectories.visits.iter().map(|visit| visit.target).collect::<Vec<_>>(), [1]);
    let mut taken = present(&problem);
    taken.open = vec![true, false];
    let best = solver().plan(&problem, &taken, &foresight, Duration::from_secs(60)).unwrap();
    assert!(best.trajectories.visits.is_empty());
}

/// The validator finds each kind of mistake in a good plan that was changed.
#[test]
fn the_validator_refuses_changed_plans() {
    let problem = lattice(&[[2.5, 3.5]], Some([2.5, 2.5]));
    let (start, foresight) = (present(&problem), passer_by(3));
    let best = solver().plan(&problem, &start, &foresight, Duration::from_secs(60)).unwrap();
    let broken = |problem: &Problem, of: &Trajectories| -> String {
        let found = validate(problem, &start, &foresight, of);
        found.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
    };
    assert_eq!(broken(&problem, &best.trajectories), "");
    let mut of = best.trajectories.clone();
    of.inputs[0][0] = [1.0, -1.0];
    assert!(broken(&problem, &of).contains("is in the obstacle"), "{}", broken(&problem, &of));
    of.inputs[0][0] = [-1.0, 0.0];
    of.inputs[0][1] = [-1.0, 0.0];
    assert!(broken(&problem, &of).contains("leaves the area"));
    of.inputs[0][0] = [1.4, 0.0];
    assert!(broken(&problem, &of).contains("faster than it can"));
    of.inputs[0].pop();
    assert!(broken(&problem, &of).contains("an input for each"));
    let mut of = best.trajectories.clone();
    of.visits.push(of.visits[0]);
    assert!(broken(&problem, &of).contains("taken more than once"));
    of.visits.truncate(1);
    of.visits[0].step = 0;
    assert!(!broken(&problem, &of).contains("more than once"));
    let mut near = problem.clone();
    near.connection = rectangle([0.0; 2], [3.0, 3.0]);
    assert!(broken(&near, &best.trajectories).contains("not connected"));
    let mut fast = problem.clone();
    fast.person.speed = 3.0;
    assert!(broken(&fast, &best.trajectories).contains("where `anna` may walk"));
    let mut slow = problem.clone();
    slow.robots[0].acceleration = 0.1;
    assert!(broken(&slow, &best.trajectories).contains("accelerates more"));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    /// Every plan of random small worlds passes the validator, which integrates the motion by itself.
    #[test]
    fn plans_of_random_worlds_are_valid(
        kind in 0..3_usize,
        robot in [0.7..4.3_f64, 2.0..5.3_f64],
        obstacle in [1.0..4.0_f64, 2.5..5.0_f64],
        target in [0.5..4.5_f64, 1.5..5.5_f64],
        speed in 0.5..2.5_f64,
        steps in prop::collection::vec(0..4_usize, 3),
    ) {
        let mut problem = lattice(&[target], Some(obstacle));
        problem.planner.nodes = 200;
        problem.robots[0].dynamics = [Dynamics::Velocity, Dynamics::Acceleration, Dynamics::Lag(0.4)][kind];
        problem.robots[0].speed = speed;
        problem.robots[0].acceleration = 3.0;
        problem.robots[0].start = robot;
        prop_assume!(distance(robot, obstacle) > 0.6);
        let mut at: Point = [2.5, 0.5];
        let mut positions = vec![at];
        for step in steps {
            let way = [[0.2, 0.0], [0.0, 0.2], [-0.2, 0.0], [0.0, -0.1]][step];
            at = [at[0] + way[0], at[1] + way[1]];
            positions.push(at);
        }
        let foresight = Foresight { positions, visits: Vec::new(), arrives: false, spread: Vec::new() };
        let present = present(&problem);
        match solver().plan(&problem, &present, &foresight, Duration::from_secs(20)) {
            Ok(best) => {
                let broken = validate(&problem, &present, &foresight, &best.trajectories);
                prop_assert!(broken.is_empty(), "{broken:?}");
                prop_assert!(best.bound <= best.cost + 1e-6);
            }
            Err(NoPlan::Infeasible(_) | NoPlan::Late) => {}
            Err(other) => prop_assert!(false, "{other}"),
        }
    }
}

#[test]
fn shapes_of_problems_are_read_and_refused() {
    let text = serde_json::to_string(&world()).unwrap();
    assert_eq!(serde_json::from_str::<Problem>(&text).unwrap(), world());
    assert!(serde_json::from_str::<Convex>("[[0, 0], [1, 1], [2, 2]]").is_err());
}
