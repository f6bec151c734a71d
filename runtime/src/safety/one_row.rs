//! The planner's quadratic program: separable, in a box, with one soft row. It is solved exactly, in one pass.
//!
//! ```text
//! min 1/2 sum_i Q_i (x_i - n_i)^2 + 1/2 q w^2   s.t.   l <= x <= u,   j . x + w >= r        thesis (4.27)-(4.30)
//! ```
//!
//! With the multiplier `t >= 0` of the row, the Lagrangian separates into one problem for each number, and its
//! minimiser is `x_i(t) = clamp(n_i + t j_i / Q_i, l_i, u_i)`, `w(t) = t / q`. The residual of the row,
//!
//! ```text
//! s(t) = j . x(t) + t / q - r,
//! ```
//!
//! is continuous, piecewise linear, and rises with slope `1/q + sum of j_i^2 / Q_i over the numbers that are free`,
//! which is at least `1/q > 0`. Either `s(0) >= 0`, and `t = 0` is optimal, or `s` has exactly one root `t > 0`. In
//! both cases `(x(t), w(t), t)` meets the conditions of Karush, Kuhn and Tucker, which are sufficient because the
//! program is strictly convex: the point is the unique optimum. A number becomes free once and reaches its other bound
//! once, so there are at most two breaks for each. The breaks are sorted, and the root lies between two of them. The
//! cost is O(k log k), without iteration. There is no failure: the row is soft, and the box is not empty by
//! construction.

use stdlib_tasks::field::{SafetyError, setting};

/// The program with its storage. The vectors have k numbers and must keep this length; write them, then call
/// [`OneRowProgram::solve`].
#[derive(Clone, Debug)]
pub struct OneRowProgram {
    /// Q: positive.
    pub weight: Vec<f64>,
    /// n: the preferred values of the numbers.
    pub nominal: Vec<f64>,
    /// l: may be minus infinity.
    pub lower: Vec<f64>,
    /// u >= l: may be infinity.
    pub upper: Vec<f64>,
    /// j
    pub row: Vec<f64>,
    /// r; minus infinity if the row demands nothing.
    pub need: f64,
    /// q: positive.
    pub slack_weight: f64,
    /// (t, change of the slope)
    breaks: Vec<(f64, f64)>,
}

/// Multiplier and slack at the optimum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outcome {
    /// t: cost of a unit of the row; zero if the row is inactive.
    pub multiplier: f64,
    /// w >= 0: shortfall of the row.
    pub slack: f64,
}

impl OneRowProgram {
    /// Creates a program of k numbers: weights 1, no bounds, and a row that demands nothing.
    pub fn new(k: usize) -> OneRowProgram {
        OneRowProgram {
            weight: vec![1.0; k],
            nominal: vec![0.0; k],
            lower: vec![f64::NEG_INFINITY; k],
            upper: vec![f64::INFINITY; k],
            row: vec![0.0; k],
            need: f64::NEG_INFINITY,
            slack_weight: 1.0,
            breaks: Vec::with_capacity(2 * k),
        }
    }

    fn check(&self, x: &[f64]) -> Result<(), SafetyError> {
        let k = self.weight.len();
        if [x.len(), self.nominal.len(), self.lower.len(), self.upper.len(), self.row.len()] != [k; 5] {
            return Err(SafetyError::Shape { name: "program" });
        }
        setting("slack weight", self.slack_weight, positive(self.slack_weight), "positive and finite")?;
        for i in 0..k {
            setting("weight", self.weight[i], positive(self.weight[i]), "positive and finite")?;
            let (l, u) = (self.lower[i], self.upper[i]);
            let open = l <= u && l < f64::INFINITY && u > f64::NEG_INFINITY;
            if !open || !self.nominal[i].is_finite() || !self.row[i].is_finite() {
                return Err(SafetyError::NotFinite { name: "program" });
            }
        }
        if self.need.is_nan() || self.need == f64::INFINITY {
            return Err(SafetyError::NotFinite { name: "program" });
        }
        Ok(())
    }

    /// Values of t at which number `i` becomes free, and at which it reaches its other bound.
    fn free(&self, i: usize) -> (f64, f64) {
        let (near, far) =
            if self.row[i] > 0.0 { (self.lower[i], self.upper[i]) } else { (self.upper[i], self.lower[i]) };
        let at = |bound: f64| (bound - self.nominal[i]) * (self.weight[i] / self.row[i]);
        (at(near).max(0.0), at(far))
    }

    /// x_i at t.
    fn at(&self, i: usize, t: f64) -> f64 {
        let x = if self.row[i] == 0.0 { self.nominal[i] } else { self.nominal[i] + t * self.row[i] / self.weight[i] };
        x.max(self.lower[i]).min(self.upper[i])
    }

