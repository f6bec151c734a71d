//! Executes an exploration with many seeds, and prints the measures of Tables 1 and 2 of the paper the times of planning and the gaps of plans.
//!
//! `cargo run --release -p hierarq-mission --example explore -- MISSION.json SEEDS [open|hunted]`, with a mission as `hierarq compile --format json`
//! has it. `open` keeps the first plan. With `hunted` the person walks to a robot, in nine of ten seconds to the nearest one, for half a minute or until
//! the exit.

use std::time::Instant;

use hierarq_mission::execution::Replan;
use hierarq_mission::kind::{Cell, Detail, Event, Execution, ReportPart, Run};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

fn main() {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().expect("the path of a mission");
    let seeds: u64 = arguments.next().and_then(|seeds| seeds.parse().ok()).unwrap_or(10);
    let how = arguments.next();
    let (open, hunted) = (how.as_deref() == Some("open"), how.as_deref() == Some("hunted"));
    let text = std::fs::read_to_string(&path).expect("a readable file");
    let value: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let robots = value["problem"]["robots"].as_array().map_or(0, Vec::len);
    let kind = hierarq_mission::kinds::find("explore").expect("the kind");
    let mission = (kind.read)(value).expect("a mission");
    mission.check().expect("a sound mission");
    let names = [
        "targets",
        "by_robots",
        "redundant",
        "collisions",
        "disconnections",
        "without_plan",
        "kept",
        "exposed",
        "worst_gap",
        "makespan",
        "closest",
    ];
    println!("seed {}", names.join(" "));
    let mut sums = vec![0.0; names.len()];
    let mut times: Vec<f64> = Vec::new();
    let mut gaps: Vec<f64> = Vec::new();
    for seed in 0..seeds {
        let replan = if open { Replan::None } else { Replan::Both };
        let mut run = mission.execute(&Run { sampled: Some(seed), replan, ..Run::default() }).expect("a plan");
        run.advance(0.0);
        let mut draws = Pcg64::seed_from_u64(seed);
        while run.done().is_none() && run.time() < if hunted { 30.0 } else { 100.0 } {
            if hunted {
                hunt(run.as_mut(), robots, &mut draws);
            }
            let begun = Instant::now();
            run.advance(run.time() + 1.0);
            times.push(begun.elapsed().as_secs_f64());
        }
        gaps.extend(gaps_of(&run.report_parts()));
        let values: Vec<f64> = names.iter().map(|name| run.measure(name, None)[0]).collect();
        sums.iter_mut().zip(&values).for_each(|(sum, value)| *sum += value);
        println!("{seed} {}", values.iter().map(|x| format!("{x:.3}")).collect::<Vec<_>>().join(" "));
        if std::env::var("VERBOSE").is_ok() {
            run.log().iter().for_each(|entry| println!("   {:.2} {}", entry.time, entry.text));
        }
    }
    let means: Vec<String> = sums.iter().map(|sum| format!("{:.4}", sum / seeds as f64)).collect();
    println!("mean {}", means.join(" "));
    times.sort_by(f64::total_cmp);
    let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize];
    println!(
        "{} periods: median {:.3} s, p95 {:.3} s, p99 {:.3} s, worst {:.3} s",
        times.len(),
        at(0.5),
        at(0.95),
        at(0.99),
        at(1.0)
    );
    gaps.sort_by(f64::total_cmp);
    let at = |share: f64| gaps[((gaps.len() - 1) as f64 * share) as usize];
    println!("{} plans: gap median {:.3}, p95 {:.3}, worst {:.3}", gaps.len(), at(0.5), at(0.95), at(1.0));
}

/// Sends the person to a robot.
fn hunt(run: &mut dyn Execution, robots: usize, draws: &mut Pcg64) {
    let at = run.measure("position", Some(robots));
    let places: Vec<[f64; 3]> = (0..robots).map(|robot| run.measure("position", Some(robot))).collect();
    let far = |of: &[f64; 3]| f64::hypot(of[0] - at[0], of[1] - at[1]);
    let nearest = places.iter().min_by(|a, b| far(a).total_cmp(&far(b))).copied().expect("a robot");
    let to = if !draws.next_u64().is_multiple_of(10) {
        nearest
    } else {
        places[(draws.next_u64() % robots as u64) as usize]
    };
    // Cells that no way leads to are refused.
    let _ = run.handle(&Event::of("strays", robots).and("to", Detail::Point([to[0], to[1]])));
}

/// Gaps of the plans of a run to the lower bound.
fn gaps_of(parts: &[ReportPart]) -> Vec<f64> {
    let tables = parts.iter().filter_map(|part| match part {
        ReportPart::Table { table, .. } => Some(table),
        _ => None,
    });
    let gaps = tables.flat_map(|table| {
        let column = table.columns.iter().position(|column| *column == "gap");
        table.rows.iter().filter_map(move |row| match row.get(column?)? {
            Cell::Number(gap, "%") => Some(0.01 * gap),
            _ => None,
        })
    });
    gaps.collect()
}
