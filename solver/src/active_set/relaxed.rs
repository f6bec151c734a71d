//! The relaxed problem of a working set: only the rows of the working set exist, each at its stage. One pass over the
//! stages computes its lexicographic optimum and the multipliers that show whether the working set is right.
//!
//! Factorisations are kept: the frame contains the rows in the order of the stages, first those held against a stage,
//! then those that the stage minimises. A change at a stage recomputes only what comes after it.

use super::frame::Frame;
use super::group::Group;
use super::kernels::{LANES, axpy, dot, norm, scaled};
use super::rows::Rows;
use super::working_set::{Entry, WorkingSet};
use crate::problem::Problem;

/// A multiplier below this fraction of the forces that it balances is rounding.
const NOISE: f64 = 1e-13;

#[derive(Clone, Debug)]
pub(crate) struct Relaxed {
    /// Number of levels that are solved; also the index of the last stage.
    pub(crate) levels: usize,
    pub(crate) rows: Rows,
    pub(crate) working_set: WorkingSet,
    pub(crate) frame: Frame,
    group: Group,
    /// The frame contains the stages before this one, and `pushed` active rows of this one.
    pub(crate) stage: usize,
    pub(crate) pushed: usize,
    /// Length of the frame and the point at the beginning of each stage.
    pub(crate) mark: Vec<usize>,
    start: Vec<f64>,
    /// Half the gradient of each stage's cost, a flag that it is not zero, and the noise of the multipliers that
    /// balance it.
    gradient: Vec<f64>,
    presses: Vec<bool>,
    noise: Vec<f64>,
    /// Lower triangles of the active rows in the frame, n numbers per row, indexed by the position in the frame.
    pub(crate) lower: Vec<f64>,
    /// The current row, and the error of its remainder.
    row: Vec<f64>,
    error: f64,
    /// Norm of the largest row of its level, in the same scale.
    largest: f64,
    /// Frame coefficients of the direction in which a stage moves if one of its active rows is released.
    lets_go: Vec<f64>,
    pub(crate) reference: Vec<f64>,
    pub(crate) stride: usize,
    pub(crate) n: usize,
}

impl Relaxed {
    pub(crate) fn new(problem: &Problem) -> Self {
        let n = problem.n;
        let stride = n.div_ceil(LANES) * LANES;
        let levels = problem.levels.len();
        let sizes: Vec<usize> = problem.levels.iter().map(crate::Level::rows).collect();
        let most = sizes.iter().max().copied().unwrap_or(0) + n;
        let rows = Rows::new(problem);
        Relaxed {
            levels,
            rows,
            working_set: WorkingSet::new(&sizes),
            frame: Frame::new(n),
            group: Group::new(n, most),
            stage: 0,
            pushed: 0,
            mark: vec![0; levels + 1],
            start: vec![0.0; (levels + 1) * stride],
            gradient: vec![0.0; (levels + 1) * stride],
            presses: vec![false; levels + 1],
            noise: vec![0.0; levels + 1],
            lower: vec![0.0; n * n],
            row: vec![0.0; stride],
            error: 0.0,
            largest: 1.0,
            lets_go: vec![0.0; n],
            reference: vec![0.0; stride],
            stride,
            n,
        }
    }

    /// Begins a solve of the first `levels` levels from the current working set.
    pub(crate) fn begin(&mut self, problem: &Problem, levels: usize) {
        self.levels = levels;
        self.working_set.adopt(problem, &mut self.rows, levels);
        self.reference[..self.n].copy_from_slice(&problem.reference);
        self.start[..self.stride].copy_from_slice(&self.reference);
        self.mark[0] = 0;
        (self.stage, self.pushed) = (0, 0);
        self.frame.cut(0, 0, &self.reference);
        self.frame.lost = 0.0;
        self.frame.doubt = false;
    }

    /// Truncates the frame to the first `keep` active rows of stage `s`, if it is longer.
    pub(crate) fn rewind(&mut self, s: usize, keep: usize) {
        if self.stage > s || (self.stage == s && self.pushed > keep) {
            let from = self.mark[s];
            self.frame.cut(from + keep, from, &self.start[s * self.stride..(s + 1) * self.stride]);
            (self.stage, self.pushed) = (s, keep);
        }
    }

