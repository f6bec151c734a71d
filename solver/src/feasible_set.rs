//! The set that the levels so far leave: an affine set, and inequality rows in it.

use crate::dense::{Matrix, dot, norm};
use crate::problem::{Level, Problem};

/// A violation below this counts as zero, in units of x: relative to the size of the row, and to the bound.
pub(crate) const FEASIBLE: f64 = 1e-11;

/// Level and row of an inequality.
pub(crate) type RowId = (usize, usize);

/// `{ x = x0 + Z y }` with `lower <= A x <= upper`.
#[derive(Clone, Debug)]
pub(crate) struct FeasibleSet {
    /// A point of the set that meets all higher rows; usually the nearest such point to the reference.
    pub(crate) x0: Vec<f64>,
    /// n x k, orthonormal columns.
    pub(crate) z: Matrix,
    /// Higher rows, each of norm one (h x n).
    pub(crate) rows: Matrix,
    pub(crate) lower: Vec<f64>,
    pub(crate) upper: Vec<f64>,
    pub(crate) names: Vec<RowId>,
}

impl FeasibleSet {
    /// Returns the whole space, relative to the reference.
    pub(crate) fn whole(problem: &Problem) -> Self {
        FeasibleSet {
            x0: problem.reference.clone(),
            z: Matrix::identity(problem.n),
            rows: Matrix::zeros(0, problem.n),
            lower: Vec::new(),
            upper: Vec::new(),
            names: Vec::new(),
        }
    }

    /// Returns the dimension of the affine set.
    pub(crate) fn dimension(&self) -> usize {
        self.z.cols
    }

    /// Adds a higher row. If rounding left a bound violated at `x0`, the bound is moved to `x0`, so that the set never
    /// becomes empty.
    pub(crate) fn hold(&mut self, name: RowId, row: &[f64], lower: f64, upper: f64) {
        let value = dot(row, &self.x0);
        self.rows.push(row);
        self.lower.push(lower.min(value));
        self.upper.push(upper.max(value));
        self.names.push(name);
    }
}

/// One level with each row scaled to norm one, the form that the solver works on.
#[derive(Clone, Debug)]
pub(crate) struct UnitLevel {
    /// m x n.
    pub(crate) rows: Matrix,
    pub(crate) lower: Vec<f64>,
    pub(crate) upper: Vec<f64>,
    /// Square root of the weight of the scaled row in the cost: `sqrt(w) |a|`.
    pub(crate) scale: Vec<f64>,
    /// Norm of the row as given; 1 for a zero row, which is not scaled.
    pub(crate) norms: Vec<f64>,
    pub(crate) kind: Vec<Kind>,
    /// Square root of the damping.
    pub(crate) damping: f64,
}

/// Role of a row in the solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Equality,
    Inequality,
    /// No bounds, or no weight.
    Silent,
}

impl UnitLevel {
    /// Scales the rows of a level. Rows whose norm is `nothing` or less are zero.
    pub(crate) fn new(level: &Level, nothing: f64) -> Self {
        let m = level.rows();
        let mut unit = UnitLevel {
            rows: Matrix::zeros(m, level.columns()),
            lower: vec![0.0; m],
            upper: vec![0.0; m],
            scale: vec![0.0; m],
            norms: vec![1.0; m],
            kind: vec![Kind::Silent; m],
            damping: level.damping.sqrt(),
        };
        for i in 0..m {
            let size = norm(level.row(i));
            let size = if size > nothing { size } else { 1.0 };
            if size > nothing {
                for (u, a) in unit.rows.row_mut(i).iter_mut().zip(level.row(i)) {
                    *u = a / size;
                }
            }
            unit.norms[i] = size;
            unit.lower[i] = level.lower[i] / size;
            unit.upper[i] = level.upper[i] / size;
            let weight = if level.hard { 1.0 } else { level.weight[i] };
            unit.scale[i] = weight.sqrt() * size;
            let unbounded = unit.lower[i] == f64::NEG_INFINITY && unit.upper[i] == f64::INFINITY;
            unit.kind[i] = if unbounded || weight == 0.0 {
                Kind::Silent
            } else if level.is_equality(i) {
                Kind::Equality
            } else {
                Kind::Inequality
            };
        }
        unit
    }

    /// Returns the distance up to which row `i` counts as within its interval, in units of x.
    pub(crate) fn tolerance(&self, i: usize) -> f64 {
        tolerance(self.lower[i], self.upper[i])
    }

    /// Returns the signed distance of scaled row `i` from its interval.
    pub(crate) fn slack(&self, i: usize, x: &[f64]) -> f64 {
        let value = dot(self.rows.row(i), x);
        (value - self.upper[i]).max(0.0) + (value - self.lower[i]).min(0.0)
    }

    /// Returns true if `x` already meets every row, so that nothing has to be decided.
    pub(crate) fn is_met(&self, x: &[f64]) -> bool {
        (0..self.kind.len()).all(|i| self.kind[i] == Kind::Silent || self.slack(i, x).abs() <= self.tolerance(i))
    }
}

/// Returns the tolerance of a row with these bounds, see [`FEASIBLE`].
pub(crate) fn tolerance(lower: f64, upper: f64) -> f64 {
    let finite = |b: f64| if b.is_finite() { b.abs() } else { 0.0 };
    FEASIBLE * (1.0 + finite(lower).max(finite(upper)))
}
