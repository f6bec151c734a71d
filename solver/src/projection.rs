//! The point nearest to another one that meets rows with two bounds each: a problem without levels, of which most are solved by changing a
//! few rows, and most of all by none.
//!
//! ```text
//! minimise  || x - y ||     subject to    l_i <= a_i x <= u_i
//! ```
//!
//! The dual method of Goldfarb and Idnani (A numerically stable dual method for solving strictly convex quadratic programs, 1983) for the
//! identity: rows that are missed are added one after the other, the one that is missed most first, and rows whose multipliers reach zero
//! leave. The rows that held last time are the start; those that would have to pull leave first. Nothing is allocated while it solves.

use crate::dense::{axpy, dot, norm};

/// A row is met if its value is beyond a bound by no more than this, times one plus the size of the value.
const MET: f64 = 1e-9;

/// A row belongs to the space of others if less than this part of it lies outside.
const DEPENDENT: f64 = 1e-9;

/// Changes of the working set for each variable after which there is no answer.
const PATIENCE: usize = 10;

/// A row: `lower <= coefficients x <= upper`.
#[derive(Clone, Copy, Debug)]
pub struct Bounded<'a> {
    /// One number for each variable.
    pub coefficients: &'a [f64],
    /// Lower bound; `-inf` for none.
    pub lower: f64,
    /// Upper bound; `inf` for none.
    pub upper: f64,
}

/// What became of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Projected {
    /// It meets all rows.
    Stays,
    /// It was moved to the nearest point that does.
    Moved,
    /// No such point was found, as a rule because the rows contradict each other. The point is where it was.
    Nowhere,
}

/// A row that holds at one of its bounds.
#[derive(Clone, Copy, Debug)]
struct Held {
    row: usize,
    /// 1 for the lower bound, -1 for the upper one.
    sign: f64,
}

impl Held {
    /// Its bound, as a lower one of the coefficients times the sign.
    fn bound(self, of: Bounded) -> f64 {
        if self.sign > 0.0 { of.lower } else { -of.upper }
    }
}

/// Storage of projections in a space of fixed dimension.
#[derive(Clone, Debug)]
pub struct Projection {
    n: usize,
    /// Rows that hold, at most one for each variable, with their multipliers.
    working: Vec<Held>,
    multipliers: Vec<f64>,
    /// An orthonormal basis of the rows that hold, `n` numbers each, and the coordinates of each row in it, `n` numbers each.
    basis: Vec<f64>,
    triangle: Vec<f64>,
    /// The point that is projected.
    from: Vec<f64>,
    /// Number of rows that the basis contains.
    fitted: usize,
    /// Of a row that enters: its coordinates in the basis, the part of it outside, and the rates of the multipliers.
    coordinates: Vec<f64>,
    outside: Vec<f64>,
    rates: Vec<f64>,
}

impl Projection {
    /// Creates the storage for points of `n` numbers.
    pub fn new(n: usize) -> Projection {
        Projection {
            n,
            working: Vec::with_capacity(n),
            multipliers: Vec::with_capacity(n + 1),
            basis: vec![0.0; n * n],
            triangle: vec![0.0; n * n],
            from: vec![0.0; n],
            fitted: 0,
            coordinates: vec![0.0; n],
            outside: vec![0.0; n],
            rates: vec![0.0; n],
        }
    }

