//! The point nearest to a given one, subject to two-sided rows: `min |z - z_0|` with `lower <= G z <= upper`.
//!
//! The dual active-set method of Goldfarb and Idnani (Math. Programming 27, 1983) with the identity as Hessian: it
//! starts at `z_0`, adds one violated row after the other, and ends at the nearest point or with a proof that there is
//! none. Rows that are never violated are never factorised.

use crate::dense::{Frame, Matrix, axpy, dot, is_dependent, norm};

/// Rows with their bounds and the violation that still counts as zero.
pub(crate) struct Rows {
    pub(crate) g: Matrix,
    pub(crate) lower: Vec<f64>,
    pub(crate) upper: Vec<f64>,
    pub(crate) tolerance: Vec<f64>,
}

/// Result of [`nearest`].
#[derive(Clone, Debug)]
pub(crate) enum Nearest {
    /// The nearest point.
    Point(Vec<f64>),
    /// No point exists: these rows contradict each other, each at the given side (-1 lower, +1 upper). The first is the
    /// one that could not be added.
    Contradiction(Vec<(usize, i8)>),
    /// The maximum number of steps was reached, or rounding made the active rows dependent.
    Failed,
}

/// Multiple of its tolerance by which a row that others block may be violated: rounding.
const BLOCKED: f64 = 30.0;

struct Active {
    row: usize,
    side: i8,
    multiplier: f64,
}

/// Returns the point nearest to `start` that meets all rows, see the documentation of the file.
pub(crate) fn nearest(rows: &Rows, start: &[f64]) -> Nearest {
    let k = start.len();
    let mut z = start.to_vec();
    let mut active: Vec<Active> = Vec::new();
    let mut frame = Frame::new(k);
    let mut ignored = vec![false; rows.g.rows];
    for _ in 0..(4 * (k + 10)).max(rows.g.rows) {
        let Some((p, side, mut violation)) = most_violated(rows, &z, &ignored, &active) else {
            return polish(rows, start, &frame, &active, &z);
        };
        let normal: Vec<f64> = rows.g.row(p).iter().map(|g| -f64::from(side) * g).collect();
        let mut multiplier = 0.0;
        loop {
            let (coordinates, direction) = frame.split(&normal);
            let size = norm(&direction);
            let r = frame.solve(&coordinates);
            let blocked = is_dependent(size, norm(&normal));
            let full = if blocked { f64::INFINITY } else { violation / (size * size) };
            let mut step = full;
            let mut leaving = None;
            let least = 1e-11 * r.iter().fold(0.0_f64, |m, r| m.max(r.abs()));
            for (j, r) in r.iter().enumerate() {
                if *r > least && active[j].multiplier / r < step {
                    step = active[j].multiplier / r;
                    leaving = Some(j);
                }
            }
            if step == f64::INFINITY {
                if violation <= BLOCKED * rows.tolerance[p] {
                    ignored[p] = true;
                    break;
                }
                return Nearest::Contradiction(contradiction(rows, p, side, &z, &active, &r));
            }
            multiplier += step;
            for (active, r) in active.iter_mut().zip(&r) {
                active.multiplier -= step * r;
            }
            if !blocked {
                axpy(step, &direction, &mut z);
                violation -= step * size * size;
            }
            match leaving {
                Some(j) => {
                    active.remove(j);
                    frame = frame_of(rows, &active, k);
                }
                None => {
                    if !frame.push(&normal) {
                        return Nearest::Failed;
                    }
                    active.push(Active { row: p, side, multiplier });
                    break;
                }
            }
        }
    }
    Nearest::Failed
}

fn most_violated(rows: &Rows, z: &[f64], ignored: &[bool], active: &[Active]) -> Option<(usize, i8, f64)> {
    let mut worst: Option<(usize, i8, f64)> = None;
    for (i, ignored) in ignored.iter().enumerate() {
        if *ignored {
            continue;
        }
        let value = dot(rows.g.row(i), z);
        let below = rows.lower[i] - value;
        let above = value - rows.upper[i];
        let (violation, side) = if below > above { (below, -1) } else { (above, 1) };
        let larger = worst.is_none_or(|w| violation > w.2);
        if violation > rows.tolerance[i] && larger && active.iter().all(|a| a.row != i) {
            worst = Some((i, side, violation));
        }
    }
    worst
}

