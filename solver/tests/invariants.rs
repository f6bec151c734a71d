//! Invariants of all problems, and the status of problems without a solution.

use crate::common;

use common::{Dice, Taste, hierarchy, size, solve, turned};
use hierarq_solver::{
    Active, ClarabelCascade, HierarchicalSolver, Level, LevelShape, LevelStatus, Problem, ProblemError, Solution,
    Status, check,
};
use proptest::prelude::*;

const TASTE: Taste = Taste {
    variables: 8,
    levels: 4,
    rows: 8,
    equalities: 0.3,
    dependent: 0.2,
    decades: 0.0,
    weights: true,
    ties: false,
};

fn shape(rows: usize) -> LevelShape {
    LevelShape { rows, hard: false, damping: 0.0 }
}

fn hard(rows: usize) -> LevelShape {
    LevelShape { hard: true, ..shape(rows) }
}

type Coefficients<'a> = &'a [(f64, f64, f64)];

/// One variable; each level a list of (coefficient, lower, upper).
fn line(levels: &[(LevelShape, Coefficients)]) -> Problem {
    let shapes: Vec<LevelShape> = levels.iter().map(|(s, _)| *s).collect();
    let mut problem = Problem::new(1, &shapes);
    for (level, (_, rows)) in problem.levels.iter_mut().zip(levels) {
        for (i, (a, lower, upper)) in rows.iter().enumerate() {
            level.set(i, &[*a], *lower, *upper);
        }
    }
    problem
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(250))]

    #[test]
    fn a_level_below_changes_nothing_above(seed: u64) {
        let whole = hierarchy(&mut Dice(seed), TASTE);
        let full = solve(&whole);
        for keep in 1..whole.levels.len() {
            let mut upper = whole.clone();
            upper.levels.truncate(keep);
            let part = solve(&upper);
            for (a, b) in part.levels.iter().zip(&full.levels) {
                let most = 1e-8 * size(&full.x);
                prop_assert!((a.violation - b.violation).abs() < most, "{} {}", a.violation, b.violation);
            }
        }
    }

    #[test]
    fn the_order_of_rows_in_a_level_means_nothing(seed: u64) {
        let problem = hierarchy(&mut Dice(seed), TASTE);
        let turned = turned(&problem);
        let (a, b) = (solve(&problem), solve(&turned));
        prop_assert_eq!(a.status, Status::Optimal);
        for (a, b) in a.x.iter().zip(&b.x) {
            prop_assert!((a - b).abs() < 1e-7 * (1.0 + a.abs()));
        }
    }

    /// Ticks that drift: what is remembered from the last one makes no difference.
    #[test]
    fn warm_and_cold_agree(seed: u64) {
        let mut dice = Dice(seed);
        let mut problem = hierarchy(&mut dice, TASTE);
        let mut warm = ClarabelCascade::new(&problem);
        let mut solution = Solution::new(&problem);
        for _ in 0..6 {
            warm.solve(&problem, &mut solution);
            let cold = solve(&problem);
            for (a, b) in solution.x.iter().zip(&cold.x) {
                prop_assert!((a - b).abs() < 1e-7 * (1.0 + a.abs()));
            }
            for level in &mut problem.levels {
                for i in 0..level.rows() {
                    let move_by = 0.1 * dice.unit();
                    level.lower[i] += move_by;
                    level.upper[i] += move_by;
                    level.row_mut(i).iter_mut().for_each(|a| *a *= 1.0 + 0.05 * dice.unit());
                }
            }
        }
    }

    /// A hard level that can be met changes nothing against a soft one; one that cannot is named.
    #[test]
    fn hard_levels_are_met_or_named(seed: u64) {
        let mut dice = Dice(seed);
        let mut problem = hierarchy(&mut dice, TASTE);
        for level in &mut problem.levels {
            level.weight.fill(1.0);
        }
        let soft = solve(&problem);
        prop_assume!(soft.levels.iter().all(|l| l.violation < 1e-10 || l.violation > 1e-6));
        let l = dice.below(problem.levels.len());
        problem.levels[l].hard = true;
        let found = solve(&problem);
        if soft.levels[l].violation < 1e-10 {
            prop_assert_eq!(found.status, Status::Optimal);
            for (a, b) in found.x.iter().zip(&soft.x) {
                prop_assert!((a - b).abs() < 1e-7 * (1.0 + a.abs()));
            }
        } else {
            prop_assert_eq!(found.status, Status::Infeasible { level: l });
            prop_assert_eq!(found.levels[l].status, LevelStatus::Infeasible);
            prop_assert!(found.levels[l].active.contains(&Active::Violated));
            prop_assert!(found.levels[l + 1..].iter().all(|l| l.status == LevelStatus::NotSolved));
            let mut above = problem.clone();
            above.levels.truncate(l);
            for (a, b) in found.x.iter().zip(&solve(&above).x) {
                prop_assert!((a - b).abs() < 1e-7 * (1.0 + a.abs()));
            }
        }
    }
}

#[test]
fn a_contradicted_hard_row_is_named() {
    let problem = line(&[
        (hard(1), &[(1.0, -1.0, 1.0)]),
        (hard(3), &[(1.0, 0.5, 9.0), (2.0, 4.0, f64::INFINITY), (0.0, -1.0, 1.0)]),
        (shape(1), &[(1.0, 0.0, 0.0)]),
    ]);
    let solution = solve(&problem);
    assert_eq!(solution.status, Status::Infeasible { level: 1 });
    assert_eq!(solution.levels[0].status, LevelStatus::Met);
    assert_eq!(solution.levels[1].active, [Active::Free, Active::Violated, Active::Free]);
    assert_eq!(solution.levels[2].status, LevelStatus::NotSolved);
    assert_eq!(solution.x, [0.0], "the optimum of the level above");
}

