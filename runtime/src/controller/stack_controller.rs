//! Controller of a stack: its tasks, the problem that they fill, the solver, and the [`blend`](super::blend) from the
//! velocity of another stack.
//!
//! Late tick: the budget is spent before the hierarchy is solved. The robot then moves with the velocity nearest to
//! v*, as in a blend, among those that meet every hard level. The solver follows a line from the last answer to this one, and v* is the
//! point of the line that was reached. If there is no such line, as at a first tick, or if it does not lead to the
//! answer itself because a level is to be damped, v* is the velocity of the previous tick; from the second such tick in
//! a row on
//!
//! ```text
//! v*  =  exp(-T / 0.1 s) v
//! ```
//!
//! with `T` the period: the robot continues its motion and slows down from tick to tick. At the next tick, the solver
//! continues from the point that it reached.

use std::time::Instant;

use solver::{HierarchicalSolver, LevelStatus, Problem, Smooth, Solution, Status};
use stdlib_tasks::task::RowKind;

use super::blend::{Blend, STANDS, Tick, usable};
use super::guard::{Guard, Leader, Robot, Sent};
use super::hard_limits::HardLimits;
use super::look_ahead::{At, LookAhead};
use crate::evaluator::{Evaluator, TickInputs};
use crate::fault::Fault;
use crate::program::{LevelProgram, Program, ProgramError, StackProgram};

/// Stack prepared for execution.
pub struct StackController {
    pub(super) evaluator: Evaluator,
    problem: Problem,
    pub(super) solution: Solution,
    level_names: Vec<String>,
    pub(super) value_names: Vec<ValueName>,
    solver: Smooth,
    blend: Blend,
    /// Index of the stack in the program.
    index: usize,
    hard_limits: HardLimits,
    look_ahead: LookAhead,
    /// Number of ticks since the stack was entered.
    ticks: u64,
    /// Number of ticks since each part of it was entered.
    part_ticks: Vec<u64>,
    /// True if the hierarchy was not solved in time at the last tick.
    late: bool,
    /// Factor on the velocity from one late tick to the next.
    slowing: f64,
    /// Control period (s).
    period: f64,
    /// Largest change of each velocity in a period, in rad/s or m/s.
    decelerations: Vec<f64>,
    /// True if the robot came to rest at the last tick.
    stops: bool,
    /// The stack at the measured configuration.
    pub(super) guard: Guard,
}

/// Part of a stack that is entered.
#[derive(Clone, Copy)]
pub(super) struct Carried {
    /// Time since which it has run (s).
    pub entered: f64,
    /// Part of the stack before of which it is the continuation; `None` if it is entered with the stack.
    pub before: Option<usize>,
}

/// Name of a range of the table of values.
pub(super) struct ValueName {
    pub at: std::ops::Range<usize>,
    pub text: String,
}

/// Names of the parameters of a stack's tasks, as `` `gain` of task `reach` ``.
fn value_names(program: &Program, stack: &StackProgram) -> Vec<ValueName> {
    let tasks = stack.levels.iter().flat_map(|l| &l.members).filter_map(|m| program.tasks.get(m.task));
    let named = |task: &crate::program::TaskProgram| {
        let one = |(name, bound): (&String, &stdlib_tasks::bound::Bound)| {
            let text = format!("`{name}` of task `{}`", task.name);
            bound
                .slots()
                .into_iter()
                .map(|s| ValueName { at: s.at..s.at + s.len, text: text.clone() })
                .collect::<Vec<_>>()
        };
        task.params.iter().flat_map(one).collect::<Vec<_>>()
    };
    tasks.flat_map(named).collect()
}

/// Returns true if two levels have the same settings and equivalent tasks.
fn same_level(program: &Program, a: &LevelProgram, b: &LevelProgram) -> bool {
    let members = || a.members.iter().zip(&b.members);
    a.hard == b.hard
        && a.damping == b.damping
        && a.exact == b.exact
        && a.members.len() == b.members.len()
        && members().all(|(x, y)| x.weight == y.weight && program.same_task(x.task, y.task))
}

