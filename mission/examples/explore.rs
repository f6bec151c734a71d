//! Executes an exploration with many seeds, and prints the measures of Tables 1 and 2 of the paper the times of planning and the gaps of plans.
//!
//! `cargo run --release -p hierarq-mission --example explore -- MISSION.json SEEDS [open]`, with a mission as `hierarq compile --format json`
//! has it.

use std::time::Instant;

use hierarq_mission::execution::Replan;
use hierarq_mission::kind::{Cell, ReportPart, Run};

fn main() {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().expect("the path of a mission");
    let seeds: u64 = arguments.next().and_then(|seeds| seeds.parse().ok()).unwrap_or(10);
    let open = arguments.next().is_some();
    let text = std::fs::read_to_string(&path).expect("a readable file");
    let value: serde_json::Value = serde_json::from_str(&text).expect("JSON");
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
        while run.done().is_none() && run.time() < 100.0 {
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
