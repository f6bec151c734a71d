//! One level of the cascade in the coordinates `y` of the remaining space, and the search for its active set: guess,
//! solve by orthogonal factorisation, prove, repair.
//!
//! With the violated rows V of the level (each on a known side), its equalities E, and the higher rows W that block it,
//! the level is `min |M_EV y - t|` subject to `C_W y = d`: two factorisations compute all minimisers. The guess is
//! right, and the result exact, if
//!
//! * every row of V is violated on its side, and the multipliers of W are non-negative: the conditions of Karush, Kuhn
//!   and Tucker of the level's convex cost;
//! * some minimiser meets all other rows. [`crate::distance::nearest`] finds the one nearest to the reference, or
//!   returns rows that contradict each other, which repair the guess.
//!
//! Higher rows are the inequality rows of the levels above, which the level must meet.

use crate::dense::{DEPENDENT, Frame, Matrix, axpy, dot, norm};
use crate::distance::{Nearest, Rows, nearest};
use crate::factor::least_squares;
use crate::feasible_set::{FeasibleSet, Kind, RowId, UnitLevel, tolerance};
use crate::nnls::nnls;

/// Maximum number of guesses in a search; more rows than this have never been seen to change in one tick.
const ROUNDS: usize = 80;

/// A guess of the active set: the rows that the level violates, and the higher rows that block it.
#[derive(Clone, Debug, Default)]
pub(crate) struct ActiveSetGuess {
    /// Per row of the level: -1 below, +1 above, 0 within.
    pub(crate) violated: Vec<i8>,
    /// Blocking higher rows, with the bound (-1 lower, +1 upper) that they are at.
    pub(crate) blocking: Vec<(RowId, i8)>,
}

/// A level in reduced coordinates.
pub(crate) struct ReducedLevel<'a> {
    pub(crate) level: &'a UnitLevel,
    pub(crate) space: &'a FeasibleSet,
    /// Rows of the level times Z (m x k), and their intervals relative to x0.
    pub(crate) own: Rows,
    /// Higher rows times Z (h x k), and their intervals relative to x0.
    pub(crate) higher: Rows,
    /// The reference, relative to x0.
    pub(crate) start: Vec<f64>,
}

/// A proven optimum of a stage.
pub(crate) struct Proven {
    /// The minimiser nearest to the reference, or any minimiser.
    pub(crate) y: Vec<f64>,
    /// True if `y` is the nearest one.
    pub(crate) is_nearest: bool,
    /// k x k', directions along which the cost of the level is constant.
    pub(crate) null: Matrix,
    pub(crate) guess: ActiveSetGuess,
}

/// All minimisers for one guess.
pub(crate) struct Flat {
    pub(crate) y: Vec<f64>,
    pub(crate) null: Matrix,
}

impl<'a> ReducedLevel<'a> {
    pub(crate) fn new(level: &'a UnitLevel, space: &'a FeasibleSet, reference: &[f64]) -> Self {
        let own = project(&level.rows, &level.lower, &level.upper, space);
        let higher = project(&space.rows, &space.lower, &space.upper, space);
        let away: Vec<f64> = reference.iter().zip(&space.x0).map(|(r, x)| r - x).collect();
        ReducedLevel { level, space, own, higher, start: space.z.apply_transposed(&away) }
    }

