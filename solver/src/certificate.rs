//! A proof of optimality that does not depend on how a point was found.
//!
//! A point is lexicographically optimal if and only if, for every level, the descent direction of that level's cost is
//! a combination of the normals of the rows of higher levels that are fixed there (equalities, violated rows: any sign)
//! or at a bound (the sign that pushes inwards). Rows at a bound that hold a higher level back count as fixed from
//! there on: that level's balance, times any number, may be added to those of the levels below. The fixed rows are
//! projected out, and the multipliers of the other rows are computed by non-negative least squares; the remainder is
//! the residual.

use crate::dense::{Matrix, axpy, dot, norm};
use crate::nnls::Nnls;
use crate::problem::{Level, Problem, nothing};

/// Distance up to which a row is at its bound, in units of x (row scaled to norm one).
const AT_BOUND: f64 = 1e-8;

/// Maximum residual of a proven point; rounding of the largest row's value is added.
const PROVEN: f64 = 1e-7;
const ROUNDING: f64 = 1e-14;

/// A row depends on the fixed rows if less than this, relative to its norm, lies outside of them.
const INDEPENDENT: f64 = 1e-12;

/// A multiplier below this, relative to the gradient that it balances, may be rounding.
const SURE: f64 = 1e-13;

/// Returns the largest relative stationarity residual at `x` (`n` long) over all levels and the final nearest-point
/// stage; 0 means exactly optimal, 1 is the order of "not at all". Infinite if `x` is not finite or has another length,
/// or if a hard level is violated. A damped level counts with its damping, and ends the proof: it leaves nothing to
/// choose. Rows of 1e-14 of the largest row of the problem, or less, are zero.
///
/// The residual of each level is relative to the largest row of the level, `sqrt(w) |a|`, times one plus its violation;
/// the final one is relative to `1 + |x - reference|`.
pub fn certificate(problem: &Problem, x: &[f64]) -> f64 {
    Certifier::new(problem).look(problem, Claim::Optimum(problem.levels.len()), x).residual
}

/// The property of a point that is to be proven.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Claim {
    /// The point is the optimum of this many levels.
    Optimum(usize),
    /// The point is the best compromise of this hard level, which cannot be met, below the levels above it.
    Compromise(usize),
}

/// Distance of a point from the claimed property.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Look {
    /// The residual of [`certificate`].
    pub(crate) residual: f64,
    /// The level with the largest residual; the number of levels for the choice of the nearest point.
    pub(crate) level: usize,
    /// The largest row that was examined, `sqrt(w) |a|`.
    pub(crate) largest: f64,
}

impl Look {
    /// Returns true if the residual at `x` proves the claim.
    pub(crate) fn proves(&self, x: &[f64]) -> bool {
        self.residual <= PROVEN + ROUNDING * size_of(x) * self.largest.max(1.0)
    }
}

/// Certifier of points of problems of one shape, with its storage.
#[derive(Clone, Debug)]
pub(crate) struct Certifier {
    n: usize,
    /// Orthonormal frame of the fixed rows.
    fixed: Matrix,
    /// Directions that a row at its bound forbids: the part of its normal outside the fixed rows, of unit length.
    normals: Matrix,
    /// Number of fixed rows that were removed from each normal.
    taken: Vec<usize>,
    nnls: Nnls,
    descent: Vec<f64>,
    /// Scratch vector.
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

    /// Examines a point, as if the levels that the claim leaves out did not exist. Does not allocate if the problem has
    /// the shape that the certifier was created for.
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

    /// Returns the part of the descent direction that is not balanced. Rows at a bound that balance more of it than
    /// this residual plus `least` are fixed from now on.
    fn balance(&mut self, least: f64) -> f64 {
        let Certifier { fixed, normals, taken, nnls, descent, rest, .. } = self;
        for (j, taken) in taken.iter_mut().enumerate() {
            let normal = normals.row_mut(j);
            // A normal that depends on the fixed rows forbids nothing more, from now on.
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

    /// Adds the directions that row `i` of a level forbids at `x`. The row must not be zero.
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

/// Removes the components of the fixed rows, from the given one on, from `v`. Returns the norm of the remainder.
fn outside(fixed: &Matrix, from: usize, v: &mut [f64]) -> f64 {
    // Two passes suffice to remove rounding.
    for k in (from..fixed.rows).chain(from..fixed.rows) {
        let part = dot(fixed.row(k), v);
        axpy(-part, fixed.row(k), v);
    }
    norm(v)
}

/// Scales `v` of norm `size` to length one; returns false if it counts as zero.
fn scaled(size: f64, v: &mut [f64]) -> bool {
    let any = size > INDEPENDENT;
    if any {
        v.iter_mut().for_each(|v| *v /= size);
    }
    any
}

/// Fixes a row of unit length; `row` is overwritten by its part outside the fixed rows.
fn fix(fixed: &mut Matrix, row: &mut [f64]) {
    if scaled(outside(fixed, 0, row), row) {
        fixed.push(row);
    }
}

/// Returns the distance of a row of norm `size` from its interval, in units of x.
fn distance(slack: f64, size: f64) -> f64 {
    slack.abs() / if size > 0.0 { size } else { 1.0 }
}

fn size_of(x: &[f64]) -> f64 {
    1.0 + norm(x)
}