    /// Moves `x` (`n` numbers) to the nearest point that meets rows `0..rows`. Rows that held at the last call are expected to hold again.
    pub fn project<'a>(&mut self, rows: usize, row: impl Fn(usize) -> Bounded<'a>, x: &mut [f64]) -> Projected {
        if self.n == 0 || most_missed(rows, &row, x).is_none() {
            return Projected::Stays;
        }
        self.from.copy_from_slice(x);
        self.resume(rows, &row, x);
        for _ in 0..PATIENCE * (self.n + 1) {
            let Some(missed) = most_missed(rows, &row, x) else { return Projected::Moved };
            if !self.add(missed, &row, x) {
                break;
            }
        }
        self.working.clear();
        self.fitted = 0;
        x.copy_from_slice(&self.from);
        Projected::Nowhere
    }

    /// Takes those of the last working set whose multipliers still push, and sets `x` to the nearest point that meets them.
    fn resume<'a>(&mut self, rows: usize, row: &impl Fn(usize) -> Bounded<'a>, x: &mut [f64]) {
        self.working.retain(|held| held.row < rows && held.bound(row(held.row)).is_finite());
        self.rebuild(0, row);
        loop {
            self.settle(row, x);
            let weakest = (0..self.working.len()).min_by(|i, j| self.multipliers[*i].total_cmp(&self.multipliers[*j]));
            match weakest.filter(|i| self.multipliers[*i] < 0.0) {
                // Any set is a start.
                Some(i) => _ = self.remove(i, row),
                None => return,
            }
        }
    }

    /// Computes the multipliers of the working set, and the nearest point that meets it.
    fn settle<'a>(&mut self, row: &impl Fn(usize) -> Bounded<'a>, x: &mut [f64]) {
        let n = self.n;
        x.copy_from_slice(&self.from);
        self.multipliers.clear();
        for (j, held) in self.working.iter().enumerate() {
            let of = row(held.row);
            let column = &self.triangle[j * n..][..=j];
            let missing =
                held.bound(of) - held.sign * dot(of.coefficients, &self.from) - dot(column, &self.multipliers);
            self.multipliers.push(missing / column[j]);
        }
        for (y, q) in self.multipliers.iter().zip(self.basis.chunks_exact(n)) {
            axpy(*y, q, x);
        }
        solve(n, &self.triangle, &mut self.multipliers);
    }

    /// Adds a row that is missed at `x` to the working set and moves `x` until it is met. Returns false if that cannot be.
    fn add<'a>(&mut self, held: Held, row: &impl Fn(usize) -> Bounded<'a>, x: &mut [f64]) -> bool {
        let of = row(held.row);
        let size = norm(of.coefficients);
        loop {
            let outside = self.split(held, of.coefficients);
            self.rates[..self.working.len()].copy_from_slice(&self.coordinates[..self.working.len()]);
            solve(self.n, &self.triangle, &mut self.rates[..self.working.len()]);
            let free = outside > DEPENDENT * size && self.fitted < self.n;
            let missing = held.bound(of) - held.sign * dot(of.coefficients, x);
            let whole = if free { missing.max(0.0) / (outside * outside) } else { f64::INFINITY };
            let falls = (0..self.working.len()).filter(|i| self.rates[*i] > 0.0);
            let first = falls
                .map(|i| (self.multipliers[i].max(0.0) / self.rates[i], i))
                .min_by(|(a, _), (b, _)| a.total_cmp(b));
            match first.filter(|(step, _)| *step < whole) {
                Some((step, i)) => {
                    self.multipliers.iter_mut().zip(&self.rates).for_each(|(m, rate)| *m -= step * rate);
                    if free {
                        axpy(step, &self.outside, x);
                    }
                    self.multipliers.remove(i);
                    if !self.remove(i, row) {
                        return false;
                    }
                }
                None if whole.is_finite() => {
                    self.working.push(held);
                    self.fit(outside);
                    self.settle(row, x);
                    return x.iter().all(|x| x.is_finite());
                }
                None => return false,
            }
        }
    }

    /// Splits a row into its coordinates in the basis and the part outside, whose length it returns.
    fn split(&mut self, held: Held, coefficients: &[f64]) -> f64 {
        self.outside.iter_mut().zip(coefficients).for_each(|(o, a)| *o = held.sign * a);
        self.coordinates.fill(0.0);
        // The second pass takes what rounding has left in the first one.
        for _ in 0..2 {
            for (c, q) in self.coordinates.iter_mut().zip(self.basis.chunks_exact(self.n)).take(self.fitted) {
                let part = dot(q, &self.outside);
                *c += part;
                axpy(-part, q, &mut self.outside);
            }
        }
        norm(&self.outside)
    }

    /// Adds the direction outside of the basis to it, with the coordinates of the row that was split.
    fn fit(&mut self, outside: f64) {
        let (n, k) = (self.n, self.fitted);
        self.basis[k * n..][..n].iter_mut().zip(&self.outside).for_each(|(q, o)| *q = o / outside);
        self.triangle[k * n..][..k].copy_from_slice(&self.coordinates[..k]);
        self.triangle[k * n + k] = outside;
        self.fitted += 1;
    }

    /// Removes row `i` from the working set. Returns false if others had to leave with it.
    fn remove<'a>(&mut self, i: usize, row: &impl Fn(usize) -> Bounded<'a>) -> bool {
        self.working.remove(i);
        self.rebuild(i, row)
    }

    /// Computes the basis anew from row `first` of the working set on. Rows that depend on those before them leave: the result is then false.
    fn rebuild<'a>(&mut self, first: usize, row: &impl Fn(usize) -> Bounded<'a>) -> bool {
        let count = self.working.len();
        self.fitted = first;
        for i in first..count {
            let held = self.working[i];
            let coefficients = row(held.row).coefficients;
            let outside = self.split(held, coefficients);
            if outside > DEPENDENT * norm(coefficients) && self.fitted < self.n {
                self.working[self.fitted] = held;
                self.fit(outside);
            }
        }
        self.working.truncate(self.fitted);
        self.fitted == count
    }
}

