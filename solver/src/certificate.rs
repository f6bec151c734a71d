//! A proof of optimality that knows nothing of how a point was found.
//!
//! A point is lexicographically optimal exactly when, for every level, the descent direction of
//! that level's cost is a combination of the normals of the rows of higher levels that are fixed
//! there (equalities, violated rows: any sign) or at a bound (the sign that pushes inwards). Rows at a bound that hold a higher
//! level back count as fixed from there on: that level's balance, times any number, may be added to those of the levels below.
//! What is fixed is projected out, and the multipliers of the other rows are found by non-negative least squares; what is left
//! over is the residual.

use crate::dense::{Matrix, axpy, dot, norm};
use crate::nnls::Nnls;
use crate::problem::{Level, Problem, nothing};

/// Distances up to this, in units of x (row scaled to norm one), are read as "at the bound".
const AT_BOUND: f64 = 1e-8;

/// The residual that a point may have and still be proven; rounding of the largest row's value comes on top.
const PROVEN: f64 = 1e-7;
const ROUNDING: f64 = 1e-14;

/// A row of which less lies outside the rows that are fixed, relative to its norm, depends on them.
const INDEPENDENT: f64 = 1e-12;

/// A multiplier below this, relative to the gradient that it balances, may be rounding.
const SURE: f64 = 1e-13;

/// The largest relative stationarity residual over all levels and the final nearest-point stage
/// at `x` (`n` long); 0 means exactly optimal, 1 is the order of "not at all". Infinite if `x`
/// is not finite or has another length, or if a hard level is violated. A damped level counts
/// with its damping, and ends the proof: it leaves nothing to choose. Rows of 1e-14 of the largest row of the problem are zero.
///
/// Each level's residual is measured against the largest row of the level, `sqrt(w) |a|`, times
/// one plus its violation; the final one against `1 + |x - reference|`.
pub fn certificate(problem: &Problem, x: &[f64]) -> f64 {
    Certifier::new(problem).look(problem, Claim::Optimum(problem.levels.len()), x).residual
}

/// What a point is said to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Claim {
    /// The optimum of so many levels.
    Optimum(usize),
    /// The best that this hard level, which cannot be met, can get below the levels above it.
    Compromise(usize),
}

/// How far a point is from what it is said to be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Look {
    /// The residual of [`certificate`].
    pub(crate) residual: f64,
    /// The level that is farthest off; the number of levels for the choice of the nearest point.
    pub(crate) level: usize,
    /// The largest row that was looked at, `sqrt(w) |a|`.
    pub(crate) largest: f64,
}

impl Look {
    /// Whether it proves what was said of the point.
    pub(crate) fn proves(&self, x: &[f64]) -> bool {
        self.residual <= PROVEN + ROUNDING * size_of(x) * self.largest.max(1.0)
    }
}

/// What certifies points of problems of one shape, with its storage.
#[derive(Clone, Debug)]
pub(crate) struct Certifier {
    n: usize,
    /// An orthonormal frame of the rows that are fixed.
    fixed: Matrix,
    /// Directions along which a row at its bound forbids to go: what of its normal lies outside the rows that are fixed, of unit
    /// length.
    normals: Matrix,
    /// So many of the rows that are fixed were taken out of each normal.
    taken: Vec<usize>,
    nnls: Nnls,
    descent: Vec<f64>,
    /// A vector at hand.
    rest: Vec<f64>,
}

impl Certifier {
    pub(crate) fn new(problem: &Problem) -> Self {
        let n = problem.n;
        let rows = problem.levels.iter().map(Level::rows).sum();
        Certifier {
            n,
            fixed: Matrix::with_room(n, n),
            normals: Matrix::with_room(rows, n),
            taken: Vec::with_capacity(rows),
            nnls: Nnls::new(n, rows),
            descent: vec![0.0; n],
            rest: vec![0.0; n],
        }
    }