/// Number of levels that two stacks share, from the top. A soft level does not count if one of its tasks depends on the
/// entry of the stack.
fn in_common(program: &Program, a: &StackProgram, b: &StackProgram) -> usize {
    if a.locked != b.locked {
        return 0;
    }
    let lasting = |l: &LevelProgram| l.hard || !l.members.iter().any(|m| program.depends_on_entry(m.task));
    a.levels.iter().zip(&b.levels).take_while(|(a, b)| same_level(program, a, b) && lasting(a)).count()
}

/// Time constant (s) with which the damping by rows above a level fades, and with which the velocity decays at late
/// ticks.
const FADING: f64 = 0.1;

/// Creates the solver of a stack. A planner's own level is exact: it asks for the velocity that the planner decided on,
/// damped if necessary.
fn smooth(problem: &Problem, stack: &StackProgram, program: &Program) -> Smooth {
    let solver = Smooth::new(problem, program.run.solver).with_fading((-program.robot.period / FADING).exp());
    let plans = |task: usize| program.tasks.get(task).is_some_and(|t| crate::planning::protected_by(t).is_some());
    let planned = |level: &LevelProgram| level.members.iter().any(|m| plans(m.task));
    let exact = stack.levels.iter().enumerate().filter(|(_, level)| level.exact || planned(level));
    exact.fold(solver, |solver, (k, _)| solver.with_exact(k))
}

impl StackController {
    pub(super) fn new(program: &Program, stack: usize) -> Result<StackController, ProgramError> {
        let Some(stack_program) = program.stacks.get(stack) else {
            return Err(crate::program::error("stacks", "there is no such stack"));
        };
        let (mut evaluator, mut problem) = Evaluator::new(program, stack)?;
        let exact: Vec<bool> = stack_program.levels.iter().map(|level| level.exact).collect();
        evaluator.measure_curvature(program.robot.period, &program.interface, &exact, &mut problem);
        evaluator.foresee(program, program.robot.behind());
        let blend = Blend::new(&evaluator, &problem, program);
        Ok(StackController {
            solution: Solution::new(&problem),
            solver: smooth(&problem, stack_program, program),
            level_names: stack_program.levels.iter().map(|l| l.name.clone()).collect(),
            value_names: value_names(program, stack_program),
            blend,
            hard_limits: HardLimits::new(&evaluator, program, stack_program),
            look_ahead: LookAhead::new(&evaluator, stack_program, program.robot.period),
            index: stack,
            ticks: 0,
            part_ticks: vec![0; evaluator.parts()],
            late: false,
            slowing: (-program.robot.period / FADING).exp(),
            stops: false,
            period: program.robot.period,
            guard: Guard::new(program, stack_program)?,
            decelerations: evaluator.acceleration_limits().iter().map(|a| a * program.robot.period).collect(),
            evaluator,
            problem,
        })
    }

    /// Index of the stack in the program.
    pub fn index(&self) -> usize {
        self.index
    }

    /// Returns true if one of its tasks is a target.
    pub(super) fn has_targets(&self) -> bool {
        self.evaluator.members().iter().any(|m| m.row_kind == RowKind::Equality)
    }

    /// Evaluates the tasks for a robot that stands: without a velocity, for their outputs.
    ///
    /// # Errors
    /// A task could not write its rows.
    pub(super) fn stand(&mut self, q: &[f64], inputs: TickInputs) -> Result<(), Fault> {
        self.late = false;
        self.evaluator.update(q, inputs, &mut self.problem)
    }

    /// Enters the stack where the robot is too. Called after [`StackController::enter`].
    pub(super) fn enter_beside(&mut self, robot: Robot, inputs: TickInputs) {
        self.guard.enter(robot, inputs, &self.evaluator);
    }

    /// Looks at the hard limits where the robot is, after the stack was evaluated at the reference. `apart` is false if the robot is there.
    /// `dt` is the time since the last tick (s).
    ///
    /// # Errors
    /// The robot has passed a hard limit.
    pub(super) fn measure(
        &mut self,
        reference: &[f64],
        robot: Robot,
        apart: bool,
        inputs: TickInputs,
        dt: f64,
    ) -> Result<(), Fault> {
        if !apart {
            self.guard.leave_out();
            return Ok(());
        }
        let StackController { guard, evaluator, problem, .. } = self;
        guard.update(robot, inputs, Leader { evaluator, problem, q: reference });
        guard.passed(dt, inputs.signals).map_or(Ok(()), Err)
    }

