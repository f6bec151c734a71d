//! The rows that a level minimises, its equalities and violated rows, outside the frame: weighted least squares of any
//! rank.
//!
//! The rows are eliminated one by one, the one with the largest remainder first, and their directions are added to the
//! frame (a complete orthogonal decomposition `W A = C Q`, the rows of `Q` orthonormal, `C` trapezoidal). Usually the
//! point that meets the rows on the diagonal meets all others too, and no residual is left. Otherwise, with
//! `C = [L; B]` and `e` the residual of the dependent rows, the residuals of the minimiser are
//!
//! ```text
//! u = (1 + G G^T)^-1 e   of the dependent rows,   -G^T u   of the others,   G = B L^-1
//! ```
//!
//! The size of this system is the number of dependent rows. It is well conditioned, because the elimination with the
//! largest row first keeps `G` small.

use super::closed::{Closed, Member};
use super::frame::{DEPENDENT, Frame, is_dependent, is_near};
use super::kernels::{LANES, axpy, dot, norm, scaled};
use super::rows::{Norms, weight};
use super::working_set::Entry;
use crate::problem::Level;
use crate::structure::Structure;

/// A residual below this, relative to the size of the row, the bound and the point, counts as zero.
const CONSISTENT: f64 = 1e-12;

/// A force below this fraction of all forces of its level may belong to a direction that moves the rows of the level so
/// little that it counts as not moving them, see [`Group::moves`].
const SLIGHT: f64 = DEPENDENT;

/// A force below this fraction of all forces of its level is rounding.
const NOISE: f64 = 1e-14;

#[derive(Clone, Debug)]
pub(crate) struct Group {
    n: usize,
    stride: usize,
    /// Weighted rows, overwritten by their remainders.
    rows: Vec<f64>,
    /// The trapezoidal factor, n numbers per row; column 0 is the first direction that the level adds to the frame.
    factor: Vec<f64>,
    /// Residual targets.
    target: Vec<f64>,
    /// Norms of the weighted rows, squared norms of their remainders, and the latter as last computed directly and not
    /// by an update.
    size: Vec<f64>,
    left: Vec<f64>,
    sure: Vec<f64>,
    /// Threshold below which a residual counts as zero.
    quiet: Vec<f64>,
    /// The members: row of the level, or `rows + i` for the damping of `x_i`; and square roots of weights.
    member: Vec<usize>,
    root: Vec<f64>,
    /// Members in the order of elimination, followed by the dependent ones.
    order: Vec<usize>,
    /// Weighted residuals `sqrt(w) (target - a x)` of the minimiser, per member.
    residual: Vec<f64>,
    /// `B L^-1` (n numbers per row), `1 + G G^T`, and a right-hand side.
    g: Vec<f64>,
    gram: Vec<f64>,
    u: Vec<f64>,
    /// Rounding errors of the rows' remainders, and their effect on the residuals, see [`Group::blur`].
    error: Vec<f64>,
    blur: Vec<f64>,
    closed: Closed,
    /// Compute all directions of the next level, as [`Group::moves`] requires.
    pub(crate) thorough: bool,
    /// Displacement of each member by a direction.
    moved: Vec<f64>,
    /// Number of directions that the level added to the frame.
    rank: usize,
    /// A component of the gradient below this is rounding.
    pub(crate) noise: f64,
    /// A component of the gradient below this may belong to a direction that hardly moves the level.
    pub(crate) slight: f64,
}

impl Group {
    /// Creates storage for levels of up to `most` rows, damping included.
    pub(crate) fn new(n: usize, most: usize) -> Self {
        let stride = n.div_ceil(LANES) * LANES;
        Group {
            n,
            stride,
            rows: vec![0.0; most * stride],
            factor: vec![0.0; most * n],
            target: vec![0.0; most],
            size: vec![0.0; most],
            left: vec![0.0; most],
            sure: vec![0.0; most],
            quiet: vec![0.0; most],
            member: Vec::with_capacity(most),
            root: vec![0.0; most],
            order: Vec::with_capacity(most),
            residual: vec![0.0; most],
            g: vec![0.0; most * n],
            gram: vec![0.0; most * most],
            u: vec![0.0; most.max(n)],
            error: vec![0.0; most],
            blur: vec![0.0; most],
            closed: Closed::new(n),
            thorough: false,
            moved: vec![0.0; most],
            rank: 0,
            noise: 0.0,
            slight: 0.0,
        }
    }

