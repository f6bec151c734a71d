//! Measures the planners on the shapes of thesis Tables 5.5 to 5.7 and with speeds as decisions.
//!
//! ```text
//! cargo run --release -p hierarq-mission --example measure --
//!     [fixed|speeds|vineyard|operations|weights|batches|large|durations|agree] [position] [highs] [SECONDS]
//! ```
//!
//! `durations` measures Table 5.4, `vineyard` the first plan of 5.7.2; `agree` compares all formulations and engines on
//! problems that all of them prove, with HiGHS if it is available.

#[path = "../tests/common/mod.rs"]
mod common;

use std::time::{Duration, Instant};

use hierarq_mission::engine::Engine;
use hierarq_mission::engine::{Budget, Highs};
use hierarq_mission::kinds::schedule;
use hierarq_mission::kinds::schedule::choose::{Formulation, Options, plan};
use hierarq_mission::kinds::schedule::duration_quantile::quantile;
use hierarq_mission::kinds::schedule::problem::Problem;
use hierarq_mission::kinds::schedule::validate::validate;
use rand_distr::{Distribution, Normal};

fn show(name: &str, problem: &Problem, options: &Options) -> f64 {
    let begun = Instant::now();
    let plan = match plan(problem, options) {
        Ok(plan) => plan,
        Err(refusal) => {
            println!("{name}: refused: {refusal}");
            return f64::NAN;
        }
    };
    let seconds = begun.elapsed().as_secs_f64();
    let wrong = validate(problem, &plan).len();
    let gap = plan.status.bound().map_or(f64::NAN, |bound| (plan.cost - bound) / plan.cost);
    let Some(status) = format!("{:?}", plan.status).split(' ').next().map(str::to_owned) else { return f64::NAN };
    println!(
        "{name:<24} {seconds:8.3} s  cost {:10.6}  gap {:7.4} %  {status:<9} {} solves {} nodes {} cuts  {}{}",
        plan.cost,
        100.0 * gap,
        plan.statistics.solves,
        plan.statistics.nodes,
        plan.statistics.cuts,
        plan.engine,
        if wrong > 0 { "  NOT VALID" } else { "" },
    );
    plan.cost
}