    /// Removes active row `j` of stage `s` from the working set and from the frame. At the last stage, which nothing
    /// follows, the frame is updated in place by Givens rotations; elsewhere it is truncated before the row.
    pub(crate) fn release(&mut self, s: usize, j: usize) {
        let active = &mut self.working_set.active[s];
        let gone = active.remove(j);
        let left = active.len();
        let at = self.rows.at(gone.level, gone.row);
        self.rows.side[at] = 0;
        if s < self.levels || self.stage != s || self.pushed != left + 1 {
            self.rewind(s, j);
            return;
        }
        let (n, from) = (self.n, self.mark[s]);
        for i in j..left {
            // Row i + 1 becomes row i: its entry to the right of the diagonal is rotated into the diagonal.
            let below = (from + i + 1) * n;
            self.lower.copy_within(below + from..below + from + i + 2, below - n + from);
            let k = (from + i) * n + from + i;
            let (a, b) = (self.lower[k], self.lower[k + 1]);
            let r = a.hypot(b);
            let (c, s) = (a / r, b / r);
            self.lower[k] = r;
            for row in i + 2..=left {
                let k = (from + row) * n + from + i;
                let (a, b) = (self.lower[k], self.lower[k + 1]);
                (self.lower[k], self.lower[k + 1]) = (c * a + s * b, c * b - s * a);
            }
            self.frame.turn(from + i, c, s);
        }
        self.frame.pop();
        self.pushed = left;
    }

    /// Scales a row to norm one, pointing out of its bound, into `self.row`. Returns the distance of the point from the
    /// bound, positive inside.
    pub(crate) fn outward(&mut self, problem: &Problem, e: &Entry) -> f64 {
        let level = &problem.levels[e.level];
        let scale = e.side / self.rows.norm[self.rows.at(e.level, e.row)];
        scaled(scale, &level.padded()[e.row * self.stride..(e.row + 1) * self.stride], &mut self.row);
        let bound = if e.side > 0.0 { level.upper[e.row] } else { level.lower[e.row] };
        self.largest = scale.abs() * self.rows.largest[e.level];
        scale * bound - dot(&self.row, &self.frame.x)
    }

    /// Removes the frame's components from the row that `outward` prepared. Returns the norm of the remainder, 0 if the
    /// row depends on the frame. The frame stores the coefficients.
    pub(crate) fn project(&mut self) -> f64 {
        let (left, error) = self.frame.project(&mut self.row, 1.0, self.largest);
        self.error = error;
        if self.frame.is_full() { 0.0 } else { left }
    }

    /// Adds the active row that `project` prepared to the frame, and moves the point to its bound.
    pub(crate) fn fix(&mut self, left: f64, room: f64) {
        let (k, n) = (self.frame.len(), self.n);
        let from = self.mark[self.stage];
        self.lower[k * n + from..k * n + k].copy_from_slice(&self.frame.coefficient[from..k]);
        self.lower[k * n + k] = left;
        self.frame.push(&self.row, left, self.error, room / left);
        self.pushed += 1;
    }

    /// Brings the frame to just before the minimisation of stage `s`. Held rows that have become dependent leave the
    /// working set.
    pub(crate) fn advance(&mut self, problem: &Problem, s: usize) {
        loop {
            while self.pushed < self.working_set.active[self.stage].len() {
                let e = self.working_set.active[self.stage][self.pushed];
                let room = self.outward(problem, &e);
                let left = self.project();
                if left > 0.0 {
                    self.fix(left, room);
                } else {
                    self.working_set.active[self.stage].remove(self.pushed);
                    let at = self.rows.at(e.level, e.row);
                    self.rows.side[at] = 0;
                }
            }
            if self.stage == s {
                return;
            }
            let l = self.stage;
            self.minimise(problem, l);
            if self.presses[l] && self.is_close(l) {
                let from = self.mark[l];
                let start = &self.start[l * self.stride..(l + 1) * self.stride];
                self.frame.cut(from + self.pushed, from, start);
                self.group.thorough = true;
                self.minimise(problem, l);
                self.group.thorough = false;
                self.weigh(problem, l);
            }
            self.stage = l + 1;
            self.pushed = 0;
            self.mark[self.stage] = self.frame.len();
            self.start[self.stage * self.stride..(self.stage + 1) * self.stride].copy_from_slice(&self.frame.x);
        }
    }

