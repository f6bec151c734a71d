//! Experiment S.4: how long a team takes to find three hidden tokens on 750 m^2, planned for together, greedily, and for each agent
//! as if it were alone, over many seeds: `cargo run --release -p hierarq-mission --example hidden -- 100`.
//!
//! A seed gives the places of the tokens, their thresholds of detection and the times of ways, the same for the three planners, so
//! that differences are those of pairs. `-- 100 people` runs the yard with simulated people in their place.

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "hidden/people.rs"]
mod people;
#[path = "../tests/searched/mod.rs"]
mod searched;

use hierarq_mission::execution::{DiscreteEvents, PlanChange};
use hierarq_mission::kind::Run;
use hierarq_mission::kinds::search::Search;
use hierarq_mission::kinds::search::choose::Formulation;
use hierarq_mission::kinds::search::execution::{LogEntry, SearchExecution};
use hierarq_mission::kinds::search::problem::Problem;

use searched::yard;

const HORIZON: f64 = 900.0;
/// Times at which progress is reported (s).
const TIMES: [f64; 6] = [60.0, 120.0, 180.0, 240.0, 300.0, 360.0];

/// An episode.
#[derive(Clone, Debug, Default)]
struct Episode {
    /// Time at which the last token was found (s); the horizon, if one never was.
    time: f64,
    found: usize,
    /// Share of the ground that was explored then, by agent.
    explored: [f64; 2],
    /// The same of both at the times of the report, up to the end of the episode.
    progress: [f64; TIMES.len()],
    plans: usize,
}

fn episode(problem: &Problem, formulation: Formulation, seed: u64) -> Episode {
    let mut settings = Search { problem: problem.clone() }.settings(&Run { sampled: Some(seed), ..Run::default() });
    settings.formulation = formulation;
    let mut run = SearchExecution::new(problem.clone(), settings).expect("a mission without mistakes");
    let (mut time, mut progress) = (0.0, [0.0; TIMES.len()]);
    while time < HORIZON && run.problem().is_searching() {
        time += 0.5;
        run.run_until(time);
        for (_, share) in TIMES.iter().zip(&mut progress).filter(|(at, _)| **at >= time) {
            *share = run.explored(None);
        }
    }
    let times = run.secrets().iter().map(|secret| secret.found.unwrap_or(HORIZON));
    Episode {
        time: times.fold(0.0, f64::max),
        found: run.problem().objects[0].found,
        explored: [0, 1].map(|agent| run.explored(Some(agent))),
        progress,
        plans: run.records().iter().filter(|record| is_plan(&record.what)).count(),
    }
}

fn is_plan(what: &LogEntry) -> bool {
    matches!(what, LogEntry::Plan(PlanChange::Reallocated { .. }))
}

/// Mean and standard error.
fn mean(of: impl Iterator<Item = f64>) -> (f64, f64) {
    let all: Vec<f64> = of.collect();
    let count = all.len() as f64;
    let mean = all.iter().sum::<f64>() / count;
    let squares: f64 = all.iter().map(|x| (x - mean) * (x - mean)).sum();
    (mean, (squares / (count - 1.0) / count).sqrt())
}

fn main() {
    let seeds: u64 = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(100);
    if std::env::args().nth(2).as_deref() == Some("people") {
        return people::report(seeds);
    }
    let begun = std::time::Instant::now();
    let problem = yard();
    // One thread for half of the seeds each; planners use a single thread then.
    let all: Vec<[Episode; 3]> = std::thread::scope(|scope| {
        let part = |first: u64| {
            let problem = &problem;
            scope.spawn(move || {
                (first..seeds)
                    .step_by(2)
                    .map(|seed| (seed, Formulation::ALL.map(|formulation| episode(problem, formulation, seed))))
                    .collect::<Vec<_>>()
            })
        };
        let parts = [part(0), part(1)];
        let mut all: Vec<_> = parts.into_iter().flat_map(|part| part.join().expect("episodes")).collect();
        all.sort_by_key(|(seed, _)| *seed);
        all.into_iter().map(|(_, episodes)| episodes).collect()
    });
    println!("{seeds} seeds, {:.0} s", begun.elapsed().as_secs_f64());
    for (number, formulation) in Formulation::ALL.into_iter().enumerate() {
        let of = || all.iter().map(move |episodes| &episodes[number]);
        let (time, error) = mean(of().map(|e| e.time));
        let (explored, _) = mean(of().map(|e| e.explored.iter().sum::<f64>()));
        let (robot, _) = mean(of().map(|e| e.explored[0] / e.explored.iter().sum::<f64>()));
        let (plans, _) = mean(of().map(|e| e.plans as f64));
        let whole = of().filter(|e| e.found == 3).count();
        let mut times: Vec<f64> = of().map(|e| e.time).collect();
        times.sort_by(f64::total_cmp);
        println!(
            "{:<12} {time:6.1} +- {error:4.1} s, median {:.1}, slowest {:.1}; {whole} found all; explored {:.1} %, the robot {:.1} % \
             of it; {plans:.1} plans",
            formulation.name(),
            times[times.len() / 2],
            times[times.len() - 1],
            100.0 * explored,
            100.0 * robot
        );
        let shares = TIMES
            .iter()
            .enumerate()
            .map(|(k, at)| format!("{at:.0} s {:.1} %", 100.0 * mean(of().map(|e| e.progress[k])).0));
        println!("             explored after {}", shares.collect::<Vec<_>>().join(", "));
        if number > 0 {
            let (difference, error) = mean(all.iter().map(|e| e[number].time - e[0].time));
            println!("             longer than tree search by {difference:.1} +- {error:.1} s");
        }
    }
}
