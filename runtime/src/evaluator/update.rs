//! Update of an evaluator at a tick: kinematics, values, planners, and the rows of every task.

use solver::Problem;
use stdlib_tasks::task::{Doubt, Rows, State, TaskFault};

use super::{Evaluator, LedValue, TickInputs};
use crate::fault::Fault;
use crate::planning::RobotState;
use crate::program::Times;
use crate::values::ValueTable;

/// Numbers below this magnitude are set to zero: products of them would be denormal, which processors handle far more
/// slowly.
const TINY: f64 = 1e-150;

fn flush(numbers: &mut [f64]) {
    for x in numbers {
        *x = if x.abs() < TINY { 0.0 } else { *x };
    }
}

impl Evaluator {
    pub(super) fn kinematics(&mut self, q: &[f64], inputs: TickInputs) {
        self.model.forward(q, &mut self.data);
        self.look_up(inputs);
    }

    /// Computes the values of parameters.
    fn look_up(&mut self, inputs: TickInputs) {
        for (table, clock) in self.values.iter_mut().zip(&self.clocks) {
            let times = Times { t: clock.map_or(inputs.times.t, |clock| inputs.times.time - clock), ..inputs.times };
            table.evaluate(times, inputs.signals);
            self.foresight.apply(table);
        }
        for p in &mut self.planners {
            let ValueTable { current, rates, .. } = &mut self.values[self.members[p.task].part()];
            p.evaluate(inputs.signals, current, rates);
        }
        for &LedValue { part, at, value, rate } in self.led.values.iter().filter(|_| self.led.on) {
            let ValueTable { current, rates, .. } = &mut self.values[part];
            (current[at], rates[at]) = (value, rate);
        }
    }

    /// Lets the planners of tasks on a level decide, unless another evaluator's decisions are used. The levels above
    /// are written.
    fn plan(&mut self, level: usize, q: &[f64], inputs: TickInputs, problem: &Problem) -> Result<(), Fault> {
        if self.led.on {
            return Ok(());
        }
        let Evaluator { model, data, values, planners, tasks, members, .. } = self;
        let TickInputs { velocity, stack_velocity, .. } = inputs;
        let now = RobotState { model, data, q, velocity, stack_velocity };
        for p in planners.iter_mut().filter(|p| members[p.task].level == level) {
            let ValueTable { current, rates, .. } = &mut values[members[p.task].part()];
            p.values.check(inputs.signals)?;
            p.see(tasks[p.task].as_mut(), &now, current, rates)?;
            p.decide(&problem.levels[..level], current, rates)?;
            tasks[p.guard].set_decided_velocity(&p.internal);
        }
        Ok(())
    }

    /// Passes the velocity `x`, which the hierarchy computed from the plans, to planner `k` in the order of decisions.
    /// If the planner revises its decision, its rows are written again and the result is true: the problem must be
    /// solved again before the next planner is asked.
    ///
    /// # Errors
    /// A task could not write its rows.
    pub fn reconsider(
        &mut self,
        k: usize,
        q: &[f64],
        inputs: TickInputs,
        problem: &mut Problem,
        x: &[f64],
    ) -> Result<bool, Fault> {
        let Some(p) = self.planners.get_mut(k) else { return Ok(false) };
        let (task, guard) = (p.task, p.guard);
        let above = &problem.levels[..self.members[task].level];
        let table = &mut self.values[self.members[task].part()];
        if !p.reconsider(above, x, &table.current, &mut table.rates)? {
            return Ok(false);
        }
        self.tasks[guard].set_decided_velocity(&p.internal);
        self.write(task, q, inputs, problem)?;
        self.write(guard, q, inputs, problem)?;
        Ok(true)
    }

    /// Fills the problem for this tick. Never allocates.
    ///
    /// # Errors
    /// A task could not write its rows.
    pub fn update(&mut self, q: &[f64], inputs: TickInputs, problem: &mut Problem) -> Result<(), Fault> {
        self.kinematics(q, inputs);
        self.values.iter_mut().try_for_each(|table| table.check(inputs.signals))?;
        self.locked_joint_motion.begin();
        self.margins.fill(f64::INFINITY);
        self.inside = self.is_within_limits(q);
        let mut level = None;
        for i in 0..self.members.len() {
            let own = self.members[i].level;
            if level != Some(own) {
                level = Some(own);
                self.plan(own, q, inputs, problem)?;
            }
            self.write(i, q, inputs, problem)?;
        }
        Ok(())
    }

    /// Fills the problem for a robot that comes to rest. A task that cannot be evaluated, because a signal is lost, has no rows; planners decide
    /// nothing. Never allocates.
    pub(crate) fn update_for_rest(&mut self, q: &[f64], inputs: TickInputs, problem: &mut Problem) {
        self.begin_update(q, inputs);
        self.model.forward(q, &mut self.data);
        (0..self.members.len()).for_each(|i| self.update_one(i, q, inputs, problem));
    }

    /// Begins an update for which single tasks are evaluated by [`Evaluator::update_one`], those that are not constant after
    /// [`Evaluator::update_kinematics`].
    pub(crate) fn begin_update(&mut self, q: &[f64], inputs: TickInputs) {
        self.look_up(inputs);
        self.locked_joint_motion.begin();
        self.margins.fill(f64::INFINITY);
        self.inside = self.is_within_limits(q);
    }

