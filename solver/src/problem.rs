//! The input of a solver: levels of weighted, two-sided linear rows, from the highest priority to the lowest.
//!
//! [`Problem::new`] creates all storage; filling it at every tick does not allocate.

use std::ops::Range;

use crate::structure::{self, Structure};

/// The stored length of a row is a multiple of this, so that the inner loops vectorise.
pub(crate) const LANES: usize = 8;

/// Properties of a level that are known before its numbers: its size, and the treatment of its rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelShape {
    /// Number of rows. Rows that a tick does not use stay at zero with infinite bounds.
    pub rows: usize,
    /// True for no slack: if the level cannot be met together with all above it, the solve reports it.
    pub hard: bool,
    /// delta >= 0, adds `delta * |x|^2` to the cost of this level; 0 for a strict level.
    pub damping: f64,
}

/// A hierarchical least-squares problem in `n` variables.
///
/// Level `k` minimises the weighted sum of squared distances of its rows from their intervals,
/// `sum_i w_i dist(a_i x, [lower_i, upper_i])^2 + damping |x|^2`, among the minimisers of all levels above; the freedom
/// that is left after the last level is settled by the point nearest to `reference`. A row whose norm is 1e-14 of the
/// largest row's, or less, counts as a row of zeros. Source: thesis (2.21)-(2.23) with strict priorities (see the
/// documentation of the crate).
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// Number of variables (joint velocities, usually).
    pub n: usize,
    /// Levels, from the highest priority to the lowest.
    pub levels: Vec<Level>,
    /// The preferred point in the directions that no level decides; `n` long, initially 0.
    pub reference: Vec<f64>,
}

impl Problem {
    /// Creates a problem of `n` variables with all storage; every level is clear (see [`Level::clear`]) and the
    /// reference is zero.
    pub fn new(n: usize, shapes: &[LevelShape]) -> Self {
        Problem { n, levels: shapes.iter().map(|s| Level::new(n, *s)).collect(), reference: vec![0.0; n] }
    }
}

/// The rows of one priority: `lower <= A x <= upper`, each row with a weight.
///
/// A row with `lower == upper` is an equality; an infinite bound means that the side does not exist. The three public
/// vectors are `rows()` long and must stay so.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    rows: usize,
    n: usize,
    stride: usize,
    /// True for no slack. The weights are ignored then.
    pub hard: bool,
    /// delta >= 0: adds `delta * |x|^2` to this level's own cost. In a solver of exact hierarchies a damped level
    /// therefore fixes `x` completely, and no level below it has any freedom left; [`crate::Smooth`] passes on the
    /// values that its rows reached.
    pub damping: f64,
    /// Row-major, `stride` numbers per row of which the first `n` are used; the padding stays 0.
    a: Vec<f64>,
    /// Lower bounds, in the unit of the row times the unit of `x`; `-inf` for none.
    pub lower: Vec<f64>,
    /// Upper bounds; `inf` for none.
    pub upper: Vec<f64>,
    /// Weights of the squared distances, >= 0. A row of weight 0 has no effect in a soft level.
    pub weight: Vec<f64>,
    /// Known structure of each row's coefficients.
    structure: Vec<Structure>,
    /// Number of rows with a known structure.
    fixed: usize,
    /// Bound of the row's second derivatives for each row and variable, `n` numbers per row; empty for linear rows.
    curvature: Vec<f64>,
}

/// A row whose norm is this fraction of the largest of its problem, or less, is a row of zeros with rounding.
const NOTHING: f64 = 1e-14;

/// Returns the norm up to which a row counts as zero, if the largest row of its problem has norm `largest`.
pub(crate) fn nothing(largest: f64) -> f64 {
    NOTHING * largest
}

impl Level {
    /// Creates a clear level of the given shape for `n` variables.
    pub fn new(n: usize, shape: LevelShape) -> Self {
        let stride = n.div_ceil(LANES) * LANES;
        Level {
            rows: shape.rows,
            n,
            stride,
            hard: shape.hard,
            damping: shape.damping,
            a: vec![0.0; stride * shape.rows],
            lower: vec![f64::NEG_INFINITY; shape.rows],
            upper: vec![f64::INFINITY; shape.rows],
            weight: vec![1.0; shape.rows],
            structure: vec![Structure::Open; shape.rows],
            fixed: 0,
            curvature: Vec::new(),
        }
    }

    /// Sets the curvature of the rows: for each row and variable `c_ij >= 0`, `n` numbers per row, a time times the sum
    /// over `k` of `|d^2 a_i x / dx_j dx_k|`. [`crate::Smooth`] damps a level with a `c_ij` above zero if it is not
    /// met; exact solvers ignore it. A vector of another length than `rows() n`, or with a number that is negative or
    /// not finite, is rejected: the rows then count as linear.
    pub fn set_curvature(&mut self, curvature: Vec<f64>) {
        let good = curvature.len() == self.rows * self.n && curvature.iter().all(|c| c.is_finite() && *c >= 0.0);
        self.curvature = if good && curvature.iter().any(|c| *c > 0.0) { curvature } else { Vec::new() };
    }

