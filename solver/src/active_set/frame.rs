//! The orthonormal frame of all fixed rows, in the order in which they were fixed, and the point that meets them.
//!
//! A row is added by removing its components in the frame (classical Gram-Schmidt, with a second pass if the remainder
//! is small: twice is enough); the point moves along the new direction until the row has its target. Rows are removed
//! by truncating the frame to an earlier length. Both operations leave the earlier rows untouched, so that a change of
//! the active set costs only what comes after it.

use super::kernels::{LANES, axpy, combine, dot, norm, rotate, scaled};
pub(crate) const DEPENDENT: f64 = 3e-11;

/// A second projection follows if less than this fraction of the row is left after the first.
const SMALL: f64 = 0.1;

/// Rounding error of a row, relative to the largest row of its level: rows of one level are differences of numbers of
/// one magnitude, so that a small row is known no better than a large one.
const ROUNDING: f64 = 1e-15;

/// A remainder up to this multiple of its known error is rounding.
const SURE: f64 = 10.0;

/// A remainder is clearly zero below this fraction of the row's norm, or below its error. It is clearly not zero above
/// `SOMETHING` times the threshold.
const NOTHING: f64 = 2e-15;
const SOMETHING: f64 = 1e5;

/// Returns true if the remainder `left` of a row of norm `size` counts as zero; sets `doubt` if that is not clear.
#[inline(always)]
pub(crate) fn is_dependent(left: f64, size: f64, error: f64, doubt: &mut bool) -> bool {
    let threshold = (DEPENDENT * size).max(SURE * error);
    *doubt |= left > (NOTHING * size).max(error) && left < SOMETHING * threshold;
    left <= threshold
}

/// Numbers between these multiples of a threshold are near it.
const NEAR: [f64; 2] = [0.1, 1e3];

/// Returns true if a number is so near to the threshold that decides about it that another threshold would have decided
/// otherwise.
#[inline(always)]
pub(crate) fn is_near(number: f64, threshold: f64) -> bool {
    let number = number.abs();
    number > NEAR[0] * threshold && number < NEAR[1] * threshold
}

#[derive(Clone, Debug)]
pub(crate) struct Frame {
    n: usize,
    stride: usize,
    len: usize,
    /// Number of directions that were computed; fewer than `len`, which is `n` then, after [`Frame::close`].
    real: usize,
    /// Orthonormal rows.
    q: Vec<f64>,
    /// Distance that the point has moved along each of them.
    step: Vec<f64>,
    /// The point.
    pub(crate) x: Vec<f64>,
    /// Coefficients of the last projected row in the frame.
    pub(crate) coefficient: Vec<f64>,
    /// The largest step that was taken back: the point has lost its digits below the rounding of that step.
    pub(crate) lost: f64,
    /// A row was taken for dependent, or for independent, by a number that is not clear.
    pub(crate) doubt: bool,
    /// Maximum rotation of each row by rounding: a small remainder of a row has a large relative error.
    error: Vec<f64>,
}

