//! Smooth levels: exact if they can be met, damped if they cannot.
//!
//! The optimum of a level that cannot be met jumps with its data. Near a singular configuration, or if a bound above
//! causes one, a direction that moves the level by 1e-6 is used at full speed, forwards or backwards by the sign of a
//! gradient of that size. The linear rows promise an improvement there that the step does not achieve. The actual
//! change is of second order: with `s_i` the residual of row `i` at the level's optimum, a step of `x` over a time T
//! changes the cost by `T sum_i w_i s_i x^T H_i x` more than the rows predict, with `H_i` the second derivative of row
//! `i`.
//!
//! A level that is not met is therefore solved with damping,
//!
//! ```text
//! min  sum_i w_i dist(a_i x, [lower_i, upper_i])^2  +  sum_j D_j x_j^2
//! D_j^2  =  sum_i (c_ij f_i)^2,      c_ij >= tau sum_k |H_ijk|
//! ```
//!
//! among the minimisers of the levels above. The forces `f_i` are those of the optimum without damping: `w_i s_i` for
//! the level's own rows, and the multipliers of the rows above that hold it back, at a bound or at a fixed value.
//! `c_ij` is set by [`crate::Level::set_curvature`]. For one row `diag(D)` bounds the second derivatives of the level's
//! Lagrangian by Gershgorin's theorem, so that with tau of half a period or more a step does not lose what it promises;
//! m independent rows may add up to sqrt(m) times as much, for which tau needs a margin. This is the
//! Levenberg-Marquardt step of Sugihara (2011) with a bound of the second derivative instead of a constant, and with
//! the part of the error that no motion removes instead of the whole error; Pfeiffer, Escande and Kheddar (2018) use
//! the matrix itself, also of the Lagrangian. D vanishes with the residual: a level that can be met is met exactly.
//!
//! A damped level passes on the values that its rows reached, `y_i = a_i x`, to the levels below, and not the point:
//! its damping takes none of their freedom. If these values were equalities, a direction that moves the level by next
//! to nothing would belong to it down to rounding, and to the levels below beyond it, with a jump. Levels below may
//! therefore move row `i` by at most [`SLACK`], less if the residual is smaller; they never worsen it by more.
//!
//! If the velocity is limited from tick to tick, the rows that carry the force of a level against those above change
//! from tick to tick. The contribution of the rows above to D therefore rises at once and fades with a time constant of
//! its own ([`Smooth::with_fading`]). This is the only memory that affects the result; [`Smooth::forget`] clears it.
//!
//! A level that is met, or that nothing curved holds back, is passed on unchanged. So is a level with a hard level
//! below, because a damped answer might not leave room for its rows. Limits use a shorter time T than targets
//! (`LIMIT` in `damped`).

mod damped;
mod ties;

use crate::backend::Backend;
use crate::problem::{Level, Problem};
use crate::solution::{Active, HierarchicalSolver, LevelStatus, MET, Solution, Status};
use damped::Damped;
use std::ops::Range;
use std::time::Instant;

/// Maximum distance that levels below may move a row of weight one of a damped level, in the unit of the row (0.02
/// mm/s, 0.02 mrad/s).
pub const SLACK: f64 = 2e-5;

/// Residual of a level at which they may move it half as far.
pub const HALF: f64 = 1e-2;

/// A solver of smooth hierarchies on top of one of exact hierarchies.
pub struct Smooth {
    exact: Box<dyn HierarchicalSolver + Send>,
    /// One entry per level; None if the level is never damped.
    damped: Vec<Option<Damped>>,
    /// The problem with the values that damped levels reached in place of their targets.
    settled: Problem,
    answer: Solution,
    /// Fraction of the damping by the rows above that is left at the next solve.
    fading: f64,
    /// True if levels were damped at the last solve.
    used: bool,
    /// True if the exact answer of all levels was known before the first was damped.
    whole: bool,
}

impl Smooth {
    /// Creates a solver for problems of this shape.
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

    /// Sets the fraction of the damping by the rows above that is left at the next solve, 0 to 1; 0 by default.
    pub fn with_fading(mut self, part: f64) -> Self {
        self.fading = part.clamp(0.0, 1.0);
        self
    }

