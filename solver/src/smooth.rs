//! Smooth levels: exact where they can be met, damped where they cannot.
//!
//! The optimum of a level that cannot be met jumps with its data. Near a singular configuration, or where a bound above
//! makes one, a direction that moves the level by 1e-6 is used at full speed, one way or the other by the sign of a
//! gradient of that size. The linear rows promise an improvement there that the step does not bring. What the step does
//! bring is second order: with `s_i` what remains of row `i` in the level's optimum, a step of `x` over a time T changes
//! the cost by `T sum_i w_i s_i x^T H_i x` more than the rows say, `H_i` the second derivative of row `i`.
//!
//! A level that is not met is therefore solved with damping,
//!
//! ```text
//! min  sum_i w_i dist(a_i x, [lower_i, upper_i])^2  +  sum_j D_j x_j^2
//! D_j^2  =  sum_i (c_ij f_i)^2,      c_ij >= tau sum_k |H_ijk|
//! ```
//!
//! among the minimisers of the levels above. The forces `f_i` are those of the optimum without damping: `w_i s_i` for the
//! level's own rows, and the multipliers of the rows above that hold it back, be they at a bound or tied to one value.
//! `c_ij` is [`crate::Level::set_curvature`].
//! For one row `diag(D)` bounds the second derivatives of the level's Lagrangian by Gershgorin's theorem, so that with tau
//! of half a period or more a step does not take back what it promises; m independent rows may add up to sqrt(m) times as
//! much, for which tau has to have room. This is the Levenberg-Marquardt step of Sugihara (2011)
//! with a bound of the second derivative in place of a constant and the part of the error that no motion removes in place
//! of the whole; Pfeiffer, Escande and Kheddar (2018) use the matrix itself, of the Lagrangian too. D vanishes with what
//! remains: a level that can be met is met exactly.
//!
//! To the levels below a damped level passes on what its rows reached, `y_i = a_i x`, and not the point: its damping takes
//! none of their freedom. Were these equalities, a direction that moves the level by next to nothing would belong to it
//! down to rounding, and to the levels below beyond it, with a jump. So levels below may move row `i` by at most
//! [`SLACK`], less where less remains; that is all by which they ever worsen it.
//!
//! Where the velocity is limited from tick to tick, it changes from tick to tick which rows carry the force of a level
//! that presses against those above. What the rows above add to D therefore fades with a time of its own
//! ([`Smooth::with_fading`]) and only rises at once. This is the one thing that is remembered; [`Smooth::forget`] ends it.
//!
//! A level that is met, or that nothing curved holds back, is passed on as ever. So is one with a hard level below, whose rows
//! a damped answer might not leave room for. For limits a shorter time T counts than for targets ([`LIMIT`]).

use crate::backend::Backend;
use crate::problem::{Level, LevelShape, Problem};
use crate::solution::{Active, HierarchicalSolver, LevelStatus, Solution, Status};
use crate::structure::Structure;
use std::ops::Range;
use std::time::Instant;

/// How far levels below may move a row of weight one of a damped level, in the unit of the row (0.02 mm/s, 0.02 mrad/s).
pub const SLACK: f64 = 2e-5;

/// What remains of a level where they may move it half as far.
pub const HALF: f64 = 1e-2;

/// A room below this is none, in the unit of the row: solvers tell the two sides of a narrower one apart by rounding.
const NARROW: f64 = 1e-7;

/// A direction whose square is below this part of the largest row's bears nothing.
const LOOSE: f64 = 1e-6;

/// A linear level is as smooth as it need be with this part of its own stiffness as damping.
const FIRM: f64 = 0.1;

/// The least damping of a variable, as a part of the greatest.
const LEAST: f64 = 1e-6;

/// How much of a second derivative counts for a level's own limits. With as much as for targets a limit that was passed is
/// regained a fifth later; with this it is regained as fast as without damping.
const LIMIT: f64 = 0.3;

/// A slack up to this part of a row and its bound is none, as in [`LevelStatus::Met`].
const MET: f64 = 1e-9;

/// How much of a row's derivative stands in a gradient: its slack times its weight, or its multiplier. Positive where the
/// row is to have less.
#[derive(Clone, Copy, Debug)]
struct Force {
    level: usize,
    row: usize,
    force: f64,
}

