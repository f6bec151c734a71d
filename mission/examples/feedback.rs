//! The experiment of thesis 5.7.3 (Table 5.2, Figs. 5.7 and 5.8): compares the next plan with the feedback of three
//! people on their first service.
//!
//! Prints for each person the wait after the first operation, the planned wait and approach of the second one before
//! and after the feedback is applied, and their executed values.
//!
//! `cargo run --release -p hierarq-mission --example feedback -- [THRESHOLD] [SEED or planned] [LIMIT]`; without a seed
//! operations take as long as planned, without a LIMIT waits (s) are unlimited, as in the thesis.

#[path = "../tests/common/mod.rs"]
mod common;

use std::time::Duration;

use hierarq_mission::engine::Budget;
use hierarq_mission::execution::Durations;
use hierarq_mission::kinds::schedule::assistance::from_plan;
use hierarq_mission::kinds::schedule::choose::Options;
use hierarq_mission::kinds::schedule::cost::wait;
use hierarq_mission::kinds::schedule::execution::{Event, LogEntry, ScheduleExecution, Settings};
use hierarq_mission::kinds::schedule::problem::Problem;
use hierarq_mission::numbers::Range;

/// Steps of Fig. 5.5 that the people of Table 5.2 choose for wait, approach and distance.
const SAID: [(i8, i8, i8); 3] = [(1, 1, -1), (-1, 0, 0), (-1, 1, 0)];

/// Default of `iota_t` of (5.19): feedback triggers a new plan.
const THRESHOLD: f64 = 0.003;

/// `examples/vineyard.hq`.
fn vineyard() -> Problem {
    let mut problem = common::vineyard(3);
    for robot in &mut problem.robots {
        robot.proximity = Some(Range::new(0.05, 0.15));
        (robot.serve, robot.deposit) = (20.0, 10.0);
    }
    problem.agents[3].duration.sigma = 0.0;
    problem
}

/// Robot, wait (s), waiting distance (m), time (s) and speed (m/s) of the approach of an operation in the plan.
fn planned(execution: &ScheduleExecution, agent: usize, operation: usize) -> Option<(usize, f64, f64, f64, f64)> {
    let schedule = from_plan(execution.plan()).ok()?;
    let at = schedule.iter().find(|at| (at.agent, at.operation) == (agent, operation))?;
    let (length, time) =
        (execution.problem().lengths(agent, at.robot).proximity, at.times.serving - at.times.proximity);
    Some((at.robot, wait(&schedule, at), length, time, length / time))
}

fn show(name: &str, of: Option<(usize, f64, f64, f64, f64)>) {
    if let Some((robot, wait, length, time, speed)) = of {
        println!("  {name:<22} m{}  wait {wait:6.1} s  {length:.2} m in {time:5.1} s, {speed:.3} m/s", robot + 1);
    }
}

fn main() {
    let seed = std::env::args().nth(2).and_then(|word| word.parse().ok());
    let reallocate_above = std::env::args().nth(1).and_then(|word| word.parse().ok()).unwrap_or(THRESHOLD);
    let durations = seed.map_or(Durations::Planned, |seed| Durations::Sampled { seed });
    // With limits most plans are not proven: the node limit ends the search.
    let nodes = if std::env::args().nth(3).is_some() { 2000 } else { Budget::default().nodes };
    let budget = Budget { time: Duration::from_secs(120), nodes, ..Budget::default() };
    let planning = Options { budget, ..Options::default() };
    let mut problem = vineyard();
    if let Some(limit) = std::env::args().nth(3).and_then(|word| word.parse().ok()) {
        problem.agents.iter_mut().for_each(|who| who.wait_limit = limit);
    }
    let settings = Settings { durations, planning, reallocate_above, ..Settings::default() };
    let mut execution = match ScheduleExecution::new(problem, settings) {
        Ok(execution) => execution,
        Err(refusal) => return println!("{refusal}"),
    };
    println!("first plan: cost {:.4}, {:?}", execution.plan().cost, execution.plan().status);
    for agent in 0..3 {
        show(&format!("h{} first, planned", agent + 1), planned(&execution, agent, 0));
        show(&format!("h{} second, planned", agent + 1), planned(&execution, agent, 1));
    }
    while let Some(next) = execution.next() {
        let served = execution.advance(next).iter().filter_map(|record| match record.what {
            LogEntry::Served { agent, operation: 0, .. } => Some(agent),
            _ => None,
        });
        for agent in served.collect::<Vec<_>>() {
            let Some((wait, approach, distance)) = SAID.get(agent).copied() else { continue };
            println!("{:.1} s: h{} has been served and says {:?}", execution.time(), agent + 1, SAID[agent]);
            show("first, as it was", planned(&execution, agent, 0));
            show("second, before", planned(&execution, agent, 1));
            if let Err(error) = execution.handle_event(Event::Said { agent, wait, approach, distance }) {
                println!("  not taken: {error}");
            }
            show("second, after", planned(&execution, agent, 1));
            println!(
                "  planned anew so far: {} times; cost now {:.4}",
                execution.statistics().reallocations,
                execution.plan().cost
            );
            println!(
                "  alpha {:.2}, zeta {:.2}",
                execution.problem().wait_weight(agent, 1),
                execution.problem().approach_weight(agent, 1)
            );
        }
    }
    for agent in &execution.statistics().agents {
        let rounded = |values: &[f64], digits: usize| {
            values.iter().map(|value| format!("{value:.digits$}")).collect::<Vec<_>>().join(", ")
        };
        println!(
            "{}: waits {} s, speeds {} m/s, index of waits {:.2}, of speeds {:.2}",
            agent.name,
            rounded(&agent.waits, 1),
            rounded(&agent.speeds, 3),
            agent.wait_index,
            agent.speed_index
        );
    }
    println!("end after {:.1} s", execution.statistics().makespan);
}
