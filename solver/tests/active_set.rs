//! The active-set solver on random hierarchies: the optimality certificate, which shares no step
//! with it, holds at every answer; the Clarabel cascade finds the same points; what was solved
//! before, the order of rows and the levels below change nothing; multipliers balance.

use crate::common;

use common::{Dice, Taste, WILD, hierarchy, size, turned};
use hierarq_solver::{
    ActiveSet, ClarabelCascade, HierarchicalSolver, Level, LevelShape, LevelStatus, Problem, Solution, Status,
    certificate,
};
use proptest::prelude::*;

const LARGE: Taste = Taste { variables: 40, levels: 6, rows: 30, dependent: 0.1, ..WILD };

fn solve(problem: &Problem) -> Solution {
    let mut solution = Solution::new(problem);
    ActiveSet::new(problem).solve(problem, &mut solution);
    solution
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |d: f64, (a, b)| d.max((a - b).abs()))
}

fn certified(problem: &Problem, solution: &Solution) {
    assert_eq!(solution.status, Status::Optimal);
    let residual = certificate(problem, &solution.x);
    assert!(residual < 1e-8 * size(&solution.x), "{residual:e}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(250))]

    #[test]
    fn answers_are_certified(seed: u64) {
        let problem = hierarchy(&mut Dice(seed), WILD);
        certified(&problem, &solve(&problem));
    }

    /// Rows of 1e-6 to 1e6.
    #[test]
    fn rows_of_very_different_size_are_certified(seed: u64) {
        let problem = hierarchy(&mut Dice(seed), Taste { decades: 4.6, weights: false, ..WILD });
        certified(&problem, &solve(&problem));
    }

    /// Degenerate on purpose: multipliers that are zero, bounds that just touch.
    #[test]
    fn ties_are_certified(seed: u64) {
        let problem = hierarchy(&mut Dice(seed), Taste { ties: true, ..WILD });
        certified(&problem, &solve(&problem));
    }

    #[test]
    fn damped_levels_are_certified(seed: u64) {
        let mut dice = Dice(seed);
        let mut problem = hierarchy(&mut dice, WILD);
        let l = dice.below(problem.levels.len());
        problem.levels[l].damping = 10_f64.powf(2.0 * dice.unit() - 2.0);
        let solution = solve(&problem);
        certified(&problem, &solution);
        prop_assert_eq!(solution.levels[l].freedom, 0);
    }

    #[test]
    fn the_reference_is_the_nearest_point(seed: u64) {
        let mut dice = Dice(seed);
        let mut problem = hierarchy(&mut dice, Taste { rows: 6, ..WILD });
        problem.reference.iter_mut().for_each(|r| *r = dice.unit());
        certified(&problem, &solve(&problem));
    }

    #[test]
    fn clarabel_finds_the_same_point(seed: u64) {
        let problem = hierarchy(&mut Dice(seed), WILD);
        let mut other = Solution::new(&problem);
        ClarabelCascade::new(&problem).solve(&problem, &mut other);
        prop_assume!(other.status == Status::Optimal);
        let found = solve(&problem);
        prop_assert!(distance(&found.x, &other.x) < 1e-7 * size(&other.x), "{:?} {:?}", found.x, other.x);
        for (a, b) in found.levels.iter().zip(&other.levels) {
            prop_assert_eq!(&a.active, &b.active);
            prop_assert_eq!(a.status, b.status);
        }
    }

    /// From the working set of any other problem of the same shape.
    #[test]
    fn any_start_leads_to_the_same_answer(seed: u64) {
        let mut dice = Dice(seed);
        let problem = hierarchy(&mut dice, WILD);
        let mut other = problem.clone();
        scramble(&mut other, &mut dice, 1.0);
        let mut solver = ActiveSet::new(&problem);
        let mut solution = Solution::new(&problem);
        solver.solve(&other, &mut solution);
        solver.solve(&problem, &mut solution);
        certified(&problem, &solution);
        let cold = solve(&problem);
        prop_assert!(distance(&solution.x, &cold.x) < 1e-9 * size(&cold.x), "{:?} {:?}", solution.x, cold.x);
    }

    #[test]
    fn drifting_problems_are_certified(seed: u64) {
        let mut dice = Dice(seed);
        let mut problem = hierarchy(&mut dice, WILD);
        let mut solver = ActiveSet::new(&problem);
        let mut solution = Solution::new(&problem);
        for _ in 0..10 {
            solver.solve(&problem, &mut solution);
            certified(&problem, &solution);
            scramble(&mut problem, &mut dice, 0.05);
        }
    }

    #[test]
    fn the_order_of_rows_in_a_level_means_nothing(seed: u64) {
        let problem = hierarchy(&mut Dice(seed), WILD);
        let turned = turned(&problem);
        let (a, b) = (solve(&problem), solve(&turned));
        prop_assert!(distance(&a.x, &b.x) < 1e-8 * size(&a.x));
    }

    #[test]
    fn a_level_below_changes_nothing_above(seed: u64) {
        let whole = hierarchy(&mut Dice(seed), WILD);
        let full = solve(&whole);
        for keep in 1..whole.levels.len() {
            let mut upper = whole.clone();
            upper.levels.truncate(keep);
            for (a, b) in solve(&upper).levels.iter().zip(&full.levels) {
                prop_assert!((a.violation - b.violation).abs() < 1e-9 * size(&full.x));
                for (a, b) in a.slack.iter().zip(&b.slack) {
                    prop_assert!((a - b).abs() < 1e-8 * size(&full.x));
                }
            }
        }
    }

    /// A hard level that can be met changes nothing; one that cannot is named, with the best
    /// compromise of its rows and the optimum of the levels above.
    #[test]
    fn hard_levels_are_met_or_named(seed: u64) {
        let mut dice = Dice(seed);
        let mut problem = hierarchy(&mut dice, WILD);
        problem.levels.iter_mut().for_each(|l| l.weight.fill(1.0));
        let soft = solve(&problem);
        prop_assume!(soft.levels.iter().all(|l| l.violation < 1e-10 || l.violation > 1e-6));
        let l = dice.below(problem.levels.len());
        problem.levels[l].hard = true;
        let found = solve(&problem);
        if soft.levels[l].violation < 1e-10 {
            prop_assert_eq!(found.status, Status::Optimal);
            prop_assert!(distance(&found.x, &soft.x) < 1e-9 * size(&soft.x));
            return Ok(());
        }
        prop_assert_eq!(found.status, Status::Infeasible { level: l });
        prop_assert_eq!(found.levels[l].status, LevelStatus::Infeasible);
        prop_assert!((found.levels[l].violation - soft.levels[l].violation).abs() < 1e-8 * size(&soft.x));
        prop_assert!(found.levels[l + 1..].iter().all(|l| l.status == LevelStatus::NotSolved));
        let mut above = problem.clone();
        above.levels.truncate(l);
        prop_assert!(distance(&found.x, &solve(&above).x) < 1e-9 * size(&found.x));
    }

    /// The rows said to hold a level back balance its gradient, together with the rows that are
    /// fixed above it.
    #[test]
    fn multipliers_balance(seed: u64) {
        let problem = hierarchy(&mut Dice(seed), WILD);
        balance(&problem)?;
    }
}

/// A row that is nothing but what rounding left of a difference (8e-17) counts as a row of zeros.
#[test]
fn a_row_of_rounding_has_no_say() -> Result<(), TestCaseError> {
    let mut problem = hierarchy(&mut Dice(17648973721773913633), WILD);
    let row = problem.levels[1].row(1);
    assert!(row.iter().any(|a| *a != 0.0) && row.iter().all(|a| a.abs() < 1e-16));
    let solution = solve(&problem);
    certified(&problem, &solution);
    problem.levels[1].row_mut(1).fill(0.0);
    assert_eq!(solve(&problem).x, solution.x);
    balance(&problem)
}

/// The force of each level is balanced by the rows fixed above it and those said to hold it back.
fn balance(problem: &Problem) -> Result<(), TestCaseError> {
    let solution = solve(problem);
    let far = size(&solution.x);
    let mut fixed: Vec<Vec<f64>> = Vec::new();
    for (l, (level, out)) in problem.levels.iter().zip(&solution.levels).enumerate() {
        let mut force = vec![0.0; problem.n];
        let mut add = |level: &Level, i: usize, s: f64| {
            force.iter_mut().zip(level.row(i)).for_each(|(f, a)| *f += s * a);
        };
        let (mut total, mut quiet) = (0.0, 0.0);
        for i in 0..level.rows() {
            add(level, i, out.multipliers[i]);
            total += out.multipliers[i].abs() * size(level.row(i));
            // A slack is a difference of numbers as large as the point and the row; below 1e-12 of them it counts as none.
            quiet += 1e-12 * far * level.weight[i] * size(level.row(i)).powi(2);
        }
        for b in solution.blocking.iter().filter(|b| b.level == l) {
            prop_assert!(b.multiplier > 0.0 && b.by_level < l);
            add(&problem.levels[b.by_level], b.by_row, if b.at_upper { b.multiplier } else { -b.multiplier });
        }
        project_out(&mut force, &fixed);
        prop_assert!(size(&force) - 1.0 < 1e-7 * total + quiet, "level {l}: {force:?} of {total}");
        for i in 0..level.rows() {
            if level.weight[i] > 0.0 && (level.is_equality(i) || out.slack[i].abs() > 1e-9 * size(level.row(i))) {
                extend(&mut fixed, level.row(i));
            }
        }
        for b in solution.blocking.iter().filter(|b| b.level == l) {
            extend(&mut fixed, problem.levels[b.by_level].row(b.by_row));
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn large_problems_are_certified(seed: u64) {
        let problem = hierarchy(&mut Dice(seed), LARGE);
        certified(&problem, &solve(&problem));
    }
}

/// Changes coefficients and bounds a little or a lot; equalities stay equalities.
fn scramble(problem: &mut Problem, dice: &mut Dice, by: f64) {
    for level in &mut problem.levels {
        for i in 0..level.rows() {
            let move_by = by * dice.unit();
            level.lower[i] += move_by;
            level.upper[i] += move_by;
            level.row_mut(i).iter_mut().for_each(|a| *a *= 1.0 + by * dice.unit());
        }
    }
}

/// Takes the span of orthonormal rows out of `v`, twice.
fn project_out(v: &mut [f64], rows: &[Vec<f64>]) {
    for row in rows.iter().chain(rows) {
        let part: f64 = v.iter().zip(row).map(|(v, r)| v * r).sum();
        v.iter_mut().zip(row).for_each(|(v, r)| *v -= part * r);
    }
}

fn extend(rows: &mut Vec<Vec<f64>>, row: &[f64]) {
    let mut v = row.to_vec();
    let before = v.iter().map(|v| v * v).sum::<f64>().sqrt();
    project_out(&mut v, rows);
    let after = v.iter().map(|v| v * v).sum::<f64>().sqrt();
    if after > 1e-9 * before {
        rows.push(v.iter().map(|v| v / after).collect());
    }
}

/// Refusals are statuses, not panics, and the next solve is as good as ever.
#[test]
fn numbers_that_are_none_are_refused() {
    let shape = LevelShape { rows: 2, hard: false, damping: 0.0 };
    let good = {
        let mut p = Problem::new(3, &[shape, shape]);
        p.levels[0].set(0, &[1.0, 0.0, 1.0], -1.0, 1.0);
        p.levels[1].set(1, &[1.0, 2.0, 3.0], 4.0, 4.0);
        p
    };
    let expected = solve(&good);
    let mut solver = ActiveSet::new(&good);
    let mut solution = Solution::new(&good);
    type Spoil = fn(&mut Problem);
    let cases: [(Spoil, Status); 8] = [
        (|p| p.levels[0].row_mut(1)[2] = f64::NAN, Status::NotFinite { level: 0, row: 1 }),
        (|p| p.levels[1].row_mut(0)[0] = f64::INFINITY, Status::NotFinite { level: 1, row: 0 }),
        (|p| p.levels[1].lower[1] = f64::NAN, Status::NotFinite { level: 1, row: 1 }),
        (|p| p.levels[0].weight[0] = f64::NAN, Status::NotFinite { level: 0, row: 0 }),
        (|p| p.levels[0].weight[0] = -1.0, Status::Failed { level: 0 }),
        (|p| p.levels[1].lower[1] = 5.0, Status::Failed { level: 1 }),
        (|p| p.levels[1].damping = f64::NAN, Status::Failed { level: 1 }),
        (|p| p.reference[1] = f64::NAN, Status::NotFinite { level: 2, row: 0 }),
    ];
    for (spoil, status) in cases {
        let mut problem = good.clone();
        spoil(&mut problem);
        solver.solve(&problem, &mut solution);
        assert_eq!(solution.status, status);
        solver.solve(&good, &mut solution);
        assert_eq!(solution.status, Status::Optimal);
        assert_eq!(solution.x, expected.x);
    }
}

/// No variables, no levels, no rows: there is always an answer.
#[test]
fn empty_problems_have_answers() {
    let shape = |rows| LevelShape { rows, hard: true, damping: 0.0 };
    for (n, rows) in [(0, vec![]), (3, vec![]), (0, vec![2]), (3, vec![0, 0]), (1, vec![0, 1])] {
        let problem = Problem::new(n, &rows.iter().map(|m| shape(*m)).collect::<Vec<_>>());
        let solution = solve(&problem);
        assert_eq!(solution.status, Status::Optimal, "{n} {rows:?}");
        assert_eq!(solution.x, vec![0.0; n]);
    }
}

/// One solver for problems of any shape, one after the other.
#[test]
fn other_shapes_are_taken() {
    let mut solver = ActiveSet::new(&Problem::new(1, &[]));
    for seed in 0..60 {
        let problem = hierarchy(&mut Dice(seed), WILD);
        let mut solution = Solution::new(&problem);
        solver.solve(&problem, &mut solution);
        certified(&problem, &solution);
    }
}