/// One level and those above it, with damping.
struct Damped {
    /// The levels down to this one; behind its rows one for each variable.
    problem: Problem,
    solution: Solution,
    /// What solves it, what solves the level without damping and without those below, and what solves those below once it is
    /// settled. Each has its own, so that the last tick is a start.
    solver: Box<dyn HierarchicalSolver + Send>,
    alone: Box<dyn HierarchicalSolver + Send>,
    below: Option<Box<dyn HierarchicalSolver + Send>>,
    /// D.
    damping: Vec<f64>,
    /// What of it has rows of its own.
    rest: Vec<f64>,
    /// The squares of what the rows above add to it: at this solve, and with what has not faded.
    now: Vec<f64>,
    held: Vec<f64>,
    /// What its Lagrangian consists of.
    forces: Vec<Force>,
    ties: Ties,
    /// It was damped at the last solve; at the one before.
    used: bool,
    likely: bool,
    /// Freedom left after it without damping.
    freedom: usize,
}

/// The rows above a level that may only have one value: what they bear of its forces.
struct Ties {
    rows: Vec<(usize, usize)>,
    /// Of the rows, and of the forces with each of them; then the multipliers.
    gram: Vec<f64>,
    bears: Vec<f64>,
    gradient: Vec<f64>,
}

impl Ties {
    fn new(n: usize, rows: usize) -> Self {
        Ties {
            rows: Vec::with_capacity(rows),
            gram: vec![0.0; rows * rows],
            bears: vec![0.0; rows],
            gradient: vec![0.0; n],
        }
    }