    /// Evaluates all tasks where the robot is, for those who read their margins and errors; `v` is the velocity of the last tick.
    pub(super) fn complete(&mut self, signals: &[f64], v: &[f64]) {
        self.guard.complete(signals, v);
    }

    /// Takes the place of the robot between two decisions.
    pub(super) fn go_on(&mut self, robot: Robot) {
        self.guard.go(robot, &self.evaluator);
    }

    /// Brings a velocity within the limits of accelerations of single degrees of freedom since the last command.
    pub(super) fn soften(&self, sent: Sent, u: &mut [f64]) {
        for ((u, last), step) in u.iter_mut().zip(sent.velocity).zip(&self.decelerations).filter(|(_, s)| s.is_finite())
        {
            let most = step * sent.dt / self.period;
            *u = u.clamp(last - most, last + most);
        }
    }

    /// Evaluates the tasks for a robot that stands, at the reference and where it is measured, as far as they can be: for those who read margins.
    /// `dt` is the time since the last look (s).
    ///
    /// # Errors
    /// The robot has passed a hard limit.
    pub(super) fn look(
        &mut self,
        reference: &[f64],
        robot: Robot,
        apart: bool,
        inputs: TickInputs,
        dt: f64,
    ) -> Result<(), Fault> {
        self.evaluator.update_for_rest(reference, inputs, &mut self.problem);
        self.evaluator.observe(reference, inputs.velocity);
        self.measure(reference, robot, apart, inputs, dt)
    }

    /// Evaluator of its tasks at the measured configuration, as far as they were evaluated there; see [`StackController::complete`].
    pub fn measured(&self) -> &Evaluator {
        self.guard.evaluator().unwrap_or(&self.evaluator)
    }

    /// Writes to `v` the velocity nearest to it that the hard levels allow at the reference.
    ///
    /// # Errors
    /// There is none.
    pub(super) fn hold_back(&mut self, q: &[f64], inputs: TickInputs, v: &mut [f64]) -> Result<(), Fault> {
        self.blend.problem.reference.copy_from_slice(v);
        let lasts = self.blend.lasts(inputs);
        self.nearest(q, inputs, lasts)?;
        v.copy_from_slice(&self.blend.solution.x);
        Ok(())
    }

    /// Writes the velocity of a motion to rest to `out` (`nv` numbers): the one nearest to `aim` that the limits of the stack allow; see
    /// [`rest`](super::rest). `inputs` are those of the tick with the clocks at which the motion began. Never allocates.
    pub(super) fn slow_down(&mut self, q: &[f64], inputs: TickInputs, aim: &[f64], out: &mut [f64]) {
        (self.late, self.stops) = (false, true);
        (self.blend.duration, self.blend.goes_on, self.blend.locked_joints_moving) = (0.0, false, false);
        let locked_moving = self.evaluator.locked().iter().any(|&dof| inputs.velocity[dof].abs() > STANDS);
        self.evaluator.set_locked_joints_moving(locked_moving);
        self.evaluator.update_for_rest(q, inputs, &mut self.problem);
        let StackController { evaluator, problem, blend, look_ahead, .. } = self;
        if blend.rest(evaluator, problem, q, aim, look_ahead) {
            out.copy_from_slice(&blend.solution.x);
        } else {
            // Without an answer, every joint slows down as fast as the limits of accelerations allow it by itself.
            for ((out, v), most) in out.iter_mut().zip(inputs.velocity).zip(&self.decelerations) {
                *out = v.signum() * (v.abs() - most).max(0.0);
            }
        }
        self.solution.x.copy_from_slice(out);
        self.solution.measure(&self.problem);
    }