    /// Searches for the active set from `guess`. Returns `None` if no guess could be proven.
    pub(crate) fn search(&self, guess: &ActiveSetGuess) -> Option<Proven> {
        let m = self.level.kind.len();
        let mut own: Vec<i8> = guess.violated.clone();
        own.resize(m, 0);
        let mut active = vec![0_i8; self.space.names.len()];
        for (name, side) in &guess.blocking {
            if let Ok(j) = self.space.names.binary_search(name) {
                active[j] = *side;
            }
        }
        // A guess from another tick may refer to bounds that this one does not have.
        for (j, side) in active.iter_mut().enumerate() {
            let bound = if *side > 0 { self.higher.upper[j] } else { self.higher.lower[j] };
            if !bound.is_finite() {
                *side = 0;
            }
        }
        for (i, side) in own.iter_mut().enumerate() {
            if self.level.kind[i] != Kind::Inequality || (*side != 0 && !self.target(i, *side).is_finite()) {
                *side = 0;
            }
        }
        // Number of times that a contradiction added each row. A row that was added twice is no longer released as
        // undecided.
        let mut returns = vec![0_u32; m + active.len()];
        // Guesses tried so far. At the first repetition another rule for the leaving row is used; the second one ends
        // the search.
        let mut seen: Vec<(Vec<i8>, Vec<i8>)> = Vec::new();
        let mut careful = false;
        for _ in 0..ROUNDS {
            let flat = self.minimisers(&own, &active)?;
            if self.release(&flat, &mut own, &mut active, &returns, careful) {
                continue;
            }
            let here = (own.clone(), active.clone());
            if seen.contains(&here) {
                if careful {
                    return None;
                }
                careful = true;
                seen.clear();
            }
            seen.push(here);
            let (rows, origin) = self.others(&flat, &own, &active);
            let toward: Vec<f64> = self.start.iter().zip(&flat.y).map(|(s, y)| s - y).collect();
            match nearest(&rows, &flat.null.apply_transposed(&toward)) {
                Nearest::Point(u) => {
                    let mut y = flat.y.clone();
                    axpy(1.0, &flat.null.apply(&u), &mut y);
                    return Some(self.settle(Flat { y, ..flat }, own, active));
                }
                Nearest::Contradiction(set) => {
                    for (n, (row, side)) in set.into_iter().enumerate() {
                        let o = origin[row];
                        returns[o] += 1;
                        if o < m {
                            own[o] = side;
                        } else if n == 0 || flat.null.cols > 0 {
                            active[o - m] = side;
                        }
                    }
                }
                Nearest::Failed => {
                    return None;
                }
            }
        }
        None
    }

    /// Frees the rows of V and W that the proof does not need (no slack, no multiplier): for the levels below they are
    /// inequalities, not equalities.
    fn settle(&self, flat: Flat, mut own: Vec<i8>, mut active: Vec<i8>) -> Proven {
        let mut idle = false;
        for (i, side) in own.iter_mut().enumerate().filter(|(_, s)| **s != 0) {
            let residual = dot(self.own.g.row(i), &flat.y) - self.target(i, *side);
            if residual * f64::from(*side) <= self.own.tolerance[i] {
                *side = 0;
                idle = true;
            }
        }
        if active.iter().any(|s| *s != 0) {
            let (multipliers, noise) = self.multipliers(&flat, &own, &active);
            for (j, _) in multipliers.into_iter().filter(|(_, m)| *m <= noise) {
                active[j] = 0;
                idle = true;
            }
        }
        let (mut y, mut null) = (flat.y, flat.null);
        let mut is_nearest = true;
        if idle {
            let (mut rows, _, mut size) = self.cost_rows(&own);
            for j in (0..active.len()).filter(|j| active[*j] != 0) {
                rows.push(self.higher.g.row(j));
                size.push(1.0);
            }
            let zeros = vec![0.0; rows.rows];
            null = least_squares(rows, zeros, size).null;
            let wide = Flat { y, null };
            let (rows, _) = self.others(&wide, &own, &active);
            let toward: Vec<f64> = self.start.iter().zip(&wide.y).map(|(s, y)| s - y).collect();
            let found = nearest(&rows, &wide.null.apply_transposed(&toward));
            (y, null) = (wide.y, wide.null);
            if let Nearest::Point(u) = found {
                axpy(1.0, &null.apply(&u), &mut y);
            } else {
                is_nearest = false;
            }
        }
        let guess = self.guess(own, &active);
        Proven { y, null, guess, is_nearest }
    }

    pub(crate) fn guess(&self, own: Vec<i8>, active: &[i8]) -> ActiveSetGuess {
        let names = self.space.names.iter().zip(active);
        ActiveSetGuess { violated: own, blocking: names.filter(|(_, s)| **s != 0).map(|(n, s)| (*n, *s)).collect() }
    }

    /// Returns the target of a row of E or V, relative to x0.
    fn target(&self, i: usize, side: i8) -> f64 {
        if side > 0 { self.own.upper[i] } else { self.own.lower[i] }
    }

