//! The world of the tests of explorations: a room of 7 x 7 m with four obstacles and four targets, as in the paper.

use hierarq_mission::kinds::explore::motion::Dynamics;
use hierarq_mission::kinds::explore::polygon::{Convex, Point};
use hierarq_mission::kinds::explore::problem::{
    EngineChoice, Escape, Fallback, Model, Obstacle, Person, Planner, Problem, Robot, Target,
};
use hierarq_mission::kinds::explore::program::Present;

pub fn rectangle(at: Point, size: Point) -> Convex {
    Convex::rectangle(size).unwrap().moved(at)
}

/// The world; the person walks to both targets of the type `b`.
pub fn world() -> Problem {
    let obstacle =
        |(index, at): (usize, Point)| Obstacle { name: format!("o{index}"), shape: rectangle(at, [1.0, 1.0]) };
    let target = |(index, (at, of)): (usize, (Point, usize))| Target {
        name: format!("t{index}"),
        shape: rectangle(at, [0.6, 0.6]),
        of,
        worth: 5.0,
    };
    let robot = |(index, start): (usize, Point)| Robot {
        name: format!("r{index}"),
        start,
        body: rectangle([0.0; 2], [0.5, 0.5]),
        dynamics: Dynamics::Acceleration,
        speed: 2.5,
        acceleration: 5.0,
    };
    let model = Model::GoalDirected { values: vec![0.0, 1.0] };
    Problem {
        area: rectangle([3.5, 3.5], [7.0, 7.0]),
        obstacles: [[2.5, 2.5], [4.5, 2.5], [2.5, 4.5], [4.5, 4.5]].into_iter().enumerate().map(obstacle).collect(),
        types: ["a", "b"].map(String::from).to_vec(),
        targets: [([0.5, 6.5], 0), ([6.5, 0.5], 1), ([0.5, 3.5], 0), ([3.5, 3.5], 1)]
            .into_iter()
            .enumerate()
            .map(target)
            .collect(),
        exit: rectangle([6.5, 6.5], [1.0, 1.0]),
        connection: Convex::regular(8, 4.0).unwrap(),
        robots: [[1.5, 0.5], [0.5, 1.5]].into_iter().enumerate().map(robot).collect(),
        person: Person {
            name: "anna".into(),
            start: [3.5, 1.5],
            body: rectangle([0.0; 2], [0.41, 0.29]),
            speed: 1.0,
            cell: 1.0,
            walks: model.clone(),
            predicted: model,
        },
        period: 1.0,
        periods: 30,
        effort: 0.01,
        planner: Planner {
            gap: 0.05,
            time: 5.0,
            nodes: 2000,
            engine: EngineChoice::BuiltIn,
            fallback: Fallback::Barrier,
            escape: Escape::Preferred,
        },
        labels: Default::default(),
    }
}

/// Everybody at the start, and every target open.
pub fn present(problem: &Problem) -> Present {
    Present {
        states: problem.robots.iter().map(|robot| robot.at_start()).collect(),
        active: vec![true; problem.robots.len()],
        open: vec![true; problem.targets.len()],
    }
}
