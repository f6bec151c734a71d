//! A proof of optimality that knows nothing of how a point was found.
//!
//! A point is lexicographically optimal exactly when, for every level, the descent direction of
//! that level's cost is a combination of the normals of the rows of higher levels that are fixed
//! there (equalities, violated rows: any sign) or at a bound (the sign that pushes inwards). Rows at a bound that hold a higher
//! level back count as fixed from there on: that level's balance, times any number, may be added to those of the levels below.
//! What is fixed is projected out, and the multipliers of the other rows are found by non-negative least squares; what is left
//! over is the residual.

use crate::dense::{Matrix, axpy, dot, norm};
use crate::nnls::nnls;
use crate::problem::{Level, Problem, nothing};

/// Distances up to this, in units of x (row scaled to norm one), are read as "at the bound".
const AT_BOUND: f64 = 1e-8;

/// A row of which less lies outside the rows that are fixed, relative to its norm, depends on them.
const INDEPENDENT: f64 = 1e-12;

/// A multiplier below this, relative to the gradient that it balances, may be rounding.
const SURE: f64 = 1e-13;

/// The largest relative stationarity residual over all levels and the final nearest-point stage
/// at `x` (`n` long); 0 means exactly optimal, 1 is the order of "not at all". Infinite if `x`
/// is not finite or has another length, or if a hard level is violated. A damped level counts
/// with its damping, and ends the proof: it leaves nothing to choose. Rows of 1e-14 of the largest row of the problem are zero.
///
/// Each level's residual is measured against the largest row of the level, `sqrt(w) |a|`, times
/// one plus its violation; the final one against `1 + |x - reference|`.
pub fn certificate(problem: &Problem, x: &[f64]) -> f64 {
    let n = problem.n;
    if x.len() != n || x.iter().any(|x| !x.is_finite()) {
        return f64::INFINITY;
    }
    let norms = problem.levels.iter().flat_map(|level| (0..level.rows()).map(|i| norm(level.row(i))));
    let (nothing, zero) = (nothing(norms.fold(0.0, f64::max)), vec![0.0; n]);
    let mut forbidden = Forbidden { fixed: Matrix::zeros(0, n), normals: Matrix::zeros(0, n) };
    let mut worst = 0.0_f64;
    for level in &problem.levels {
        let mut descent = vec![0.0; n];
        let mut largest = level.damping.sqrt();
        let mut square = 0.0;
        for i in 0..level.rows() {
            let w = if level.hard { 1.0 } else { level.weight[i] };
            let slack = level.slack(i, x);
            let row = if norm(level.row(i)) > nothing { level.row(i) } else { &zero };
            axpy(-w * slack, row, &mut descent);
            largest = largest.max(w.sqrt() * norm(row));
            square += w * slack * slack;
            if level.hard && distance(slack, row) > AT_BOUND * size_of(x) {
                return f64::INFINITY;
            }
        }
        axpy(-level.damping, x, &mut descent);
        square += level.damping * dot(x, x);
        if largest > 0.0 {
            let scale = largest * (1.0 + square.sqrt());
            worst = worst.max(forbidden.balance(&descent, SURE * scale) / scale);
        }
        if level.damping > 0.0 {
            return worst;
        }
        for i in 0..level.rows() {
            if norm(level.row(i)) > nothing && (level.weight[i] > 0.0 || level.hard) {
                forbidden.add(level, i, x);
            }
        }
    }
    let home: Vec<f64> = problem.reference.iter().zip(x).map(|(r, x)| r - x).collect();
    worst.max(forbidden.balance(&home, 0.0) / (1.0 + norm(&home)))
}

/// Where the levels so far forbid to go.
struct Forbidden {
    /// An orthonormal frame of the rows that are fixed.
    fixed: Matrix,
    /// Normals (unit length) along which a row at its bound forbids to go.
    normals: Matrix,
}

impl Forbidden {
    /// How much of a descent direction is not balanced. Rows at a bound that balance more of it than `least`, and than what is
    /// left over, are fixed from now on.
    fn balance(&mut self, descent: &[f64], least: f64) -> f64 {
        let mut columns = Matrix::zeros(0, self.normals.cols);
        let mut of = Vec::new();
        for j in 0..self.normals.rows {
            let rest = self.outside(self.normals.row(j));
            let size = norm(&rest);
            if size > INDEPENDENT {
                columns.push(&rest.iter().map(|r| r / size).collect::<Vec<_>>());
                of.push(j);
            }
        }
        let (multipliers, residual) = nnls(&columns, &self.outside(descent));
        for (&j, _) in of.iter().zip(&multipliers).filter(|(_, u)| **u > residual + least) {
            let normal = self.normals.row(j).to_vec();
            self.fix(&normal);
        }
        residual
    }

    /// What of a vector is normal to the rows that are fixed.
    fn outside(&self, v: &[f64]) -> Vec<f64> {
        let mut rest = v.to_vec();
        // Twice is enough.
        for k in (0..self.fixed.rows).chain(0..self.fixed.rows) {
            let part = dot(self.fixed.row(k), &rest);
            axpy(-part, self.fixed.row(k), &mut rest);
        }
        rest
    }

    /// Fixes a row of unit length.
    fn fix(&mut self, unit: &[f64]) {
        let rest = self.outside(unit);
        let size = norm(&rest);
        if size > INDEPENDENT {
            self.fixed.push(&rest.iter().map(|r| r / size).collect::<Vec<_>>());
        }
    }

    /// Adds the directions that row `i` of a level forbids at `x`. The row is not zero.
    fn add(&mut self, level: &Level, i: usize, x: &[f64]) {
        let (row, slack, lower, upper) = (level.row(i), level.slack(i, x), level.lower[i], level.upper[i]);
        let size = norm(row);
        let unit: Vec<f64> = row.iter().map(|a| a / size).collect();
        let value = dot(row, x);
        let near = |bound: f64| (value - bound).abs() <= AT_BOUND * size * size_of(x);
        if lower == upper || distance(slack, row) > AT_BOUND * size_of(x) || (near(upper) && near(lower)) {
            self.fix(&unit);
        } else if near(upper) {
            self.normals.push(&unit);
        } else if near(lower) {
            self.normals.push(&unit.iter().map(|a| -a).collect::<Vec<_>>());
        }
    }
}

fn distance(slack: f64, row: &[f64]) -> f64 {
    let size = norm(row);
    slack.abs() / if size > 0.0 { size } else { 1.0 }
}

fn size_of(x: &[f64]) -> f64 {
    1.0 + norm(x)
}
