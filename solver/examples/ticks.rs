//! Runs a file of reference ticks (one JSON object a line: `kind`, `n`, `levels` with `A`, `lo`,
//! `up`, the optimum `x` and the violations `viol`) and prints, per kind, how far the cascade is
//! from them and how long it takes.
//!
//! usage: ticks FILE [cold|conic]   (cold: nothing remembered; conic: Clarabel first)

use hierarq_solver::{ClarabelCascade, HierarchicalSolver, LevelShape, Problem, Solution, Status, certificate};
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::time::Instant;

#[derive(Default)]
struct Tally {
    dx: Vec<f64>,
    violation: f64,
    certificate: f64,
    failures: usize,
    micros: Vec<f64>,
    programs: usize,
    unpolished: usize,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: ticks FILE [cold|conic]")?;
    let mode = std::env::args().nth(2).unwrap_or_default();
    let mut tallies: BTreeMap<String, Tally> = BTreeMap::new();
    let mut solver: Option<(ClarabelCascade, Vec<usize>)> = None;
    for line in BufReader::new(std::fs::File::open(path)?).lines() {
        let tick: Value = serde_json::from_str(&line?)?;
        let problem = read(&tick).ok_or("not a tick")?;
        let shape: Vec<usize> = problem.levels.iter().map(|l| l.rows()).collect();
        if solver.as_ref().is_none_or(|(_, s)| *s != shape) {
            let made = ClarabelCascade::new(&problem).with_search_first(mode != "conic");
            solver = Some((made, shape));
        }
        let Some((cascade, _)) = solver.as_mut() else { continue };
        if mode == "cold" {
            cascade.forget();
        }
        let before = cascade.statistics();
        let mut solution = Solution::new(&problem);
        let start = Instant::now();
        cascade.solve(&problem, &mut solution);
        let micros = start.elapsed().as_secs_f64() * 1e6;
        let tally = tallies.entry(text(&tick["kind"])).or_default();
        tally.micros.push(micros);
        tally.programs += cascade.statistics().conic_programs - before.conic_programs;
        tally.unpolished += cascade.statistics().unpolished - before.unpolished;
        tally.failures += usize::from(solution.status != Status::Optimal);
        let expected = numbers(&tick["x"], 0.0);
        let dx = (expected.iter().zip(&solution.x)).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
        let viol = numbers(&tick["viol"], 0.0);
        let dv = (viol.iter().zip(&solution.levels)).fold(0.0_f64, |m, (a, l)| m.max((a - l.violation).abs()));
        let residual = certificate(&problem, &solution.x);
        if dx > 1e-8 {
            println!(
                "{:16} dx {dx:.1e} dv {dv:.1e} certificate {residual:.1e} (theirs {:.1e})",
                text(&tick["id"]),
                certificate(&problem, &expected)
            );
        }
        tally.dx.push(dx);
        tally.violation = tally.violation.max(dv);
        tally.certificate = tally.certificate.max(residual);
    }
    println!(
        "{:14} {:>5} {:>8} {:>8} {:>8} {:>8} {:>6} {:>8} {:>8} {:>8} {:>8} {:>9} {:>6}",
        "kind",
        "ticks",
        "dx med",
        "dx max",
        "viol max",
        "certif",
        "failed",
        "mean us",
        "med us",
        "p99 us",
        "max us",
        "programs",
        "rough"
    );
    for (kind, mut t) in tallies {
        let count = t.dx.len();
        t.dx.sort_by(f64::total_cmp);
        t.micros.sort_by(f64::total_cmp);
        println!(
            "{kind:14} {count:5} {:8.1e} {:8.1e} {:8.1e} {:8.1e} {:6} {:8.0} {:8.0} {:8.0} {:8.0} {:9} {:6}",
            t.dx[count / 2],
            t.dx[count - 1],
            t.violation,
            t.certificate,
            t.failures,
            t.micros.iter().sum::<f64>() / count as f64,
            t.micros[count / 2],
            t.micros[count * 99 / 100],
            t.micros[count - 1],
            t.programs,
            t.unpolished
        );
    }
    Ok(())
}

fn text(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_owned()
}

fn numbers(value: &Value, null: f64) -> Vec<f64> {
    value.as_array().into_iter().flatten().map(|v| v.as_f64().unwrap_or(null)).collect()
}

fn read(tick: &Value) -> Option<Problem> {
    let n = usize::try_from(tick["n"].as_u64()?).ok()?;
    let levels = tick["levels"].as_array()?;
    let shapes: Vec<LevelShape> =
        levels.iter().map(|l| LevelShape { rows: numbers(&l["lo"], 0.0).len(), hard: false, damping: 0.0 }).collect();
    let mut problem = Problem::new(n, &shapes);
    for (l, level) in levels.iter().enumerate() {
        let (lo, up) = (numbers(&level["lo"], f64::NEG_INFINITY), numbers(&level["up"], f64::INFINITY));
        for i in 0..lo.len() {
            let row = match level["A"].as_array() {
                Some(rows) => numbers(&rows[i], 0.0),
                None => (0..n).map(|j| f64::from(u8::from(j == i % n))).collect(),
            };
            problem.levels[l].set(i, &row, lo[i], up[i]);
        }
    }
    Some(problem)
}