impl Frame {
    pub(crate) fn new(n: usize) -> Self {
        let stride = n.div_ceil(LANES) * LANES;
        Frame {
            n,
            stride,
            len: 0,
            real: 0,
            q: vec![0.0; n * stride],
            step: vec![0.0; n],
            x: vec![0.0; stride],
            coefficient: vec![0.0; n],
            lost: 0.0,
            doubt: false,
            error: vec![0.0; n],
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// Returns the first rows, one after the other; None if they were not computed.
    pub(crate) fn first(&self, rows: usize) -> Option<&[f64]> {
        (rows <= self.real).then(|| &self.q[..rows * self.stride])
    }

    pub(crate) fn is_full(&self) -> bool {
        self.len == self.n
    }

    #[inline(always)]
    pub(crate) fn row(&self, k: usize) -> &[f64] {
        &self.q[k * self.stride..(k + 1) * self.stride]
    }

    /// Truncates the frame to `len` rows. The point becomes `start`, moved along the rows from `from` on.
    #[inline(always)]
    pub(crate) fn cut(&mut self, len: usize, from: usize, start: &[f64]) {
        self.len = len;
        self.real = self.real.min(len);
        self.x.copy_from_slice(start);
        combine(&self.step[from..len], &self.q[from * self.stride..len * self.stride], &mut self.x);
    }

    /// Removes the frame's components from `v`, whose norm was `size` in a level whose largest row has norm `largest`.
    /// Returns the norm of the remainder, 0 if that is only rounding, and its error. The coefficients are stored in
    /// `coefficient`.
    #[inline(always)]
    pub(crate) fn project(&mut self, v: &mut [f64], size: f64, largest: f64) -> (f64, f64) {
        if self.real < self.len {
            return (0.0, 0.0);
        }
        let frame = &self.q[..self.len * self.stride];
        for (c, q) in self.coefficient.iter_mut().zip(frame.chunks_exact(self.stride.max(1))) {
            *c = -dot(q, v);
        }
        combine(&self.coefficient[..self.len], frame, v);
        let mut error = ROUNDING * largest;
        for (c, e) in self.coefficient[..self.len].iter_mut().zip(&self.error) {
            *c = -*c;
            error += c.abs() * e;
        }
        let mut left = norm(v);
        if left < SMALL * size {
            left = self.again(v);
        }
        (if is_dependent(left, size, error, &mut self.doubt) { 0.0 } else { left }, error)
    }

    /// Returns the maximum rotation of the last row by rounding.
    #[inline(always)]
    pub(crate) fn last_error(&self) -> f64 {
        self.error[self.len - 1]
    }

    /// Projects `v` once more, to remove the components of the frame that rounding left. Returns the norm of the
    /// remainder.
    #[inline(always)]
    pub(crate) fn again(&mut self, v: &mut [f64]) -> f64 {
        for k in 0..self.len {
            let q = &self.q[k * self.stride..(k + 1) * self.stride];
            let c = dot(q, v);
            self.coefficient[k] += c;
            axpy(-c, q, v);
        }
        norm(v)
    }

    /// Appends the direction `v` of norm `size > 0` with its error, orthogonal to the frame, and moves the point by
    /// `step` along it. The frame must not be full.
    #[inline(always)]
    pub(crate) fn push(&mut self, v: &[f64], size: f64, error: f64, step: f64) {
        let k = self.len;
        self.error[k] = error / size;
        let q = &mut self.q[k * self.stride..(k + 1) * self.stride];
        scaled(1.0 / size, v, q);
        axpy(step, q, &mut self.x);
        self.step[k] = step;
        self.len += 1;
        self.real += 1;
    }

    /// Moves the point by `step` and marks the frame as full. The missing directions are not computed: later stages
    /// have no use for them.
    pub(crate) fn close(&mut self, step: &[f64]) {
        axpy(1.0, step, &mut self.x);
        self.len = self.n;
    }

    /// Rotates rows `k` and `k + 1` in their plane, by a cosine and a sine; the point stays in place.
    #[inline(always)]
    pub(crate) fn turn(&mut self, k: usize, c: f64, s: f64) {
        let (head, tail) = self.q.split_at_mut((k + 1) * self.stride);
        rotate(c, s, &mut head[k * self.stride..], &mut tail[..self.stride]);
        let error = self.error[k].max(self.error[k + 1]);
        (self.error[k], self.error[k + 1]) = (error, error);
        let (a, b) = (self.step[k], self.step[k + 1]);
        self.lost = self.lost.max(a.abs()).max(b.abs());
        (self.step[k], self.step[k + 1]) = (c * a + s * b, c * b - s * a);
    }

    /// Removes the last row, and the motion of the point along it.
    #[inline(always)]
    pub(crate) fn pop(&mut self) {
        self.len -= 1;
        self.real = self.len;
        let k = self.len;
        self.lost = self.lost.max(self.step[k].abs());
        axpy(-self.step[k], &self.q[k * self.stride..(k + 1) * self.stride], &mut self.x);
    }

    /// Moves the point by a further `step` along row `k`.
    #[inline(always)]
    pub(crate) fn advance(&mut self, k: usize, step: f64) {
        axpy(step, &self.q[k * self.stride..(k + 1) * self.stride], &mut self.x);
        self.step[k] += step;
    }
}