    /// Shortfall of the row at the inputs that contribute most to it, which is independent of the weights.
    pub fn shortage(&self) -> f64 {
        let most = |i: usize| if self.row[i] > 0.0 { self.row[i] * self.upper[i] } else { self.row[i] * self.lower[i] };
        let all: f64 = (0..self.row.len()).filter(|&i| self.row[i] != 0.0).map(most).sum();
        (self.need - all).max(0.0)
    }

    /// Writes the optimum into `x`, k numbers. Never allocates.
    ///
    /// # Errors
    /// [`SafetyError::Setting`] for a weight that is not positive, [`SafetyError::Shape`], [`SafetyError::NotFinite`]
    /// for an empty box or a number that is not finite; `x` is then unchanged.
    pub fn solve(&mut self, x: &mut [f64]) -> Result<Outcome, SafetyError> {
        self.check(x)?;
        let k = x.len();
        let mut slope = 1.0 / self.slack_weight;
        let mut value = -self.need;
        self.breaks.clear();
        for i in 0..k {
            value += self.row[i] * self.at(i, 0.0);
            if self.row[i] == 0.0 {
                continue;
            }
            let (from, to) = self.free(i);
            if to <= from {
                continue;
            }
            let rate = self.row[i] * self.row[i] / self.weight[i];
            if from > 0.0 {
                self.breaks.push((from, rate));
            } else {
                slope += rate;
            }
            if to < f64::INFINITY {
                self.breaks.push((to, -rate));
            }
        }
        if value.is_nan() || !slope.is_finite() {
            return Err(SafetyError::NotFinite { name: "program" });
        }
        let mut outcome = Outcome::default();
        if value < 0.0 {
            outcome.multiplier = self.root(value, slope);
            outcome.slack = outcome.multiplier / self.slack_weight;
            if !outcome.multiplier.is_finite() {
                return Err(SafetyError::NotFinite { name: "program" });
            }
        }
        for (i, x) in x.iter_mut().enumerate() {
            *x = self.at(i, outcome.multiplier);
        }
        Ok(outcome)
    }

    /// Root of s, whose value and slope at zero are given.
    fn root(&mut self, mut value: f64, mut slope: f64) -> f64 {
        self.breaks.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let least = 1.0 / self.slack_weight;
        let (mut t, mut end) = (0.0, f64::INFINITY);
        for (at, change) in &self.breaks {
            let next = value + slope * (at - t);
            if next >= 0.0 {
                end = *at;
                break;
            }
            (t, value, slope) = (*at, next, (slope + change).max(least));
        }
        // Recompute from the numbers that are free between t and end, so that rounding errors do not add up.
        let middle = if end < f64::INFINITY { 0.5 * (t + end) } else { 2.0 * t + 1.0 };
        let (mut rest, mut slope) = (self.need, least);
        for i in 0..self.row.len() {
            let (from, to) = if self.row[i] == 0.0 { (0.0, 0.0) } else { self.free(i) };
            if from <= middle && middle < to {
                slope += self.row[i] * self.row[i] / self.weight[i];
                rest -= self.row[i] * self.nominal[i];
            } else {
                rest -= self.row[i] * self.at(i, middle);
            }
        }
        (rest / slope).clamp(t, end)
    }
}