fn frame_of(rows: &Rows, active: &[Active], k: usize) -> Frame {
    let mut frame = Frame::new(k);
    for a in active {
        let normal: Vec<f64> = rows.g.row(a.row).iter().map(|g| -f64::from(a.side) * g).collect();
        frame.push(&normal);
    }
    frame
}

/// Returns the rows that together exclude every point; without a dimension left, all violated rows.
fn contradiction(rows: &Rows, p: usize, side: i8, z: &[f64], active: &[Active], r: &[f64]) -> Vec<(usize, i8)> {
    let mut set = vec![(p, side)];
    let largest = r.iter().fold(0.0_f64, |m, r| m.max(r.abs()));
    for (a, r) in active.iter().zip(r) {
        if *r < -1e-9 * largest {
            set.push((a.row, a.side));
        }
    }
    if rows.g.cols == 0 {
        for i in (0..rows.g.rows).filter(|i| *i != p) {
            let value = dot(rows.g.row(i), z);
            if rows.lower[i] - value > rows.tolerance[i] {
                set.push((i, -1));
            } else if value - rows.upper[i] > rows.tolerance[i] {
                set.push((i, 1));
            }
        }
    }
    set
}

/// Recomputes the point from its active rows alone, without the rounding errors of the iteration.
fn polish(rows: &Rows, start: &[f64], frame: &Frame, active: &[Active], z: &[f64]) -> Nearest {
    if active.is_empty() {
        return Nearest::Point(z.to_vec());
    }
    let rest: Vec<f64> = active
        .iter()
        .map(|a| {
            let bound = if a.side < 0 { rows.lower[a.row] } else { rows.upper[a.row] };
            -f64::from(a.side) * (bound - dot(rows.g.row(a.row), start))
        })
        .collect();
    let (mut point, _) = frame.smallest(&rest);
    axpy(1.0, start, &mut point);
    Nearest::Point(point)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nnls::nnls;
    use proptest::prelude::*;

    proptest! {
        /// A found point is feasible and its residual lies in the cone of the active normals; a contradiction has a
        /// non-negative combination of its rows that reads 0 <= -1.
        #[test]
        fn nearest_or_contradiction_is_proven(
            k in 1usize..6, m in 1usize..14,
            numbers in prop::collection::vec(-1.0f64..1.0, 120),
            offset in -0.6f64..1.0,
        ) {
            let mut rows = Rows { g: Matrix::zeros(0, k), lower: vec![], upper: vec![], tolerance: vec![1e-11; m] };
            for i in 0..m {
                rows.g.push(&numbers[i * k..i * k + k]);
                let lower = numbers[90 + i] - offset;
                rows.lower.push(lower);
                rows.upper.push(if i % 2 == 0 { f64::INFINITY } else { lower + 0.3 });
            }
            let start = &numbers[110..110 + k];
            match nearest(&rows, start) {
                Nearest::Point(z) => {
                    let mut cone = Matrix::zeros(0, k);
                    for i in 0..m {
                        let value = dot(rows.g.row(i), &z);
                        prop_assert!(value >= rows.lower[i] - 1e-9 && value <= rows.upper[i] + 1e-9);
                        let sign = if value <= rows.lower[i] + 1e-9 { 1.0 } else if value >= rows.upper[i] - 1e-9 { -1.0 } else { continue };
                        cone.push(&rows.g.row(i).iter().map(|g| sign * g).collect::<Vec<_>>());
                    }
                    let step: Vec<f64> = z.iter().zip(start).map(|(z, s)| z - s).collect();
                    prop_assert!(nnls(&cone, &step).1 < 1e-8 * (1.0 + norm(&step)));
                }
                Nearest::Contradiction(set) => {
                    // Farkas: sum u_j (normal_j, bound_j) = (0, 1) with u >= 0.
                    let mut farkas = Matrix::zeros(0, k + 1);
                    for (i, side) in set {
                        let bound = if side < 0 { rows.lower[i] } else { -rows.upper[i] };
                        let mut row: Vec<f64> = rows.g.row(i).iter().map(|g| -f64::from(side) * g).collect();
                        row.push(bound);
                        farkas.push(&row);
                    }
                    let mut goal = vec![0.0; k + 1];
                    goal[k] = 1.0;
                    prop_assert!(nnls(&farkas, &goal).1 < 1e-6);
                }
                Nearest::Failed => prop_assert!(false, "no answer"),
            }
        }
    }
}
