//! A level that cannot be met, solved with those above it and a weight of damping on each variable; and what its rows reached, as the
//! levels below take it over.

use super::ties::{Force, Ties};
use super::{HALF, SLACK};
use crate::backend::Backend;
use crate::problem::{Level, LevelShape, Problem};
use crate::solution::{HierarchicalSolver, Solution, Status};
use crate::structure::Structure;

/// A room below this is none, in the unit of the row: solvers tell the two sides of a narrower one apart by rounding.
const NARROW: f64 = 1e-7;

/// A linear level is as smooth as it need be with this part of its own stiffness as damping.
const FIRM: f64 = 0.1;

/// The least damping of a variable, as a part of the greatest.
const LEAST: f64 = 1e-6;

/// How much of a second derivative counts for a level's own limits. With as much as for targets a limit that was passed is
/// regained a fifth later; with this it is regained as fast as without damping.
const LIMIT: f64 = 0.3;

/// One level and those above it, with damping.
pub(super) struct Damped {
    /// The levels down to this one; behind its rows one for each variable.
    pub(super) problem: Problem,
    pub(super) solution: Solution,
    /// What solves it, what solves the level without damping and without those below, and what solves those below once it is
    /// settled. Each has its own, so that the last tick is a start.
    pub(super) solver: Box<dyn HierarchicalSolver + Send>,
    pub(super) alone: Box<dyn HierarchicalSolver + Send>,
    pub(super) below: Option<Box<dyn HierarchicalSolver + Send>>,
    /// D.
    damping: Vec<f64>,
    /// What of it has rows of its own.
    rest: Vec<f64>,
    /// The squares of what the rows above add to it: at this solve, and with what has not faded.
    now: Vec<f64>,
    pub(super) held: Vec<f64>,
    /// What its Lagrangian consists of.
    forces: Vec<Force>,
    ties: Ties,
    /// It was damped at the last solve; at the one before.
    pub(super) used: bool,
    pub(super) likely: bool,
    /// Freedom left after it without damping.
    pub(super) freedom: usize,
}

impl Damped {
    /// For level `k` of problems of this shape.
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
            held: zeros(),
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

    /// Works out the damping of level `k`. `undamped` is the answer without. False if there is none.
    pub(super) fn damp(&mut self, k: usize, problem: &Problem, undamped: &Solution, fading: f64) -> bool {
        let level = &problem.levels[k];
        if level.damping > 0.0 {
            self.damping.fill(level.damping);
        } else {
            self.bound_curvature(k, problem, undamped, fading);
        }
        self.damping.iter().any(|d| *d > 0.0)
    }

    /// Solves level `k` with its damping, after the levels above as they are settled.
    pub(super) fn solve(&mut self, asked: &Level, settled: &Problem) -> Status {
        let Some((level, above)) = self.problem.levels.split_last_mut() else { return Status::Failed { level: 0 } };
        for (to, from) in above.iter_mut().zip(&settled.levels) {
            to.copy_from(from);
        }
        level.copy_rows_from(asked);
        self.rest.copy_from_slice(&self.damping);
        for (i, structure) in asked.structure().iter().enumerate() {
            // w (a x - b)^2 + D x^2 is (w + D/a^2) (a x - b')^2 and a constant: no row of its own.
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

    /// D, the bound of the second derivatives of the Lagrangian of level `k` at an answer.
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
        for ((sum, now), held) in self.damping.iter_mut().zip(&self.now).zip(&mut self.held) {
            *held = now.max(*held * fading * fading);
            *sum = (*sum + *held).sqrt();
            most = most.max(*sum);
        }
        if !level.is_curved() {
            // Its rows are as stiff in every direction as in their own: what is little beside that need not be damped.
            for i in 0..level.rows() {
                let weight = FIRM * level.weight[i];
                self.damping.iter_mut().zip(level.row(i)).for_each(|(d, a)| *d = (*d - weight * a * a).max(0.0));
            }
            most = self.damping.iter().fold(0.0, |most: f64, d| most.max(*d));
        }
        // A variable that moves no row has coefficients of rounding size, which nothing else would hold against.
        self.damping.iter_mut().for_each(|d| *d = d.max(LEAST * most));
    }

    /// Replaces what a level asks for by what its rows reached, with the room that it leaves to those below.
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
