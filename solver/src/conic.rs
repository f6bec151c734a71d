//! One level as a quadratic program for Clarabel: the fallback if the active-set search does not end.
//!
//! ```text
//! min 1/2 |M y - t|^2 + 1/2 |s|^2   s.t.   c y in [l, u] (higher rows),  m y - s in [l, u] (own rows)
//! ```
//!
//! Rows are added when they are first violated, so that the programs stay small. Infinite bounds are omitted.

use crate::dense::{Matrix, dot};
use crate::feasible_set::Kind;
use crate::reduced_level::{ActiveSetGuess, ReducedLevel};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus};

/// Maximum number of rounds that add violated rows, before all rows are added.
const ROUNDS: usize = 25;

/// Result of Clarabel for a reduced level.
pub(crate) struct Conic {
    /// The point, accurate to about 1e-8.
    pub(crate) y: Vec<f64>,
    /// Active set that the point suggests: violated rows of the level and blocking higher rows.
    pub(crate) guess: ActiveSetGuess,
    /// False if Clarabel stopped before it reached its tolerances: then only the guess is usable.
    pub(crate) converged: bool,
    /// Number of programs solved.
    pub(crate) solves: usize,
}

/// One side of one row of the program.
struct Side {
    /// True for a higher row, false for a row of the level.
    higher: bool,
    row: usize,
    side: i8,
}

/// Solution of one program: the point, and for each side its dual and its distance from the bound.
#[derive(Default)]
struct Point {
    y: Vec<f64>,
    dual: Vec<f64>,
    gap: Vec<f64>,
    converged: bool,
}

/// Solves the reduced level. With `nearest`, it computes instead the point nearest to the reference among those that
/// meet the higher rows, and ignores the rows of the level. Returns `None` if Clarabel fails too.
pub(crate) fn solve(reduced: &ReducedLevel, nearest: bool) -> Option<Conic> {
    let k = reduced.space.dimension();
    let none = vec![0; reduced.level.kind.len()];
    let (mut rows, mut target) = if nearest {
        (Matrix::identity(k), reduced.start.clone())
    } else {
        let (rows, target, _) = reduced.cost_rows(&none);
        (rows, target)
    };
    let largest = if nearest { 1.0 } else { largest_scale(reduced) };
    for (i, t) in target.iter_mut().enumerate() {
        rows.row_mut(i).iter_mut().for_each(|a| *a /= largest);
        *t /= largest;
    }
    let own: Vec<usize> = (0..none.len()).filter(|i| !nearest && reduced.level.kind[*i] == Kind::Inequality).collect();
    let mut sides: Vec<Side> = Vec::new();
    let mut point = Point::default();
    point.y.resize(k, 0.0);
    for round in 0..=ROUNDS {
        let before = sides.len();
        add_violated(reduced, &own, &point.y, round == ROUNDS, &mut sides);
        if round > 0 && sides.len() == before {
            return Some(answer(reduced, point, &own, &sides, round));
        }
        point = program(reduced, &rows, &target, &sides, largest)?;
    }
    Some(answer(reduced, point, &own, &sides, ROUNDS + 1))
}

fn largest_scale(reduced: &ReducedLevel) -> f64 {
    let scales = (reduced.level.scale.iter().zip(&reduced.level.kind)).filter(|(_, k)| **k != Kind::Silent);
    let largest = scales.fold(reduced.level.damping, |m, (s, _)| m.max(*s));
    if largest > 0.0 && largest.is_finite() { largest } else { 1.0 }
}

/// Adds every side that `y` violates (with `all`: every side with a finite bound) and that is not in the list yet.
fn add_violated(reduced: &ReducedLevel, own: &[usize], y: &[f64], all: bool, sides: &mut Vec<Side>) {
    let candidates = (own.iter().map(|i| (false, *i))).chain((0..reduced.higher.g.rows).map(|j| (true, j)));
    for (higher, row) in candidates {
        let from = if higher { &reduced.higher } else { &reduced.own };
        let value = dot(from.g.row(row), y);
        for (side, bound) in [(-1_i8, from.lower[row]), (1, from.upper[row])] {
            let excess = f64::from(side) * (value - bound);
            let present = || sides.iter().any(|s| (s.higher, s.row, s.side) == (higher, row, side));
            if bound.is_finite() && (all || excess > 1e-9 * (1.0 + bound.abs())) && !present() {
                sides.push(Side { higher, row, side });
            }
        }
    }
}