    /// Computes all minimisers with the rows of V and E in the cost and those of W as equalities. Returns `None` if the
    /// equalities of W contradict each other.
    pub(crate) fn minimisers(&self, own: &[i8], active: &[i8]) -> Option<Flat> {
        let k = self.space.dimension();
        let mut y = vec![0.0; k];
        let mut null = Matrix::identity(k);
        let (mut c, mut d) = (Matrix::zeros(0, k), Vec::new());
        for (j, side) in active.iter().enumerate().filter(|(_, s)| **s != 0) {
            c.push(self.higher.g.row(j));
            d.push(if *side > 0 { self.higher.upper[j] } else { self.higher.lower[j] });
        }
        if c.rows > 0 {
            let ones = vec![1.0; c.rows];
            let found = least_squares(c.clone(), d.clone(), ones);
            let misses = |j: usize| (dot(c.row(j), &found.point) - d[j]).abs() > 1e-8 * (1.0 + d[j].abs());
            if (0..c.rows).any(misses) {
                return None;
            }
            (y, null) = (found.point, found.null);
        }
        let (rows, mut target, size) = self.cost_rows(own);
        for (t, i) in target.iter_mut().zip(0..rows.rows) {
            *t -= dot(rows.row(i), &y);
        }
        let reduced = if c.rows > 0 { rows.times(&null, None) } else { rows };
        let found = least_squares(reduced, target, size);
        axpy(1.0, &null.apply(&found.point), &mut y);
        let null = if c.rows > 0 { null.times(&found.null, None) } else { found.null };
        Some(Flat { y, null })
    }

    /// Returns the rows of the cost for a choice of V, weighted: matrix, target relative to x0, sizes.
    pub(crate) fn cost_rows(&self, own: &[i8]) -> (Matrix, Vec<f64>, Vec<f64>) {
        let mut rows = Matrix::zeros(0, self.space.dimension());
        let (mut target, mut size) = (Vec::new(), Vec::new());
        for (i, side) in own.iter().enumerate() {
            if *side != 0 || self.level.kind[i] == Kind::Equality {
                let s = self.level.scale[i];
                rows.push(&self.own.g.row(i).iter().map(|g| s * g).collect::<Vec<_>>());
                target.push(s * self.target(i, *side));
                size.push(s);
            }
        }
        if self.level.damping > 0.0 {
            let s = self.level.damping;
            for (i, x0) in self.space.x0.iter().enumerate() {
                rows.push(&self.space.z.row(i).iter().map(|z| s * z).collect::<Vec<_>>());
                target.push(-s * x0);
                size.push(s);
            }
        }
        (rows, target, size)
    }

    /// Removes rows that are in V or W wrongly, or that have no effect there. Returns true if the guess has changed.
    fn release(&self, flat: &Flat, own: &mut [i8], active: &mut [i8], returns: &[u32], careful: bool) -> bool {
        let m = own.len();
        let mut changed = false;
        for i in (0..m).filter(|i| own[*i] != 0).collect::<Vec<_>>() {
            let residual = dot(self.own.g.row(i), &flat.y) - self.target(i, own[i]);
            let excess = residual * f64::from(own[i]);
            let tolerance = self.own.tolerance[i];
            if excess < -tolerance || (excess <= tolerance && returns[i] < 2) {
                own[i] = 0;
                changed = true;
            }
        }
        if changed || active.iter().all(|s| *s == 0) {
            return changed;
        }
        let (multipliers, noise) = self.multipliers(flat, own, active);
        let mut worst = -noise;
        let mut leaving = None;
        for &(j, multiplier) in &multipliers {
            if multiplier.abs() <= noise && returns[m + j] < 2 {
                active[j] = 0;
                changed = true;
            } else if multiplier < worst && !(careful && leaving.is_some()) {
                worst = multiplier;
                leaving = Some(j);
            }
        }
        if let Some(j) = leaving {
            active[j] = 0;
            changed = true;
        }
        changed
    }

