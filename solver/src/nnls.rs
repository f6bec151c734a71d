//! Non-negative least squares, by the active-set method of Lawson and Hanson (Solving Least
//! Squares Problems, 1974, ch. 23). It decides whether multipliers of the right sign exist.

use crate::dense::{Matrix, axpy, dot, norm};
use crate::factor::least_squares;

/// Minimises `|sum_j u_j c_j - t|` over `u >= 0`, where `c_j` are the ROWS of `columns`
/// (m x n) and `t` is n long. Returns `u` (m long) and the residual norm.
pub(crate) fn nnls(columns: &Matrix, t: &[f64]) -> (Vec<f64>, f64) {
    let m = columns.rows;
    let sizes: Vec<f64> = (0..m).map(|j| norm(columns.row(j))).collect();
    let mut u = vec![0.0; m];
    let mut passive: Vec<usize> = Vec::new();
    let mut barred = vec![false; m];
    let mut rest = t.to_vec();
    let size = norm(t);
    for _ in 0..3 * m + 10 {
        let gain = |j: usize| dot(columns.row(j), &rest) / sizes[j];
        let mut entering = None;
        let mut best = 1e-14 * size;
        for j in (0..m).filter(|j| sizes[*j] > 0.0 && !barred[*j] && !passive.contains(j)) {
            if gain(j) > best {
                best = gain(j);
                entering = Some(j);
            }
        }
        let Some(entering) = entering else { break };
        passive.push(entering);
        let mut first = true;
        while !passive.is_empty() {
            let v = fit(columns, &passive, &sizes, t);
            // Rounding may turn the entering one away; then it must not come back at once.
            if first && v.last().is_some_and(|v| *v <= 0.0) {
                passive.pop();
                barred[entering] = true;
                break;
            }
            first = false;
            let mut step = 1.0;
            for (v, &j) in v.iter().zip(&passive) {
                if *v <= 0.0 && u[j] / (u[j] - v) < step {
                    step = u[j] / (u[j] - v);
                }
            }
            for (v, &j) in v.iter().zip(&passive) {
                u[j] += step * (v - u[j]);
            }
            if step == 1.0 {
                break;
            }
            let least = 1e-15 * u.iter().fold(0.0_f64, |m, u| m.max(*u));
            passive.retain(|j| u[*j] > least);
            for j in (0..m).filter(|j| !passive.contains(j)) {
                u[j] = 0.0;
            }
        }
        if !barred[entering] {
            barred.fill(false);
        }
        rest.copy_from_slice(t);
        for &j in &passive {
            axpy(-u[j], columns.row(j), &mut rest);
        }
    }
    let residual = norm(&rest);
    (u, residual)
}

/// Least squares over the passive columns only.
fn fit(columns: &Matrix, passive: &[usize], sizes: &[f64], t: &[f64]) -> Vec<f64> {
    let n = columns.cols;
    let mut system = Matrix::zeros(n, passive.len());
    for (c, &j) in passive.iter().enumerate() {
        for i in 0..n {
            system.row_mut(i)[c] = columns.row(j)[i] / sizes[j];
        }
    }
    let largest = vec![1e-4; n];
    let mut v = least_squares(system, t.to_vec(), largest).point;
    for (v, &j) in v.iter_mut().zip(passive) {
        *v /= sizes[j];
    }
    v
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// The conditions of optimality: no column gains, used columns are orthogonal to the rest.
        #[test]
        fn residual_is_normal_to_the_cone(
            m in 1usize..12, n in 1usize..7,
            numbers in prop::collection::vec(-1.0f64..1.0, 96),
        ) {
            let mut columns = Matrix::zeros(0, n);
            for j in 0..m {
                columns.push(&numbers[j * n..j * n + n]);
            }
            let t = &numbers[88..88 + n];
            let (u, residual) = nnls(&columns, t);
            let mut rest = t.to_vec();
            for (j, u) in u.iter().enumerate() {
                prop_assert!(*u >= 0.0);
                axpy(-u, columns.row(j), &mut rest);
            }
            prop_assert!((norm(&rest) - residual).abs() < 1e-12);
            for (j, u) in u.iter().enumerate() {
                let gain = dot(columns.row(j), &rest);
                prop_assert!(gain < 1e-9, "column {j} would gain {gain}");
                prop_assert!(*u == 0.0 || gain.abs() < 1e-9);
            }
        }
    }
}