    /// Computes the places of all links.
    pub(crate) fn update_kinematics(&mut self, q: &[f64]) {
        self.model.forward(q, &mut self.data);
    }

    /// Writes the rows of one task for a robot that comes to rest; none if it cannot be evaluated.
    pub(crate) fn update_one(&mut self, i: usize, q: &[f64], inputs: TickInputs, problem: &mut Problem) {
        if self.write(i, q, inputs, problem).is_ok() {
            return;
        }
        let m = &self.members[i];
        let level = &mut problem.levels[m.level];
        if m.constant {
            // Its coefficients are written once, and must stay.
            let (lower, upper) = level.bounds_mut(m.rows.clone());
            lower.fill(f64::NEG_INFINITY);
            upper.fill(f64::INFINITY);
        } else {
            m.rows.clone().for_each(|row| level.leave_out(row));
        }
        self.margins[m.margins.clone()].fill(f64::NAN);
        self.measures[m.measures.clone()].fill(f64::NAN);
    }

    /// Writes the rows of one task.
    fn write(&mut self, i: usize, q: &[f64], inputs: TickInputs, problem: &mut Problem) -> Result<(), Fault> {
        let Evaluator { model, data, values, tasks, locked_joint_motion, margins, measures, undefined, .. } = self;
        let (m, task) = (&self.members[i], &mut tasks[i]);
        let ValueTable { current, rates, .. } = &values[m.part()];
        let TickInputs { velocity, stack_velocity, .. } = inputs;
        let state = State { model, data, q, values: current, rates, velocity, stack_velocity };
        let level = &mut problem.levels[m.level];
        let stride = level.stride();
        let (jacobian, lower, upper) = if m.constant {
            let (lower, upper) = level.bounds_mut(m.rows.clone());
            (&mut [][..], lower, upper)
        } else {
            let (jacobian, lower, upper) = level.block_mut(m.rows.clone());
            jacobian.fill(0.0);
            (jacobian, lower, upper)
        };
        lower.fill(f64::NEG_INFINITY);
        upper.fill(f64::INFINITY);
        undefined[i] = false;
        // The proofs assume that locked joints are at rest.
        let idle = if self.inside && !locked_joint_motion.on { &m.idle[..] } else { &[] };
        let mut rows = Rows {
            jacobian,
            stride,
            lower,
            upper,
            margins: &mut margins[m.margins.clone()],
            measures: &mut measures[m.measures.clone()],
            undefined: &mut undefined[i],
            idle,
            trial: false,
        };
        match task.update(&state, &mut rows) {
            Ok(()) => {}
            Err(TaskFault::NotFinite { row }) => return Err(Fault::NotFinite { member: i, row }),
            Err(TaskFault::Overlap { row }) => return Err(Fault::Overlap { member: i, row }),
            Err(TaskFault::Gain { .. }) => return Err(Fault::Gain { member: i }),
            Err(TaskFault::Crossed { row }) => return Err(Fault::Crossed { member: i, row }),
        }
        if let Some(p) = self.planners.iter().find(|p| p.task == i && !self.led.on) {
            for (row, wanted) in p.wanted.iter().enumerate().filter(|(row, _)| p.decides(*row)) {
                rows.equal(row, *wanted);
            }
        }
        flush(rows.jacobian);
        flush(rows.lower);
        flush(rows.upper);
        locked_joint_motion.keep(m, rows.jacobian, stride);
        if !self.locked.is_empty() {
            // The rows of a robot without degrees of freedom have no coefficients.
            for row in rows.jacobian.chunks_exact_mut(stride.max(1)) {
                for &dof in &self.locked {
                    row[dof] = 0.0;
                }
            }
        }
        locked_joint_motion.free(m, level);
        for (row, _) in idle.iter().enumerate().filter(|(_, is)| **is) {
            level.leave_out(m.rows.start + row);
        }
        Ok(())
    }

    /// Returns what a task takes for granted, and what is not so at the configuration of the last update.
    pub fn doubt(&mut self, member: usize, q: &[f64], inputs: TickInputs) -> Option<Doubt> {
        let Evaluator { model, data, values, members, tasks, .. } = self;
        let ValueTable { current, rates, .. } = &values[members.get(member)?.part()];
        let TickInputs { velocity, stack_velocity, .. } = inputs;
        tasks.get_mut(member)?.doubt(&State { model, data, q, values: current, rates, velocity, stack_velocity })
    }

    /// Passes the chosen velocity to the tasks and reads their outputs. Never allocates.
    pub fn observe(&mut self, q: &[f64], v: &[f64]) {
        let Evaluator { model, data, values, tasks, members, margins, measures, outputs, .. } = self;
        let state = |part: usize| {
            let ValueTable { current, rates, .. } = &values[part];
            State { model, data, q, values: current, rates, velocity: v, stack_velocity: v }
        };
        for (task, m) in tasks.iter().zip(members.iter()) {
            task.observe(&state(m.part()), v, &mut margins[m.margins.clone()], &mut measures[m.measures.clone()]);
        }
        outputs.iter_mut().for_each(|t| t.update(tasks, &state(members[t.member].part()), v));
    }
}
