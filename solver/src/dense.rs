//! Dense linear algebra of the cascade: a row-major matrix, and an orthonormal frame that grows by one vector at a
//! time.

/// A projection of a row below this, relative to the row, is zero: the row depends on the fixed ones. Rank decisions
/// are made row by row, relative to each row's own size, so that one level may have rows of 1e-6 and 1e6.
pub(crate) const DEPENDENT: f64 = 1e-9;

/// Dot product over the shorter of the two, summed in lanes so that it compiles to vector instructions.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let shorter = a.len().min(b.len());
    let ((a, a_rest), (b, b_rest)) = (a[..shorter].as_chunks::<4>(), b[..shorter].as_chunks::<4>());
    let mut sums = [0.0_f64; 4];
    for (a, b) in a.iter().zip(b) {
        for i in 0..4 {
            sums[i] += a[i] * b[i];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    (sums[0] + sums[2]) + (sums[1] + sums[3]) + rest
}

/// Euclidean norm, safe against overflow and underflow of the squares.
pub(crate) fn norm(a: &[f64]) -> f64 {
    let plain = dot(a, a);
    if plain > 1e-200 && plain < 1e200 {
        return plain.sqrt();
    }
    let largest = a.iter().fold(0.0_f64, |m, a| m.max(a.abs()));
    if largest == 0.0 || !largest.is_finite() {
        return largest;
    }
    let scaled: f64 = a.iter().map(|a| (a / largest) * (a / largest)).sum();
    largest * scaled.sqrt()
}

/// `y += s x`
pub(crate) fn axpy(s: f64, x: &[f64], y: &mut [f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += s * x;
    }
}

/// A row-major matrix.
#[derive(Clone, Debug)]
pub(crate) struct Matrix {
    pub(crate) rows: usize,
    pub(crate) cols: usize,
    data: Vec<f64>,
}

impl Matrix {
    pub(crate) fn zeros(rows: usize, cols: usize) -> Self {
        Matrix { rows, cols, data: vec![0.0; rows * cols] }
    }

    /// Creates a matrix without rows, with capacity for `rows` rows.
    pub(crate) fn with_room(rows: usize, cols: usize) -> Self {
        Matrix { rows: 0, cols, data: Vec::with_capacity(rows * cols) }
    }

    /// Removes all rows.
    pub(crate) fn clear(&mut self) {
        self.rows = 0;
        self.data.clear();
    }

    pub(crate) fn identity(n: usize) -> Self {
        let mut m = Matrix::zeros(n, n);
        for i in 0..n {
            m.row_mut(i)[i] = 1.0;
        }
        m
    }

    pub(crate) fn row(&self, i: usize) -> &[f64] {
        &self.data[i * self.cols..(i + 1) * self.cols]
    }

    pub(crate) fn row_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.data[i * self.cols..(i + 1) * self.cols]
    }

    /// Appends a row of `cols` numbers.
    pub(crate) fn push(&mut self, row: &[f64]) {
        self.data.extend_from_slice(&row[..self.cols]);
        self.rows += 1;
    }

    pub(crate) fn swap_rows(&mut self, i: usize, j: usize) {
        if i != j {
            for c in 0..self.cols {
                self.data.swap(i * self.cols + c, j * self.cols + c);
            }
        }
    }

    pub(crate) fn swap_cols(&mut self, i: usize, j: usize) {
        if i != j {
            for r in 0..self.rows {
                self.data.swap(r * self.cols + i, r * self.cols + j);
            }
        }
    }

    /// `M y`
    pub(crate) fn apply(&self, y: &[f64]) -> Vec<f64> {
        (0..self.rows).map(|i| dot(self.row(i), y)).collect()
    }

    /// `M^T a`
    pub(crate) fn apply_transposed(&self, a: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; self.cols];
        self.apply_transposed_into(a, &mut out);
        out
    }

    /// `out = M^T a`
    pub(crate) fn apply_transposed_into(&self, a: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        for (i, &s) in a.iter().enumerate() {
            if s != 0.0 {
                axpy(s, self.row(i), out);
            }
        }
    }

    /// `M N`. If `size` is given, rows of the product below [`DEPENDENT`] times `size` become exactly zero.
    pub(crate) fn times(&self, other: &Matrix, size: Option<f64>) -> Matrix {
        let mut out = Matrix::zeros(self.rows, other.cols);
        for i in 0..self.rows {
            let row = out.row_mut(i);
            other.apply_transposed_into(self.row(i), row);
            if size.is_some_and(|s| norm(row) <= DEPENDENT * s) {
                row.fill(0.0);
            }
        }
        out
    }
}