    /// Prepares the same stack once more, for monitors.
    ///
    /// # Errors
    /// The stack cannot be executed, which was excluded when this stack was made.
    pub fn again(&self, program: &Program) -> Result<(Evaluator, Problem), ProgramError> {
        match program.stacks.get(self.index) {
            Some(_) => Evaluator::new(program, self.index),
            None => Evaluator::new(&standing(program), self.index),
        }
    }

    /// Evaluator of its tasks.
    pub fn evaluator(&self) -> &Evaluator {
        &self.evaluator
    }

    /// Problem that its solver last solved.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// Problem whose exact optimum is the solution of the last tick: damped levels ask for the values that they
    /// reached.
    pub fn settled(&self) -> &Problem {
        self.solver.settled().unwrap_or(&self.problem)
    }

    /// Solver of its hierarchy, as of the last tick.
    pub fn solver(&self) -> &Smooth {
        &self.solver
    }

    /// Names of its levels.
    pub fn level_names(&self) -> &[String] {
        &self.level_names
    }

    /// Number of ticks for which a task has run: since the stack was entered, or a part with the task that goes on; 0 if
    /// the stack does not contain it.
    pub(super) fn ticks_of(&self, task: usize) -> u64 {
        let member = self.evaluator.members().iter().find(|m| m.program_index == task);
        member.and_then(|m| m.parts.iter().map(|part| self.part_ticks[*part]).max()).unwrap_or(0)
    }

    /// Prepares the entry of the stack: its parts run since `entered` (s), each from now on or as part `before` of the
    /// stack `from` that ran, or of this one if it is entered again. Never allocates.
    pub(super) fn prepare(&mut self, parts: &[Carried], from: Option<&mut StackController>) {
        for (part, carried) in parts.iter().enumerate() {
            self.evaluator.set_part(part, carried.entered, carried.before.is_none());
            if carried.before.is_none() {
                self.part_ticks[part] = 0;
            }
        }
        let before = || parts.iter().map(|carried| carried.before);
        match from {
            Some(from) => {
                for (mine, before) in self.part_ticks.iter_mut().zip(before()) {
                    *mine = before.and_then(|b| from.part_ticks.get(b)).copied().unwrap_or(0);
                }
                self.evaluator.take_over(&mut from.evaluator, before());
                self.hard_limits.take_over(&self.evaluator, &from.hard_limits);
            }
            None => {
                self.evaluator.keep_members();
                self.hard_limits.enter(&self.evaluator);
            }
        }
    }

    /// Returns true while the command blends from the velocity of the previous stack.
    pub(super) fn is_blending(&self) -> bool {
        self.blend.duration > 0.0 || self.blend.goes_on
    }

    /// Returns true if a joint that the stack locks still moved at the last tick.
    pub(super) fn has_moving_locked_joints(&self) -> bool {
        self.blend.locked_joints_moving
    }

    /// Returns true if the hierarchy was not solved in time at the last tick.
    pub(super) fn is_late(&self) -> bool {
        self.late
    }

    /// Returns true if the robot moved more slowly at the last tick than the hierarchy asks for, because a limit would have
    /// been passed otherwise.
    pub fn is_slowed(&self) -> bool {
        self.look_ahead.slowed
    }

    /// Returns true if the robot came to rest at the last tick, instead of what the hierarchy asks for.
    pub fn is_stopping(&self) -> bool {
        self.stops
    }

    /// Number of levels, from the top, that the velocity of the last tick meets as well as that of the stack itself: all,
    /// during a blend those that hold then, and none at a late tick.
    pub(super) fn levels_met(&self) -> usize {
        let kept = &self.blend.kept;
        if self.late {
            0
        } else if self.is_between() {
            kept.iter().take_while(|kept| **kept).count()
        } else {
            kept.len()
        }
    }

    /// Returns true if the velocity of the last tick is a blended one.
    fn is_between(&self) -> bool {
        self.blend.duration > 0.0 || self.blend.locked_joints_moving
    }

    /// Returns the first limit of a hard level that the robot passed at this tick; see [`HardLimits::passed`].
    pub(super) fn passed(&mut self, tolerance: f64) -> Option<Fault> {
        self.hard_limits.passed(&self.evaluator, tolerance)
    }