    /// Adds the multipliers of the tied rows to the forces with which level `k` presses: the least `mu` with
    /// `sum_i mu_i a_i + sum_f f a_f = 0`, up to [`LOOSE`] where rows are dependent.
    fn bear(&mut self, k: usize, problem: &Problem, answer: &Solution, forces: &mut Vec<Force>) {
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

/// A solver of smooth hierarchies on top of one of exact hierarchies.
pub struct Smooth {
    exact: Box<dyn HierarchicalSolver + Send>,
    /// For each level that may be damped.
    damped: Vec<Option<Damped>>,
    /// The problem with what damped levels reached in place of what they ask for.
    settled: Problem,
    answer: Solution,
    /// Which part of the damping that rows above make is left at the next solve.
    fading: f64,
    /// Levels were damped at the last solve.
    used: bool,
    /// The exact answer of all levels was known before the first was damped.
    whole: bool,
}

impl Smooth {
    /// A solver for problems of this shape.
    pub fn new(problem: &Problem, backend: Backend) -> Self {
        let last_hard = problem.levels.iter().rposition(|l| l.hard);
        let may = |k: usize| problem.levels[k].rows() > 0 && last_hard.is_none_or(|h| k > h);
        let below = |k: usize| problem.levels[k + 1..].iter().any(|l| l.rows() > 0).then(|| backend.solver(problem));
        let damped = |k: usize| {
            let below = below(k);
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
        };
        Smooth {
            exact: backend.solver(problem),
            damped: (0..problem.levels.len()).map(|k| may(k).then(|| damped(k))).collect(),
            answer: Solution::new(problem),
            settled: problem.clone(),
            fading: 0.0,
            used: false,
            whole: false,
        }
    }

    /// Which part of the damping that rows above make is left at the next solve, 0 to 1; 0 at first.
    pub fn with_fading(mut self, part: f64) -> Self {
        self.fading = part.clamp(0.0, 1.0);
        self
    }

    /// A level that is to be exact always, whether it can be met or not.
    pub fn with_exact(mut self, level: usize) -> Self {
        if let Some(damped) = self.damped.get_mut(level) {
            *damped = None;
        }
        self
    }

    /// Forgets the damping that has not faded.
    pub fn forget(&mut self) {
        self.damped.iter_mut().flatten().for_each(|d| d.held.fill(0.0));
    }

    /// The problem whose exact optimum the last answer is: that which was given, with what damped levels reached in place
    /// of what they ask for. None where nothing was damped, and the answer is the optimum of the problem itself.
    pub fn settled(&self) -> Option<&Problem> {
        self.used.then_some(&self.settled)
    }

    /// Whether a level was damped at the last solve.
    pub fn is_damped(&self, level: usize) -> bool {
        self.damped.get(level).and_then(Option::as_ref).is_some_and(|d| d.used)
    }

    /// The damped levels of the last solve: the level, its problem with those above as they were settled, and the answer.
    pub fn damped(&self) -> impl Iterator<Item = (usize, &Problem, &Solution)> {
        self.damped
            .iter()
            .enumerate()
            .filter_map(|(k, d)| d.as_ref().filter(|d| d.used).map(|d| (k, &d.problem, &d.solution)))
    }

    /// Copies the problem, without the damping of levels that may be damped here.
    fn copy(&mut self, problem: &Problem) {
        self.settled.reference.copy_from_slice(&problem.reference);
        for ((to, from), damped) in self.settled.levels.iter_mut().zip(&problem.levels).zip(&self.damped) {
            to.copy_from(from);
            to.damping = if damped.is_some() { 0.0 } else { from.damping };
        }
    }

    /// The first of these levels that is to be damped, by an answer without its damping.
    fn next(&self, problem: &Problem, levels: Range<usize>, answer: &Solution) -> Option<usize> {
        let wants = |&k: &usize| {
            let curved = |k: usize| problem.levels[k].is_curved();
            let held = || problem.levels[..k].iter().any(Level::is_curved);
            let unmet = answer.levels[k].status == LevelStatus::Relaxed;
            self.damped[k].is_some() && (problem.levels[k].damping > 0.0 || (unmet && (curved(k) || held())))
        };
        levels.clone().find(wants)
    }

    /// Solves what is settled down to the next level that was damped at the last solve: if it is again, those below would be
    /// solved in vain. `last` is the level that was settled last. Returns how many levels have an answer.
    fn undamped(&mut self, problem: &Problem, last: Option<usize>, levels: usize, solution: &mut Solution) -> usize {
        let from = last.map_or(0, |k| k + 1);
        let likely = |k: &usize| k + 1 < levels && self.damped[*k].as_ref().is_some_and(|d| d.likely);
        let likely = (from..levels).find(likely);
        let copied = self.used || problem.levels.iter().any(|l| l.damping > 0.0);
        let Smooth { exact, damped, settled, answer, used, .. } = self;
        let solver = match likely {
            Some(k) => damped[k].as_mut().map(|d| &mut d.alone),
            None => last.and_then(|k| damped[k].as_mut()).and_then(|d| d.below.as_mut()),
        };
        let covered = likely.map_or(levels, |k| k + 1);
        let answer = if *used { answer } else { solution };
        solver.unwrap_or(exact).solve_first(if copied { settled } else { problem }, covered, answer);
        covered
    }
}

impl Damped {
    /// Works out the damping of level `k`. `undamped` is the answer without. False if there is none.
    fn damp(&mut self, k: usize, problem: &Problem, undamped: &Solution, fading: f64) -> bool {
        let level = &problem.levels[k];
        if level.damping > 0.0 {
            self.damping.fill(level.damping);
        } else {
            self.bound_curvature(k, problem, undamped, fading);
        }
        self.damping.iter().any(|d| *d > 0.0)
    }

    /// Solves level `k` with its damping, after the levels above as they are settled.
    fn solve(&mut self, asked: &Level, settled: &Problem) -> Status {
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
    fn settle(&self, asked: &Level, level: &mut Level, slack: &[f64]) {
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

impl HierarchicalSolver for Smooth {
    fn name(&self) -> &'static str {
        self.exact.name()
    }

    fn set_deadline(&mut self, until: Option<Instant>) {
        self.exact.set_deadline(until);
        for one in self.damped.iter_mut().flatten() {
            one.solver.set_deadline(until);
            one.alone.set_deadline(until);
            if let Some(below) = &mut one.below {
                below.set_deadline(until);
            }
        }
    }

    fn solve_first(&mut self, problem: &Problem, levels: usize, solution: &mut Solution) {
        self.used = false;
        for one in self.damped.iter_mut().flatten() {
            (one.likely, one.used) = (one.used, false);
        }
        if problem.levels.iter().any(|l| l.damping > 0.0) {
            self.copy(problem);
        }
        // The level that was settled last, the levels that have been looked at, and those that have an answer.
        let (mut last, mut from, mut covered) = (None, 0, 0);
        loop {
            if covered == 0 {
                covered = self.undamped(problem, last, levels, solution);
                let status = if self.used { self.answer.status } else { solution.status };
                if status != Status::Optimal {
                    if self.used {
                        solution.x.copy_from_slice(&self.answer.x);
                    }
                    // A level that is about to be damped does not lead to the answer.
                    solution.status = match status {
                        Status::OutOfTime { on_the_way } => {
                            Status::OutOfTime { on_the_way: on_the_way && covered == levels }
                        }
                        other => other,
                    };
                    return;
                }
            }
            let undamped = if self.used { &self.answer } else { &*solution };
            let Some(k) = self.next(problem, from..covered, undamped) else {
                if covered == levels {
                    break;
                }
                // It was damped at the last solve, and need not be any more.
                self.damped[covered - 1].iter_mut().for_each(|one| one.likely = false);
                (from, covered) = (covered, 0);
                continue;
            };
            from = k + 1;
            if !self.damped[k].as_mut().is_some_and(|one| one.damp(k, problem, undamped, self.fading)) {
                continue;
            }
            let first = !self.used;
            if first {
                self.copy(problem);
                (self.used, self.whole) = (true, covered == levels);
            }
            let Smooth { damped, settled, answer, .. } = self;
            let undamped = if first { &*solution } else { &*answer };
            let Some(one) = damped[k].as_mut() else { return };
            match one.solve(&problem.levels[k], settled) {
                Status::Optimal => {}
                Status::OutOfTime { on_the_way } => {
                    solution.x.copy_from_slice(&one.solution.x);
                    solution.status = Status::OutOfTime { on_the_way: on_the_way && one.below.is_none() };
                    return;
                }
                Status::Unproven { .. } => {
                    solution.status = Status::Unproven { level: k };
                    return;
                }
                _ => {
                    solution.status = Status::Failed { level: k };
                    return;
                }
            }
            one.freedom = undamped.levels[k].freedom;
            one.settle(&problem.levels[k], &mut settled.levels[k], &undamped.levels[k].slack);
            // The room is for the levels below, not for the choice of the nearest point.
            settled.reference.copy_from_slice(&one.solution.x);
            // Without one nothing is left to choose.
            if one.below.is_none() {
                break;
            }
            (last, covered) = (Some(k), 0);
        }
        if self.used {
            self.report(problem, solution);
        }
    }
}

impl Smooth {
    /// Writes the answer into the solution, in which the exact one is. What remains of a damped level is measured against
    /// what it asks for, and the rows that hold it back are those of the damped problem. Freedoms are those without damping, or as good as known where the levels below were not solved without it.
    fn report(&self, problem: &Problem, solution: &mut Solution) {
        let last = problem.levels.iter().rposition(|l| l.rows() > 0).and_then(|l| self.damped[l].as_ref());
        let found = last.filter(|d| d.used).map_or(&self.answer, |d| &d.solution);
        solution.x.copy_from_slice(&found.x);
        let x = &solution.x;
        solution.blocking.clear();
        // Levels below a damped one were given the freedom of its rows' room, but for those that they press against.
        let mut room = 0_usize;
        for (l, level) in problem.levels.iter().enumerate() {
            // Levels without rows may follow the last one.
            let (Some(answer), out) = (found.levels.get(l), &mut solution.levels[l]) else { continue };
            let damped = self.damped[l].as_ref().filter(|d| d.used);
            if !self.whole {
                let pressed = found.blocking.iter().filter(|b| b.level <= l && self.is_damped(b.by_level)).count();
                let room = room.saturating_sub(pressed);
                out.freedom = damped.map_or(answer.freedom, |d| d.freedom).saturating_sub(room);
            }
            room += damped.map_or(0, |d| answer.freedom.saturating_sub(d.freedom));
            if damped.is_some() {
                let (mut sum, mut met) = (0.0, true);
                for i in 0..level.rows() {
                    let slack = level.slack(i, x);
                    let bound = if slack < 0.0 { level.lower[i] } else { level.upper[i] };
                    let size: f64 = level.row(i).iter().map(|a| a * a).sum::<f64>().sqrt();
                    let beyond = slack.abs() > MET * (size + bound.abs()) && level.weight[i] > 0.0;
                    met &= !beyond;
                    out.active[i] = if beyond { Active::Violated } else { answer.active[i] };
                    out.slack[i] = slack;
                    out.multipliers[i] = level.weight[i] * slack;
                    sum += level.weight[i] * slack * slack;
                }
                out.violation = sum.sqrt();
                out.status = if met { LevelStatus::Met } else { LevelStatus::Relaxed };
            } else {
                out.status = answer.status;
                out.violation = answer.violation;
                out.slack.copy_from_slice(&answer.slack);
                out.active.copy_from_slice(&answer.active);
                out.multipliers.copy_from_slice(&answer.multipliers);
            }
            let blocking = damped.map_or(&found.blocking, |d| &d.solution.blocking);
            for b in blocking.iter().filter(|b| b.level == l) {
                if solution.blocking.len() < solution.blocking.capacity() {
                    solution.blocking.push(*b);
                }
            }
        }
        solution.status = Status::Optimal;
    }
}