    /// Returns true if a row has a curvature above zero.
    pub fn is_curved(&self) -> bool {
        !self.curvature.is_empty()
    }

    /// Returns the curvature of row `i` for each variable; empty if no row of the level is curved.
    pub fn curvature(&self, i: usize) -> &[f64] {
        if self.curvature.is_empty() { &[] } else { &self.curvature[i * self.n..(i + 1) * self.n] }
    }

    /// Returns the shape of the level.
    pub fn shape(&self) -> LevelShape {
        LevelShape { rows: self.rows, hard: self.hard, damping: self.damping }
    }

    /// Returns the number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Returns the number of variables.
    pub fn columns(&self) -> usize {
        self.n
    }

    /// Returns the distance, in numbers, between the starts of two rows in [`Level::padded`].
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// Returns row `i` of `A`, `n` long. Panics if `i >= rows()`, as slices do.
    pub fn row(&self, i: usize) -> &[f64] {
        &self.a[i * self.stride..i * self.stride + self.n]
    }

    /// Returns row `i` of `A` for writing; `n` long. Panics if `i >= rows()`, as slices do. The known structure of the
    /// row is discarded.
    pub fn row_mut(&mut self, i: usize) -> &mut [f64] {
        self.set_structure(i, Structure::Open);
        &mut self.a[i * self.stride..i * self.stride + self.n]
    }

    /// Returns the coefficients (row-major, [`Level::stride`] numbers per row), lower and upper bounds of a range of
    /// rows, for writing in place. The padding after the first `n` numbers of a row must stay zero. The known structure
    /// of the rows is discarded.
    pub fn block_mut(&mut self, rows: Range<usize>) -> (&mut [f64], &mut [f64], &mut [f64]) {
        let stride = self.stride;
        if self.fixed > 0 {
            rows.clone().for_each(|i| self.set_structure(i, Structure::Open));
        }
        (&mut self.a[rows.start * stride..rows.end * stride], &mut self.lower[rows.clone()], &mut self.upper[rows])
    }

    /// Returns the lower and upper bounds of a range of rows, for writing in place; the coefficients stay unchanged.
    pub fn bounds_mut(&mut self, rows: Range<usize>) -> (&mut [f64], &mut [f64]) {
        (&mut self.lower[rows.clone()], &mut self.upper[rows])
    }

    /// Declares that the coefficients of a range of rows stay constant, so that solvers need not read them again. Rows
    /// with a single coefficient become bounds of their variable. Writing coefficients ends the declaration.
    pub fn fix(&mut self, rows: Range<usize>) {
        for i in rows {
            self.set_structure(i, structure::of(self.row(i)));
        }
    }

    fn set_structure(&mut self, i: usize, structure: Structure) {
        self.fixed -= usize::from(self.structure[i] != Structure::Open);
        self.fixed += usize::from(structure != Structure::Open);
        self.structure[i] = structure;
    }

    /// Returns true if no row has a known structure.
    pub(crate) fn is_open(&self) -> bool {
        self.fixed == 0
    }

    /// Removes a row from this tick's problem: zero coefficients, no bounds; solvers skip it.
    pub fn leave_out(&mut self, i: usize) {
        self.row_mut(i).fill(0.0);
        (self.lower[i], self.upper[i]) = (f64::NEG_INFINITY, f64::INFINITY);
        self.set_structure(i, Structure::Absent);
    }

    /// Copies another level with as many rows, without allocating. If the other one has fewer variables, the
    /// coefficients of the rest become zero. Panics if it does not fit, as slices do.
    pub fn copy_from(&mut self, other: &Level) {
        (self.hard, self.damping, self.fixed) = (other.hard, other.damping, other.fixed);
        if self.stride == other.stride {
            self.a.copy_from_slice(&other.a);
        } else {
            for i in 0..self.rows {
                let (row, from) = (&mut self.a[i * self.stride..(i + 1) * self.stride], other.row(i));
                row[..from.len()].copy_from_slice(from);
                row[from.len()..].fill(0.0);
            }
        }
        self.lower.copy_from_slice(&other.lower);
        self.upper.copy_from_slice(&other.upper);
        self.weight.copy_from_slice(&other.weight);
        self.structure.copy_from_slice(&other.structure);
    }

    /// Copies the rows of another level with as many variables and no more rows into the first rows of this one,
    /// without allocating. Panics if it does not fit, as slices do.
    pub fn copy_rows_from(&mut self, other: &Level) {
        for i in 0..other.rows {
            self.set_structure(i, other.structure[i]);
        }
        self.a[..other.a.len()].copy_from_slice(&other.a);
        self.lower[..other.rows].copy_from_slice(&other.lower);
        self.upper[..other.rows].copy_from_slice(&other.upper);
        self.weight[..other.rows].copy_from_slice(&other.weight);
    }

