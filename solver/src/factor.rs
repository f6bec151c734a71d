//! Rank-revealing orthogonal factorisation: all minimisers of `|M y - t|^2`, as the smallest one plus an orthonormal
//! basis of the directions that do not change the residual.
//!
//! `M = Q [R 0; 0 0] V^T` by Householder reflections with column and row pivoting, then by reflections from the right
//! (a complete orthogonal decomposition). Row pivoting keeps the error of every row relative to that row (Powell and
//! Reid), so that the rank is decided row by row: the remainder of a row is dropped if it is below 1e-9 of the row's
//! own size.

use crate::dense::{DEPENDENT, Matrix, axpy, dot, norm};

/// The set `{ point + null u }` of all minimisers.
#[derive(Clone, Debug)]
pub(crate) struct Minimisers {
    /// The smallest minimiser, k long.
    pub(crate) point: Vec<f64>,
    /// k x (k - rank), orthonormal columns.
    pub(crate) null: Matrix,
}

/// Minimises `|M y - t|`; `size[i]` is the size of row `i` for the decision about its rank (the norm that the row had
/// before anything was projected out of it). `M` is p x k, any p and k.
pub(crate) fn least_squares(mut m: Matrix, mut t: Vec<f64>, mut size: Vec<f64>) -> Minimisers {
    let (p, k) = (m.rows, m.cols);
    let mut column: Vec<usize> = (0..k).collect();
    for (i, s) in size.iter().enumerate() {
        flush(&mut m, &mut t, i, 0, *s);
    }
    let mut rank = 0;
    let mut work = vec![0.0; k];
    let mut v = vec![0.0; p];
    while rank < p.min(k) {
        let j = rank;
        if !pivot(&mut m, &mut t, &mut size, &mut column, j) {
            break;
        }
        let length = norm(&(j..p).map(|i| m.row(i)[j]).collect::<Vec<_>>());
        let head = m.row(j)[j];
        let alpha = if head > 0.0 { -length } else { length };
        // Reflection I - v v^T / (v_j (-alpha)) with v = column - alpha e_j.
        for (i, v) in v.iter_mut().enumerate().skip(j) {
            *v = m.row(i)[j];
        }
        v[j] -= alpha;
        let beta = -1.0 / (alpha * v[j]);
        work.fill(0.0);
        let mut work_t = 0.0;
        for i in j..p {
            axpy(v[i], &m.row(i)[j..], &mut work[j..]);
            work_t += v[i] * t[i];
        }
        for i in j..p {
            axpy(-beta * v[i], &work[j..], &mut m.row_mut(i)[j..]);
            t[i] -= beta * v[i] * work_t;
        }
        rank += 1;
        for (i, size) in size.iter().enumerate().skip(rank) {
            m.row_mut(i)[j] = 0.0;
            flush(&mut m, &mut t, i, rank, *size);
        }
    }
    finish(m, &t, rank, &column)
}

/// Moves the largest remaining column to position `j`, and its largest entry to row `j`. Returns false if nothing is
/// left.
fn pivot(m: &mut Matrix, t: &mut [f64], size: &mut [f64], column: &mut [usize], j: usize) -> bool {
    let mut sums = vec![0.0_f64; m.cols];
    let largest = (j..m.rows).flat_map(|i| m.row(i)[j..].iter()).fold(0.0_f64, |a, b| a.max(b.abs()));
    if largest == 0.0 || !largest.is_finite() {
        return false;
    }
    for i in j..m.rows {
        for (s, a) in sums[j..].iter_mut().zip(&m.row(i)[j..]) {
            *s += (a / largest) * (a / largest);
        }
    }
    let mut best = j;
    for c in j..m.cols {
        if sums[c] > sums[best] {
            best = c;
        }
    }
    m.swap_cols(j, best);
    column.swap(j, best);
    let mut row = j;
    for i in j..m.rows {
        if m.row(i)[j].abs() > m.row(row)[j].abs() {
            row = i;
        }
    }
    m.swap_rows(j, row);
    t.swap(j, row);
    size.swap(j, row);
    true
}

/// Sets the remainder of row `i` from column `from` on to zero if it is only rounding, and its target too: no choice of
/// `y` changes that residual.
fn flush(m: &mut Matrix, t: &mut [f64], i: usize, from: usize, size: f64) {
    if norm(&m.row(i)[from..]) <= DEPENDENT * size {
        m.row_mut(i)[from..].fill(0.0);
        t[i] = 0.0;
    }
}