fn positive(x: f64) -> bool {
    x > 0.0 && x.is_finite()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use solver::{ActiveSet, ClarabelCascade, HierarchicalSolver, LevelShape, Problem, Solution, Status};

    /// The same program as two levels: the hard box, and everything else as weighted rows.
    fn hierarchy(p: &OneRowProgram) -> Problem {
        let k = p.row.len();
        let shape = |rows, hard| LevelShape { rows, hard, damping: 0.0 };
        let mut problem = Problem::new(k, &[shape(k, true), shape(k + 1, false)]);
        for i in 0..k {
            let mut unit = vec![0.0; k];
            unit[i] = 1.0;
            problem.levels[0].set(i, &unit, p.lower[i], p.upper[i]);
            problem.levels[1].set(i, &unit, p.nominal[i], p.nominal[i]);
            problem.levels[1].weight[i] = p.weight[i];
        }
        problem.levels[1].set(k, &p.row, p.need, f64::INFINITY);
        problem.levels[1].weight[k] = p.slack_weight;
        problem
    }

    fn program() -> impl Strategy<Value = OneRowProgram> {
        let number = (-1.0..1.0f64, -1.0..1.5f64, 0.0..0.6f64, 0.0..0.6f64, -1.0..1.0f64, 0u8..8);
        (prop::collection::vec(number, 1..24), -2.0..4.0f64, -1.0..4.0f64).prop_map(|(numbers, need, slack)| {
            let mut p = OneRowProgram::new(numbers.len());
            for (i, (nominal, weight, below, above, row, kind)) in numbers.into_iter().enumerate() {
                p.weight[i] = 10f64.powf(weight);
                p.nominal[i] = nominal;
                // The nominal point inside the box, outside on either side, at a bound; no bounds; no effect on the
                // row.
                let shift = [0.0, 0.8, -0.8, above, 0.0, 0.0, 0.0, 0.0][usize::from(kind)];
                (p.lower[i], p.upper[i]) = (nominal + shift - below, nominal + shift + above);
                match kind {
                    4 => (p.lower[i], p.upper[i]) = (f64::NEG_INFINITY, f64::INFINITY),
                    5 => p.upper[i] = f64::INFINITY,
                    _ => {}
                }
                p.row[i] = if kind == 6 { 0.0 } else { row };
            }
            p.need = need;
            p.slack_weight = 10f64.powf(slack);
            p
        })
    }

    proptest! {
        #[test]
        fn the_optimum_of_two_other_solvers(mut p in program()) {
            let mut x = vec![0.0; p.row.len()];
            let Ok(outcome) = p.solve(&mut x) else { panic!("{p:?}") };
            let problem = hierarchy(&p);
            let mut active = ActiveSet::new(&problem);
            let mut clarabel = ClarabelCascade::new(&problem);
            let solvers: [&mut dyn HierarchicalSolver; 2] = [&mut active, &mut clarabel];
            for solver in solvers {
                let mut solution = Solution::new(&problem);
                solver.solve(&problem, &mut solution);
                prop_assert_eq!(solution.status, Status::Optimal);
                for (a, b) in x.iter().zip(&solution.x) {
                    prop_assert!((a - b).abs() < 1e-8, "{a} {b} {p:?}");
                }
            }
            let value: f64 = p.row.iter().zip(&x).map(|(a, b)| a * b).sum();
            prop_assert!(value + outcome.slack >= p.need - 1e-9);
        }

        /// The conditions of Karush, Kuhn and Tucker hold, up to rounding.
        #[test]
        fn the_conditions_of_optimality(mut p in program()) {
            let mut x = vec![0.0; p.row.len()];
            let Ok(outcome) = p.solve(&mut x) else { panic!("{p:?}") };
            let (t, w) = (outcome.multiplier, outcome.slack);
            prop_assert!(t >= 0.0 && (p.slack_weight * w - t).abs() <= 1e-12 * (1.0 + t));
            let value: f64 = p.row.iter().zip(&x).map(|(a, b)| a * b).sum::<f64>() + w - p.need;
            prop_assert!(value > -1e-10 && (t == 0.0 || value < 1e-10), "{value} {t}");
            for (i, x) in x.iter().enumerate() {
                prop_assert!((p.lower[i]..=p.upper[i]).contains(x));
                let force = p.weight[i] * (x - p.nominal[i]) - t * p.row[i];
                let noise = 1e-10 * (1.0 + t);
                prop_assert!(*x == p.lower[i] || force < noise, "{force}");
                prop_assert!(*x == p.upper[i] || force > -noise, "{force}");
            }
        }
    }

    #[test]
    fn a_row_that_asks_for_nothing_and_nonsense() {
        let mut p = OneRowProgram::new(2);
        p.nominal = vec![3.0, -1.0];
        p.upper[0] = 2.0;
        let mut x = [0.0; 2];
        assert_eq!(p.solve(&mut x), Ok(Outcome::default()));
        assert_eq!(x, [2.0, -1.0]);
        // No number can help: all is slack.
        p.need = 5.0;
        assert_eq!(p.solve(&mut x), Ok(Outcome { multiplier: 5.0, slack: 5.0 }));
        let breaks: [fn(&mut OneRowProgram); 7] = [
            |p| p.need = f64::NAN,
            |p| p.need = f64::INFINITY,
            |p| p.row[1] = f64::NAN,
            |p| p.nominal[0] = f64::INFINITY,
            |p| p.lower[0] = 3.0,
            |p| p.weight[1] = 0.0,
            |p| p.slack_weight = f64::INFINITY,
        ];
        for (i, break_it) in breaks.iter().enumerate() {
            let mut bad = p.clone();
            break_it(&mut bad);
            let mut y = [7.0; 2];
            assert!(bad.solve(&mut y).is_err(), "{i}");
            assert_eq!(y, [7.0; 2]);
        }
        assert!(p.solve(&mut [0.0; 3]).is_err());
    }
}