    /// Minimises level `l` within the frame, see [`Group::minimise`], and computes the trial multipliers of the rows
    /// held against it.
    fn minimise(&mut self, problem: &Problem, l: usize) {
        let span = l * self.stride..(l + 1) * self.stride;
        self.presses[l] = self.group.minimise(
            &problem.levels[l],
            self.rows.norms(l),
            &self.working_set.equal[l],
            &mut self.working_set.own[l],
            &mut self.frame,
            &mut self.gradient[span],
        );
        self.noise[l] = self.group.noise;
        self.balance(l);
    }

    /// Returns true if a row held against level `l` has a multiplier so small that `weigh` has to examine it.
    fn is_close(&self, l: usize) -> bool {
        let (n, from) = (self.n, self.mark[l]);
        self.working_set.active[l].iter().enumerate().any(|(j, e)| {
            let diagonal = self.lower[(from + j) * n + from + j];
            e.trial.abs() > e.noise && e.trial.abs() <= self.group.slight / diagonal
        })
    }

    /// Computes the trial multipliers of the rows held against stage `s` from its gradient.
    fn balance(&mut self, s: usize) {
        let active = &mut self.working_set.active[s];
        let gradient = &self.gradient[s * self.stride..(s + 1) * self.stride];
        if !self.presses[s] {
            active.iter_mut().for_each(|e| (e.trial, e.noise) = (0.0, 0.0));
            return;
        }
        let (n, from, w) = (self.n, self.mark[s], active.len());
        for j in (0..w).rev() {
            let mut sum = -dot(self.frame.row(from + j), gradient);
            for (i, e) in active.iter().enumerate().skip(j + 1) {
                sum -= self.lower[(from + i) * n + from + j] * e.trial;
            }
            active[j].trial = sum / self.lower[(from + j) * n + from + j];
            active[j].noise = self.noise[s] / self.lower[(from + j) * n + from + j];
        }
    }

    /// Decides whether rows with a tiny multiplier hold level `l` back: only if the level moves on the release of the
    /// row, by at least the threshold of an independent row. Ranks and forces share one threshold: otherwise a level
    /// could release a row and then follow the direction to where the row forbids it.
    fn weigh(&mut self, problem: &Problem, l: usize) {
        let (n, from) = (self.n, self.mark[l]);
        let w = self.working_set.active[l].len();
        for j in 0..w {
            let diagonal = self.lower[(from + j) * n + from + j];
            let e = self.working_set.active[l][j];
            if e.trial.abs() <= e.noise || e.trial.abs() > self.group.slight / diagonal {
                continue;
            }
            // L c = -e_j: row j moves inwards by one, the others stay.
            self.row.fill(0.0);
            for i in j..w {
                let mut sum = if i == j { -1.0 } else { 0.0 };
                for k in j..i {
                    sum -= self.lower[(from + i) * n + from + k] * self.lets_go[k];
                }
                self.lets_go[i] = sum / self.lower[(from + i) * n + from + i];
                axpy(self.lets_go[i], self.frame.row(from + i), &mut self.row);
            }
            if !self.group.moves(&problem.levels[l], &self.row) {
                self.working_set.active[l][j].noise = self.group.slight / diagonal;
            }
        }
    }

    /// Completes the frame up to and including the last stage.
    pub(crate) fn complete(&mut self, problem: &Problem) {
        let last = self.levels;
        self.advance(problem, last);
        if self.working_set.active[last].is_empty() {
            return;
        }
        let span = last * self.stride..(last + 1) * self.stride;
        for ((g, x), r) in self.gradient[span].iter_mut().zip(&self.frame.x).zip(&self.reference) {
            *g = x - r;
        }
        self.presses[last] = true;
        self.noise[last] = NOISE * (norm(&self.frame.x) + norm(&self.reference));
        self.balance(last);
    }

    /// Replaces the multipliers from stage `s` on by the trial multipliers.
    pub(crate) fn accept(&mut self, s: usize) {
        let own = self.working_set.own[s.min(self.levels)..].iter_mut();
        for e in own.chain(&mut self.working_set.active[s..]).flatten() {
            e.value = e.trial;
        }
    }

    /// Returns the dimension of the space that level `l` and those above leave.
    pub(crate) fn freedom(&self, l: usize) -> usize {
        self.n - self.mark[l + 1]
    }
}
