//! Blend from the velocity of another stack.
//!
//! Let v be the velocity of the reference at the last tick, and v_B(0) the solution of the stack at its first tick. During a blend of T seconds, the stack's hierarchy is solved as usual, which yields v_B, and then once more
//! for
//!
//! ```text
//! v*  =  v_B + (1 - s) (v - v_B(0)),     s = x²(3 - 2x),  x = t/T
//! ```
//!
//! The result is the point nearest to v* among those that meet every hard level of the stack as well as possible, and
//! every soft level that it shares with the previous stack, above the first level in which the two differ. At x = 0 the
//! result is v, up to the demands of these levels; at x = 1 it is v_B. A hard level therefore holds at every tick of a
//! blend as at every other. Source: ours.
//!
//! Limits of accelerations are not part of v_B during a blend: with them v_B(0) would be close to v and leave nothing
//! to blend, and the stack would approach its own solution as fast as the limits allow. They are part of the problem of
//! the point nearest to v*. A stack with a safety planner keeps them in v_B, since the planner takes all rows above it
//! into account.
//!
//! The damping of a level applies to v_B only: in the problem of the point nearest to v* it would pull v* to rest. In
//! that problem, a soft level that was damped asks for the values that its rows reached.
//!
//! Locked joints that move when the stack is entered come to rest during the blend. Their velocity is zero in v_B, so
//! v* reduces it from v to zero with 1 - s. The problem of the point nearest to v* contains their true columns, with
//! `0 <= v_i / v_i(last tick) <= 1` above all levels. That problem has a solution whenever the stack's own problem has
//! one: v_B is one, except for limits of accelerations, which `v_i(last tick) - a T` meets. If these limits hold a
//! joint back, the blend continues until the joint is at rest; without a blend, the joint stops as soon as they allow.
//! A limit of acceleration that concerns more than one joint may have no solution at a switch, which is the fault
//! `infeasible`.

use solver::{HierarchicalSolver, LevelShape, Problem, Solution, Status};

use super::look_ahead::{At, LookAhead};
use crate::evaluator::{Evaluator, LevelRows, TickInputs};
use crate::fault::Fault;
use crate::program::Program;

/// Speed up to which a locked joint counts as stationary, in rad/s or m/s.
pub(super) const STANDS: f64 = 1e-9;

/// The tick whose velocity is blended.
#[derive(Clone, Copy)]
pub(super) struct Tick<'t> {
    /// Configuration of the evaluator's last update.
    pub q: &'t [f64],
    /// Inputs of the tick.
    pub inputs: TickInputs<'t>,
    /// True if the blend goes on after it.
    pub lasts: bool,
    /// True if its hierarchy was not solved in time.
    pub late: bool,
}

/// Blend from the velocity of another stack.
pub(super) struct Blend {
    pub(super) problem: Problem,
    pub(super) solution: Solution,
    solver: Box<dyn HierarchicalSolver + Send>,
    /// v - v_B(0)
    pub(super) offset: Vec<f64>,
    /// Duration (s); 0 if no blend is in progress.
    pub(super) duration: f64,
    /// True for each level that holds during this blend.
    pub(super) kept: Vec<bool>,
    /// Rows of limits of accelerations; none if a planner takes them into account. Their bounds at this tick
    /// follow.
    gentle: Vec<LevelRows>,
    bounds: Vec<(f64, f64)>,
    /// All rows of limits of accelerations. On the way to rest they stand on a level of their own, the last one.
    accelerations: Vec<LevelRows>,
    /// True if a locked joint moved at the last tick.
    pub(super) locked_joints_moving: bool,
    /// True if a locked joint moves at this tick too.
    pub(super) goes_on: bool,
    /// True once the first tick has been solved and the offset is known.
    pub(super) begun: bool,
}

impl Blend {
    /// Prepares the blends of a stack with this problem.
    pub(super) fn new(evaluator: &Evaluator, problem: &Problem, program: &Program) -> Blend {
        let nv = evaluator.model().nv();
        // One more level above those of the stack, for the joints that it locks.
        let mut between = problem.clone();
        let rows = evaluator.locked().len();
        between.levels.iter_mut().for_each(|level| level.damping = 0.0);
        let accelerations = evaluator.acceleration_rows();
        let yielding = accelerations.iter().map(|a| a.rows.len()).sum();
        let (locks, last) = ((rows, true), (yielding, false));
        let shape = |(rows, hard): (usize, bool)| LevelShape { rows, hard, damping: 0.0 };
        let mut beside = Problem::new(nv, &[shape(locks), shape(last)]).levels.into_iter();
        between.levels.splice(0..0, beside.next());
        between.levels.extend(beside);
        let gentle = if evaluator.safety().count() > 0 { Vec::new() } else { accelerations.clone() };
        Blend {
            solution: Solution::new(&between),
            solver: program.run.solver.solver(&between),
            problem: between,
            offset: vec![0.0; nv],
            duration: 0.0,
            kept: vec![false; problem.levels.len()],
            bounds: vec![(0.0, 0.0); gentle.iter().map(|g| g.rows.len()).sum()],
            gentle,
            accelerations,
            locked_joints_moving: false,
            goes_on: false,
            begun: false,
        }
    }