    /// Looks at a point, as if the levels that the claim leaves out did not exist. Allocates nothing if the problem has the shape of
    /// the one that the certifier was made for.
    pub(crate) fn look(&mut self, problem: &Problem, claim: Claim, x: &[f64]) -> Look {
        let mut worst = Look { residual: 0.0, level: problem.levels.len(), largest: 0.0 };
        if x.len() != self.n || x.iter().any(|x| !x.is_finite()) {
            worst.residual = f64::INFINITY;
            return worst;
        }
        self.fixed.clear();
        self.normals.clear();
        self.taken.clear();
        let norms = problem.levels.iter().flat_map(|level| (0..level.rows()).map(|i| norm(level.row(i))));
        let nothing = nothing(norms.fold(0.0, f64::max));
        let levels = match claim {
            Claim::Optimum(levels) => levels,
            Claim::Compromise(level) => level + 1,
        };
        for (l, level) in problem.levels[..levels].iter().enumerate() {
            self.descent.fill(0.0);
            let mut largest = level.damping.sqrt();
            let mut square = 0.0;
            for i in 0..level.rows() {
                let w = if level.hard { 1.0 } else { level.weight[i] };
                let (slack, mut size) = (level.slack(i, x), norm(level.row(i)));
                if size > nothing {
                    axpy(-w * slack, level.row(i), &mut self.descent);
                } else {
                    size = 0.0;
                }
                largest = largest.max(w.sqrt() * size);
                square += w * slack * slack;
                if level.hard && claim != Claim::Compromise(l) && distance(slack, size) > AT_BOUND * size_of(x) {
                    return Look { residual: f64::INFINITY, level: l, ..worst };
                }
            }
            axpy(-level.damping, x, &mut self.descent);
            square += level.damping * dot(x, x);
            worst.largest = worst.largest.max(largest);
            if largest > 0.0 {
                let scale = largest * (1.0 + square.sqrt());
                let residual = self.balance(SURE * scale) / scale;
                if residual > worst.residual || residual.is_nan() {
                    worst = Look { residual, level: l, ..worst };
                }
            }
            if level.damping > 0.0 || claim == Claim::Compromise(l) {
                return worst;
            }
            for i in 0..level.rows() {
                if norm(level.row(i)) > nothing && (level.weight[i] > 0.0 || level.hard) {
                    self.add(level, i, x);
                }
            }
        }
        for (d, (r, x)) in self.descent.iter_mut().zip(problem.reference.iter().zip(x)) {
            *d = r - x;
        }
        let far = norm(&self.descent);
        let residual = self.balance(0.0) / (1.0 + far);
        if residual > worst.residual || residual.is_nan() {
            worst = Look { residual, level: problem.levels.len(), ..worst };
        }
        worst
    }

    /// How much of the descent direction is not balanced. Rows at a bound that balance more of it than `least`, and than what is
    /// left over, are fixed from now on.
    fn balance(&mut self, least: f64) -> f64 {
        let Certifier { fixed, normals, taken, nnls, descent, rest, .. } = self;
        for (j, taken) in taken.iter_mut().enumerate() {
            let normal = normals.row_mut(j);
            // One that depends on what is fixed is none, from now on.
            if !scaled(outside(fixed, *taken, normal), normal) {
                normal.fill(0.0);
            }
            *taken = fixed.rows;
        }
        outside(fixed, 0, descent);
        let residual = nnls.solve(normals, descent);
        for (j, u) in nnls.u.iter().enumerate() {
            if *u > residual + least {
                rest.copy_from_slice(normals.row(j));
                fix(fixed, rest);
            }
        }
        residual
    }

    /// Adds the directions that row `i` of a level forbids at `x`. The row is not zero.
    fn add(&mut self, level: &Level, i: usize, x: &[f64]) {
        let (row, slack, lower, upper) = (level.row(i), level.slack(i, x), level.lower[i], level.upper[i]);
        let size = norm(row);
        let value = dot(row, x);
        let near = |bound: f64| (value - bound).abs() <= AT_BOUND * size * size_of(x);
        let (at_lower, at_upper) = (near(lower), near(upper));
        let is_fixed = lower == upper || distance(slack, size) > AT_BOUND * size_of(x) || (at_lower && at_upper);
        let sign = if is_fixed || at_upper { 1.0 } else { -1.0 };
        self.rest.iter_mut().zip(row).for_each(|(r, a)| *r = sign * a / size);
        if is_fixed {
            fix(&mut self.fixed, &mut self.rest);
        } else if at_lower || at_upper {
            self.normals.push(&self.rest);
            self.taken.push(0);
        }
    }
}

/// Takes what the rows that are fixed, from the given one on, have of `v` out of it; returns the norm of what is left.
fn outside(fixed: &Matrix, from: usize, v: &mut [f64]) -> f64 {
    // Twice is enough.
    for k in (from..fixed.rows).chain(from..fixed.rows) {
        let part = dot(fixed.row(k), v);
        axpy(-part, fixed.row(k), v);
    }
    norm(v)
}

/// Scales `v` of this norm to length one; false if it is nothing.
fn scaled(size: f64, v: &mut [f64]) -> bool {
    let any = size > INDEPENDENT;
    if any {
        v.iter_mut().for_each(|v| *v /= size);
    }
    any
}

/// Fixes a row of unit length; `row` is what of it is new.
fn fix(fixed: &mut Matrix, row: &mut [f64]) {
    if scaled(outside(fixed, 0, row), row) {
        fixed.push(row);
    }
}

/// How far a row of norm `size` is from its interval, in units of x.
fn distance(slack: f64, size: f64) -> f64 {
    slack.abs() / if size > 0.0 { size } else { 1.0 }
}

fn size_of(x: &[f64]) -> f64 {
    1.0 + norm(x)
}