/// Row that is missed most at a point, in units of its size.
fn most_missed<'a>(rows: usize, row: &impl Fn(usize) -> Bounded<'a>, x: &[f64]) -> Option<Held> {
    let mut most = (0.0, None);
    for i in 0..rows {
        let of = row(i);
        let value = dot(of.coefficients, x);
        let room = MET * (1.0 + value.abs());
        // Whatever is no number is missed.
        let (is_above, is_below) = (value >= of.lower - room, value <= of.upper + room);
        if is_above && is_below {
            continue;
        }
        let (sign, by) = if is_above { (-1.0, value - of.upper) } else { (1.0, of.lower - value) };
        let by = by / norm(of.coefficients);
        if by.is_nan() {
            return Some(Held { row: i, sign });
        }
        if by > most.0 {
            most = (by, Some(Held { row: i, sign }));
        }
    }
    most.1
}

/// Solves `R z = z` in place, `R` the triangle whose columns are stored one after the other, `n` numbers each.
fn solve(n: usize, triangle: &[f64], z: &mut [f64]) {
    for j in (0..z.len()).rev() {
        let column = &triangle[j * n..];
        z[j] /= column[j];
        let (before, at) = z.split_at_mut(j);
        axpy(-at[0], &column[..j], before);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{HierarchicalSolver, LevelShape, Problem, Solution, Status};
    use proptest::prelude::*;

    /// The same point from the hierarchy with one hard level.
    fn by_hierarchy(level: &crate::Level, y: &[f64]) -> Option<Vec<f64>> {
        let shape = LevelShape { rows: level.rows(), hard: true, damping: 0.0 };
        let mut problem = Problem::new(y.len(), &[shape]);
        problem.levels[0].copy_from(level);
        problem.reference.copy_from_slice(y);
        let mut solution = Solution::new(&problem);
        crate::ClarabelCascade::new(&problem).solve(&problem, &mut solution);
        (solution.status == Status::Optimal).then_some(solution.x)
    }

    fn bounded(level: &crate::Level, i: usize) -> Bounded<'_> {
        Bounded { coefficients: level.row(i), lower: level.lower[i], upper: level.upper[i] }
    }

    /// Rows, some of them twice, and bounds that mostly contain the origin.
    fn level(n: usize, rows: usize) -> impl Strategy<Value = crate::Level> {
        let row = (prop::collection::vec(-1.0..1.0_f64, n), -0.2..1.0_f64, 0.0..1.0_f64, any::<bool>(), any::<bool>());
        prop::collection::vec(row, rows).prop_map(move |of| {
            let mut level = crate::Level::new(n, LevelShape { rows: of.len(), hard: true, damping: 0.0 });
            for (i, (a, below, above, single, again)) in of.iter().enumerate() {
                let mut a = a.clone();
                if *single {
                    a.iter_mut().enumerate().for_each(|(j, a)| *a = if j == i % n { 1.0 } else { 0.0 });
                } else if *again && i > 0 {
                    a.copy_from_slice(level.row(i - 1));
                }
                let upper = if above > below { *above } else { f64::INFINITY };
                level.set(i, &a, -below, upper);
            }
            level
        })
    }

    proptest! {
        /// One after the other, each from what held at the one before.
        #[test]
        fn the_point_is_that_of_the_reference_solver(
            levels in prop::collection::vec((level(6, 14), prop::collection::vec(-3.0..3.0_f64, 6)), 1..5),
        ) {
            let mut projection = Projection::new(6);
            for (level, y) in &levels {
                let mut x = y.clone();
                let became = projection.project(level.rows(), |i| bounded(level, i), &mut x);
                match by_hierarchy(level, y) {
                    Some(expected) => {
                        prop_assert_ne!(became, Projected::Nowhere);
                        let off = x.iter().zip(&expected).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
                        prop_assert!(off < 1e-6, "{off}: {x:?}, and {expected:?}");
                    }
                    None => {
                        prop_assert_eq!(became, Projected::Nowhere);
                        prop_assert_eq!(&x, y);
                    }
                }
            }
        }
    }

    #[test]
    fn what_is_no_number_has_no_answer() {
        let mut projection = Projection::new(2);
        let mut x = [1.0, 2.0];
        let row = |_| Bounded { coefficients: &[1.0, f64::NAN], lower: 0.0, upper: 1.0 };
        assert_eq!(projection.project(1, row, &mut x), Projected::Nowhere);
        let row = |_| Bounded { coefficients: &[0.0, 0.0], lower: 1.0, upper: 2.0 };
        assert_eq!(projection.project(1, row, &mut x), Projected::Nowhere);
        assert_eq!(x, [1.0, 2.0]);
        let row = |_| Bounded { coefficients: &[1.0, 0.0], lower: 3.0, upper: 3.0 };
        assert_eq!(projection.project(1, row, &mut x), Projected::Moved);
        assert_eq!(x, [3.0, 2.0]);
    }
}
