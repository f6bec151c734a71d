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

mod damped;
mod ties;

use crate::backend::Backend;
use crate::problem::{Level, Problem};
use crate::solution::{Active, HierarchicalSolver, LevelStatus, MET, Solution, Status};
use damped::Damped;
use std::ops::Range;
use std::time::Instant;

/// How far levels below may move a row of weight one of a damped level, in the unit of the row (0.02 mm/s, 0.02 mrad/s).
pub const SLACK: f64 = 2e-5;

/// What remains of a level where they may move it half as far.
pub const HALF: f64 = 1e-2;

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
        Smooth {
            exact: backend.solver(problem),
            damped: (0..problem.levels.len()).map(|k| may(k).then(|| Damped::new(problem, k, backend))).collect(),
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
