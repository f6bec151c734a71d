//! Comparison of the planner of layers with external solvers.
//!
//! Without an argument, prints 50 random problems with fixed speeds, one JSON object per line, with all modes of each
//! task and the cost that branch and bound proves. `examples/cp_sat.py` solves them with OR-Tools CP-SAT and compares:
//!
//! `cargo run --release -p hierarq-mission --example layers_outside | python3 mission/examples/cp_sat.py`
//!
//! With `highs`, speeds are decisions, and branch and bound is compared with the mixed-integer program solved by HiGHS,
//! on random problems and on letters H and D.

#[path = "../tests/layered/mod.rs"]
mod layered;

use std::time::{Duration, Instant};

use hierarq_mission::engine::Budget;
use hierarq_mission::engine::Engine;
use hierarq_mission::kinds::layers::choose::{Formulation, Options, plan};
use hierarq_mission::kinds::layers::problem::{Body, Problem};
use hierarq_mission::kinds::layers::scales::Scales;
use hierarq_mission::numbers::Range;
use hierarq_mission::plan::Status;

const COUNT: usize = 50;

/// Returns agent, object (-1: none), seconds and cost of every mode of a task.
fn modes(problem: &Problem, scales: &Scales, task: usize) -> Vec<String> {
    let needs = problem.tasks[task].needs_object();
    let objects = (0..problem.objects.len()).filter(|object| problem.suits(task, *object)).map(Some);
    let mut modes = Vec::new();
    for object in objects.chain((!needs).then_some(None)) {
        for (agent, who) in problem.agents.iter().enumerate().filter(|(agent, _)| problem.able(*agent, task, object)) {
            let Some(skill) = who.skill(&problem.tasks[task].action) else { continue };
            let way = problem.distance(agent, task, object);
            let per = |value: f64| if scales.of_agent[agent] > 0.0 { value / scales.of_agent[agent] } else { 0.0 };
            let (time, cost) = match who.body {
                Body::Robot { speed, energy } => {
                    let v = speed.low;
                    let joules = (energy.standby + energy.friction * v + energy.drag * v * v) * way / v;
                    (skill.duration + way / v, problem.weights.energy * per(joules))
                }
                Body::Human { .. } => {
                    let mass = problem.mass(object);
                    let pace = problem.pace(who, skill, mass).unwrap_or(f64::NAN);
                    let time = skill.duration + way / pace;
                    (time, problem.weights.workload * per(time * mass.unwrap_or(0.0)))
                }
            };
            let object = object.map_or(-1, |object| object as i64);
            modes.push(format!("[{agent}, {object}, {time}, {cost}]"));
        }
    }
    modes
}

fn fixed() {
    let options = Options { budget: Budget { gap: 1e-6, ..Budget::default() }, ..Options::default() };
    let mut printed = 0;
    for seed in 0.. {
        let mut problem = layered::random(seed, 5 + seed as usize % 6, 14, 2, 1 + seed as usize % 2);
        for who in &mut problem.agents {
            if let Body::Robot { speed, .. } = &mut who.body {
                *speed = Range::point(speed.high);
            }
        }
        let Ok(found) = plan(&problem, &options) else { continue };
        let scales = Scales::of(&problem);
        let second = problem.weights.makespan / scales.makespan;
        let tasks = problem.tasks.iter().enumerate().map(|(index, task)| {
            format!("{{\"layer\": {}, \"modes\": [{}]}}", task.layer, modes(&problem, &scales, index).join(", "))
        });
        let tasks: Vec<String> = tasks.collect();
        let proven = matches!(found.status, Status::Proven { .. });
        println!(
            "{{\"seed\": {seed}, \"second\": {second}, \"cost\": {}, \"proven\": {proven}, \"tasks\": [{}]}}",
            found.cost,
            tasks.join(", ")
        );
        printed += 1;
        if printed == COUNT {
            return;
        }
    }
}

fn highs() {
    let budget = Budget { time: Duration::from_secs(60), gap: 1e-5, nodes: 1_000_000 };
    let mut problems: Vec<(String, Problem)> = vec![];
    for seed in 0..20 {
        let tasks = 5 + seed as usize % 5;
        problems.push((format!("random {seed}, {tasks} tasks"), layered::random(seed, tasks, 14, 2, 1)));
    }
    problems.extend([("letter H".into(), layered::letter_h(1)), ("letter D".into(), layered::letter_d(1))]);
    for (name, problem) in problems {
        let mut told = vec![];
        for formulation in [Formulation::Branch, Formulation::Mixed] {
            let options =
                Options { formulation: Some(formulation), engine: Engine::Highs, budget, ..Options::default() };
            let begun = Instant::now();
            told.push(match plan(&problem, &options) {
                Ok(plan) => {
                    let bound = plan.status.bound().unwrap_or(f64::NAN);
                    format!("J {:.6}, bound {bound:.6}, {:.2} s", plan.cost, begun.elapsed().as_secs_f64())
                }
                Err(refusal) => refusal.to_string(),
            });
        }
        println!("{name:<20} branch and bound {}; HiGHS {}", told[0], told[1]);
    }
}

fn main() {
    if std::env::args().any(|word| word == "highs") { highs() } else { fixed() }
}
