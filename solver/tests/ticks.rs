//! Ticks of a 100 Hz loop of thesis chapter 3 on a robot of 19 degrees of freedom, with optima
//! that were found by other solvers and hold a certificate: nothing active, at limits, near
//! singularities, hands crossing, contradictions, random. Both solvers find them, cold and warm,
//! in order and in reverse.

use hierarq_solver::{
    ActiveSet, ClarabelCascade, HierarchicalSolver, LevelShape, Problem, Solution, Status, certificate,
};
use serde_json::Value;

struct Tick {
    id: String,
    kind: String,
    problem: Problem,
    x: Vec<f64>,
    violation: Vec<f64>,
}

fn numbers(v: &Value, missing: f64) -> Vec<f64> {
    v.as_array().expect("a list").iter().map(|x| x.as_f64().unwrap_or(missing)).collect()
}

fn ticks() -> Vec<Tick> {
    include_str!("data/ticks.jsonl").lines().map(tick).collect()
}

fn tick(line: &str) -> Tick {
    let v: Value = serde_json::from_str(line).expect("JSON");
    let n = v["n"].as_u64().expect("n") as usize;
    let levels = v["levels"].as_array().expect("levels");
    let bounds: Vec<(Vec<f64>, Vec<f64>)> =
        levels.iter().map(|l| (numbers(&l["lo"], f64::NEG_INFINITY), numbers(&l["up"], f64::INFINITY))).collect();
    let shapes: Vec<LevelShape> =
        bounds.iter().map(|(lower, _)| LevelShape { rows: lower.len(), hard: false, damping: 0.0 }).collect();
    let mut problem = Problem::new(n, &shapes);
    for ((level, l), (lower, upper)) in problem.levels.iter_mut().zip(levels).zip(&bounds) {
        for i in 0..level.rows() {
            let row = match l["A"].as_array() {
                Some(rows) => numbers(&rows[i], f64::NAN),
                None => (0..n).map(|j| f64::from(u8::from(j == i % n))).collect(),
            };
            level.set(i, &row, lower[i], upper[i]);
        }
    }
    let text = |key: &str| v[key].as_str().unwrap_or("").to_string();
    let known = |key: &str| if v[key].is_array() { numbers(&v[key], f64::NAN) } else { Vec::new() };
    Tick { id: text("id"), kind: text("kind"), problem, x: known("x"), violation: known("viol") }
}

/// The published optimum, to 1e-8 (1e-6 near singularities), every level's violation to 1e-6, and
/// the certificate.
fn agrees(tick: &Tick, solution: &Solution) {
    assert_eq!(solution.status, Status::Optimal, "{}", tick.id);
    let tolerance = if tick.kind == "near-singular" { 1e-6 } else { 1e-8 };
    for (found, x) in solution.x.iter().zip(&tick.x) {
        assert!((found - x).abs() < tolerance, "{}: {found} instead of {x}", tick.id);
    }
    for (level, violation) in solution.levels.iter().zip(&tick.violation) {
        assert!((level.violation - violation).abs() < 1e-6, "{}: {}", tick.id, level.violation);
    }
    let residual = certificate(&tick.problem, &solution.x);
    assert!(residual < 1e-9, "{}: {residual:e}", tick.id);
}

fn solve_all(solver: &mut dyn HierarchicalSolver, ticks: &mut dyn Iterator<Item = &Tick>) {
    for tick in ticks {
        let mut solution = Solution::new(&tick.problem);
        solver.solve(&tick.problem, &mut solution);
        agrees(tick, &solution);
    }
}

#[test]
fn active_set_cold() {
    let ticks = ticks();
    assert!(ticks.len() > 30);
    let mut solver = ActiveSet::new(&ticks[0].problem).with_warm_start(false);
    solve_all(&mut solver, &mut ticks.iter());
    assert_eq!(solver.effort().failures, 0);
}

/// Warm from the tick before, which often is of another scenario: the worst start there is.
#[test]
fn active_set_warm() {
    let ticks = ticks();
    let mut solver = ActiveSet::new(&ticks[0].problem);
    solve_all(&mut solver, &mut ticks.iter());
    solve_all(&mut solver, &mut ticks.iter().rev());
    solve_all(&mut solver, &mut ticks.iter().step_by(7).chain(ticks.iter().step_by(3)));
    assert_eq!(solver.effort().failures, 0);
}

#[test]
fn clarabel_cascade() {
    let ticks = ticks();
    solve_all(&mut ClarabelCascade::new(&ticks[0].problem), &mut ticks.iter());
}

/// A seven-joint arm beyond its reach, almost straight: a direction that moves a task by 3e-10 of
/// its size. Whether it counts must not depend on where the search comes from.
#[test]
fn what_hardly_counts_is_judged_alike_from_any_start() {
    let ticks: Vec<Tick> = include_str!("data/borderline.jsonl").lines().map(tick).collect();
    let solve = |solver: &mut ActiveSet, tick: &Tick| {
        let mut solution = Solution::new(&tick.problem);
        solver.solve(&tick.problem, &mut solution);
        assert_eq!(solution.status, Status::Optimal);
        solution.x
    };
    let mut warm = ActiveSet::new(&ticks[0].problem);
    solve(&mut warm, &ticks[0]);
    let from_there = solve(&mut warm, &ticks[1]);
    let from_nothing = solve(&mut ActiveSet::new(&ticks[1].problem), &ticks[1]);
    for (a, b) in from_there.iter().zip(&from_nothing) {
        assert!((a - b).abs() < 1e-6, "{from_there:?} {from_nothing:?}");
    }
}

/// The work of a solve in changes of the working set, which no machine's mood alters: a change that makes the search
/// longer shows here. Warm from the tick before in the file, which often is of another scenario; `tests/solvers.rs` counts
/// those of consecutive ticks.
#[test]
fn the_search_is_as_short_as_it_was() {
    let ticks = ticks();
    let changes = |warm: bool| {
        let mut solver = ActiveSet::new(&ticks[0].problem).with_warm_start(warm);
        solve_all(&mut solver, &mut ticks.iter());
        assert_eq!(solver.effort().restarts, 0);
        solver.effort().changes
    };
    let (cold, warm) = (changes(false), changes(true));
    assert!(cold <= 490 && warm <= 450, "{cold} cold, {warm} warm");
}
