//! Multipliers of tied rows, which can only have one value (equalities and violated rows of the levels above), in the
//! balance of a level that presses against them. The solution already contains the multipliers of rows at a bound.

use crate::problem::Problem;
use crate::solution::{Active, Solution};
use crate::structure::Structure;

/// A direction whose square is below this fraction of the largest row's carries no force.
const LOOSE: f64 = 1e-6;

/// Factor of a row's derivative in a gradient: its slack times its weight, or its multiplier. Positive if the row
/// should have a smaller value.
#[derive(Clone, Copy, Debug)]
pub(super) struct Force {
    pub(super) level: usize,
    pub(super) row: usize,
    pub(super) force: f64,
}

/// The tied rows above a level, and the forces that they carry.
pub(super) struct Ties {
    rows: Vec<(usize, usize)>,
    /// Gram matrix of the rows; their products with the gradient, overwritten by the multipliers; the gradient.
    gram: Vec<f64>,
    bears: Vec<f64>,
    gradient: Vec<f64>,
}

impl Ties {
    pub(super) fn new(n: usize, rows: usize) -> Self {
        Ties {
            rows: Vec::with_capacity(rows),
            gram: vec![0.0; rows * rows],
            bears: vec![0.0; rows],
            gradient: vec![0.0; n],
        }
    }

    /// Adds the multipliers of the tied rows to the forces with which level `k` presses: the least `mu` with
    /// `sum_i mu_i a_i + sum_f f a_f = 0`, up to [`LOOSE`] if rows are dependent.
    pub(super) fn bear(&mut self, k: usize, problem: &Problem, answer: &Solution, forces: &mut Vec<Force>) {
        self.rows.clear();
        for (l, level) in problem.levels[..k].iter().enumerate() {
            for i in 0..level.rows() {
                let tied = matches!(answer.levels[l].active[i], Active::Equality | Active::Violated);
                if tied && level.weight[i] > 0.0 && level.structure()[i] != Structure::Absent {
                    self.rows.push((l, i));
                }
            }
        }
        let m = self.rows.len();
        if m == 0 {
            return;
        }
        self.gradient.fill(0.0);
        for f in forces.iter() {
            let row = problem.levels[f.level].row(f.row);
            self.gradient.iter_mut().zip(row).for_each(|(g, a)| *g += f.force * a);
        }
        let row = |(l, i): (usize, usize)| problem.levels[l].row(i);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut most = 0.0_f64;
        for i in 0..m {
            for j in 0..=i {
                self.gram[i * m + j] = dot(row(self.rows[i]), row(self.rows[j]));
            }
            most = most.max(self.gram[i * m + i]);
            self.bears[i] = -dot(row(self.rows[i]), &self.gradient);
        }
        if most == 0.0 {
            return;
        }
        // Cholesky, and both substitutions.
        for i in 0..m {
            self.gram[i * m + i] += LOOSE * most;
            for j in 0..=i {
                let (a, b) = (&self.gram[i * m..i * m + j], &self.gram[j * m..j * m + j]);
                let left = self.gram[i * m + j] - dot(a, b);
                self.gram[i * m + j] = if i == j { left.max(LOOSE * most).sqrt() } else { left / self.gram[j * m + j] };
            }
            self.bears[i] =
                (self.bears[i] - dot(&self.gram[i * m..i * m + i], &self.bears[..i])) / self.gram[i * m + i];
        }
        for i in (0..m).rev() {
            let below: f64 = (i + 1..m).map(|j| self.gram[j * m + i] * self.bears[j]).sum();
            self.bears[i] = (self.bears[i] - below) / self.gram[i * m + i];
        }
        for (&(level, row), &force) in self.rows.iter().zip(&self.bears) {
            if force != 0.0 {
                forces.push(Force { level, row, force });
            }
        }
    }
}
