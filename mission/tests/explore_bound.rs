//! The lower bound on the cost of plans, against the cost of plans that were not made by the planner, and plans with the best inputs for their
//! choices.

use std::time::Duration;

use hierarq_mission::kinds::explore::bound::{Ways, lower_bound};
use hierarq_mission::kinds::explore::foresight::Foresight;
use hierarq_mission::kinds::explore::lattice::{Aim, Deadline, Ground, construct};
use hierarq_mission::kinds::explore::motion::Dynamics;
use hierarq_mission::kinds::explore::objective::Costs;
use hierarq_mission::kinds::explore::polygon::{Convex, Point};
use hierarq_mission::kinds::explore::problem::{Escape, Problem};
use hierarq_mission::kinds::explore::program::{Present, Trajectories, Visit, build, replayed};
use hierarq_mission::kinds::explore::validate::validate;
use proptest::prelude::*;

use crate::explored::{present, rectangle, world};

/// The motions of these inputs and then of those after which the robots stand; targets are taken as soon as a robot is there.
fn motions(problem: &Problem, present: &Present, inputs: Vec<Vec<Point>>) -> Trajectories {
    let mut inputs = inputs;
    let moved = replayed(problem, present, &inputs);
    for (robot, inputs) in inputs.iter_mut().enumerate() {
        let d = problem.robots[robot].over(problem.period);
        let last = moved.states[robot].last().copied().unwrap_or_default();
        inputs.push(last.velocity.map(|v| -d.velocity_velocity * v / d.velocity_input));
    }
    let mut all = replayed(problem, present, &inputs);
    for (target, of) in problem.targets.iter().enumerate() {
        let visits =
            (1..=inputs[0].len()).flat_map(|step| (0..inputs.len()).map(move |robot| Visit { robot, target, step }));
        let first = visits.into_iter().find(|visit| of.shape.contains(all.states[visit.robot][visit.step].at, 0.0));
        all.visits.extend(first);
    }
    all
}

fn walks(steps: &[usize], from: Point, stride: f64) -> Foresight {
    let mut positions = vec![from];
    for step in steps {
        let way = [[stride, 0.0], [0.0, stride], [-stride, 0.0], [0.0, -stride]][*step];
        let at = positions[positions.len() - 1];
        positions.push([at[0] + way[0], at[1] + way[1]]);
    }
    Foresight { positions, visits: Vec::new(), arrives: false, spread: Vec::new() }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, max_global_rejects: 20_000, ..ProptestConfig::default() })]

    /// Random inputs of two robots, with targets along their ways so that they take them at once: no such plan costs less than the bound.
    #[test]
    fn no_plan_costs_less_than_the_bound(
        kind in 0..3_usize,
        starts in [[0.5..6.5_f64, 2.0..6.5_f64], [0.5..6.5_f64, 2.0..6.5_f64]],
        velocities in [[-1.0..1.0_f64, -1.0..1.0_f64], [-1.0..1.0_f64, -1.0..1.0_f64]],
        inputs in prop::collection::vec([[-2.0..2.0_f64, -2.0..2.0_f64], [-2.0..2.0_f64, -2.0..2.0_f64]], 0..6),
        still in 0..3_usize,
        placed in prop::collection::vec([0..2_usize, 0..8_usize], 1..4),
        steps in prop::collection::vec(0..4_usize, 8),
        range in 4.0..9.0_f64,
        obstacle in [1.0..6.0_f64, 1.5..6.0_f64],
    ) {
        let mut problem = world();
        problem.obstacles.truncate(1);
        problem.obstacles[0].shape = rectangle(obstacle, [0.6, 0.6]);
        problem.connection = Convex::regular(8, range).unwrap();
        problem.person.speed = 0.3;
        for robot in &mut problem.robots {
            robot.dynamics = [Dynamics::Acceleration, Dynamics::Velocity, Dynamics::Lag(0.4)][kind];
            robot.body = rectangle([0.0; 2], [0.2, 0.2]);
        }
        let mut present = present(&problem);
        let slow = if kind == 1 { 0.0 } else { 1.0 };
        for robot in 0..2 {
            present.states[robot].at = starts[robot];
            present.states[robot].velocity = velocities[robot].map(|v| v * slow);
        }
        let periods = inputs.len() + still + 1;
        let mut by_robot: Vec<Vec<Point>> = (0..2).map(|robot| inputs.iter().map(|both| both[robot]).collect()).collect();
        by_robot.iter_mut().for_each(|inputs| inputs.extend(std::iter::repeat_n([0.0; 2], still)));
        let foresight = walks(&steps[..periods.min(8)], [3.5, 0.5], 0.3);
        let way = motions(&problem, &present, by_robot.clone());
        problem.targets.truncate(placed.len());
        for (target, [robot, step]) in problem.targets.iter_mut().zip(&placed) {
            let at = way.states[*robot][(*step).min(periods)].at;
            target.shape = rectangle(at, [0.3, 0.3]);
        }
        let plan = motions(&problem, &present, by_robot);
        prop_assume!(validate(&problem, &present, &foresight, &plan).is_empty());
        let cost = Costs::of(&problem, &present, &foresight, &plan).total();
        let bound = lower_bound(&problem, &Ways::new(&problem), &present, &foresight);
        prop_assert!(bound <= cost + 1e-6, "{bound} {cost}");
    }

    /// A plan on the lattice of a random situation, and the same with the best inputs for its choices.
    #[test]
    fn polished_plans_are_sound_and_cost_less(
        steps in prop::collection::vec(0..4_usize, 4..9),
        targets in prop::collection::vec([0.5..6.5_f64, 0.5..6.5_f64], 1..4),
        range in 4.0..9.0_f64,
    ) {
        let mut problem = world();
        problem.planner.escape = Escape::Ignored;
        problem.connection = Convex::regular(8, range).unwrap();
        problem.targets.truncate(targets.len());
        for (target, at) in problem.targets.iter_mut().zip(&targets) {
            target.shape = rectangle(*at, [0.6, 0.6]);
        }
        let (present, foresight) = (present(&problem), walks(&steps, [3.5, 1.5], 0.5));
        let ways = Ways::new(&problem);
        let bound = lower_bound(&problem, &ways, &present, &foresight);
        let ground = Ground::new(&problem).unwrap();
        let until = Deadline::never();
        let aim = Aim { bound, until: &until };
        let Some(plan) = construct(&problem, &ground, &present, &foresight, None, &aim) else { return Ok(()) };
        let cost = |of: &Trajectories| Costs::of(&problem, &present, &foresight, of).total();
        prop_assert!(bound <= cost(&plan) + 1e-6, "{bound} {}", cost(&plan));
        let program = build(&problem, &present, &foresight, None).unwrap();
        if let Some(polished) = program.polished(&problem, &present, &plan, Duration::from_secs(60)) {
            prop_assert_eq!(validate(&problem, &present, &foresight, &polished), []);
            prop_assert!(cost(&polished) <= cost(&plan) + 1e-6);
            prop_assert!(bound <= cost(&polished) + 1e-6, "{bound} {}", cost(&polished));
        }
    }
}