/// Thesis Table 5.4: fraction of sufficient planned durations, and their slack (s), from `samples` samples of each of
/// four agents.
fn durations(samples: usize) {
    println!("{samples} samples of each agent\nconfidence  enough  left over (s)");
    let mut generator = rand_pcg::Pcg64::new(5, 4);
    for confidence in [0.6, 0.7, 0.8, 0.9, 0.95, 0.99] {
        let mut left = Vec::new();
        for agent in 1..=4 {
            let mean = 250.0 + 10.0 * f64::from(agent);
            let planned = quantile(schedule::problem::Duration { mean, sigma: 0.1 * mean }, confidence);
            let Ok(normal) = Normal::new(mean, 0.1 * mean) else { return };
            let taken = (0..samples).map(|_| normal.sample(&mut generator));
            left.extend(taken.filter(|taken| *taken <= planned).map(|taken| planned - taken));
        }
        let count = left.len() as f64;
        let mean = left.iter().sum::<f64>() / count;
        let deviation = (left.iter().map(|more| (more - mean).powi(2)).sum::<f64>() / count).sqrt();
        println!("{confidence:10.2}  {:6.3}  {mean:6.2} +- {deviation:5.2}", count / (4 * samples) as f64);
    }
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let asked = |word: &str| words.iter().any(|other| other == word);
    let seconds = words.iter().find_map(|word| word.parse::<u64>().ok()).unwrap_or(10);
    let engine = if asked("highs") { Engine::Highs } else { Engine::BuiltIn };
    let budget = Budget { time: Duration::from_secs(seconds), ..Budget::default() };
    let options = Options { engine, budget, ..Options::default() };
    if asked("fixed") {
        for agents in 1..=10 {
            for seed in 0..3 {
                show(&format!("fixed {agents} x 2, seed {seed}"), &common::fixed(seed, agents, 2, 1), &options);
            }
        }
        for robots in 3..=10 {
            show(&format!("fixed 4 x {robots}"), &common::fixed(0, 4, robots, 1), &options);
        }
    }
    let whole = Options { formulation: Some(Formulation::Position), ..options };
    let chosen = if asked("position") { whole } else { options };
    if asked("speeds") {
        for agents in [2, 3, 4, 5, 6, 8, 10, 12, 14] {
            if engine == Engine::Highs || !asked("position") || agents <= 12 {
                for seed in 0..3 {
                    show(&format!("speeds {agents} x 2, seed {seed}"), &common::random(seed, agents, 2, 1), &chosen);
                }
            }
        }
    }
    if asked("operations") {
        for robots in [3, 4] {
            for agents in [4, 6, 8] {
                show(&format!("speeds {agents} x {robots}"), &common::random(1, agents, robots, 1), &chosen);
            }
        }
        for operations in 1..=3 {
            show(&format!("vineyard 4 x {operations}"), &common::vineyard(operations), &chosen);
        }
        for (agents, operations) in [(2, 3), (3, 3), (4, 3), (2, 6), (3, 4), (6, 2)] {
            for seed in 0..3 {
                let name = format!("speeds {agents} x {operations} operations, seed {seed}");
                show(&name, &common::random(seed, agents, 2, operations), &chosen);
            }
        }
    }
    if asked("vineyard") {
        show("vineyard", &common::vineyard(3), &chosen);
    }
    if asked("durations") {
        durations(50);
        durations(20_000);
    }
    if asked("large") {
        for (agents, operations) in [(60, 1), (50, 4), (100, 5)] {
            show(&format!("large {agents} x {operations}"), &common::random(1, agents, 4, operations), &options);
        }
    }
    if asked("weights") {
        for agents in [5, 8, 10, 12] {
            for seed in 0..3 {
                let mut problem = common::random(seed, agents, 2, 1);
                let mut random = common::Random(seed + 100);
                for agent in &mut problem.agents {
                    agent.wait_weights = vec![random.within(0.2, 3.0)];
                    agent.approach_weights = vec![random.within(0.2, 3.0)];
                }
                show(&format!("uneven {agents} x 2, seed {seed}"), &problem, &chosen);
            }
        }
        for (agents, operations) in [(2, 3), (3, 2), (4, 2), (3, 3), (4, 3)] {
            let problem = common::fixed(1, agents, 2, operations);
            for formulation in [Formulation::Constraint, Formulation::Position] {
                let options = Options { formulation: Some(formulation), ..options };
                show(&format!("fixed {agents} x {operations} operations"), &problem, &options);
            }
        }
    }
    if asked("agree") {
        let highs = Highs::find().map_err(|error| println!("without HiGHS: {error}")).is_ok();
        let engines = if highs { vec![Engine::BuiltIn, Engine::Highs] } else { vec![Engine::BuiltIn] };
        let mut wrong = 0;
        for seed in 0..20 {
            for (agents, operations) in [(1, 2), (2, 2), (3, 1), (4, 1), (5, 1)] {
                let fixed = common::fixed(seed, agents, 2, operations);
                let mut ways = vec![Some(Formulation::Constraint)];
                ways.extend((operations == 1).then_some(Some(Formulation::Subsets)));
                let mut costs = vec![];
                for formulation in ways {
                    costs.push(show("fixed", &fixed, &Options { formulation, ..options }));
                }
                let mut free = vec![];
                for &engine in &engines {
                    costs.push(show("fixed", &fixed, &Options { engine, ..whole }));
                    let random = common::random(seed, agents, 2, operations);
                    free.push(show("speeds", &random, &Options { engine, ..whole }));
                }
                for costs in [costs, free] {
                    let least = costs.iter().copied().fold(f64::INFINITY, f64::min);
                    wrong += costs.iter().filter(|cost| **cost > least * (1.0 + 1e-4)).count();
                }
            }
        }
        println!("{wrong} disagreements");
    }
    if asked("batches") {
        let parts = Options { formulation: Some(Formulation::Batches), ..options };
        for agents in [5, 6, 7, 8, 9, 10] {
            let problem = common::fixed(1, agents, 2, 1);
            let all = show(&format!("whole {agents}"), &problem, &options);
            let cost = show(&format!("batches {agents}"), &problem, &parts);
            println!("  error {:.3} %", 100.0 * (cost / all - 1.0));
        }
        for agents in [15, 20, 25, 30] {
            show(&format!("batches {agents}"), &common::fixed(1, agents, 2, 1), &parts);
            show(&format!("with speeds {agents}"), &common::random(1, agents, 2, 1), &parts);
        }
    }
}
