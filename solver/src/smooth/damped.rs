//! A level that cannot be met: its problem together with the levels above and a damping weight for each variable, and
//! the values that its rows reached, for the levels below.

use super::ties::{Force, Ties};
use super::{HALF, SLACK};
use crate::backend::Backend;
use crate::problem::{Level, LevelShape, Problem};
use crate::solution::{HierarchicalSolver, Solution, Status};
use crate::structure::Structure;

/// A margin below this counts as zero, in the unit of the row: solvers distinguish the two sides of a narrower interval
/// only by rounding.
const NARROW: f64 = 1e-7;

/// Fraction of a linear level's own stiffness that counts as damping.
const FIRM: f64 = 0.1;

/// Minimum damping of a variable, relative to the maximum.
const LEAST: f64 = 1e-6;

/// Factor on the second derivatives of a level's own limits. With the factor of targets, 1, returning to an exceeded
/// limit takes a fifth longer; with this factor it is as fast as without damping.
const LIMIT: f64 = 0.3;

/// One level and those above it, with damping.
pub(super) struct Damped {
    /// The levels down to this one; its own rows are followed by one row for each variable.
    pub(super) problem: Problem,
    pub(super) solution: Solution,
    /// Solvers of the damped level, of the level without damping and without those below, and of the levels below once
    /// this one is settled. They are separate, so that each can start from its last tick.
    pub(super) solver: Box<dyn HierarchicalSolver + Send>,
    pub(super) alone: Box<dyn HierarchicalSolver + Send>,
    pub(super) below: Option<Box<dyn HierarchicalSolver + Send>>,
    /// Damping D of each variable.
    damping: Vec<f64>,
    /// Part of D that has rows of its own.
    rest: Vec<f64>,
    /// Squared contribution of the rows above to D at this solve.
    now: Vec<f64>,
    /// The same with its fading peak: the part of earlier solves that has not faded yet counts.
    pub(super) peak: Vec<f64>,
    /// Forces in the Lagrangian of the level.
    forces: Vec<Force>,
    ties: Ties,
    /// True if the level was damped at the last solve; at the one before.
    pub(super) used: bool,
    pub(super) likely: bool,
    /// Freedom that the level leaves without damping.
    pub(super) freedom: usize,
}

impl Damped {
    /// Creates the damped problem of level `k` for problems of this shape.
    pub(super) fn new(problem: &Problem, k: usize, backend: Backend) -> Self {
        let below = problem.levels[k + 1..].iter().any(|l| l.rows() > 0).then(|| backend.solver(problem));
        let mut shapes: Vec<LevelShape> = problem.levels[..=k].iter().map(Level::shape).collect();
        shapes.iter_mut().for_each(|s| s.damping = 0.0);
        let own = shapes[k].rows;
        shapes[k].rows += problem.n;
        let alone = backend.solver(problem);
        let mut problem = Problem::new(problem.n, &shapes);
        for j in 0..problem.n {
            let level = &mut problem.levels[k];
            level.row_mut(own + j)[j] = 1.0;
            (level.lower[own + j], level.upper[own + j]) = (0.0, 0.0);
        }
        problem.levels[k].fix(own..own + problem.n);
        let zeros = || vec![0.0; problem.n];
        let above = problem.levels[..k].iter().map(Level::rows).sum();
        Damped {
            forces: Vec::with_capacity(above + problem.levels[k].rows() + problem.n + 1),
            ties: Ties::new(problem.n, above),
            damping: zeros(),
            rest: zeros(),
            now: zeros(),
            peak: zeros(),
            solution: Solution::new(&problem),
            solver: backend.solver(&problem),
            alone,
            below,
            problem,
            used: false,
            likely: false,
            freedom: 0,
        }
    }

    /// Computes the damping of level `k` from `undamped`, the answer without damping. Returns false if it is zero.
    pub(super) fn damp(&mut self, k: usize, problem: &Problem, undamped: &Solution, fading: f64) -> bool {
        let level = &problem.levels[k];
        if level.damping > 0.0 {
            self.damping.fill(level.damping);
        } else {
            self.bound_curvature(k, problem, undamped, fading);
        }
        self.damping.iter().any(|d| *d > 0.0)
    }

