//! Levels that determine the whole point: a target for almost every variable (a posture, damping) and possibly some
//! other rows.
//!
//! The general elimination computes a direction for each remaining degree of freedom. None is needed here, because
//! nothing is left for the stages that follow. Let `t` be the step that the level's rows with a single variable ask for
//! and `w` their weights, `A` its other rows with their targets `a`, `Q` the rows of the frame and `U` the variables
//! without a row of their own. The minimiser of
//!
//! ```text
//! sum_j w_j (d_j - t_j)^2 + |A d - a|^2   with  Q d = 0
//! ```
//!
//! is `d = t - V C^T y` outside `U` and `u` in it, with `v_j = 1 / w_j`, the rows of `Q` and `A` in `C`, and
//!
//! ```text
//! (C V C^T + D) y - C_U u = C t - (0, a),   C_U^T y = 0,   D = diag(0, 1)
//! ```
//!
//! As `C_U^T y` is zero, any `v > 0` in `U` gives the same result, and makes the matrix positive definite. The size of
//! the system is that of the frame plus the level's other rows. It is diagonal if all weights are equal and there are
//! no other rows. Iterative refinement compensates for different weights.

use super::frame::Frame;
use super::kernels::{LANES, axpy, dot, norm};

/// Maximum ratio of the largest weight, or squared norm of another row, to the smallest weight: a step of refinement
/// then gains five digits.
const SPREAD: f64 = 1e10;

/// Variables in `U` are determined by the other rows if at least this fraction of them lies in the span of these.
const SETTLED: f64 = 1e-6;

/// Maximum number of refinement steps, and maximum relative change of the last one.
const REFINEMENTS: usize = 4;
const REFINED: f64 = 1e-13;

/// A member of a level: its weighted row, its target relative to the point, and its variable if it has a single one.
pub(crate) struct Member<'r> {
    pub(crate) row: &'r [f64],
    pub(crate) target: f64,
    pub(crate) column: Option<usize>,
}

#[derive(Clone, Debug)]
pub(crate) struct Closed {
    n: usize,
    stride: usize,
    /// Per variable: weight (0 in `U`), target of the step, inverse weight.
    weight: Vec<f64>,
    wish: Vec<f64>,
    loose: Vec<f64>,
    /// All weights are equal.
    even: bool,
    /// Inverse weight that is used for the variables in `U`.
    middle: f64,
    /// The variables in `U`.
    free: Vec<usize>,
    /// C and C V with `size` rows, of which the first `fixed` are those of the frame; targets of the others.
    rows: Vec<f64>,
    spread: Vec<f64>,
    asked: Vec<f64>,
    fixed: usize,
    size: usize,
    /// The upper Cholesky factor R of the system, `size` numbers per row.
    factor: Vec<f64>,
    /// `R^-T C_U`, `size` numbers per variable, and the lower Cholesky factor of `C_U^T (R^T R)^-1 C_U`.
    reach: Vec<f64>,
    gram: Vec<f64>,
    /// Solution of the system, and its correction.
    y: Vec<f64>,
    y_more: Vec<f64>,
    u: Vec<f64>,
    /// The step, and its correction.
    pub(crate) step: Vec<f64>,
    more: Vec<f64>,
}

impl Closed {
    pub(crate) fn new(n: usize) -> Self {
        let stride = n.div_ceil(LANES) * LANES;
        let most = 2 * n;
        Closed {
            n,
            stride,
            weight: vec![0.0; n],
            wish: vec![0.0; stride],
            loose: vec![0.0; stride],
            even: true,
            middle: 1.0,
            free: Vec::with_capacity(n),
            rows: vec![0.0; most * stride],
            spread: vec![0.0; most * stride],
            asked: vec![0.0; most],
            fixed: 0,
            size: 0,
            factor: vec![0.0; most * most],
            reach: vec![0.0; most * n],
            gram: vec![0.0; n * n],
            y: vec![0.0; most],
            y_more: vec![0.0; most],
            u: vec![0.0; n],
            step: vec![0.0; stride],
            more: vec![0.0; stride],
        }
    }