#[test]
fn an_impossible_zero_row_is_a_constant_violation() {
    let soft = line(&[(shape(2), &[(0.0, 2.0, 3.0), (1.0, 1.0, 1.0)])]);
    let solution = solve(&soft);
    assert_eq!(solution.status, Status::Optimal);
    assert_eq!(solution.levels[0].status, LevelStatus::Relaxed);
    assert!((solution.levels[0].violation - 2.0).abs() < 1e-12);
    assert!((solution.x[0] - 1.0).abs() < 1e-12);
    let strict = line(&[(hard(2), &[(0.0, 2.0, 3.0), (1.0, 1.0, 1.0)])]);
    assert_eq!(solve(&strict).status, Status::Infeasible { level: 0 });
}

#[test]
fn weights_share_a_conflict() {
    let mut problem = line(&[(shape(2), &[(1.0, f64::NEG_INFINITY, 0.0), (1.0, 1.0, f64::INFINITY)])]);
    problem.levels[0].weight[1] = 3.0;
    let solution = solve(&problem);
    assert!((solution.x[0] - 0.75).abs() < 1e-12);
    assert!((solution.levels[0].multipliers[0] - 0.75).abs() < 1e-12);
    assert!((solution.levels[0].multipliers[1] + 0.75).abs() < 1e-12);
    assert!((solution.levels[0].violation - 0.75_f64.sqrt()).abs() < 1e-12);
}

/// min (x - 3)^2 + delta x^2 has its minimum at 3 / (1 + delta), below a limit or at it.
#[test]
fn damping_is_an_explicit_trade() {
    for (limit, expected) in [(9.0, 2.0), (1.5, 1.5)] {
        let damped = LevelShape { damping: 0.5, ..shape(1) };
        let mut problem = line(&[
            (shape(1), &[(1.0, -limit, limit)]),
            (damped, &[(1.0, 3.0, 3.0)]),
            (shape(1), &[(1.0, -5.0, -5.0)]),
        ]);
        problem.reference[0] = 7.0;
        let solution = solve(&problem);
        assert!((solution.x[0] - expected).abs() < 1e-12);
        assert_eq!(solution.levels[1].freedom, 0);
    }
}

#[test]
fn the_reference_settles_what_is_left() {
    let mut problem = Problem::new(3, &[shape(1), shape(1)]);
    problem.levels[0].set(0, &[0.0, 0.0, 1.0], f64::NEG_INFINITY, 2.0);
    problem.levels[1].set(0, &[1.0, 1.0, 0.0], 0.0, 0.0);
    problem.reference.copy_from_slice(&[1.0, 2.0, 3.0]);
    let solution = solve(&problem);
    for (x, expected) in solution.x.iter().zip([-0.5, 0.5, 2.0]) {
        assert!((x - expected).abs() < 1e-12);
    }
    assert_eq!(solution.levels[0].active[0], Active::Upper);
    assert_eq!(solution.levels[1].active[0], Active::Equality);
    assert_eq!(solution.levels[1].freedom, 2);
}

#[test]
fn unusable_numbers_are_found_and_named() {
    let good = line(&[(shape(1), &[(1.0, 0.0, 1.0)]), (shape(2), &[(1.0, 0.0, 1.0), (1.0, 2.0, 2.0)])]);
    assert_eq!(check(&good), Ok(()));
    let spoil = |change: &dyn Fn(&mut Level)| {
        let mut bad = good.clone();
        change(&mut bad.levels[1]);
        (check(&bad), solve(&bad).status)
    };
    let (level, row) = (1, 1);
    let not_finite = (Err(ProblemError::NotFinite { level, row }), Status::NotFinite { level, row });
    assert_eq!(spoil(&|l| l.row_mut(1)[0] = f64::NAN), not_finite);
    assert_eq!(spoil(&|l| l.row_mut(1)[0] = f64::INFINITY), not_finite);
    assert_eq!(spoil(&|l| l.lower[1] = f64::NAN), not_finite);
    assert_eq!(spoil(&|l| l.weight[1] = f64::NAN), not_finite);
    let failed = Status::Failed { level };
    let empty = (Err(ProblemError::EmptyInterval { level, row }), failed);
    assert_eq!(spoil(&|l| l.lower[1] = 2.5), empty);
    assert_eq!(spoil(&|l| (l.lower[1], l.upper[1]) = (f64::INFINITY, f64::INFINITY)), empty);
    assert_eq!(spoil(&|l| l.weight[1] = -1.0), (Err(ProblemError::NegativeWeight { level, row }), failed));
    assert_eq!(spoil(&|l| l.damping = -1.0), (Err(ProblemError::BadDamping { level }), failed));
    assert_eq!(spoil(&|l| l.lower.clear()), (Err(ProblemError::WrongSize { level }), failed));
    let mut bad = good.clone();
    bad.reference.clear();
    assert_eq!(check(&bad), Err(ProblemError::BadReference));
    assert_eq!(solve(&bad).status, Status::NotFinite { level: 2, row: 0 });
}

#[test]
fn nothing_asked_is_nothing_done() {
    for problem in [Problem::new(0, &[]), Problem::new(0, &[shape(2)]), Problem::new(3, &[shape(0), hard(4)])] {
        let solution = solve(&problem);
        assert_eq!(solution.status, Status::Optimal);
        assert!(solution.x.iter().all(|x| *x == 0.0));
        assert!(solution.levels.iter().all(|l| l.status == LevelStatus::Met));
    }
}