    /// Solves a problem that differs little from that of the last solve, in the same tick: no damping fades in between.
    pub fn solve_again(&mut self, problem: &Problem, solution: &mut Solution) {
        let fading = std::mem::replace(&mut self.fading, 1.0);
        self.solve(problem, solution);
        self.fading = fading;
    }

    /// Excludes a level from damping: it is exact even if it cannot be met.
    pub fn with_exact(mut self, level: usize) -> Self {
        if let Some(damped) = self.damped.get_mut(level) {
            *damped = None;
        }
        self
    }

    /// Clears the damping that has not faded.
    pub fn forget(&mut self) {
        self.damped.iter_mut().flatten().for_each(|d| d.peak.fill(0.0));
    }

    /// Returns the problem whose exact optimum the last answer is: the given one, with the values that damped levels
    /// reached in place of their targets. None if nothing was damped; the answer is then the optimum of the problem
    /// itself.
    pub fn settled(&self) -> Option<&Problem> {
        self.used.then_some(&self.settled)
    }

    /// Returns true if a level was damped at the last solve.
    pub fn is_damped(&self, level: usize) -> bool {
        self.damped.get(level).and_then(Option::as_ref).is_some_and(|d| d.used)
    }

    /// Returns the damped levels of the last solve: the level, its problem with the settled levels above, and the
    /// answer.
    pub fn damped(&self) -> impl Iterator<Item = (usize, &Problem, &Solution)> {
        self.damped
            .iter()
            .enumerate()
            .filter_map(|(k, d)| d.as_ref().filter(|d| d.used).map(|d| (k, &d.problem, &d.solution)))
    }

    /// Copies the problem, without the damping of levels that this solver may damp.
    fn copy(&mut self, problem: &Problem) {
        self.settled.reference.copy_from_slice(&problem.reference);
        for ((to, from), damped) in self.settled.levels.iter_mut().zip(&problem.levels).zip(&self.damped) {
            to.copy_from(from);
            to.damping = if damped.is_some() { 0.0 } else { from.damping };
        }
    }

    /// Returns the first of these levels that is to be damped, judged by an answer without its damping.
    fn next(&self, problem: &Problem, levels: Range<usize>, answer: &Solution) -> Option<usize> {
        let wants = |&k: &usize| {
            let curved = |k: usize| problem.levels[k].is_curved();
            let curved_above = || problem.levels[..k].iter().any(Level::is_curved);
            let unmet = answer.levels[k].status == LevelStatus::Relaxed;
            self.damped[k].is_some() && (problem.levels[k].damping > 0.0 || (unmet && (curved(k) || curved_above())))
        };
        levels.clone().find(wants)
    }

    /// Solves the settled problem down to the next level that was damped at the last solve: if it is damped again,
    /// solving the levels below would be in vain. `last` is the level that was settled last. Returns the number of
    /// levels with an answer.
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
        // The last settled level, the number of levels that were examined, and the number of levels with an answer.
        let (mut last, mut from, mut covered) = (None, 0, 0);
        loop {
            if covered == 0 {
                covered = self.undamped(problem, last, levels, solution);
                let status = if self.used { self.answer.status } else { solution.status };
                if status != Status::Optimal {
                    if self.used {
                        solution.x.copy_from_slice(&self.answer.x);
                    }
                    // The undamped point of a level that is about to be damped is not on the way to the answer.
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
                // This level was damped at the last solve, and does not need it any more.
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
            // The margin is for the levels below, not for the choice of the nearest point.
            settled.reference.copy_from_slice(&one.solution.x);
            // Without levels below, nothing is left to choose.
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
    /// Writes the answer into the solution, which contains the exact one. The residual of a damped level refers to its
    /// targets, and the rows that hold it back are those of the damped problem. Freedoms are those without damping;
    /// they are estimated if the levels below were not solved without it.
    fn report(&self, problem: &Problem, solution: &mut Solution) {
        let last = problem.levels.iter().rposition(|l| l.rows() > 0).and_then(|l| self.damped[l].as_ref());
        let found = last.filter(|d| d.used).map_or(&self.answer, |d| &d.solution);
        solution.x.copy_from_slice(&found.x);
        let x = &solution.x;
        solution.blocking.clear();
        // The margin of a damped level's rows counts as freedom in the answer; it is subtracted, except for the rows
        // that the levels below press against.
        let mut room = 0_usize;
        for (l, level) in problem.levels.iter().enumerate() {
            // The answer may end before trailing levels without rows.
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
