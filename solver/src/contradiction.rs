//! The rows to blame for a hard level that cannot be met: a smallest set that contradicts itself.
//!
//! The least-squares compromise of rows `a_i x >= b_i` that cannot all be met leaves slacks `w` with `sum_i w_i a_i = 0` and
//! `sum_i w_i b_i > 0`: a certificate of Farkas' lemma, so that the rows with a slack contradict each other by themselves. Of
//! these, one row after the other is left out; those without which the rest can be met stay. Each proper subset of the
//! result can be met. There may be other such sets. Source: J. Chinneck, Feasibility and Infeasibility in Optimization
//! (2008), deletion filter.

use crate::backend::Backend;
use crate::problem::{LevelShape, Problem};
use crate::solution::{Solution, Status};

/// A slack above this share of its row's bound and norm counts as one.
const TOLERANCE: f64 = 1e-8;

/// A row of a problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct RowIndex {
    /// Level, from 0.
    pub level: usize,
    /// Row in the level, from 0.
    pub row: usize,
}

/// A row that takes part, scaled to norm 1.
#[derive(Clone)]
struct Scaled {
    index: RowIndex,
    coefficients: Vec<f64>,
    lower: f64,
    upper: f64,
}

/// Returns rows of the first `level + 1` levels of a problem that contradict each other, in ascending order; without any of
/// them, the others can be met. Rows of soft levels take part with the values that they have at `x`, the optimum of the
/// levels above `level` ([`Solution::x`] after [`Status::Infeasible`]). Empty if no contradiction is found. Allocates, and
/// solves a problem for each row: not for use in a control loop.
///
/// ```
/// use hierarq_solver::contradiction::{RowIndex, contradiction};
/// use hierarq_solver::{LevelShape, Problem};
///
/// let shape = |rows| LevelShape { rows, hard: true, damping: 0.0 };
/// let mut problem = Problem::new(2, &[shape(2), shape(1)]);
/// problem.levels[0].set(0, &[1.0, 0.0], -1.0, 1.0); // |x| <= 1
/// problem.levels[0].set(1, &[0.0, 1.0], -1.0, 1.0); // |y| <= 1
/// problem.levels[1].set(0, &[1.0, 0.0], 2.0, 3.0); // 2 <= x <= 3
/// let found = contradiction(&problem, 1, &[0.0, 0.0]);
/// assert_eq!(found, [RowIndex { level: 0, row: 0 }, RowIndex { level: 1, row: 0 }]);
/// ```
pub fn contradiction(problem: &Problem, level: usize, x: &[f64]) -> Vec<RowIndex> {
    let mut rows = rows(problem, level, x);
    match conflicting(problem.n, &rows) {
        Some(fewer) => rows = fewer,
        None => return Vec::new(),
    }
    // Rows before this one are needed.
    let mut open = 0;
    while open < rows.len() {
        let mut without = rows.clone();
        without.remove(open);
        match conflicting(problem.n, &without) {
            // Needed rows take part in each contradiction of these rows, so they stay in front.
            Some(fewer) => rows = fewer,
            None => open += 1,
        }
    }
    let mut found: Vec<RowIndex> = rows.iter().map(|r| r.index).collect();
    found.sort_unstable();
    found
}

/// Rows of the first levels with at least one bound.
fn rows(problem: &Problem, level: usize, x: &[f64]) -> Vec<Scaled> {
    let mut rows = Vec::new();
    for (k, l) in problem.levels.iter().enumerate().take(level + 1) {
        for row in 0..l.rows() {
            let a = l.row(row);
            let norm = a.iter().map(|c| c * c).sum::<f64>().sqrt();
            // A row of zeros contradicts itself if zero is not allowed; its bounds stay as they are.
            let scale = if norm > 0.0 { norm.recip() } else { 1.0 };
            let (mut lower, mut upper) = (l.lower[row], l.upper[row]);
            if !l.hard {
                if l.weight[row] == 0.0 {
                    continue;
                }
                // The slacks of a soft level are fixed for the levels below.
                let reached = a.iter().zip(x).map(|(c, x)| c * x).sum::<f64>();
                if reached < lower || reached > upper {
                    (lower, upper) = (reached, reached);
                }
            }
            if lower == f64::NEG_INFINITY && upper == f64::INFINITY {
                continue;
            }
            rows.push(Scaled {
                index: RowIndex { level: k, row },
                coefficients: a.iter().map(|c| c * scale).collect(),
                lower: lower * scale,
                upper: upper * scale,
            });
        }
    }
    rows
}

/// The rows with a slack in the compromise of all of these rows; `None` if they can all be met.
fn conflicting(n: usize, rows: &[Scaled]) -> Option<Vec<Scaled>> {
    if rows.is_empty() {
        return None;
    }
    let with_slack = slacks(n, rows)?;
    let fewer: Vec<Scaled> = rows.iter().zip(&with_slack).filter(|(_, is)| **is).map(|(r, _)| r.clone()).collect();
    if fewer.is_empty() {
        return None;
    }
    // Rounding can hide a small slack of a row that is needed.
    match slacks(n, &fewer) {
        Some(again) if again.contains(&true) => Some(fewer),
        _ => Some(rows.to_vec()),
    }
}

/// For each row, whether it has a slack in the compromise; `None` if it could not be computed.
fn slacks(n: usize, rows: &[Scaled]) -> Option<Vec<bool>> {
    let mut problem = Problem::new(n, &[LevelShape { rows: rows.len(), hard: false, damping: 0.0 }]);
    for (i, r) in rows.iter().enumerate() {
        problem.levels[0].set(i, &r.coefficients, r.lower, r.upper);
    }
    let mut solution = Solution::new(&problem);
    Backend::ActiveSet.solver(&problem).solve(&problem, &mut solution);
    if solution.status != Status::Optimal {
        return None;
    }
    let bound =
        |r: &Scaled| [r.lower, r.upper].into_iter().filter(|b| b.is_finite()).fold(1.0, |m: f64, b| m.max(b.abs()));
    Some(rows.iter().zip(&solution.levels[0].slack).map(|(r, w)| w.abs() > TOLERANCE * bound(r)).collect())
}
