//! Known structure of rows changes the duration of a solve, and nothing else.

use crate::common;

use common::{Dice, Taste, hierarchy, size};
use hierarq_solver::{
    ActiveSet, HierarchicalSolver, Level, LevelShape, Problem, Solution, Status, Structure, certificate,
};
use proptest::prelude::*;
use proptest::test_runner::TestCaseError;

const TASTE: Taste = Taste {
    variables: 8,
    levels: 4,
    rows: 12,
    equalities: 0.2,
    dependent: 0.2,
    decades: 0.0,
    weights: true,
    ties: false,
};

/// Makes about half of the rows bounds of one variable, some of them of none.
fn with_bounds(problem: &mut Problem, dice: &mut Dice) {
    let n = problem.n;
    for level in &mut problem.levels {
        for i in 0..level.rows() {
            if dice.unit() < 0.0 {
                continue;
            }
            let (column, coefficient) = (dice.below(n), [1.0, -1.0, 0.5, -3.0, 0.0][dice.below(5)]);
            let row = level.row_mut(i);
            row.fill(0.0);
            row[column] = coefficient;
        }
    }
}

fn drift(problem: &mut Problem, dice: &mut Dice) {
    for level in &mut problem.levels {
        for i in 0..level.rows() {
            let by = 0.2 * dice.unit();
            level.lower[i] += by;
            level.upper[i] += by;
        }
    }
}

/// Checks that two answers are equal up to rounding.
fn same(a: &Solution, b: &Solution) -> Result<(), TestCaseError> {
    for (x, y) in a.x.iter().zip(&b.x) {
        prop_assert!((x - y).abs() < 1e-9 * size(&a.x), "{} {}", x, y);
    }
    for (p, q) in a.levels.iter().zip(&b.levels) {
        prop_assert!((p.violation - q.violation).abs() < 1e-9 * size(&a.x));
        prop_assert_eq!(&p.active, &q.active);
        prop_assert_eq!(p.freedom, q.freedom);
    }
    Ok(())
}

/// Drifts two problems alike and solves them tick by tick: proven, and the same.
fn same_ticks(mut open: Problem, mut fixed: Problem, mut dice: Dice) -> Result<(), TestCaseError> {
    let mut solvers = [ActiveSet::new(&open), ActiveSet::new(&fixed)];
    let mut solutions = [Solution::new(&open), Solution::new(&fixed)];
    for _ in 0..5 {
        solvers[0].solve(&open, &mut solutions[0]);
        solvers[1].solve(&fixed, &mut solutions[1]);
        let [a, b] = &solutions;
        prop_assert_eq!(a.status, Status::Optimal);
        prop_assert_eq!(b.status, Status::Optimal);
        prop_assert!(certificate(&fixed, &b.x) < 1e-8, "{}", certificate(&fixed, &b.x));
        same(a, b)?;
        let state = dice.0;
        drift(&mut open, &mut dice);
        dice.0 = state;
        drift(&mut fixed, &mut dice);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// The same ticks, with and without the promise that coefficients stay: the same answers.
    #[test]
    fn fixed_rows_give_the_same_answer(seed: u64) {
        let mut dice = Dice(seed);
        let mut open = hierarchy(&mut dice, TASTE);
        with_bounds(&mut open, &mut dice);
        let mut fixed = open.clone();
        for level in &mut fixed.levels {
            level.fix(0..level.rows());
        }
        same_ticks(open, fixed, dice)?;
    }

    /// Wishes for most variables, of weights that differ by orders, with other rows above, beside and below: a level that
    /// settles the point is solved in a way of its own, and to the same answer.
    #[test]
    fn a_posture_gives_the_same_answer(seed: u64) {
        let mut dice = Dice(seed);
        let mut open = hierarchy(&mut dice, TASTE);
        let (n, l) = (open.n, dice.below(open.levels.len()));
        let beside = dice.below(3);
        let decades = [0.0, 1.0, 3.0][dice.below(3)];
        let mut level = Level::new(n, LevelShape { rows: n + beside, hard: false, damping: 0.0 });
        for i in 0..n + beside {
            let mut row: Vec<f64> = (0..n).map(|j| if i < n { f64::from(u8::from(i == j)) } else { dice.unit() }).collect();
            if i < n && dice.chance(0.1) {
                row[i] = 0.0;
            }
            let wish = dice.unit();
            level.set(i, &row, wish, wish);
            level.weight[i] = 10_f64.powf(decades * dice.unit());
        }
        open.levels[l] = level;
        let mut fixed = open.clone();
        fixed.levels[l].fix(0..n);
        same_ticks(open, fixed, dice)?;
    }

    /// A row that is left out is as if it had never been there.
    #[test]
    fn rows_left_out_have_no_say(seed: u64) {
        let mut dice = Dice(seed);
        let whole = hierarchy(&mut dice, TASTE);
        let gone: Vec<Vec<bool>> =
            whole.levels.iter().map(|l| (0..l.rows()).map(|_| dice.unit() > 0.3).collect()).collect();
        let mut without = whole.clone();
        let shapes: Vec<LevelShape> = whole
            .levels
            .iter()
            .zip(&gone)
            .map(|(l, g)| LevelShape { rows: g.iter().filter(|x| !**x).count(), hard: l.hard, damping: l.damping })
            .collect();
        let mut small = Problem::new(whole.n, &shapes);
        small.reference.copy_from_slice(&whole.reference);
        for (l, gone) in gone.iter().enumerate() {
            let mut next = 0;
            for (i, gone) in gone.iter().enumerate() {
                if *gone {
                    without.levels[l].leave_out(i);
                    prop_assert_eq!(without.levels[l].structure()[i], Structure::Absent);
                } else {
                    let from = &whole.levels[l];
                    small.levels[l].set(next, from.row(i), from.lower[i], from.upper[i]);
                    small.levels[l].weight[next] = from.weight[i];
                    next += 1;
                }
            }
        }
        let (mut a, mut b) = (Solution::new(&without), Solution::new(&small));
        ActiveSet::new(&without).solve(&without, &mut a);
        ActiveSet::new(&small).solve(&small, &mut b);
        prop_assert_eq!(a.status, Status::Optimal);
        for (x, y) in a.x.iter().zip(&b.x) {
            prop_assert!((x - y).abs() < 1e-9 * (1.0 + x.abs()), "{} {}", x, y);
        }
    }
}

#[test]
fn writing_a_coefficient_ends_the_promise() {
    let mut problem = Problem::new(2, &[LevelShape { rows: 3, hard: false, damping: 0.0 }]);
    let level = &mut problem.levels[0];
    level.set(0, &[0.0, 2.0], -1.0, 1.0);
    level.set(1, &[3.0, 4.0], -1.0, 1.0);
    level.fix(0..3);
    let bound = Structure::Bound { column: 1, coefficient: 2.0 };
    assert_eq!(level.structure(), [bound, Structure::Constant { norm: 5.0 }, Structure::Constant { norm: 0.0 }]);
    level.bounds_mut(0..3).0[0] = -2.0;
    assert_eq!(level.structure()[0], bound);
    level.row_mut(0)[0] = 1.0;
    level.block_mut(2..3).0[0] = 1.0;
    assert_eq!(level.structure(), [Structure::Open, Structure::Constant { norm: 5.0 }, Structure::Open]);
    level.set(0, &[f64::NAN, 1.0], 0.0, 0.0);
    level.fix(0..1);
    assert_eq!(level.structure()[0], Structure::Open, "a NaN has to be seen at every tick");
}
