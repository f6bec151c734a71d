//! The rows to blame for a contradiction: planted ones among others that exclude nothing, and those of random problems,
//! which Clarabel judges.

use crate::common::Dice;

use hierarq_solver::contradiction::{RowIndex, contradiction};
use hierarq_solver::{Backend, LevelShape, LevelStatus, Problem, Solution, Status};
use nalgebra::{DMatrix, DVector};

/// A one-sided row `a x >= b`.
struct Row {
    a: DVector<f64>,
    b: f64,
}

/// Rows with `sum_i l_i a_i = 0` and `sum_i l_i b_i = 1` for some positive `l_i`, any of which but one are independent.
fn planted(dice: &mut Dice, n: usize, number: usize) -> Vec<Row> {
    let mut rows: Vec<Row> =
        (1..number).map(|_| Row { a: DVector::from_fn(n, |_, _| dice.unit()), b: dice.unit() }).collect();
    let (mut a, mut b) = (DVector::zeros(n), 1.0);
    for row in &rows {
        let l = 1.25 + 0.75 * dice.unit();
        a -= l * &row.a;
        b -= l * row.b;
    }
    rows.push(Row { a, b });
    rows
}

/// A point that meets all rows but one.
fn witness(rows: &[Row], without: usize) -> DVector<f64> {
    let others: Vec<&Row> = rows.iter().enumerate().filter(|(i, _)| *i != without).map(|(_, r)| r).collect();
    let a = DMatrix::from_rows(&others.iter().map(|r| r.a.transpose()).collect::<Vec<_>>());
    let b = DVector::from_iterator(others.len(), others.iter().map(|r| r.b + 0.05));
    a.svd(true, true).solve(&b, 1e-12).expect("both sides of the decomposition")
}

fn hard(rows: usize) -> LevelShape {
    LevelShape { rows, hard: true, damping: 0.0 }
}

#[test]
fn exactly_the_planted_rows_are_found_among_a_hundred() {
    let mut dice = Dice(20_261_127);
    for _ in 0..300 {
        let n = 2 + dice.below(7);
        let number = 2 + dice.below(n);
        let rows = planted(&mut dice, n, number);
        let smallest = rows.iter().map(|r| r.a.norm()).fold(f64::INFINITY, f64::min);
        let a = DMatrix::from_rows(&rows[1..].iter().map(|r| r.a.transpose()).collect::<Vec<_>>());
        // Nearly dependent rows have witnesses far away, where rounding decides.
        if smallest < 0.1 || a.singular_values().min() < 0.05 {
            continue;
        }
        let witnesses: Vec<DVector<f64>> = (0..number).map(|i| witness(&rows, i)).collect();
        let mut all: Vec<(Row, bool)> = rows.into_iter().map(|r| (r, true)).collect();
        while all.len() < 100 {
            let a = DVector::from_fn(n, |_, _| dice.unit());
            // All witnesses meet it, so that no contradiction needs it.
            let least = witnesses.iter().map(|x| a.dot(x)).fold(f64::INFINITY, f64::min);
            let b = least - 0.2 * dice.unit().abs();
            let at = dice.below(all.len() + 1);
            all.insert(at, (Row { a, b }, false));
        }
        let levels = 1 + dice.below(3);
        let mut problem = Problem::new(n, &vec![hard(100); levels]);
        let mut expected = Vec::new();
        for (row, (Row { a, b }, is_planted)) in all.iter().enumerate() {
            let (level, scale) = (dice.below(levels), (2.0 * dice.unit()).exp());
            let (a, b) = (a * scale, b * scale);
            match dice.chance(0.5) {
                true => problem.levels[level].set(row, a.as_slice(), b, f64::INFINITY),
                false => problem.levels[level].set(row, (-a).as_slice(), f64::NEG_INFINITY, -b),
            }
            if *is_planted {
                expected.push(RowIndex { level, row });
            }
        }
        expected.sort();
        assert_eq!(contradiction(&problem, levels - 1, &vec![0.0; n]), expected, "n = {n}");
    }
}

/// True if Clarabel finds a point that meets these rows of hard levels.
fn can_be_met(problem: &Problem, rows: &[RowIndex]) -> bool {
    let mut reduced = Problem::new(problem.n, &[hard(rows.len())]);
    for (i, r) in rows.iter().enumerate() {
        let level = &problem.levels[r.level];
        reduced.levels[0].set(i, level.row(r.row), level.lower[r.row], level.upper[r.row]);
    }
    let mut solution = Solution::new(&reduced);
    Backend::Clarabel.solver(&reduced).solve(&reduced, &mut solution);
    solution.status == Status::Optimal && solution.levels[0].status != LevelStatus::Infeasible
}

#[test]
fn the_rows_contradict_each_other_and_no_fewer_do() {
    let mut dice = Dice(7);
    let mut found = 0;
    for _ in 0..400 {
        let n = 1 + dice.below(5);
        let mut problem = Problem::new(n, &[hard(2 + dice.below(8)), hard(1 + dice.below(8))]);
        for level in &mut problem.levels {
            for row in 0..level.rows() {
                let a: Vec<f64> = (0..n).map(|_| dice.unit()).collect();
                let (x, width) = (2.0 * dice.unit(), dice.unit().abs());
                match dice.below(3) {
                    0 => level.set(row, &a, x, x),
                    1 => level.set(row, &a, x, x + width),
                    _ => level.set(row, &a, x, f64::INFINITY),
                }
            }
        }
        let all: Vec<RowIndex> = (0..2)
            .flat_map(|level| (0..problem.levels[level].rows()).map(move |row| RowIndex { level, row }))
            .collect();
        let rows = contradiction(&problem, 1, &vec![0.0; n]);
        assert_eq!(rows.is_empty(), can_be_met(&problem, &all));
        if rows.is_empty() {
            continue;
        }
        found += 1;
        assert!(!can_be_met(&problem, &rows), "{rows:?} can be met");
        for left_out in &rows {
            let others: Vec<RowIndex> = rows.iter().copied().filter(|r| r != left_out).collect();
            assert!(can_be_met(&problem, &others), "{left_out:?} is not needed in {rows:?}");
        }
    }
    assert!(found > 100, "only {found} contradictions");
}

#[test]
fn a_soft_level_takes_part_with_what_it_reached() {
    let soft = LevelShape { rows: 1, hard: false, damping: 0.0 };
    let mut problem = Problem::new(2, &[hard(1), soft, hard(2)]);
    problem.levels[0].set(0, &[1.0, 0.0], -1.0, 1.0);
    problem.levels[1].set(0, &[2.0, 0.0], 3.0, 3.0);
    problem.levels[2].set(0, &[0.0, 1.0], 0.0, 5.0);
    problem.levels[2].set(1, &[1.0, 0.0], -4.0, 0.5);
    let mut solution = Solution::new(&problem);
    Backend::ActiveSet.solver(&problem).solve(&problem, &mut solution);
    assert_eq!(solution.status, Status::Infeasible { level: 2 });
    let rows = [RowIndex { level: 1, row: 0 }, RowIndex { level: 2, row: 1 }];
    assert_eq!(contradiction(&problem, 2, &solution.x), rows);
}
