//! Comparison of the planner of schedules with an external solver.
//!
//! Prints 50 random problems with fixed speeds, one JSON object per line: the problem, and the cost of its plan.
//! `examples/cp_sat_schedules.py` formulates its own program for each, from thesis (5.1) to (5.14), solves it with
//! OR-Tools CP-SAT and compares:
//!
//! `cargo run --release -p hierarq-mission --example schedules_outside | python3 mission/examples/cp_sat_schedules.py`

#![allow(clippy::expect_used, reason = "an example that cannot plan fails")]

#[path = "../tests/common/mod.rs"]
mod common;

use std::time::Duration;

use hierarq_mission::engine::Budget;
use hierarq_mission::kinds::schedule::choose::{Options, plan};
use hierarq_mission::numbers::Range;
use hierarq_mission::plan::Status;
use serde_json::json;

/// Numbers of agents, of robots, and of operations per agent.
const SHAPES: [(usize, usize, usize); 10] =
    [(3, 2, 1), (5, 2, 1), (6, 3, 1), (7, 2, 1), (8, 2, 1), (2, 2, 2), (3, 2, 2), (2, 1, 3), (2, 2, 3), (4, 2, 2)];

fn main() {
    let budget = Budget { time: Duration::from_secs(60), ..Budget::default() };
    for seed in 0..50 {
        let (agents, robots, operations) = SHAPES[seed % SHAPES.len()];
        let mut problem = common::random(seed as u64, agents, robots, operations);
        for (robot, speed) in problem.robots.iter_mut().zip([0.1, 0.16, 0.13]) {
            robot.speed = Range::point(speed);
            robot.proximity = Some(Range::point(speed));
        }
        problem.confidence = [0.6, 0.9, 0.95][seed % 3];
        problem.weights.worker_wait = [1.0, 2.5][seed % 2];
        problem.weights.makespan = [1.0, 4.0, 0.0][seed % 3];
        let found = plan(&problem, &Options { budget, ..Options::default() }).expect("a plan");
        let proven = matches!(found.status, Status::Proven { .. });
        let line =
            json!({ "seed": seed, "problem": problem, "cost": found.cost, "proven": proven, "by": found.engine });
        println!("{line}");
    }
}