/// Computes the smallest solution and the null space from the first `rank` rows of `[R11 R12]`.
fn finish(mut r: Matrix, t: &[f64], rank: usize, column: &[usize]) -> Minimisers {
    let k = r.cols;
    let mut q = Matrix::identity(k);
    for i in 0..rank {
        let mut v = r.row(i)[i..].to_vec();
        let length = norm(&v);
        let alpha = if v[0] > 0.0 { -length } else { length };
        v[0] -= alpha;
        let beta = -1.0 / (alpha * v[0]);
        for l in i..rank {
            let row = &mut r.row_mut(l)[i..];
            axpy(-beta * dot(row, &v), &v, row);
        }
        for l in 0..k {
            let row = &mut q.row_mut(l)[i..];
            axpy(-beta * dot(row, &v), &v, row);
        }
    }
    let mut w = vec![0.0; rank];
    for i in 0..rank {
        w[i] = (t[i] - dot(&r.row(i)[..i], &w)) / r.row(i)[i];
    }
    let mut point = vec![0.0; k];
    let mut null = Matrix::zeros(k, k - rank);
    for (l, &c) in column.iter().enumerate() {
        point[c] = dot(&q.row(l)[..rank], &w);
        null.row_mut(c).copy_from_slice(&q.row(l)[rank..]);
    }
    Minimisers { point, null }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// A matrix of known rank: the point is a minimiser (normal equations) and the smallest (no component in the
        /// null space); the basis is orthonormal, in the null space, and complete.
        #[test]
        fn smallest_minimiser_and_null_space(
            p in 1usize..9, k in 1usize..9, rank in 1usize..6,
            numbers in prop::collection::vec(-1.0f64..1.0, 200),
        ) {
            let rank = rank.min(p).min(k);
            let mut rows = Matrix::zeros(0, k);
            for i in 0..p {
                let mut row = vec![0.0; k];
                for r in 0..rank {
                    let own = f64::from(u8::from(i == r));
                    axpy(2.0 * own + 0.2 * numbers[i * rank + r], &numbers[64 + r * k..], &mut row);
                }
                rows.push(&row);
            }
            // Full rank of the second factor, by Gram-Schmidt, with a margin.
            let mut frame = crate::dense::Frame::new(k);
            for r in 0..rank {
                let vector = &numbers[64 + r * k..64 + r * k + k];
                prop_assume!(norm(&frame.split(vector).1) > 1e-2);
                frame.push(vector);
            }
            let t = &numbers[130..130 + p];
            let size = (0..p).map(|i| norm(rows.row(i))).collect();
            let found = least_squares(rows.clone(), t.to_vec(), size);
            prop_assert_eq!(found.null.cols, k - rank);
            let rest: Vec<f64> = rows.apply(&found.point).iter().zip(t).map(|(a, b)| a - b).collect();
            let scale = 1.0 + norm(&found.point);
            prop_assert!(norm(&rows.apply_transposed(&rest)) < 1e-12 * scale);
            prop_assert!(norm(&found.null.apply_transposed(&found.point)) < 1e-12 * scale);
            for i in 0..p {
                prop_assert!(norm(&found.null.apply_transposed(rows.row(i))) < 1e-12);
            }
            for a in 0..found.null.cols {
                for b in 0..found.null.cols {
                    let product: f64 = (0..k).map(|i| found.null.row(i)[a] * found.null.row(i)[b]).sum();
                    prop_assert!((product - f64::from(u8::from(a == b))).abs() < 1e-13);
                }
            }
        }
    }

    /// Two large rows and two tiny ones that can all be met are all met.
    #[test]
    fn tiny_rows_beside_large_ones_are_met() {
        let (mut m, mut t, mut size) = (Matrix::zeros(0, 4), Vec::new(), Vec::new());
        let x = [1.0, -2.0, 0.5, 3.0];
        let rows = [[1.0, 2.0, 3.0, 4.0], [2.0, 1.0, 0.0, 1.0], [1.0, 1.0, -1.0, 0.0], [0.0, 3.0, 1.0, 1.0]];
        for (row, s) in rows.iter().zip([1e6, 1e-6, 1e6, 1e-6]) {
            let row = row.map(|a| a * s);
            t.push(dot(&row, &x));
            size.push(norm(&row));
            m.push(&row);
        }
        let found = least_squares(m, t, size);
        assert_eq!(found.null.cols, 0);
        for (found, x) in found.point.iter().zip(x) {
            assert!((found - x).abs() < 1e-11, "{found} instead of {x}");
        }
    }
}
