//! Properties of a tick's rows: norm, kind, and membership in the working set.

use super::kernels::{LANES, dot};
use crate::feasible_set::{FEASIBLE, Kind};
use crate::problem::{Level, Problem, ProblemError, check, nothing};
use crate::structure::{Structure, usable};

/// Norms of a level's rows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Norms<'r> {
    /// Norm of each row; 1 for a zero row.
    pub(crate) each: &'r [f64],
    /// The largest of them.
    pub(crate) largest: f64,
}

#[derive(Clone, Debug)]
pub(crate) struct Rows {
    /// Index of each level's first row in the vectors below; the total number of rows at the end.
    pub(crate) first: Vec<usize>,
    /// Norms; 1 for a zero row, which is silent: its value is the same at every point.
    pub(crate) norm: Vec<f64>,
    pub(crate) kind: Vec<Kind>,
    /// The largest norm of each level; 1 if all rows are zero.
    pub(crate) largest: Vec<f64>,
    /// For inequality rows: 0 outside the working set, else the side of the bound at which the row is held.
    pub(crate) side: Vec<i8>,
    /// Values at the last evaluated point; not valid for bounds of one variable.
    pub(crate) value: Vec<f64>,
    /// Interval of each variable in which it meets all bounds that a level sets on it alone, including their tolerance;
    /// `stride` numbers per level.
    low: Vec<f64>,
    high: Vec<f64>,
    stride: usize,
}

impl Rows {
    pub(crate) fn new(problem: &Problem) -> Self {
        let mut first = vec![0];
        let mut total = 0;
        for level in &problem.levels {
            total += level.rows();
            first.push(total);
        }
        let stride = problem.n.div_ceil(LANES) * LANES;
        Rows {
            low: vec![f64::NEG_INFINITY; stride * problem.levels.len()],
            high: vec![f64::INFINITY; stride * problem.levels.len()],
            stride,
            first,
            norm: vec![1.0; total],
            kind: vec![Kind::Silent; total],
            largest: vec![1.0; problem.levels.len()],
            side: vec![0; total],
            value: vec![0.0; total],
        }
    }

    /// Reads and checks the numbers of the problem; coefficients of known structure are not read again.
    #[inline(always)]
    pub(crate) fn read(&mut self, problem: &Problem) -> Result<(), ProblemError> {
        let mut good = problem.reference.iter().all(|r| r.is_finite());
        for (l, level) in problem.levels.iter().enumerate() {
            good &= level.damping.is_finite() && level.damping >= 0.0;
            good &= if level.is_open() { self.read_open(l, level) } else { self.read_known(l, level) };
        }
        if !good {
            return check(problem);
        }
        for (largest, span) in self.largest.iter_mut().zip(self.first.windows(2)) {
            *largest = self.norm[span[0]..span[1]].iter().fold(0.0, |most: f64, norm| most.max(*norm));
        }
        let nothing = nothing(self.largest.iter().fold(0.0, |most: f64, largest| most.max(*largest)));
        self.largest.iter_mut().filter(|l| **l <= nothing).for_each(|l| *l = 1.0);
        for (norm, kind) in self.norm.iter_mut().zip(&mut self.kind) {
            if *norm <= nothing {
                (*norm, *kind) = (1.0, Kind::Silent);
            }
        }
        Ok(())
    }

    /// Reads a level without any known structure.
    #[inline(always)]
    fn read_open(&mut self, l: usize, level: &Level) -> bool {
        let mut good = true;
        let rows = level.padded().chunks_exact(level.stride().max(1));
        let bounds = level.lower.iter().zip(&level.upper).zip(&level.weight);
        let out = self.norm[self.first[l]..].iter_mut().zip(&mut self.kind[self.first[l]..]);
        for ((row, ((&lower, &upper), &weight)), (norm, kind)) in rows.zip(bounds).zip(out) {
            let square = dot(row, row);
            *norm = if usable(square) { square.sqrt() } else { unusual(row) };
            good &= sound(*norm, lower, upper, weight);
            *kind = kind_of(level, lower, upper, weight);
        }
        good
    }

