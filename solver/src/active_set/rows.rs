//! What a tick's rows are: their size, their kind, and which of them are in the working set.

use super::kernels::dot;
use crate::problem::{Level, Problem, ProblemError, check};
use crate::space::{FEASIBLE, Kind};

#[derive(Clone, Debug)]
pub(crate) struct Rows {
    /// Where each level's rows begin in the vectors below; one more at the end.
    pub(crate) first: Vec<usize>,
    /// Norms; 1 for a zero row.
    pub(crate) norm: Vec<f64>,
    pub(crate) kind: Vec<Kind>,
    /// For inequality rows: 0 outside the working set, else the side of the bound it is held at.
    pub(crate) side: Vec<i8>,
    /// Values at the point that was looked at last.
    pub(crate) value: Vec<f64>,
}

impl Rows {
    pub(crate) fn new(problem: &Problem) -> Self {
        let mut first = vec![0];
        let mut total = 0;
        for level in &problem.levels {
            total += level.rows();
            first.push(total);
        }
        Rows {
            first,
            norm: vec![1.0; total],
            kind: vec![Kind::Silent; total],
            side: vec![0; total],
            value: vec![0.0; total],
        }
    }

    /// Looks at every number once.
    #[inline(always)]
    pub(crate) fn read(&mut self, problem: &Problem) -> Result<(), ProblemError> {
        let mut good = problem.reference.iter().all(|r| r.is_finite());
        for (l, level) in problem.levels.iter().enumerate() {
            good &= level.damping.is_finite() && level.damping >= 0.0;
            let stride = level.stride();
            let rows = level.padded().chunks_exact(stride.max(1));
            let bounds = level.lower.iter().zip(&level.upper).zip(&level.weight);
            let out = self.norm[self.first[l]..].iter_mut().zip(&mut self.kind[self.first[l]..]);
            for ((row, ((&lower, &upper), &weight)), (norm, kind)) in rows.zip(bounds).zip(out) {
                let square = dot(row, row);
                *norm = if square > 1e-200 && square < 1e200 { square.sqrt() } else { unusual(row) };
                // Comparisons with NaN are false.
                good &= *norm < f64::INFINITY
                    && lower <= upper
                    && lower < f64::INFINITY
                    && upper > f64::NEG_INFINITY
                    && (0.0..f64::INFINITY).contains(&weight);
                *kind = if (lower == f64::NEG_INFINITY && upper == f64::INFINITY) || (weight == 0.0 && !level.hard) {
                    Kind::Silent
                } else if lower == upper {
                    Kind::Equality
                } else {
                    Kind::Inequality
                };
            }
        }
        if good { Ok(()) } else { check(problem) }
    }

    /// Index of row `i` of level `l` in the vectors.
    #[inline(always)]
    pub(crate) fn at(&self, l: usize, i: usize) -> usize {
        self.first[l] + i
    }
}

/// The norm of a row whose square is no ordinary number; 1 for a zero row.
#[cold]
fn unusual(row: &[f64]) -> f64 {
    if row.iter().any(|a| a.is_nan()) {
        return f64::NAN;
    }
    let norm = crate::dense::norm(row);
    if norm == 0.0 { 1.0 } else { norm }
}

/// The weight of row `i`: hard rows all count the same.
#[inline(always)]
pub(crate) fn weight(level: &Level, i: usize) -> f64 {
    if level.hard { 1.0 } else { level.weight[i] }
}

/// How far beyond its bound a row of norm one may be and still count as within; `far` is the
/// size of x.
#[inline(always)]
pub(crate) fn tolerance(bound: f64, far: f64) -> f64 {
    FEASIBLE * (1.0 + bound.abs()) + 1e-14 * far
}