    /// Moves the frame's point to the minimisers and extends the frame by the directions that they fix. Writes half the
    /// gradient of the cost into `gradient` and returns true if it is not zero. Sets the trial multipliers of `own`.
    pub(crate) fn minimise(
        &mut self,
        level: &Level,
        norms: Norms,
        equal: &[usize],
        own: &mut [Entry],
        frame: &mut Frame,
        gradient: &mut [f64],
    ) -> bool {
        self.collect(level, norms, equal, own, frame);
        let p = self.member.len();
        if p == 0 {
            return false;
        }
        let closed = !self.thorough && own.is_empty() && self.close(level, frame);
        let mut left_over = false;
        if !closed {
            self.gather(norms, frame);
            let base = frame.len();
            self.eliminate(frame);
            self.rank = frame.len() - base;
            self.quieten(frame);
            for &i in &self.order[self.rank..] {
                frame.doubt |= is_near(self.target[i], self.quiet[i]);
                left_over |= self.target[i].abs() > self.quiet[i];
            }
            if left_over {
                self.compromise(frame, base, self.rank);
            }
        } else {
            self.quieten(frame);
            for (residual, quiet) in self.residual[..p].iter().zip(&self.quiet) {
                frame.doubt |= is_near(*residual, *quiet);
                left_over |= residual.abs() > *quiet;
            }
        }
        if left_over {
            self.differentiate(level, gradient);
            let mut unsure = 0.0;
            (self.noise, self.slight) = (0.0, 0.0);
            for m in 0..p {
                let residual = self.residual[m].abs();
                unsure += self.error[m] * residual;
                self.noise += self.size[m] * (NOISE * residual + 0.01 * self.quiet[m]);
                self.slight += self.size[m] * (SLIGHT * residual + 0.01 * self.quiet[m]);
            }
            if !closed {
                self.blur(unsure);
            }
        } else {
            self.blur[..p].fill(0.0);
        }
        for (entry, m) in own.iter_mut().zip(equal.len()..) {
            let e = if left_over { self.residual[m] } else { 0.0 };
            entry.trial = -entry.side * e * self.root[m];
            entry.noise = self.root[m] * (0.01 * self.quiet[m] + self.blur[m]);
        }
        left_over
    }

    /// Adds the rounding error that the point causes to the threshold of each residual.
    fn quieten(&mut self, frame: &Frame) {
        let far = norm(&frame.x);
        for (quiet, size) in self.quiet.iter_mut().zip(&self.size).take(self.member.len()) {
            *quiet += CONSISTENT * size * far;
        }
    }

    /// Minimises a level that determines the whole point, without computing its directions. Returns false if the level
    /// is of another kind.
    fn close(&mut self, level: &Level, frame: &mut Frame) -> bool {
        let Group { rows, target, member: names, residual, closed, stride, .. } = self;
        let member = |(m, &i): (usize, &usize)| Member {
            row: &rows[m * *stride..(m + 1) * *stride],
            target: target[m],
            column: match i.checked_sub(level.rows()) {
                Some(column) => Some(column),
                None => match level.structure()[i] {
                    Structure::Bound { column, .. } => Some(column),
                    _ => None,
                },
            },
        };
        let members = names.iter().enumerate().map(member);
        if !closed.minimise(members.clone(), frame) {
            return false;
        }
        for (member, residual) in members.zip(residual) {
            let moved = member.column.map_or_else(|| dot(member.row, &closed.step), |j| member.row[j] * closed.step[j]);
            *residual = member.target - moved;
        }
        frame.close(&closed.step);
        true
    }