/// Orthonormal vectors `q_1..q_a` and the triangle `R` with `v_j = sum_i R_ij q_i`, for vectors `v_1..v_a` that are
/// added one after the other (Gram-Schmidt with two passes).
#[derive(Clone, Debug)]
pub(crate) struct Frame {
    q: Matrix,
    r: Vec<Vec<f64>>,
}

impl Frame {
    pub(crate) fn new(k: usize) -> Self {
        Frame { q: Matrix::zeros(0, k), r: Vec::new() }
    }

    /// Returns the coordinates of `v` in the frame and the part of `v` outside of it.
    pub(crate) fn split(&self, v: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let mut rest = v.to_vec();
        let mut coordinates = vec![0.0; self.q.rows];
        for _ in 0..2 {
            for (i, c) in coordinates.iter_mut().enumerate() {
                let q = self.q.row(i);
                let part = dot(q, &rest);
                *c += part;
                axpy(-part, q, &mut rest);
            }
        }
        (coordinates, rest)
    }

    /// Adds a vector. Returns false, without an effect, if it depends on those already there.
    pub(crate) fn push(&mut self, v: &[f64]) -> bool {
        let (mut coordinates, mut rest) = self.split(v);
        let size = norm(&rest);
        if is_dependent(size, norm(v)) {
            return false;
        }
        rest.iter_mut().for_each(|r| *r /= size);
        self.q.push(&rest);
        coordinates.push(size);
        self.r.push(coordinates);
        true
    }

    /// Solves `R x = c`.
    pub(crate) fn solve(&self, c: &[f64]) -> Vec<f64> {
        let a = self.r.len();
        let mut x = c[..a].to_vec();
        for j in (0..a).rev() {
            x[j] /= self.r[j][j];
            for i in 0..j {
                x[i] -= self.r[j][i] * x[j];
            }
        }
        x
    }

    /// Returns the smallest `z` with `v_j z = b_j` for all vectors of the frame, together with `R^-1 R^-T b`.
    pub(crate) fn smallest(&self, b: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let a = self.r.len();
        let mut c = vec![0.0; a];
        for j in 0..a {
            c[j] = (b[j] - dot(&self.r[j][..j], &c)) / self.r[j][j];
        }
        (self.q.apply_transposed(&c), self.solve(&c))
    }
}

/// Returns true if a vector of size `whole`, of which `rest` lies outside a space, belongs to that space.
pub(crate) fn is_dependent(rest: f64, whole: f64) -> bool {
    rest <= 1e-10 * whole + 1e-12
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_solves_underdetermined_systems() {
        let vectors = [[1.0, 2.0, 0.5, -1.0], [0.3, -1.0, 4.0, 0.0], [1.0, 1.0, 1.0, 1.0]];
        let mut frame = Frame::new(4);
        assert!(vectors.iter().all(|v| frame.push(v)));
        assert!(!frame.push(&[2.3, 2.0, 5.5, 0.0]), "the sum of the three");
        let b = [1.0, -2.0, 3.0];
        let (z, multipliers) = frame.smallest(&b);
        let mut sum = [0.0; 4];
        for j in 0..3 {
            assert!((dot(&vectors[j], &z) - b[j]).abs() < 1e-13);
            axpy(multipliers[j], &vectors[j], &mut sum);
        }
        assert!(z.iter().zip(&sum).all(|(z, s)| (z - s).abs() < 1e-13), "z is not in the span");
    }

    #[test]
    fn norm_survives_extremes() {
        assert!((norm(&[3e200, 4e200]) / 5e200 - 1.0).abs() < 1e-15);
        assert!((norm(&[3e-200, 4e-200]) / 5e-200 - 1.0).abs() < 1e-15);
        assert_eq!(norm(&[0.0, 0.0]), 0.0);
    }
}
