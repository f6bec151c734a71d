//! Prints the values of thesis Tables 6.3 to 6.5 for the proposed method, for letters H and D and sorting with
//! handwritten layers: time of the planner, J, makespan, workload, energy; the error of batches relative to the whole,
//! and the relative error (6.17) of a naive allocation, which replaces a model that allocates too: agents in turn,
//! objects by name. With `large`, random problems of maximum size.
//!
//! `cargo run --release -p hierarq-mission --example letters [SECONDS] [large]`

#[path = "../tests/layered/mod.rs"]
mod layered;

use std::time::{Duration, Instant};

use hierarq_mission::engine::Budget;
use hierarq_mission::kinds::layers::choose::{Formulation, Options, plan};
use hierarq_mission::kinds::layers::cost::cost;
use hierarq_mission::kinds::layers::problem::Problem;
use hierarq_mission::kinds::layers::steps::from_plan;
use hierarq_mission::kinds::layers::validate::validate;
use hierarq_mission::plan::Status;

fn show(name: &str, problem: &Problem, options: &Options) -> f64 {
    let begun = Instant::now();
    let plan = match plan(problem, options) {
        Ok(plan) => plan,
        Err(refusal) => {
            println!("{name}: {refusal}");
            return f64::NAN;
        }
    };
    let seconds = begun.elapsed().as_secs_f64();
    let cost = cost(problem, &from_plan(&plan));
    let sure = match plan.status {
        Status::Proven { .. } => "proven".to_string(),
        Status::Gap { gap, .. } => format!("gap {:.2} %", 100.0 * gap),
        Status::Unbounded { .. } => "no bound".to_string(),
    };
    println!(
        "{name:<28} {seconds:8.3} s  J {:.4}  mu {:.4}  omega {:.4}  e {:.4}  end {:6.1} s  {sure}, {} parts, {} relaxed{}",
        plan.cost,
        cost.makespan,
        cost.workload,
        cost.energy,
        plan.end().unwrap_or(0.0),
        plan.statistics.nodes,
        plan.statistics.solves,
        if validate(problem, &plan).is_empty() { "" } else { "  NOT VALID" },
    );
    plan.cost
}

/// Allocates agents in turn, and to each task the first free object by name; the planner then decides only speeds.
fn naive(problem: &Problem) -> Option<Problem> {
    let mut naive = problem.clone();
    let mut names: Vec<usize> = (0..problem.objects.len()).collect();
    names.sort_by_key(|object| &problem.objects[*object].name);
    let mut turn = 0;
    for task in 0..problem.tasks.len() {
        let needs = problem.tasks[task].needs_object();
        let free = |object: &usize| naive.tasks.iter().all(|other| other.object != Some(*object));
        let object = names.iter().copied().find(|object| problem.suits(task, *object) && free(object));
        let object = if needs { Some(object?) } else { None };
        let count = problem.agents.len();
        let agent = (turn..turn + count).map(|a| a % count).find(|agent| problem.able(*agent, task, object))?;
        turn = agent + 1;
        (naive.tasks[task].agent, naive.tasks[task].object) = (Some(agent), object);
    }
    Some(naive)
}

fn main() {
    let seconds = std::env::args().nth(1).and_then(|word| word.parse().ok()).unwrap_or(10);
    let budget = Budget { time: Duration::from_secs(seconds), ..Budget::default() };
    let whole = Options { formulation: Some(Formulation::Branch), budget, ..Options::default() };
    let parts = Options { formulation: Some(Formulation::Batches), ..whole };
    if std::env::args().any(|word| word == "large") {
        for (tasks, objects, robots, humans) in
            [(20, 40, 3, 1), (30, 60, 4, 2), (40, 80, 6, 2), (64, 128, 8, 4), (128, 256, 8, 4), (256, 512, 20, 12)]
        {
            for seed in 0..2 {
                let problem = layered::random(seed, tasks, objects, robots, humans);
                let name = format!("{tasks} tasks, {objects} objects, {} agents", robots + humans);
                let best = show(&name, &problem, &whole);
                let batched = show(&format!("{name}, batches"), &problem, &parts);
                println!("  error of batches {:.2} %", 100.0 * (batched / best - 1.0));
            }
        }
        return;
    }
    type Mission = fn(u64) -> Problem;
    let missions: [(&str, Mission); 3] =
        [("letter H", layered::letter_h), ("letter D", layered::letter_d), ("sorting", layered::sorting)];
    for (name, mission) in missions {
        for set in 1..=3 {
            let problem = mission(set);
            let best = show(&format!("{name}, objects {set}"), &problem, &whole);
            let batched = show(&format!("{name}, objects {set}, batches"), &problem, &parts);
            let allocated = naive(&problem).map(|naive| show(&format!("{name}, objects {set}, naive"), &naive, &whole));
            let error = allocated.unwrap_or(f64::NAN) / best - 1.0;
            println!("  error of batches {:.2} %, of the naive allocation {error:.2}", 100.0 * (batched / best - 1.0));
        }
    }
}