    /// Returns true if a blend is in progress and this is not its last tick.
    pub(super) fn lasts(&self, inputs: TickInputs) -> bool {
        // Tolerates half a microsecond, for the rounding error of a sum of periods.
        inputs.times.t < self.duration - 5e-7
    }

    /// Fraction of the offset that is left, `1 - s`.
    pub(super) fn left(&self, inputs: TickInputs) -> f64 {
        let x = if self.lasts(inputs) { inputs.times.t / self.duration } else { 1.0 };
        1.0 - x * x * (3.0 - 2.0 * x)
    }

    /// Removes the bounds of accelerations from the problem of the stack and stores them.
    pub(super) fn leave_out_accelerations(&mut self, problem: &mut Problem) {
        let mut bounds = self.bounds.iter_mut();
        for LevelRows { level, rows } in &self.gentle {
            let (lower, upper) = problem.levels[*level].bounds_mut(rows.clone());
            for ((l, u), kept) in lower.iter_mut().zip(upper).zip(&mut bounds) {
                *kept = (*l, *u);
                (*l, *u) = (f64::NEG_INFINITY, f64::INFINITY);
            }
        }
    }

    /// Restores the bounds of accelerations in the problem of the blended velocity, for levels that hold during the
    /// blend.
    fn give_back_accelerations(&mut self) {
        let mut bounds = self.bounds.iter();
        for LevelRows { level, rows } in &self.gentle {
            let (lower, upper) = self.problem.levels[level + 1].bounds_mut(rows.clone());
            for ((l, u), kept) in lower.iter_mut().zip(upper).zip(&mut bounds) {
                if self.kept[*level] {
                    (*l, *u) = *kept;
                }
            }
        }
    }

    /// Computes the velocity nearest to the reference among those that meet the levels of `stack` that hold during a blend,
    /// or at a late tick the hard levels. Locked joints come to rest, at once if these levels allow nothing else.
    pub(super) fn nearest(
        &mut self,
        evaluator: &Evaluator,
        stack: &Problem,
        of: Tick,
        look_ahead: &mut LookAhead,
    ) -> Result<(), Fault> {
        self.between(evaluator, stack, of, false);
        if self.locked_joints_moving && matches!(self.solution.status, Status::Infeasible { .. }) {
            self.between(evaluator, stack, of, true);
        }
        let Blend { problem, solution, solver, .. } = self;
        let at = At { evaluator, q: of.q, above: 1 };
        look_ahead.hold(at, problem, solution, |problem, solution| solver.solve(problem, solution))?;
        for &dof in evaluator.locked() {
            if self.solution.x[dof].abs() <= STANDS {
                self.solution.x[dof] = 0.0;
            } else {
                self.goes_on = true;
            }
        }
        usable_between(&self.solution, evaluator)
    }

    /// Solves for that velocity; `stack` is the problem of the stack, and `stop` brings locked joints to rest at once. A row that depends on these joints alone
    /// is then met, since its distance stays constant.
    fn between(&mut self, evaluator: &Evaluator, stack: &Problem, of: Tick, stop: bool) {
        let Tick { inputs, lasts, late, .. } = of;
        let Some((locks, levels)) = self.problem.levels.split_first_mut() else { return };
        for (i, &dof) in evaluator.locked().iter().enumerate() {
            let last = inputs.velocity[dof];
            locks.leave_out(i);
            if last.abs() > STANDS && !stop {
                locks.row_mut(i)[dof] = 1.0;
                (locks.lower[i], locks.upper[i]) = (last.min(0.0), last.max(0.0));
            } else {
                self.problem.reference[dof] = 0.0;
                if self.locked_joints_moving {
                    locks.row_mut(i)[dof] = 1.0;
                    (locks.lower[i], locks.upper[i]) = (0.0, 0.0);
                }
            }
        }
        // A damped level asks for the values that its rows reached, so that the blended velocity need not give them up. The last level is not the
        // stack's own: it is for the way to rest.
        if let Some(last) = levels.last_mut() {
            (0..last.rows()).for_each(|i| last.leave_out(i));
        }
        for ((to, from), kept) in levels.iter_mut().zip(&stack.levels).zip(&self.kept) {
            if from.hard || (*kept && !late) {
                to.copy_from(from);
                to.damping = 0.0;
            } else {
                (0..to.rows()).for_each(|i| to.leave_out(i));
            }
        }
        // Rows of accelerations that depend on locked joints alone have their bounds from these joints, which come last.
        if lasts {
            self.give_back_accelerations();
        }
        let hard =
            self.problem.levels.iter_mut().skip(1).zip(&stack.levels).enumerate().filter(|(_, (_, from))| from.hard);
        hard.for_each(|(i, (to, _))| evaluator.locked_joint_motion().give_back(i, !stop, to));
        self.solver.solve(&self.problem, &mut self.solution);
    }

