//! Inner loops: operations on padded rows, written in lanes so that they compile to vector instructions. The order of
//! the sums is fixed, so that the result does not depend on the width of the machine's registers.

/// Rows are padded with zeros to a multiple of this.
pub(crate) const LANES: usize = crate::problem::LANES;

/// Dot product of two padded rows of equal length.
#[inline(always)]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (a.as_chunks::<LANES>().0, b.as_chunks::<LANES>().0);
    let mut s = [0.0_f64; LANES];
    for k in 0..a.len().min(b.len()) {
        for i in 0..LANES {
            s[i] += a[k][i] * b[k][i];
        }
    }
    ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]))
}

/// `y += s x` on padded rows.
#[inline(always)]
pub(crate) fn axpy(s: f64, x: &[f64], y: &mut [f64]) {
    let (x, y) = (x.as_chunks::<LANES>().0, y.as_chunks_mut::<LANES>().0);
    for k in 0..x.len().min(y.len()) {
        for i in 0..LANES {
            y[k][i] += s * x[k][i];
        }
    }
}

/// `y += sum_k s_k x_k` on padded rows; `x` contains the rows one after the other. The sums stay in registers during
/// the loop over the rows.
#[inline(always)]
pub(crate) fn combine(s: &[f64], x: &[f64], y: &mut [f64]) {
    let stride = y.len();
    let rows = x.as_chunks::<LANES>().0;
    for (c, y) in y.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
        let mut sum = *y;
        for (s, x) in s.iter().zip(rows[c.min(rows.len())..].iter().step_by(stride / LANES)) {
            for i in 0..LANES {
                sum[i] += s * x[i];
            }
        }
        *y = sum;
    }
}

/// `y = s x` on padded rows.
#[inline(always)]
pub(crate) fn scaled(s: f64, x: &[f64], y: &mut [f64]) {
    let (x, y) = (x.as_chunks::<LANES>().0, y.as_chunks_mut::<LANES>().0);
    for k in 0..x.len().min(y.len()) {
        for i in 0..LANES {
            y[k][i] = s * x[k][i];
        }
    }
}

/// `(x, y) = (c x + s y, c y - s x)` on padded rows.
#[inline(always)]
pub(crate) fn rotate(c: f64, s: f64, x: &mut [f64], y: &mut [f64]) {
    let (x, y) = (x.as_chunks_mut::<LANES>().0, y.as_chunks_mut::<LANES>().0);
    for k in 0..x.len().min(y.len()) {
        for i in 0..LANES {
            (x[k][i], y[k][i]) = (c * x[k][i] + s * y[k][i], c * y[k][i] - s * x[k][i]);
        }
    }
}

/// Euclidean norm of a padded row, safe if the squares overflow or underflow.
#[inline(always)]
pub(crate) fn norm(a: &[f64]) -> f64 {
    let square = dot(a, a);
    if square > 1e-200 && square < 1e200 { square.sqrt() } else { crate::dense::norm(a) }
}