    /// Returns the multipliers of W, and the size below which a multiplier is rounding.
    pub(crate) fn multipliers(&self, flat: &Flat, own: &[i8], active: &[i8]) -> (Vec<(usize, f64)>, f64) {
        let k = self.space.dimension();
        let (rows, target, size) = self.cost_rows(own);
        let mut descent = vec![0.0; k];
        let mut noise = 0.0;
        let far = norm(&flat.y) + norm(&self.space.x0);
        for i in 0..rows.rows {
            let residual = dot(rows.row(i), &flat.y) - target[i];
            axpy(-residual, rows.row(i), &mut descent);
            noise += size[i] * (1e-11 * residual.abs() + 1e-14 * (size[i] * (1.0 + far) + target[i].abs()));
        }
        let members: Vec<usize> = (0..active.len()).filter(|j| active[*j] != 0).collect();
        let normal = |j: usize| -> Vec<f64> { self.higher.g.row(j).iter().map(|g| f64::from(active[j]) * g).collect() };
        let mut frame = Frame::new(k);
        let found = if members.iter().all(|j| frame.push(&normal(*j))) {
            let (coordinates, _) = frame.split(&descent);
            frame.solve(&coordinates)
        } else {
            let mut columns = Matrix::zeros(0, k);
            members.iter().for_each(|j| columns.push(&normal(*j)));
            let (found, residual) = nnls(&columns, &descent);
            if residual > 100.0 * noise {
                // Some multiplier is negative: the solution without sign constraints shows which one.
                let mut system = Matrix::zeros(k, members.len());
                for i in 0..k {
                    for c in 0..members.len() {
                        system.row_mut(i)[c] = columns.row(c)[i];
                    }
                }
                least_squares(system, descent, vec![1.0; k]).point
            } else {
                found
            }
        };
        (members.into_iter().zip(found).collect(), noise)
    }

    /// Returns the rows that are neither in V nor in W, restricted to the minimisers, and the origin of each: `i < m`
    /// is a row of the level, `m + j` a higher one.
    fn others(&self, flat: &Flat, own: &[i8], active: &[i8]) -> (Rows, Vec<usize>) {
        let m = own.len();
        let mut rows =
            Rows { g: Matrix::zeros(0, flat.null.cols), lower: Vec::new(), upper: Vec::new(), tolerance: Vec::new() };
        let mut origin = Vec::new();
        let mut image = vec![0.0; flat.null.cols];
        let free = (0..m).filter(|i| self.level.kind[*i] == Kind::Inequality && own[*i] == 0);
        let kept = (0..active.len()).filter(|j| active[*j] == 0);
        for (from, i, o) in free.map(|i| (&self.own, i, i)).chain(kept.map(|j| (&self.higher, j, m + j))) {
            flat.null.apply_transposed_into(from.g.row(i), &mut image);
            if norm(&image) <= DEPENDENT {
                image.fill(0.0);
            }
            let value = dot(from.g.row(i), &flat.y);
            rows.g.push(&image);
            rows.lower.push(from.lower[i] - value);
            rows.upper.push(from.upper[i] - value);
            rows.tolerance.push(from.tolerance[i]);
            origin.push(o);
        }
        (rows, origin)
    }
}

/// Transforms rows of norm one to the coordinates of `space`, with intervals relative to its point.
fn project(rows: &Matrix, lower: &[f64], upper: &[f64], space: &FeasibleSet) -> Rows {
    let offset = rows.apply(&space.x0);
    Rows {
        g: rows.times(&space.z, Some(1.0)),
        lower: lower.iter().zip(&offset).map(|(b, o)| b - o).collect(),
        upper: upper.iter().zip(&offset).map(|(b, o)| b - o).collect(),
        tolerance: (0..rows.rows).map(|i| tolerance(lower[i], upper[i]).max(1e-12 * offset[i].abs())).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LevelShape, Problem};

    /// A higher row in the guess that blocks nothing (its multiplier is zero) must stay an inequality for the levels
    /// below, and must not keep the point away from the reference.
    #[test]
    fn rows_that_stop_nothing_are_freed() {
        let shape = LevelShape { rows: 1, hard: false, damping: 0.0 };
        let mut problem = Problem::new(2, &[shape, shape]);
        problem.levels[0].set(0, &[1.0, 0.0], -1.0, 1.0);
        problem.levels[1].set(0, &[0.0, 1.0], 0.5, 0.5);
        let mut space = FeasibleSet::whole(&problem);
        space.hold((0, 0), &[1.0, 0.0], -1.0, 1.0);
        let unit = UnitLevel::new(&problem.levels[1], 0.0);
        let reduced = ReducedLevel::new(&unit, &space, &problem.reference);
        let flat = reduced.minimisers(&[0], &[1]).expect("the row can be held");
        assert!((flat.y[0] - 1.0).abs() < 1e-14 && flat.null.cols == 0);
        let proven = reduced.settle(flat, vec![0], vec![1]);
        assert_eq!(proven.null.cols, 1);
        assert!(proven.is_nearest && proven.guess.blocking.is_empty());
        assert!(proven.y[0].abs() < 1e-14 && (proven.y[1] - 0.5).abs() < 1e-14);
    }
}