    /// Reads a level in which the structure of at least one row is known.
    #[inline(always)]
    fn read_known(&mut self, l: usize, level: &Level) -> bool {
        let mut good = true;
        let stride = level.stride();
        let span = l * self.stride..(l + 1) * self.stride;
        let (low, high) = (&mut self.low[span.clone()], &mut self.high[span]);
        low.fill(f64::NEG_INFINITY);
        high.fill(f64::INFINITY);
        for (i, structure) in level.structure().iter().enumerate() {
            let (lower, upper, weight) = (level.lower[i], level.upper[i], level.weight[i]);
            let kind = kind_of(level, lower, upper, weight);
            let norm = match *structure {
                Structure::Open => {
                    let row = &level.padded()[i * stride..(i + 1) * stride];
                    let square = dot(row, row);
                    if usable(square) { square.sqrt() } else { unusual(row) }
                }
                Structure::Constant { norm } => norm,
                Structure::Bound { column, coefficient } => {
                    if kind == Kind::Inequality {
                        let (a, b) = if coefficient == 1.0 {
                            (lower, upper)
                        } else if coefficient > 0.0 {
                            (lower / coefficient, upper / coefficient)
                        } else {
                            (upper / coefficient, lower / coefficient)
                        };
                        low[column] = low[column].max(a - tolerance(a, 0.0));
                        high[column] = high[column].min(b + tolerance(b, 0.0));
                    }
                    coefficient.abs()
                }
                Structure::Absent => 0.0,
            };
            good &= sound(norm, lower, upper, weight);
            self.norm[self.first[l] + i] = norm;
            self.kind[self.first[l] + i] = kind;
        }
        good
    }

    /// Returns true if a point meets all bounds that level `l` sets on single variables.
    #[inline(always)]
    pub(crate) fn within(&self, l: usize, x: &[f64]) -> bool {
        let span = l * self.stride..(l + 1) * self.stride;
        let bounds = self.low[span.clone()].iter().zip(&self.high[span]);
        x.iter().zip(bounds).fold(true, |all, (x, (low, high))| all & (low <= x) & (x <= high))
    }

    /// Returns the norms of level `l`.
    #[inline(always)]
    pub(crate) fn norms(&self, l: usize) -> Norms<'_> {
        Norms { each: &self.norm[self.first[l]..self.first[l + 1]], largest: self.largest[l] }
    }

    /// Returns the index of row `i` of level `l` in the vectors.
    #[inline(always)]
    pub(crate) fn at(&self, l: usize, i: usize) -> usize {
        self.first[l] + i
    }
}

/// Returns true if the numbers of a row are usable. Comparisons with NaN are false.
#[inline(always)]
fn sound(norm: f64, lower: f64, upper: f64, weight: f64) -> bool {
    norm < f64::INFINITY
        && lower <= upper
        && lower < f64::INFINITY
        && upper > f64::NEG_INFINITY
        && (0.0..f64::INFINITY).contains(&weight)
}

#[inline(always)]
fn kind_of(level: &Level, lower: f64, upper: f64, weight: f64) -> Kind {
    if (lower == f64::NEG_INFINITY && upper == f64::INFINITY) || (weight == 0.0 && !level.hard) {
        Kind::Silent
    } else if lower == upper {
        Kind::Equality
    } else {
        Kind::Inequality
    }
}

/// Computes the norm of a row whose square is not usable.
#[cold]
fn unusual(row: &[f64]) -> f64 {
    if row.iter().any(|a| a.is_nan()) { f64::NAN } else { crate::dense::norm(row) }
}

/// Returns the weight of row `i`; all rows of a hard level have weight 1.
#[inline(always)]
pub(crate) fn weight(level: &Level, i: usize) -> f64 {
    if level.hard { 1.0 } else { level.weight[i] }
}

/// Returns the distance beyond its bound up to which a row of norm one counts as within; `far` is the norm of x.
#[inline(always)]
pub(crate) fn tolerance(bound: f64, far: f64) -> f64 {
    FEASIBLE * (1.0 + bound.abs()) + 1e-14 * far
}