/// Builds and solves one program. Returns `None` if Clarabel does not even find a feasible point.
fn program(reduced: &ReducedLevel, rows: &Matrix, target: &[f64], sides: &[Side], largest: f64) -> Option<Point> {
    let k = reduced.space.dimension();
    let slacks: Vec<usize> = (0..sides.len()).filter(|s| !sides[*s].higher).collect();
    let n = k + slacks.len();
    let (mut pi, mut pj, mut pv) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..k {
        for j in i..k {
            let value: f64 = (0..rows.rows).map(|r| rows.row(r)[i] * rows.row(r)[j]).sum();
            if value != 0.0 {
                pi.push(i);
                pj.push(j);
                pv.push(value);
            }
        }
    }
    for j in k..n {
        pi.push(j);
        pj.push(j);
        pv.push(1.0);
    }
    let mut q = rows.apply_transposed(target);
    q.iter_mut().for_each(|q| *q = -*q);
    q.resize(n, 0.0);
    let (mut ai, mut aj, mut av) = (Vec::new(), Vec::new(), Vec::new());
    let mut b = Vec::with_capacity(sides.len());
    for (r, side) in sides.iter().enumerate() {
        let from = if side.higher { &reduced.higher } else { &reduced.own };
        let scale = if side.higher { 1.0 } else { reduced.level.scale[side.row] / largest };
        let sign = f64::from(side.side);
        for (j, g) in from.g.row(side.row).iter().enumerate() {
            if *g != 0.0 {
                ai.push(r);
                aj.push(j);
                av.push(sign * scale * g);
            }
        }
        if !side.higher {
            ai.push(r);
            aj.push(k + slacks.iter().position(|s| *s == r)?);
            av.push(-sign);
        }
        let bound = if side.side > 0 { from.upper[side.row] } else { from.lower[side.row] };
        b.push(sign * scale * bound);
    }
    let settings = DefaultSettings {
        verbose: false,
        max_iter: 60,
        max_threads: 1,
        tol_gap_abs: 1e-11,
        tol_gap_rel: 1e-11,
        tol_feas: 1e-11,
        ..DefaultSettings::default()
    };
    let p = CscMatrix::new_from_triplets(n, n, pi, pj, pv);
    let a = CscMatrix::new_from_triplets(sides.len(), n, ai, aj, av);
    let cones = [NonnegativeConeT(sides.len())];
    let cones = if sides.is_empty() { &cones[..0] } else { &cones[..] };
    let mut solver = DefaultSolver::new(&p, &q, &a, &b, cones, settings).ok()?;
    solver.solve();
    let solution = &solver.solution;
    let small = solution.r_prim < 1e-7 && solution.r_dual < 1e-7;
    if !small || solution.x.iter().any(|x| !x.is_finite()) {
        return None;
    }
    Some(Point {
        y: solution.x[..k].to_vec(),
        dual: solution.z.clone(),
        gap: solution.s.clone(),
        converged: matches!(solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved),
    })
}

/// Derives the active set from Clarabel's point: a row of the level is violated if its distance from the interval
/// exceeds a tolerance; a higher row is blocking if its dual is larger than its gap.
fn answer(reduced: &ReducedLevel, point: Point, own: &[usize], sides: &[Side], solves: usize) -> Conic {
    let y = point.y;
    let mut guess = ActiveSetGuess { violated: vec![0; reduced.level.kind.len()], blocking: Vec::new() };
    for &i in own {
        let value = dot(reduced.own.g.row(i), &y);
        let size = 1e-7 * (1.0 + value.abs());
        if value < reduced.own.lower[i] - size {
            guess.violated[i] = -1;
        } else if value > reduced.own.upper[i] + size {
            guess.violated[i] = 1;
        }
    }
    for (s, side) in sides.iter().enumerate().filter(|(_, s)| s.higher) {
        if point.dual[s] > point.gap[s] {
            guess.blocking.push((reduced.space.names[side.row], side.side));
        }
    }
    Conic { y, guess, solves, converged: point.converged }
}