    /// Collects the weighted rows and their residuals at the point.
    fn collect(&mut self, level: &Level, norms: Norms, equal: &[usize], own: &[Entry], frame: &Frame) {
        let s = self.stride;
        self.member.clear();
        let members = equal.iter().map(|i| (*i, level.lower[*i]));
        let violated = own.iter().map(|e| (e.row, if e.side > 0.0 { level.upper[e.row] } else { level.lower[e.row] }));
        for (i, bound) in members.chain(violated) {
            let m = self.member.len();
            let w = weight(level, i);
            let root = if w == 1.0 { 1.0 } else { w.sqrt() };
            let row = &mut self.rows[m * s..(m + 1) * s];
            scaled(root, &level.padded()[i * s..(i + 1) * s], row);
            self.size[m] = root * norms.each[i];
            self.root[m] = root;
            self.target[m] = root * bound - dot(row, &frame.x);
            self.quiet[m] = CONSISTENT * (self.size[m] + (root * bound).abs());
            self.member.push(i);
        }
        if level.damping > 0.0 {
            let root = level.damping.sqrt();
            for i in 0..self.n {
                let m = self.member.len();
                let row = &mut self.rows[m * s..(m + 1) * s];
                row.fill(0.0);
                row[i] = root;
                self.size[m] = root;
                self.root[m] = root;
                self.target[m] = -root * frame.x[i];
                self.quiet[m] = CONSISTENT * root;
                self.member.push(level.rows() + i);
            }
        }
    }

    /// Removes the frame's components from the rows.
    fn gather(&mut self, norms: Norms, frame: &mut Frame) {
        let s = self.stride;
        for m in 0..self.member.len() {
            let size = self.size[m];
            let row = &mut self.rows[m * s..(m + 1) * s];
            let (left, error) =
                if frame.is_full() { (0.0, 0.0) } else { frame.project(row, size, self.root[m] * norms.largest) };
            self.error[m] = error;
            self.left[m] = left * left;
            self.sure[m] = self.left[m];
        }
    }

    /// Right-looking Gram-Schmidt with the largest remaining row first. A row that counts as dependent adds no
    /// direction, but later directions are still removed from its remainder: otherwise all residuals would have an
    /// error of that size.
    fn eliminate(&mut self, frame: &mut Frame) {
        let (s, n) = (self.stride, self.n);
        let base = frame.len();
        self.order.clear();
        self.order.extend(0..self.member.len());
        let (mut rank, mut doubt) = (0, false);
        while rank < self.order.len() && !frame.is_full() {
            let mut best = rank;
            for k in rank + 1..self.order.len() {
                if self.left[self.order[k]] > self.left[self.order[best]] {
                    best = k;
                }
            }
            self.order.swap(rank, best);
            let i = self.order[rank];
            if self.left[i] == 0.0 {
                break;
            }
            let row = &mut self.rows[i * s..(i + 1) * s];
            let mut size = norm(row);
            if size < 0.1 * self.size[i] {
                size = frame.again(row);
            }
            if is_dependent(size, self.size[i], self.error[i], &mut doubt) {
                (self.left[i], self.sure[i]) = (0.0, 0.0);
                continue;
            }
            let step = self.target[i] / size;
            frame.push(row, size, self.error[i], step);
            let turned = frame.last_error();
            let q = frame.row(base + rank);
            self.factor[i * n + rank] = size;
            self.target[i] = 0.0;
            for &k in &self.order[rank + 1..] {
                let row = &mut self.rows[k * s..(k + 1) * s];
                let c = dot(row, q);
                axpy(-c, q, row);
                self.error[k] += c.abs() * turned;
                self.factor[k * n + rank] = c;
                self.target[k] -= c * step;
                let left = self.left[k] - c * c;
                self.left[k] = if self.sure[k] > 0.0 { left } else { 0.0 };
                if self.sure[k] > 0.0 && left < 0.01 * self.sure[k] {
                    let left = norm(row);
                    let nothing = is_dependent(left, self.size[k], self.error[k], &mut doubt);
                    self.left[k] = if nothing { 0.0 } else { left * left };
                    self.sure[k] = self.left[k];
                }
            }
            rank += 1;
        }
        frame.doubt |= doubt;
    }

