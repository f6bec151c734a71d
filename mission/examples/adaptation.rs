//! The experiment of thesis 5.7.4 (Fig. 5.9): adaptation indices of waits and speeds.
//!
//! Two to six people with three operations each and two robots; random positions from 3 to 10 m, and one of the five
//! steps of feedback on wait and speed at random after every service. Prints mean and standard deviation of the
//! adaptation index over people and runs, with feedback and replanning, and with neither.
//!
//! `cargo run -p hierarq-mission --example adaptation -- [RUNS] [THRESHOLD]`

#[path = "../tests/common/mod.rs"]
mod common;

use std::time::Duration;

use hierarq_mission::engine::Budget;
use hierarq_mission::execution::{Durations, Replan};
use hierarq_mission::kinds::schedule::choose::{Formulation, Options};
use hierarq_mission::kinds::schedule::execution::{Event, LogEntry, Outcome, Refusal, ScheduleExecution, Settings};
use hierarq_mission::kinds::schedule::problem::{AgentKind, Problem};

/// Default number of runs.
const RUNS: u64 = 30;

/// Default of `iota_t` of (5.19): feedback nearly always triggers a new plan.
const THRESHOLD: f64 = 0.003;

/// People at random positions, served from the depots of thesis 5.7.2.
fn team(run: u64, people: usize) -> Problem {
    let mut random = common::Random(run.wrapping_mul(7919) + people as u64);
    random.unit();
    let robots = vec![common::robot("m1", [-10.4, 7.0], 0.75), common::robot("m2", [-14.4, 7.0], 1.0)];
    let person = |number: usize| {
        let place = [random.within(3.0, 10.0), random.within(3.0, 10.0)];
        common::agent(&format!("h{number}"), AgentKind::Human, place, 3, random.within(200.0, 300.0))
    };
    Problem::new(robots, (1..=people).map(person).collect())
}

/// Runs one mission to its end.
fn run(problem: Problem, seed: u64, replan: Replan, reallocate_above: f64) -> Result<Outcome, Refusal> {
    let budget = Budget { time: Duration::from_secs(60), nodes: 20, ..Budget::default() };
    let planning = Options { formulation: Some(Formulation::Batches), budget, ..Options::default() };
    let durations = Durations::Sampled { seed };
    let mut execution = ScheduleExecution::new(
        problem,
        Settings { durations, replan, reallocate_above, planning, ..Settings::default() },
    )?;
    let mut random = common::Random(seed ^ 0x5eed);
    random.unit();
    while let Some(next) = execution.next() {
        let served = execution.advance(next).iter().filter_map(|record| match record.what {
            LogEntry::Served { agent, .. } => Some(agent),
            _ => None,
        });
        for agent in served.collect::<Vec<_>>() {
            let (wait, approach) = (random.below(5) as i8 - 2, random.below(5) as i8 - 2);
            if let Err(error) = execution.handle_event(Event::Said { agent, wait, approach, distance: 0 }) {
                println!("not taken: {error}");
            }
        }
    }
    Ok(execution.statistics())
}

/// Returns mean and standard deviation.
fn spread(values: &[f64]) -> (f64, f64) {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    (mean, (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt())
}

fn main() {
    let runs = std::env::args().nth(1).and_then(|word| word.parse().ok()).unwrap_or(RUNS);
    let threshold = std::env::args().nth(2).and_then(|word| word.parse().ok()).unwrap_or(THRESHOLD);
    println!("{runs} runs         wait index     speed index    wait of all (s)  planned anew");
    for (name, replan) in [("without", Replan::None), ("with", Replan::Both)] {
        for people in 2..=6 {
            let (mut waits, mut speeds, mut waited, mut anew) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
            for number in 0..runs {
                match run(team(number, people), number, replan, threshold) {
                    Ok(outcome) => {
                        waits.extend(outcome.agents.iter().map(|agent| agent.wait_index));
                        speeds.extend(outcome.agents.iter().map(|agent| agent.speed_index));
                        waited.push(outcome.waited());
                        anew.push(outcome.reallocations as f64);
                    }
                    Err(refusal) => println!("run {number}: {refusal}"),
                }
            }
            let ((w, dw), (v, dv)) = (spread(&waits), spread(&speeds));
            let (waited, anew) = (spread(&waited).0, spread(&anew).0);
            println!("{people} people {name:<8} {w:5.2} +- {dw:4.2}  {v:5.2} +- {dv:4.2}  {waited:12.0}  {anew:8.1}");
        }
    }
}
