//! Problems larger than a robot: 40, 80 and 120 variables, ten levels, hundreds of rows, most variables at a bound. Every answer holds the
//! certificate, from nothing and along a drift of the numbers, and warm and cold answers are one.

use crate::common;

use common::Dice;
use hierarq_solver::{ActiveSet, HierarchicalSolver, LevelShape, Problem, Solution, Status, certificate};

const LEVELS: usize = 10;

/// Bounds on all variables, walls beside them, and nine levels of wishes that lie outside.
fn pressed(n: usize, dice: &mut Dice) -> Problem {
    let mut shapes = vec![LevelShape { rows: 2 * n, hard: true, damping: 0.0 }];
    shapes.extend((1..LEVELS).map(|_| LevelShape { rows: n / 6, hard: false, damping: 0.0 }));
    let mut problem = Problem::new(n, &shapes);
    for i in 0..n {
        let mut unit = vec![0.0; n];
        unit[i] = 1.0;
        problem.levels[0].set(i, &unit, -1.0, 1.0);
        let wall: Vec<f64> = (0..n).map(|_| dice.unit()).collect();
        problem.levels[0].set(n + i, &wall, f64::NEG_INFINITY, 0.3 * (n as f64).sqrt() * (1.0 + dice.unit().abs()));
    }
    for level in &mut problem.levels[1..] {
        for i in 0..level.rows() {
            let row: Vec<f64> = (0..n).map(|_| dice.unit()).collect();
            let wish = 2.0 * (n as f64).sqrt() * dice.unit();
            let upper = if dice.chance(0.7) { wish } else { f64::INFINITY };
            level.set(i, &row, wish, upper);
        }
    }
    problem
}

/// The same problem a tick later.
fn drift(problem: &mut Problem, dice: &mut Dice) {
    for level in &mut problem.levels[1..] {
        for i in 0..level.rows() {
            let row: Vec<f64> = level.row(i).iter().map(|a| a + 2e-3 * dice.unit()).collect();
            let by = 2e-2 * dice.unit();
            let (lower, upper) = (level.lower[i] + by, level.upper[i] + by);
            level.set(i, &row, lower, upper);
        }
    }
}

#[test]
fn answers_to_large_problems_are_proven() {
    for (n, problems) in [(40, 8), (80, 4), (120, 2)] {
        for seed in 0..problems {
            let mut dice = Dice(1000 * n as u64 + seed);
            let mut problem = pressed(n, &mut dice);
            let mut warm = ActiveSet::new(&problem);
            let (mut one, mut other) = (Solution::new(&problem), Solution::new(&problem));
            for tick in 0..4 {
                warm.solve(&problem, &mut one);
                ActiveSet::new(&problem).solve(&problem, &mut other);
                assert_eq!((one.status, other.status), (Status::Optimal, Status::Optimal), "{n} {seed} {tick}");
                let residual = certificate(&problem, &one.x).max(certificate(&problem, &other.x));
                assert!(residual < 1e-9, "{n} {seed} {tick}: {residual:e}");
                let apart = one.x.iter().zip(&other.x).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(apart < 1e-9, "{n} {seed} {tick}: {apart:e}");
                let bound = one.x.iter().filter(|x| x.abs() > 1.0 - 1e-9).count();
                assert!(bound > n / 3, "{bound} of {n} variables are at a bound: nothing is pressed");
                drift(&mut problem, &mut dice);
            }
        }
    }
}

/// The optimum of the last tick is followed to the end if the problem changes little; a cold start would take 200
/// changes.
#[test]
fn a_large_problem_that_drifts_takes_few_changes() {
    let mut dice = Dice(560);
    let mut problem = pressed(80, &mut dice);
    let (mut warm, mut solution) = (ActiveSet::new(&problem), Solution::new(&problem));
    warm.solve(&problem, &mut solution);
    let mut most = 0;
    for _ in 0..300 {
        drift(&mut problem, &mut dice);
        let before = warm.effort().changes;
        warm.solve(&problem, &mut solution);
        most = most.max(warm.effort().changes - before);
    }
    assert!(most <= 60, "{most} changes");
}
