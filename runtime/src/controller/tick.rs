//! One tick of the controller: the observation, the machine, and the stack that runs.

use std::time::Instant;

use super::machine::{Answer, Change, Machine};
use super::machine_actions::Present;
use super::{Controller, Observation, Stage, TRACKING_LIMIT};
use crate::evaluator::Moment;
use crate::fault::Fault;
use crate::program::Times;

/// Tolerance of a limit, in the unit of its row: a margin below minus this counts as violated. The reference ends a
/// tick on the limit up to rounding.
const PASSED: f64 = 1e-6;

impl Controller {
    /// Runs the machine and the active stack for an observation. Returns the fault, if there is one.
    pub(super) fn tick(&mut self, o: &Observation, until: Option<Instant>) -> Option<Fault> {
        self.outputs_written = false;
        let fault = self.answer(o, until);
        if !self.outputs_written {
            // Outputs of an earlier tick must not keep a condition true.
            for signal in self.stages[self.active].evaluator.output_signals() {
                self.signals.forget(signal);
            }
        }
        fault
    }

    fn answer(&mut self, o: &Observation, until: Option<Instant>) -> Option<Fault> {
        // A time that is not finite is replaced by the expected one.
        let time = if o.time.is_finite() { o.time } else { self.last + self.period };
        self.sense(o.q, time);
        self.machine.begin();
        let first = self.started.is_none();
        if first {
            self.started = Some(time);
            self.last = time;
            self.moving = None;
            self.velocity.fill(0.0);
            self.machine.start(time);
            self.enter(Change { blend: 0.0, stack: true });
        }
        let seen = self.look(o);
        self.last = time;
        match seen.or(self.raised.take()) {
            Some(fault) => match self.machine.fault(&fault, &self.stages[self.active], time) {
                Answer::Went(change) => {
                    if matches!(fault, Fault::Tracking { .. }) {
                        self.anchored = false;
                    }
                    self.enter(change);
                }
                Answer::Here => {}
                Answer::None => {
                    self.halted = Some(fault);
                    return self.halted;
                }
            },
            None if !first => {
                let moment = Moment {
                    times: Times { t: 0.0, time },
                    signals: self.signals.table(),
                    velocity: &self.velocity,
                    stack_velocity: &self.stack_velocity,
                };
                let stage = &self.stages[self.active];
                if let Some(change) = self.machine.step(o.q, self.signals.events(), moment, stage) {
                    self.enter(change);
                }
            }
            None => {}
        }
        let now = Present { q: o.q, velocity: &self.velocity, time };
        let done = self.machine.perform(&mut self.signals, now);
        if seen.is_some_and(|f| matches!(f, Fault::Observation { .. })) {
            self.raised = done.err();
            return seen;
        }
        self.raised = done.and_then(|()| self.run(o.q, time, until)).err();
        self.raised.or(seen)
    }

    /// Updates the signals for a tick. A sensor whose axes are not known has no value.
    fn sense(&mut self, q: &[f64], time: f64) {
        let usable = q.len() == self.reference.len() && q.iter().all(|x| x.is_finite());
        if let Some(observed) = self.observed.as_deref_mut().filter(|_| usable) {
            observed.0.forward(q, &mut observed.1);
        }
        let data = self.observed.as_deref().filter(|_| usable).map(|o| &o.1);
        self.signals.at(time, |link| data.map(|d| d.pose(link).rotation));
    }

    /// Checks the observation, the deadline and the signals of the machine before anything is computed.
    fn look(&mut self, o: &Observation) -> Option<Fault> {
        let q = o.q;
        if !o.time.is_finite() {
            return Some(Fault::Observation { index: None });
        }
        if q.len() != self.reference.len() {
            return Some(Fault::Observation { index: Some(q.len().min(self.reference.len())) });
        }
        if let Some(i) = q.iter().position(|x| !x.is_finite()) {
            return Some(Fault::Observation { index: Some(i) });
        }
        let gap = o.time - self.last;
        if gap > self.deadline || gap < 0.0 {
            return Some(Fault::Deadline { gap });
        }
        // A signal is stale only after its timeout has passed since the first tick.
        let since = o.time - self.started.unwrap_or(o.time);
        let signals = &self.signals;
        let patience = |s: usize| signals.interface().signals[s].timeout.unwrap_or(f64::INFINITY);
        let is_stale =
            |s: usize| !signals.interface().signals[s].optional && !signals.is_known(s) && since > patience(s);
        self.machine.stale(is_stale)
    }