    /// Lets each limit of a hard level count from the next tick at which it holds.
    pub(super) fn count_limits_anew(&mut self) {
        self.hard_limits.count_anew();
    }

    pub(super) fn solver_name(&self) -> &'static str {
        self.solver.name()
    }

    /// Prepares the entry of the stack without any part that goes on. Never allocates.
    pub(super) fn begin_anew(&mut self) {
        self.evaluator.begin_anew();
        self.part_ticks.fill(0);
        self.hard_limits.enter(&self.evaluator);
    }

    /// Enters the stack, which was prepared. `blend` is the duration of the blend (s), and `common` the number of levels, from the top,
    /// that it shares with the previous stack.
    pub(super) fn enter(&mut self, q: &[f64], inputs: TickInputs, blend: f64, common: usize) {
        self.evaluator.enter_fresh(q, inputs);
        self.solver.forget();
        if blend > 0.0 {
            self.evaluator.hand_over();
        }
        (self.ticks, self.late, self.stops) = (0, false, false);
        (self.blend.duration, self.blend.begun) = (blend, false);
        for (i, (kept, level)) in self.blend.kept.iter_mut().zip(&self.problem.levels).enumerate() {
            *kept = level.hard || i < common;
        }
    }

    /// Computes the velocity of a tick at a configuration. Never allocates. If this is not finished at the instant
    /// `until`, the result is the velocity of a late tick; see the head of the file.
    ///
    /// # Errors
    /// No velocity was found.
    pub(super) fn solve(&mut self, q: &[f64], inputs: TickInputs, until: Option<Instant>) -> Result<(), Fault> {
        self.blend.locked_joints_moving =
            self.evaluator.locked().iter().any(|&dof| inputs.velocity[dof].abs() > STANDS);
        self.stops = false;
        self.evaluator.set_locked_joints_moving(self.blend.locked_joints_moving);
        self.evaluator.update(q, inputs, &mut self.problem)?;
        if self.blend.lasts(inputs) {
            self.blend.leave_out_accelerations(&mut self.problem);
        }
        self.solver.set_deadline(until);
        let before = self.late;
        self.late = !self.solve_hierarchy(q, inputs)?;
        self.blend.goes_on = false;
        if self.late {
            self.make_do(q, inputs, before)?;
        } else {
            if self.is_between() {
                self.go_over(q, inputs)?;
            }
            // At the last tick of a blend, the velocity is that of the stack itself.
            if !self.is_between() {
                self.late = !self.hold(q)?;
                if self.late {
                    self.make_do(q, inputs, before)?;
                }
            }
        }
        self.ticks += 1;
        self.part_ticks.iter_mut().for_each(|ticks| *ticks += 1);
        Ok(())
    }

    /// Solves the hierarchy, and once more for each safety planner that revises its decision. Returns false if time ran
    /// out.
    fn solve_hierarchy(&mut self, q: &[f64], inputs: TickInputs) -> Result<bool, Fault> {
        for k in 0..=self.evaluator.safety().count() {
            if k == 0 || self.evaluator.reconsider(k - 1, q, inputs, &mut self.problem, &self.solution.x)? {
                self.solver.solve(&self.problem, &mut self.solution);
                if matches!(self.solution.status, Status::OutOfTime { .. }) {
                    return Ok(false);
                }
                usable(&self.solution, &self.evaluator)?;
            }
        }
        Ok(true)
    }

    /// Changes the answer until no limit that looks ahead is passed before the next tick. Returns false if time ran out.
    fn hold(&mut self, q: &[f64]) -> Result<bool, Fault> {
        let StackController { evaluator, problem, solution, solver, look_ahead, .. } = self;
        let at = At { evaluator, q, above: 0 };
        look_ahead.hold(at, problem, solution, |problem, solution| solver.solve_again(problem, solution))?;
        if matches!(solution.status, Status::OutOfTime { .. }) {
            return Ok(false);
        }
        usable(solution, evaluator).map(|()| true)
    }

    /// Computes the velocity of a late tick, the first one or a further one in a row: see the head of the file.
    fn make_do(&mut self, q: &[f64], inputs: TickInputs, again: bool) -> Result<(), Fault> {
        let left = self.blend.left(inputs);
        let b = &mut self.blend;
        // At the first tick of a stack, the last answer of its solver belongs to an earlier visit.
        let begun = self.ticks > 0 && (b.duration == 0.0 || b.begun);
        if begun && self.solution.status == (Status::OutOfTime { on_the_way: true }) {
            for ((r, v), offset) in b.problem.reference.iter_mut().zip(&self.solution.x).zip(&b.offset) {
                *r = v + left * offset;
            }
        } else {
            let keeps = if again { self.slowing } else { 1.0 };
            b.problem.reference.iter_mut().zip(inputs.velocity).for_each(|(r, v)| *r = keeps * v);
        }
        self.nearest(q, inputs, self.blend.lasts(inputs))?;
        self.solution.x.copy_from_slice(&self.blend.solution.x);
        self.solution.measure(&self.problem);
        if begun {
            // The offset is not part of the stack's own velocity.
            self.solution.x.iter_mut().zip(&self.blend.offset).for_each(|(x, offset)| *x -= left * offset);
        }
        Ok(())
    }

    fn go_over(&mut self, q: &[f64], inputs: TickInputs) -> Result<(), Fault> {
        let b = &mut self.blend;
        if !b.begun {
            b.begun = true;
            for ((offset, v), x) in b.offset.iter_mut().zip(inputs.velocity).zip(&self.solution.x) {
                *offset = v - x;
            }
        }
        let (lasts, left) = (b.lasts(inputs), b.left(inputs));
        if !lasts {
            b.duration = 0.0;
            if !b.locked_joints_moving {
                return Ok(());
            }
        }
        for ((r, v), offset) in b.problem.reference.iter_mut().zip(&self.solution.x).zip(&b.offset) {
            *r = v + left * offset;
        }
        self.nearest(q, inputs, lasts)
    }

    /// Computes the velocity nearest to the reference of the blend.
    fn nearest(&mut self, q: &[f64], inputs: TickInputs, lasts: bool) -> Result<(), Fault> {
        let late = self.late;
        let settled = self.solver.settled().filter(|_| !late).unwrap_or(&self.problem);
        self.blend.nearest(&self.evaluator, settled, Tick { q, inputs, lasts, late }, &mut self.look_ahead)
    }

    /// The velocity of the last tick.
    pub(super) fn velocity(&self) -> &[f64] {
        if self.is_between() || self.late { &self.blend.solution.x } else { &self.solution.x }
    }

    /// Names of the rows of a level that were not met at the last tick, as `` `task`, row ``.
    pub(super) fn unmet(&self, level: usize) -> Vec<String> {
        let Some(l) = self.solution.levels.get(level) else { return Vec::new() };
        if l.status == LevelStatus::NotSolved {
            return Vec::new();
        }
        let members = self.evaluator.members().iter().filter(|m| m.level == level);
        members
            .flat_map(|m| m.rows.clone().zip(&m.row_info).map(move |(r, info)| (r, m, info)))
            .filter(|(r, _, _)| l.active.get(*r) == Some(&solver::Active::Violated))
            .map(|(_, m, info)| format!("`{}`, {}", m.name, info.name))
            .collect()
    }
}

/// Copy of a program with one more stack, which is empty: the robot stands still.
pub(super) fn standing(program: &Program) -> Program {
    let mut program = program.clone();
    let (name, locked, levels, parts) = (String::new(), Vec::new(), Vec::new(), Vec::new());
    program.stacks.push(StackProgram { name, locked, levels, parts });
    program
}

/// Number of levels that each pair of stacks shares, from the top: `common[from][to]`.
pub(super) fn common_levels(program: &Program, stacks: &[StackController]) -> Vec<Vec<usize>> {
    let of = |s: &StackController| program.stacks.get(s.index);
    let pair = |a: &StackController, b: &StackController| of(a).zip(of(b)).map_or(0, |(a, b)| in_common(program, a, b));
    stacks.iter().map(|a| stacks.iter().map(|b| pair(a, b)).collect()).collect()
}
