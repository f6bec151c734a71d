//! Non-negative least squares, by the active-set method of Lawson and Hanson (Solving Least
//! Squares Problems, 1974, ch. 23). It decides whether multipliers of the right sign exist.

use crate::dense::{Matrix, axpy, dot, norm};

/// A column of unit length depends on those before it if less than this lies outside of them.
const INDEPENDENT: f64 = 1e-13;

/// A column enters if its component along the residual exceeds this fraction of the target.
const GAIN: f64 = 1e-14;

/// Minimises `|sum_j u_j c_j - t|` over `u >= 0`, where `c_j` are the ROWS of `columns`
/// (m x n) and `t` is n long. Returns `u` (m long) and the residual norm.
pub(crate) fn nnls(columns: &Matrix, t: &[f64]) -> (Vec<f64>, f64) {
    let mut solver = Nnls::new(columns.cols, columns.rows);
    let residual = solver.solve(columns, t);
    (solver.u, residual)
}

/// Solver with its storage.
#[derive(Clone, Debug)]
pub(crate) struct Nnls {
    /// The solution.
    pub(crate) u: Vec<f64>,
    sizes: Vec<f64>,
    barred: Vec<bool>,
    /// The columns in use, in the order of their entry; at most `n` of them and the one that enters.
    passive: Vec<usize>,
    /// Residual: the target minus the current combination.
    rest: Vec<f64>,
    /// For the passive columns, scaled to length one: an orthonormal basis (`n` numbers per column), their coordinates
    /// in it (`n + 1` numbers per column, the diagonal last), and the least-squares solution.
    basis: Vec<f64>,
    triangle: Vec<f64>,
    v: Vec<f64>,
    /// Number of passive columns that the basis contains.
    fitted: usize,
    n: usize,
}

impl Nnls {
    /// Creates storage for up to `m` columns of `n` numbers, so that [`Nnls::solve`] does not allocate.
    pub(crate) fn new(n: usize, m: usize) -> Self {
        Nnls {
            u: Vec::with_capacity(m),
            sizes: Vec::with_capacity(m),
            barred: Vec::with_capacity(m),
            passive: Vec::with_capacity(n + 1),
            rest: vec![0.0; n],
            basis: vec![0.0; (n + 1) * n],
            triangle: vec![0.0; (n + 1) * (n + 1)],
            v: vec![0.0; n + 1],
            fitted: 0,
            n,
        }
    }

    /// Solves the problem of [`nnls`]; returns the residual norm and stores the solution in `u`.
    pub(crate) fn solve(&mut self, columns: &Matrix, t: &[f64]) -> f64 {
        let m = columns.rows;
        self.u.clear();
        self.u.resize(m, 0.0);
        self.barred.clear();
        self.barred.resize(m, false);
        self.sizes.clear();
        self.sizes.extend((0..m).map(|j| norm(columns.row(j))));
        self.passive.clear();
        self.fitted = 0;
        self.rest.copy_from_slice(t);
        let least = GAIN * norm(t);
        for _ in 0..3 * m + 10 {
            let Some(entering) = self.entering(columns, least) else { break };
            self.passive.push(entering);
            self.descend(columns, t);
            if !self.barred[entering] {
                self.barred.fill(false);
            }
            self.rest.copy_from_slice(t);
            for &j in &self.passive {
                axpy(-self.u[j], columns.row(j), &mut self.rest);
            }
        }
        norm(&self.rest)
    }

    /// Returns the column along which the residual shrinks most, if by more than `least`.
    fn entering(&self, columns: &Matrix, least: f64) -> Option<usize> {
        let (mut best, mut entering) = (least, None);
        for j in 0..columns.rows {
            if self.sizes[j] > 0.0 && !self.barred[j] && !self.passive.contains(&j) {
                let gain = dot(columns.row(j), &self.rest) / self.sizes[j];
                if gain > best {
                    (best, entering) = (gain, Some(j));
                }
            }
        }
        entering
    }

    /// Moves to the optimum over the passive columns, of which the last has just entered; columns that become negative
    /// on the way leave.
    fn descend(&mut self, columns: &Matrix, t: &[f64]) {
        let mut first = true;
        while !self.passive.is_empty() {
            self.fit(columns, t);
            let Nnls { u, v, passive, barred, fitted, .. } = self;
            // Rounding may reject the entering column; it must not enter again at once then.
            if std::mem::take(&mut first) && v[passive.len() - 1] <= 0.0 {
                if let Some(entering) = passive.pop() {
                    barred[entering] = true;
                }
                *fitted = (*fitted).min(passive.len());
                return;
            }
            let mut step = 1.0;
            for (v, &j) in v.iter().zip(&*passive) {
                if *v <= 0.0 && u[j] / (u[j] - v) < step {
                    step = u[j] / (u[j] - v);
                }
            }
            for (v, &j) in v.iter().zip(&*passive) {
                u[j] += step * (v - u[j]);
            }
            if step == 1.0 {
                return;
            }
            let least = 1e-15 * u.iter().fold(0.0_f64, |m, u| m.max(*u));
            *fitted = passive.iter().position(|&j| u[j] <= least).unwrap_or(*fitted).min(*fitted);
            passive.retain(|&j| {
                let stays = u[j] > least;
                if !stays {
                    u[j] = 0.0;
                }
                stays
            });
        }
    }

    /// Solves least squares over the passive columns, into `v`. A column that depends on those before it gets the
    /// coefficient 0.
    fn fit(&mut self, columns: &Matrix, t: &[f64]) {
        let Nnls { sizes, passive, basis, triangle, v, n, fitted, .. } = self;
        let (n, wide) = (*n, *n + 1);
        for (c, &j) in passive.iter().enumerate().skip(std::mem::replace(fitted, passive.len())) {
            let (before, rest) = basis.split_at_mut(c * n);
            let rest = &mut rest[..n];
            rest.iter_mut().zip(columns.row(j)).for_each(|(r, a)| *r = a / sizes[j]);
            let parts = &mut triangle[c * wide..(c + 1) * wide];
            parts.fill(0.0);
            // Two passes suffice to remove rounding.
            for _ in 0..2 {
                for (part, q) in parts.iter_mut().zip(before.chunks_exact(n)) {
                    let along = dot(q, rest);
                    *part += along;
                    axpy(-along, q, rest);
                }
            }
            let left = norm(rest);
            if left > INDEPENDENT {
                rest.iter_mut().for_each(|r| *r /= left);
                parts[n] = left;
            } else {
                rest.fill(0.0);
            }
        }
        for c in (0..passive.len()).rev() {
            let left = triangle[c * wide + n];
            let later = (c + 1..passive.len()).map(|k| triangle[k * wide + c] * v[k]).sum::<f64>();
            v[c] = if left > 0.0 { (dot(&basis[c * n..(c + 1) * n], t) - later) / left } else { 0.0 };
        }
        for (v, &j) in v.iter_mut().zip(&*passive) {
            *v /= sizes[j];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Conditions of optimality: no column has a gain, and the columns in use are orthogonal to the residual.
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