    /// Selects the stack of the current state and requests its entry.
    fn enter(&mut self, change: Change) {
        if change.stack {
            let stack = self.machine.stack();
            self.active = stack.map_or(self.stages.len() - 1, |s| self.stage_of[s]);
            self.entering = Some(change.blend);
            self.visits += 1;
            // A task that does not run has no outputs.
            for signal in self.stages.iter().flat_map(|s| s.evaluator.output_signals()) {
                self.signals.forget(signal);
            }
        }
    }

    /// Runs the active stack for one tick.
    fn run(&mut self, q: &[f64], time: f64, until: Option<Instant>) -> Result<(), Fault> {
        if !self.anchored {
            self.reference.copy_from_slice(q);
            self.anchored = true;
        }
        let stage = &mut self.stages[self.active];
        stage.evaluator.model().difference(q, &self.reference, &mut self.tracking);
        if let Some(dof) = self.tracking.iter().position(|e| e.abs().is_nan() || e.abs() > TRACKING_LIMIT) {
            return Err(Fault::Tracking { dof });
        }
        let times = Times { t: time - self.machine.stack_entered(), time };
        if self.entering.is_some() {
            self.stack_velocity.copy_from_slice(&self.velocity);
        }
        let moment = Moment {
            times,
            signals: self.signals.table(),
            velocity: &self.velocity,
            stack_velocity: &self.stack_velocity,
        };
        if let Some(blend) = self.entering.take() {
            let common = self.moving.map_or(0, |from| self.common[from][self.active]);
            stage.enter(&self.reference, moment, blend, common);
        }
        self.moving = Some(self.active);
        stage.solve(&self.reference, moment, until)?;
        self.velocity.copy_from_slice(stage.velocity());
        self.stack_velocity.copy_from_slice(&stage.solution.x);
        stage.evaluator.observe(&self.reference, &self.velocity);
        for (signal, value) in stage.evaluator.output_values(&self.velocity) {
            if !self.signals.assign(signal, &[value]) {
                self.signals.forget(signal);
            }
        }
        self.outputs_written = true;
        stage.evaluator.advance();
        let dofs = &stage.evaluator.model().dofs;
        for (((c, v), e), d) in self.command.iter_mut().zip(&self.velocity).zip(&self.tracking).zip(dofs) {
            *c = (v + self.tracking_gain * e).clamp(-d.velocity, d.velocity);
        }
        stage.evaluator.model().integrate(&mut self.reference, &self.velocity, self.period);
        passed(stage, &self.machine)
    }

    /// Commands the robot to stand still.
    pub(super) fn stand(&mut self) {
        self.command.fill(0.0);
        self.velocity.fill(0.0);
        self.stack_velocity.fill(0.0);
        self.moving = None;
        // Margins and errors of velocities must be those of a robot at rest.
        self.stages[self.active].evaluator.observe(&self.reference, &self.command);
    }
}

/// Returns the fault of the first violated limit that a transition watches.
fn passed(stage: &Stage, machine: &Machine) -> Result<(), Fault> {
    for (member, m) in stage.evaluator.members().iter().enumerate() {
        if m.margins.is_empty() || !machine.watches(m.program_index) {
            continue;
        }
        let margins = &stage.evaluator.margins()[m.margins.clone()];
        if let Some(row) = margins.iter().position(|h| *h < -PASSED) {
            return Err(Fault::Limit { member, row });
        }
    }
    Ok(())
}