    /// Distributes the residuals of the dependent rows; see the documentation of the file.
    fn compromise(&mut self, frame: &mut Frame, base: usize, rank: usize) {
        let n = self.n;
        let (pivots, dependent) = self.order.split_at(rank);
        let d = dependent.len();
        for (a, &i) in dependent.iter().enumerate() {
            // G L = B, from the last column on.
            for j in (0..rank).rev() {
                let mut sum = self.factor[i * n + j];
                for (k, pivot) in pivots.iter().enumerate().skip(j + 1) {
                    sum -= self.g[a * n + k] * self.factor[pivot * n + j];
                }
                self.g[a * n + j] = sum / self.factor[pivots[j] * n + j];
            }
            self.u[a] = self.target[i];
        }
        // Cholesky factor of 1 + G G^T in place, then the two substitutions.
        for a in 0..d {
            for b in 0..=a {
                let mut sum: f64 = if a == b { 1.0 } else { 0.0 };
                for j in 0..rank {
                    sum += self.g[a * n + j] * self.g[b * n + j];
                }
                for j in 0..b {
                    sum -= self.gram[a * d + j] * self.gram[b * d + j];
                }
                self.gram[a * d + b] = if a == b { sum.max(1.0).sqrt() } else { sum / self.gram[b * d + b] };
            }
        }
        for a in 0..d {
            for j in 0..a {
                self.u[a] -= self.gram[a * d + j] * self.u[j];
            }
            self.u[a] /= self.gram[a * d + a];
        }
        for a in (0..d).rev() {
            for j in a + 1..d {
                self.u[a] -= self.gram[j * d + a] * self.u[j];
            }
            self.u[a] /= self.gram[a * d + a];
        }
        for (a, &i) in dependent.iter().enumerate() {
            self.residual[i] = self.u[a];
        }
        // The pivots give way by z = G^T u: L dy = z.
        for (j, &i) in pivots.iter().enumerate() {
            let z: f64 = (0..d).map(|a| self.g[a * n + j] * self.u[a]).sum();
            self.residual[i] = -z;
            let mut sum = z;
            for (k, pivot) in pivots[..j].iter().enumerate() {
                sum -= self.factor[i * n + k] * self.target[*pivot];
            }
            // The pivots' targets are used up: their storage takes dy.
            self.target[i] = sum / self.factor[i * n + j];
            frame.advance(base + j, self.target[i]);
        }
    }

    /// Computes the effect of the rows' rounding on their residuals: forces that are uncertain by `unsure` move the
    /// point along each direction of the level, and all rows with it.
    fn blur(&mut self, unsure: f64) {
        let n = self.n;
        self.blur[..self.order.len()].fill(0.0);
        for (j, &pivot) in self.order[..self.rank].iter().enumerate() {
            let diagonal = self.factor[pivot * n + j];
            let moved = unsure / (diagonal * diagonal);
            for &i in &self.order[j..] {
                self.blur[i] += self.factor[i * n + j].abs() * moved;
            }
        }
    }

    /// Returns true if a direction moves a row of the level that was minimised last, and was not met, by at least the
    /// threshold of an independent row, while the rows on the diagonal stay where they are.
    pub(crate) fn moves(&mut self, level: &Level, direction: &[f64]) -> bool {
        let (n, s) = (self.n, self.stride);
        for (m, &i) in self.member.iter().enumerate() {
            let value = if i < level.rows() {
                dot(&level.padded()[i * s..(i + 1) * s], direction)
            } else {
                direction[i - level.rows()]
            };
            self.moved[m] = self.root[m] * value;
        }
        let (pivots, dependent) = self.order.split_at(self.rank);
        // The whole direction includes the motion that keeps the pivots in place: L y = -moved.
        let mut square = dot(direction, direction);
        for (j, &i) in pivots.iter().enumerate() {
            let back: f64 = (0..j).map(|k| self.factor[i * n + k] * self.u[k]).sum();
            self.u[j] = (-self.moved[i] - back) / self.factor[i * n + j];
            square += self.u[j] * self.u[j];
        }
        let length = square.sqrt();
        dependent.iter().any(|&i| {
            let along: f64 = (0..self.rank).map(|k| self.factor[i * n + k] * self.u[k]).sum();
            (self.moved[i] + along).abs() > DEPENDENT * self.size[i] * length
        })
    }

    /// Computes half the gradient of the cost at the minimiser: `-A^T W^(1/2) e`.
    fn differentiate(&self, level: &Level, gradient: &mut [f64]) {
        gradient.fill(0.0);
        for (m, &i) in self.member.iter().enumerate() {
            let force = -self.residual[m] * self.root[m];
            if i < level.rows() {
                axpy(force, &level.padded()[i * self.stride..(i + 1) * self.stride], gradient);
            } else {
                gradient[i - level.rows()] += force;
            }
        }
    }
}
