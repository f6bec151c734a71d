//! A proof of optimality that knows nothing of how a point was found.
//!
//! A point is lexicographically optimal exactly when, for every level, the descent direction of
//! that level's cost is a combination of the normals of the rows of higher levels that are fixed
//! there (equalities, violated rows: any sign) or at a bound (the sign that pushes inwards). The
//! multipliers are found by non-negative least squares; what is left over is the residual.

use crate::dense::{Matrix, axpy, dot, norm};
use crate::nnls::nnls;
use crate::problem::Problem;

/// Distances up to this, in units of x (row scaled to norm one), are read as "at the bound".
const AT_BOUND: f64 = 1e-8;

/// The largest relative stationarity residual over all levels and the final nearest-point stage
/// at `x` (`n` long); 0 means exactly optimal, 1 is the order of "not at all". Infinite if `x`
/// is not finite or has another length, or if a hard level is violated. A damped level counts
/// with its damping, and ends the proof: it leaves nothing to choose.
///
/// Each level's residual is measured against the largest row of the level, `sqrt(w) |a|`, times
/// one plus its violation; the final one against `1 + |x - reference|`.
pub fn certificate(problem: &Problem, x: &[f64]) -> f64 {
    let n = problem.n;
    if x.len() != n || x.iter().any(|x| !x.is_finite()) {
        return f64::INFINITY;
    }
    let mut normals = Matrix::zeros(0, n);
    let mut worst = 0.0_f64;
    for level in &problem.levels {
        let mut descent = vec![0.0; n];
        let mut largest = level.damping.sqrt();
        let mut square = 0.0;
        for i in 0..level.rows() {
            let w = if level.hard { 1.0 } else { level.weight[i] };
            let slack = level.slack(i, x);
            axpy(-w * slack, level.row(i), &mut descent);
            largest = largest.max(w.sqrt() * norm(level.row(i)));
            square += w * slack * slack;
            if level.hard && distance(slack, level.row(i)) > AT_BOUND * size_of(x) {
                return f64::INFINITY;
            }
        }
        axpy(-level.damping, x, &mut descent);
        square += level.damping * dot(x, x);
        if largest > 0.0 {
            let residual = nnls(&normals, &descent).1;
            worst = worst.max(residual / (largest * (1.0 + square.sqrt())));
        }
        if level.damping > 0.0 {
            return worst;
        }
        for i in 0..level.rows() {
            if level.weight[i] > 0.0 || level.hard {
                add_normals(level.row(i), level.slack(i, x), (level.lower[i], level.upper[i]), x, &mut normals);
            }
        }
    }
    let home: Vec<f64> = problem.reference.iter().zip(x).map(|(r, x)| r - x).collect();
    worst.max(nnls(&normals, &home).1 / (1.0 + norm(&home)))
}

/// Adds the normals (unit length) along which the row forbids to go.
fn add_normals(row: &[f64], slack: f64, (lower, upper): (f64, f64), x: &[f64], normals: &mut Matrix) {
    let size = norm(row);
    if size == 0.0 {
        return;
    }
    let unit: Vec<f64> = row.iter().map(|a| a / size).collect();
    let value = dot(row, x);
    let near = |bound: f64| (value - bound).abs() <= AT_BOUND * size * size_of(x);
    let fixed = lower == upper || distance(slack, row) > AT_BOUND * size_of(x);
    if fixed || near(upper) {
        normals.push(&unit);
    }
    if fixed || near(lower) {
        normals.push(&unit.iter().map(|a| -a).collect::<Vec<_>>());
    }
}

fn distance(slack: f64, row: &[f64]) -> f64 {
    let size = norm(row);
    slack.abs() / if size > 0.0 { size } else { 1.0 }
}

fn size_of(x: &[f64]) -> f64 {
    1.0 + norm(x)
}