    /// Computes the velocity nearest to `aim` (`nv` numbers) on the way to rest, from the rows of the hard levels of `stack`; see
    /// [`rest`](super::rest). Returns false if the solver has none.
    pub(super) fn rest(
        &mut self,
        evaluator: &Evaluator,
        stack: &Problem,
        q: &[f64],
        aim: &[f64],
        look_ahead: &mut LookAhead,
    ) -> bool {
        self.problem.reference.copy_from_slice(aim);
        let Blend { problem, solution, solver, accelerations, .. } = self;
        let Some(((locks, last), levels)) = problem
            .levels
            .split_first_mut()
            .and_then(|(locks, rest)| rest.split_last_mut().map(|(last, levels)| ((locks, last), levels)))
        else {
            return false;
        };
        (0..locks.rows()).for_each(|i| locks.leave_out(i));
        for (i, (to, from)) in levels.iter_mut().zip(&stack.levels).enumerate() {
            to.copy_from(from);
            to.damping = 0.0;
            evaluator.locked_joint_motion().give_back(i, true, to);
        }
        let mut row = 0;
        for LevelRows { level, rows } in accelerations.iter() {
            for r in rows.clone() {
                let from = &levels[*level];
                last.set(row, from.row(r), from.lower[r], from.upper[r]);
                levels[*level].leave_out(r);
                row += 1;
            }
        }
        for to in levels.iter_mut() {
            if !to.hard {
                (0..to.rows()).for_each(|i| to.leave_out(i));
                continue;
            }
            for (l, u) in to.lower.iter_mut().zip(&mut to.upper) {
                // Targets of hard levels stay where they are, and rest meets every limit.
                let is_target = l == u;
                *l = if is_target { 0.0 } else { l.min(0.0) };
                *u = if is_target { 0.0 } else { u.max(0.0) };
            }
        }
        solver.solve(problem, solution);
        let at = At { evaluator, q, above: 1 };
        let held = look_ahead.hold(at, problem, solution, |problem, solution| solver.solve(problem, solution));
        let usable = held.is_ok() && solution.status == Status::Optimal && solution.x.iter().all(|v| v.is_finite());
        if usable {
            // Rounding of the solver must not keep the robot from rest.
            let small = |v: &f64| v.abs() <= STANDS;
            solution.x.iter_mut().filter(|v| small(v)).for_each(|v| *v = 0.0);
        }
        usable
    }
}

/// Checks a solution for the blended velocity, whose problem has one more level on top.
fn usable_between(solution: &Solution, evaluator: &Evaluator) -> Result<(), Fault> {
    match solution.status {
        Status::Optimal => usable(solution, evaluator),
        Status::Infeasible { level } => Err(Fault::Infeasible { level: level.saturating_sub(1) }),
        Status::OutOfTime { .. } => Err(Fault::Solver { level: 0 }),
        Status::Failed { level } | Status::Unproven { level } | Status::NotFinite { level, .. } => {
            Err(Fault::Solver { level: level.saturating_sub(1) })
        }
    }
}

/// Checks that a solution may be used.
pub(super) fn usable(solution: &Solution, evaluator: &Evaluator) -> Result<(), Fault> {
    match solution.status {
        Status::Optimal if solution.x.iter().all(|v| v.is_finite()) => Ok(()),
        Status::Optimal => Err(Fault::Solver { level: 0 }),
        Status::Infeasible { level } => Err(Fault::Infeasible { level }),
        Status::OutOfTime { .. } => Err(Fault::Solver { level: 0 }),
        Status::Failed { level } | Status::Unproven { level } => Err(Fault::Solver { level }),
        Status::NotFinite { level, row } => {
            let member = evaluator.members().iter().position(|m| m.level == level && m.rows.contains(&row));
            Err(match member {
                Some(i) => Fault::NotFinite { member: i, row: row - evaluator.members()[i].rows.start },
                None => Fault::Solver { level },
            })
        }
    }
}