    /// Computes the step from the frame's point to the minimiser. Returns false if the members do not determine the
    /// whole point, or are not suitable for this method.
    pub(crate) fn minimise<'r>(&mut self, members: impl Iterator<Item = Member<'r>>, frame: &Frame) -> bool {
        if frame.is_full() || !self.read(members, frame) {
            return false;
        }
        self.build();
        if !self.factorise() {
            return false;
        }
        for k in 0..self.size {
            let row = &self.rows[k * self.stride..(k + 1) * self.stride];
            self.y[k] = dot(row, &self.wish) - self.asked[k];
        }
        self.u.fill(0.0);
        let mut y = std::mem::take(&mut self.y);
        self.solve(&mut y);
        self.y = y;
        self.step.copy_from_slice(&self.wish);
        for k in 0..self.size {
            axpy(-self.y[k], &self.spread[k * self.stride..(k + 1) * self.stride], &mut self.step);
        }
        for (&j, &u) in self.free.iter().zip(&self.u) {
            self.step[j] = u;
        }
        // With equal weights and no other rows the step is the target without its component in the frame: nothing to
        // refine.
        (self.even && self.fixed == self.size && self.free.is_empty()) || self.refine(frame)
    }

    /// Sorts the members into rows with a single variable and others; returns false if they are not suitable.
    fn read<'r>(&mut self, members: impl Iterator<Item = Member<'r>>, frame: &Frame) -> bool {
        let s = self.stride;
        self.weight.fill(0.0);
        self.wish.fill(0.0);
        self.fixed = frame.len();
        self.size = self.fixed;
        let mut largest = 0.0_f64;
        for member in members {
            if let Some(j) = member.column {
                let a = member.row[j];
                self.weight[j] += a * a;
                self.wish[j] += a * member.target;
            } else if self.size < 2 * self.n {
                self.rows[self.size * s..(self.size + 1) * s].copy_from_slice(member.row);
                self.asked[self.size] = member.target;
                largest = largest.max(dot(member.row, member.row));
                self.size += 1;
            } else {
                return false;
            }
        }
        self.free.clear();
        let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
        for (j, &w) in self.weight.iter().enumerate() {
            if w > 0.0 {
                (least, most) = (least.min(w), most.max(w));
                self.wish[j] /= w;
                self.loose[j] = 1.0 / w;
            } else {
                self.free.push(j);
            }
        }
        if 2 * self.free.len() > self.n
            || self.free.len() > self.size
            || most.max(largest) > SPREAD * least
            || !(1e-100..1e100).contains(&least)
        {
            return false;
        }
        self.even = most == least;
        self.middle = if self.even { 1.0 / most } else { 1.0 / (most.sqrt() * least.sqrt()) };
        self.free.iter().for_each(|&j| self.loose[j] = self.middle);
        for k in 0..self.fixed {
            self.asked[k] = 0.0;
            self.rows[k * s..(k + 1) * s].copy_from_slice(frame.row(k));
        }
        true
    }

    /// Computes C V and the matrix of the system.
    fn build(&mut self) {
        let (s, m) = (self.stride, self.size);
        for (spread, row) in self.spread.chunks_exact_mut(s).zip(self.rows.chunks_exact(s)).take(m) {
            for ((spread, a), v) in spread.iter_mut().zip(row).zip(&self.loose) {
                *spread = a * v;
            }
        }
        for i in 0..m {
            let spread = &self.spread[i * s..(i + 1) * s];
            for k in i..m {
                self.factor[i * m + k] = if self.even && k < self.fixed {
                    // The rows of the frame are orthonormal.
                    if i == k { self.middle } else { 0.0 }
                } else {
                    dot(spread, &self.rows[k * s..(k + 1) * s])
                };
            }
            if i >= self.fixed {
                self.factor[i * m + i] += 1.0;
            }
        }
    }

    /// Computes both Cholesky factors; returns false if a freedom remains.
    fn factorise(&mut self) -> bool {
        let m = self.size;
        for k in 0..m {
            let (above, below) = self.factor.split_at_mut((k + 1) * m);
            let row = &mut above[k * m + k..];
            if row[0].is_nan() || row[0] <= 0.0 {
                return false;
            }
            let root = row[0].sqrt();
            row.iter_mut().for_each(|a| *a /= root);
            // With equal weights the rows of the frame are not coupled.
            let next = if self.even { self.fixed.max(k + 1) } else { k + 1 };
            for i in next..m {
                let at = (i - k - 1) * m;
                subtract(row[i - k], &row[i - k..], &mut below[at + i..at + m]);
            }
        }
        for (c, &j) in self.free.iter().enumerate() {
            let reach = &mut self.reach[c * m..(c + 1) * m];
            for (k, r) in reach.iter_mut().enumerate() {
                *r = self.rows[k * self.stride + j];
            }
            forward(&self.factor, m, reach);
        }
        let f = self.free.len();
        for a in 0..f {
            for b in 0..=a {
                let (ra, rb) = (&self.reach[a * m..(a + 1) * m], &self.reach[b * m..(b + 1) * m]);
                let left = product(ra, rb) - product(&self.gram[a * f..a * f + b], &self.gram[b * f..b * f + b]);
                self.gram[a * f + b] = if a > b {
                    left / self.gram[b * f + b]
                } else if left * self.middle > SETTLED {
                    left.sqrt()
                } else {
                    return false;
                };
            }
        }
        true
    }

    /// Solves `R^T R y - C_U u = b`, `C_U^T y = -c` with `b` in `y` and `c` in `u`; the solution overwrites both.
    fn solve(&mut self, y: &mut [f64]) {
        let (m, f) = (self.size, self.free.len());
        let y = &mut y[..m];
        forward(&self.factor, m, y);
        for c in 0..f {
            self.u[c] += product(&self.reach[c * m..(c + 1) * m], y);
        }
        for a in 0..f {
            let sum = -self.u[a] - product(&self.gram[a * f..a * f + a], &self.more[..a]);
            self.more[a] = sum / self.gram[a * f + a];
        }
        for a in (0..f).rev() {
            let mut sum = self.more[a];
            for b in a + 1..f {
                sum -= self.gram[b * f + a] * self.u[b];
            }
            self.u[a] = sum / self.gram[a * f + a];
        }
        for c in 0..f {
            for (y, r) in y.iter_mut().zip(&self.reach[c * m..(c + 1) * m]) {
                *y += r * self.u[c];
            }
        }
        for i in (0..m).rev() {
            let (at, after) = y[i..].split_at_mut(1);
            at[0] = (at[0] - product(&self.factor[i * m + i + 1..(i + 1) * m], after)) / self.factor[i * m + i];
        }
    }

    /// Computes the residual of the equations at the step, and corrects it. Returns false if this does not converge.
    fn refine(&mut self, frame: &Frame) -> bool {
        let (s, m) = (self.stride, self.size);
        for _ in 0..REFINEMENTS {
            for k in 0..m {
                let row = &self.rows[k * s..(k + 1) * s];
                let own = if k < self.fixed { 0.0 } else { self.y[k] };
                self.y_more[k] = dot(row, &self.step) - self.asked[k] - own;
            }
            for (c, &j) in self.free.iter().enumerate() {
                let sum: f64 = (0..m).map(|k| self.rows[k * s + j] * self.y[k]).sum();
                self.u[c] = sum;
                (0..m).for_each(|k| self.y_more[k] -= self.middle * sum * self.rows[k * s + j]);
            }
            let mut y = std::mem::take(&mut self.y_more);
            self.solve(&mut y);
            self.y_more = y;
            self.more.fill(0.0);
            for (k, y) in self.y_more[..m].iter().enumerate() {
                axpy(-y, &self.spread[k * s..(k + 1) * s], &mut self.more);
                self.y[k] += y;
            }
            for (&j, &u) in self.free.iter().zip(&self.u) {
                self.more[j] = u;
            }
            self.step.iter_mut().zip(&self.more).for_each(|(step, more)| *step += more);
            if norm(&self.more) <= REFINED * (norm(&self.step) + norm(&frame.x)) {
                return true;
            }
        }
        false
    }
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let mut s = [0.0_f64; 4];
    for (a, b) in a.iter().zip(b) {
        for i in 0..4 {
            s[i] += a[i] * b[i];
        }
    }
    a_rest.iter().zip(b_rest).fold((s[0] + s[2]) + (s[1] + s[3]), |sum, (a, b)| sum + a * b)
}

/// `y -= s x`.
fn subtract(s: f64, x: &[f64], y: &mut [f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y -= s * x;
    }
}

/// `R^-T y` in place, `R` with `m` numbers a row.
fn forward(factor: &[f64], m: usize, y: &mut [f64]) {
    for i in 0..m {
        let (at, after) = y[i..m].split_at_mut(1);
        at[0] /= factor[i * m + i];
        subtract(at[0], &factor[i * m + i + 1..(i + 1) * m], after);
    }
}