    /// Returns the known structure of each row's coefficients.
    pub fn structure(&self) -> &[Structure] {
        &self.structure
    }

    /// Returns the whole matrix `A`, row-major with [`Level::stride`] numbers per row; the padding is 0.
    pub fn padded(&self) -> &[f64] {
        &self.a
    }

    /// Returns the entry of `A` in row `i` and column `j < n`.
    pub fn entry(&self, i: usize, j: usize) -> f64 {
        self.row(i)[j]
    }

    /// Sets rows to zero, bounds to infinity, weights to one: the level has no effect.
    pub fn clear(&mut self) {
        self.a.fill(0.0);
        self.lower.fill(f64::NEG_INFINITY);
        self.upper.fill(f64::INFINITY);
        self.weight.fill(1.0);
        self.structure.fill(Structure::Open);
        self.fixed = 0;
    }

    /// Sets the coefficients (`n` long) and bounds of one row; the weight is unchanged.
    pub fn set(&mut self, i: usize, row: &[f64], lower: f64, upper: f64) {
        self.row_mut(i).copy_from_slice(row);
        self.lower[i] = lower;
        self.upper[i] = upper;
    }

    /// Returns true if row `i` is an equality, `lower == upper`.
    pub fn is_equality(&self, i: usize) -> bool {
        self.lower[i] == self.upper[i]
    }

    /// Returns the signed distance of row `i` from its interval at `x`: `a x` minus its projection.
    pub fn slack(&self, i: usize, x: &[f64]) -> f64 {
        let value: f64 = self.row(i).iter().zip(x).map(|(a, x)| a * x).sum();
        if value < self.lower[i] {
            value - self.lower[i]
        } else if value > self.upper[i] {
            value - self.upper[i]
        } else {
            0.0
        }
    }
}

/// Reason why a problem is unusable, with its location.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ProblemError {
    /// A coefficient is NaN or infinite, or a bound is NaN, or a weight is not finite.
    #[error("level {level}, row {row}: a number is not finite")]
    NotFinite {
        /// The level, from 0.
        level: usize,
        /// The row in it, from 0.
        row: usize,
    },
    /// `lower > upper`, `lower = +inf` or `upper = -inf`: no number lies in the interval.
    #[error("level {level}, row {row}: no number lies between its bounds")]
    EmptyInterval {
        /// The level, from 0.
        level: usize,
        /// The row in it, from 0.
        row: usize,
    },
    /// A weight below zero.
    #[error("level {level}, row {row}: the weight is negative")]
    NegativeWeight {
        /// The level, from 0.
        level: usize,
        /// The row in it, from 0.
        row: usize,
    },
    /// The damping of a level is negative or not finite.
    #[error("level {level}: damping must be finite and not negative")]
    BadDamping {
        /// The level, from 0.
        level: usize,
    },
    /// A level's vectors do not have one entry per row, or it was made for another `n`.
    #[error("level {level}: its size does not fit the problem")]
    WrongSize {
        /// The level, from 0.
        level: usize,
    },
    /// The reference is not `n` finite numbers.
    #[error("the reference is not n finite numbers")]
    BadReference,
}

/// Checks every number of the problem and reports the first that no solver can use. Does not allocate.
///
/// # Errors
/// The first error, from the highest level down; see [`ProblemError`].
pub fn check(problem: &Problem) -> Result<(), ProblemError> {
    let n = problem.n;
    for (l, level) in problem.levels.iter().enumerate() {
        let m = level.rows;
        if level.n != n || [&level.lower, &level.upper, &level.weight].map(Vec::len) != [m; 3] {
            return Err(ProblemError::WrongSize { level: l });
        }
        if !level.damping.is_finite() || level.damping < 0.0 {
            return Err(ProblemError::BadDamping { level: l });
        }
        for i in 0..m {
            check_row(level, l, i)?;
        }
    }
    if problem.reference.len() != n || problem.reference.iter().any(|r| !r.is_finite()) {
        return Err(ProblemError::BadReference);
    }
    Ok(())
}

fn check_row(level: &Level, l: usize, row: usize) -> Result<(), ProblemError> {
    let (lo, up, w) = (level.lower[row], level.upper[row], level.weight[row]);
    let finite = level.row(row).iter().all(|a| a.is_finite());
    if !finite || lo.is_nan() || up.is_nan() || !w.is_finite() {
        return Err(ProblemError::NotFinite { level: l, row });
    }
    if lo > up || lo == f64::INFINITY || up == f64::NEG_INFINITY {
        return Err(ProblemError::EmptyInterval { level: l, row });
    }
    if w < 0.0 {
        return Err(ProblemError::NegativeWeight { level: l, row });
    }
    Ok(())
}