    /// Solves level `k` with its damping, within the settled levels above.
    pub(super) fn solve(&mut self, asked: &Level, settled: &Problem) -> Status {
        let Some((level, above)) = self.problem.levels.split_last_mut() else { return Status::Failed { level: 0 } };
        for (to, from) in above.iter_mut().zip(&settled.levels) {
            to.copy_from(from);
        }
        level.copy_rows_from(asked);
        self.rest.copy_from_slice(&self.damping);
        for (i, structure) in asked.structure().iter().enumerate() {
            // w (a x - b)^2 + D x^2 equals (w + D/a^2) (a x - b')^2 plus a constant: it needs no row of its own.
            if let Structure::Bound { column, coefficient } = *structure
                && asked.is_equality(i)
                && asked.weight[i] > 0.0
            {
                let weight = asked.weight[i] + self.rest[column] / (coefficient * coefficient);
                let asks = asked.lower[i] * asked.weight[i] / weight;
                (level.weight[i], level.lower[i], level.upper[i]) = (weight, asks, asks);
                self.rest[column] = 0.0;
            }
        }
        level.weight[asked.rows()..].copy_from_slice(&self.rest);
        self.problem.reference.copy_from_slice(&settled.reference);
        self.solver.solve(&self.problem, &mut self.solution);
        self.used = true;
        self.solution.status
    }

    /// Computes D, the bound of the second derivatives of the Lagrangian of level `k` at an answer.
    fn bound_curvature(&mut self, k: usize, problem: &Problem, answer: &Solution, fading: f64) {
        self.damping.fill(0.0);
        self.now.fill(0.0);
        self.forces.clear();
        let level = &problem.levels[k];
        for (row, slack) in answer.levels[k].slack.iter().enumerate().filter(|(_, s)| **s != 0.0) {
            self.forces.push(Force { level: k, row, force: level.weight[row] * slack });
        }
        for b in answer.blocking.iter().filter(|b| b.level == k) {
            let force = if b.at_upper { b.multiplier } else { -b.multiplier };
            self.forces.push(Force { level: b.by_level, row: b.by_row, force });
        }
        self.ties.bear(k, problem, answer, &mut self.forces);
        for f in &self.forces {
            let sums = if f.level == k { &mut self.damping } else { &mut self.now };
            let limit = f.level == k && !level.is_equality(f.row);
            let part = if limit { LIMIT } else { 1.0 };
            for (sum, c) in sums.iter_mut().zip(problem.levels[f.level].curvature(f.row)) {
                *sum += (c * f.force * part).powi(2);
            }
        }
        let mut most = 0.0_f64;
        for ((sum, now), peak) in self.damping.iter_mut().zip(&self.now).zip(&mut self.peak) {
            *peak = now.max(*peak * fading * fading);
            *sum = (*sum + *peak).sqrt();
            most = most.max(*sum);
        }
        if !level.is_curved() {
            // Damping that is small relative to the stiffness of a linear level's own rows is not needed.
            for i in 0..level.rows() {
                let weight = FIRM * level.weight[i];
                self.damping.iter_mut().zip(level.row(i)).for_each(|(d, a)| *d = (*d - weight * a * a).max(0.0));
            }
            most = self.damping.iter().fold(0.0, |most: f64, d| most.max(*d));
        }
        // A variable that moves no row has coefficients of the size of rounding; only damping keeps it in place.
        self.damping.iter_mut().for_each(|d| *d = d.max(LEAST * most));
    }

    /// Replaces the targets of a level by the values that its rows reached, with a margin for the levels below.
    pub(super) fn settle(&self, asked: &Level, level: &mut Level, slack: &[f64]) {
        let x = &self.solution.x;
        let square: f64 = slack.iter().zip(&asked.weight).map(|(s, w)| w * s * s).sum();
        let remains = square.sqrt();
        for i in 0..asked.rows() {
            let weight = asked.weight[i];
            let beyond = asked.slack(i, x);
            if weight == 0.0 || (beyond == 0.0 && !asked.is_equality(i)) {
                continue;
            }
            let reached = asked.row(i).iter().zip(x).map(|(a, x)| a * x).sum::<f64>();
            let room = SLACK * remains / (remains + HALF) / weight.sqrt();
            let room = if room > NARROW { room } else { 0.0 };
            if asked.is_equality(i) {
                (level.lower[i], level.upper[i]) = (reached - room, reached + room);
            } else if beyond < 0.0 {
                level.lower[i] = reached - room;
            } else {
                level.upper[i] = reached + room;
            }
        }
    }
}
