//! One tick of the controller: the observation, the machine, and the stack that runs.

use std::time::Instant;

use super::machine::{FaultResponse, Machine, Part, StateChange};
use super::machine_actions::ObservedState;
use super::stack_controller::Carried;
use super::{Controller, Observation, StackController, TRACKING_LIMIT};
use crate::evaluator::TickInputs;
use crate::fault::{Fault, PASSED};
use crate::program::Times;
use crate::signals::SignalValue;

impl Controller {
    /// Runs the machine and the active stack for an observation. Returns the fault, if there is one.
    pub(super) fn tick(&mut self, o: &Observation, until: Option<Instant>) -> Option<Fault> {
        self.outputs_written = false;
        let fault = self.execute(o, until);
        if !self.outputs_written {
            // Outputs of an earlier tick must not keep a condition true.
            for signal in self.stacks[self.active].evaluator.output_signals() {
                self.signals.forget(signal);
            }
        }
        fault
    }

    fn execute(&mut self, o: &Observation, until: Option<Instant>) -> Option<Fault> {
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
            self.entered = None;
            self.enter(StateChange { blend: 0.0, stack: true, anew: true });
        }
        self.machine.observe_targets(&mut self.signals, &self.stacks[self.active], first);
        let seen = self.look(o);
        self.last = time;
        match seen.or(self.raised.take()) {
            Some(fault) => match self.machine.fault(&fault, &self.stacks[self.active], time) {
                FaultResponse::Transition(change) => {
                    if matches!(fault, Fault::Tracking { .. }) {
                        self.anchored = false;
                    }
                    self.enter(change);
                }
                FaultResponse::AlreadyInTarget => {
                    self.stopped_by = Some(fault);
                    if matches!(fault, Fault::Tracking { .. }) {
                        self.anchored = false;
                    }
                }
                FaultResponse::Unhandled => {
                    self.halted = Some(fault);
                    return self.halted;
                }
            },
            None if !first => {
                let inputs = TickInputs {
                    times: Times { t: 0.0, time },
                    signals: self.signals.table(),
                    velocity: &self.velocity,
                    stack_velocity: &self.stack_velocity,
                };
                let stack = &self.stacks[self.active];
                if let Some(change) = self.machine.step(o.q, self.signals.events(), inputs, stack) {
                    self.enter(change);
                }
            }
            None => {}
        }
        let now = ObservedState { q: o.q, velocity: &self.velocity, time };
        let done = self.machine.perform(&mut self.signals, now);
        if seen.is_some_and(|f| matches!(f, Fault::Observation { .. })) {
            self.raised = done.err();
            return seen;
        }
        if self.machine.stands() {
            self.raised = done.err();
            self.keep_standing(o.q, time);
            return self.raised.or(seen).or(self.stopped_by);
        }
        if self.wait(o.q, time) {
            self.raised = done.err();
            return self.raised.or(seen);
        }
        self.raised = done.and_then(|()| self.run(o.q, time, until)).err();
        self.raised.or(seen)
    }

    /// Stands still instead of entering a stack that lacks a signal that may still be late. Returns false if there is
    /// nothing to wait for; the stack then begins anew, if it was waited for.
    fn wait(&mut self, q: &[f64], time: f64) -> bool {
        let since = time - self.started.unwrap_or(time);
        let needs = self.stacks[self.active].evaluator.needs();
        let awaited = self.entering.and_then(|_| self.signals.awaited(needs, since));
        let waited = std::mem::replace(&mut self.awaited, awaited).is_some();
        if awaited.is_some() {
            if !self.anchored {
                self.reference.copy_from_slice(q);
            }
            self.stand();
        } else if waited && self.entering.is_some() {
            // Its time begins when it is entered, and monitors enter it then.
            self.machine.begin_stack(time);
            self.anew = true;
            self.visits += 1;
        }
        awaited.is_some()
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
    fn enter(&mut self, change: StateChange) {
        if change.stack {
            let stack = self.machine.stack();
            self.active = stack.map_or(self.stacks.len() - 1, |s| self.index_of_stack[s]);
            self.entering = Some(change.blend);
            self.anew |= change.anew;
            self.visits += 1;
            // A task that does not run has no outputs.
            for signal in self.stacks.iter().flat_map(|s| s.evaluator.output_signals()) {
                self.signals.forget(signal);
            }
        }
    }

    /// Evaluates the active stack for a robot that stands after a fault, so that conditions can read its outputs.
    fn keep_standing(&mut self, q: &[f64], time: f64) {
        if self.entering.is_some() {
            return;
        }
        self.velocity.fill(0.0);
        self.stack_velocity.fill(0.0);
        if !self.anchored {
            self.reference.copy_from_slice(q);
            self.anchored = true;
        }
        let stack = &mut self.stacks[self.active];
        let inputs = TickInputs {
            times: Times { t: time - self.machine.stack_entered(), time },
            signals: self.signals.table(),
            velocity: &self.velocity,
            stack_velocity: &self.stack_velocity,
        };
        // A fault of the stack must not hide the transitions that lead out of the state, and the robot stands already.
        if stack.stand(&self.reference, inputs).is_err() {
            return;
        }
        stack.evaluator.observe(&self.reference, &self.velocity);
        for SignalValue { signal, value } in stack.evaluator.output_values(&self.velocity) {
            if !self.signals.assign(signal, &[value]) {
                self.signals.forget(signal);
            }
        }
        self.outputs_written = true;
    }

    /// Runs the active stack for one tick.
    fn run(&mut self, q: &[f64], time: f64, until: Option<Instant>) -> Result<(), Fault> {
        if !self.anchored {
            self.reference.copy_from_slice(q);
            self.anchored = true;
        }
        let met = self.moving.map_or(0, |from| self.stacks[from].levels_met());
        let stack = &mut self.stacks[self.active];
        stack.evaluator.model().difference(q, &self.reference, &mut self.tracking);
        if let Some(dof) = self.tracking.iter().position(|e| e.abs().is_nan() || e.abs() > TRACKING_LIMIT) {
            return Err(Fault::Tracking { dof });
        }
        let times = Times { t: time - self.machine.stack_entered(), time };
        let entering = self.entering.take();
        if entering.is_some() {
            self.stack_velocity.copy_from_slice(&self.velocity);
            self.prepare();
        }
        let stack = &mut self.stacks[self.active];
        let inputs = TickInputs {
            times,
            signals: self.signals.table(),
            velocity: &self.velocity,
            stack_velocity: &self.stack_velocity,
        };
        if let Some(blend) = entering {
            let common = self.moving.map_or(0, |from| self.common[from][self.active].min(met));
            stack.enter(&self.reference, inputs, blend, common);
        }
        self.moving = Some(self.active);
        stack.solve(&self.reference, inputs, until)?;
        self.velocity.copy_from_slice(stack.velocity());
        self.stack_velocity.copy_from_slice(&stack.solution.x);
        stack.evaluator.observe(&self.reference, &self.velocity);
        for SignalValue { signal, value } in stack.evaluator.output_values(&self.velocity) {
            if !self.signals.assign(signal, &[value]) {
                self.signals.forget(signal);
            }
        }
        self.outputs_written = true;
        stack.evaluator.advance();
        let dofs = &stack.evaluator.model().dofs;
        for (((c, v), e), d) in self.command.iter_mut().zip(&self.velocity).zip(&self.tracking).zip(dofs) {
            *c = (v + self.tracking_gain * e).clamp(-d.velocity, d.velocity);
        }
        stack.evaluator.model().integrate(&mut self.reference, &self.velocity, self.period);
        // Both are evaluated: the second one updates its record of the limits that hold.
        let hard = stack.passed(PASSED);
        watched(stack, &self.machine).and(hard.map_or(Ok(()), Err))
    }

    /// Prepares the entry of the active stack: parts of the stack before it that its regions have not left go on.
    fn prepare(&mut self) {
        let anew = std::mem::take(&mut self.anew) || !self.machine.has_regions();
        let from = self.entered.replace(self.active).filter(|_| !anew);
        self.carried.clear();
        for part in self.machine.parts() {
            let same = |p: &Part| (p.owner, p.entries) == (part.owner, part.entries);
            let before = from.and_then(|_| self.parts.iter().position(same));
            self.carried.push(Carried { entered: part.entered, before });
        }
        self.parts.clear();
        self.parts.extend(self.machine.parts());
        self.carried_from = from.filter(|_| self.carried.iter().any(|c| c.before.is_some()));
        if !self.machine.has_regions() {
            return self.stacks[self.active].begin_anew();
        }
        let before = self.carried_from.filter(|from| *from != self.active);
        let Some(from) = before else {
            return self.stacks[self.active].prepare(&self.carried, None);
        };
        let (low, high) = self.stacks.split_at_mut(from.max(self.active));
        let (Some(last), Some(high)) = (low.get_mut(from.min(self.active)), high.first_mut()) else { return };
        if from < self.active {
            high.prepare(&self.carried, Some(last))
        } else {
            last.prepare(&self.carried, Some(high))
        }
    }

    /// Commands the robot to stand still.
    pub(super) fn stand(&mut self) {
        self.command.fill(0.0);
        self.velocity.fill(0.0);
        self.stack_velocity.fill(0.0);
        self.moving = None;
        // Margins and errors of velocities must be those of a robot at rest.
        self.stacks[self.active].evaluator.observe(&self.reference, &self.command);
    }
}

/// Returns the fault of the first violated limit that a transition watches.
fn watched(stack: &StackController, machine: &Machine) -> Result<(), Fault> {
    for (member, m) in stack.evaluator.members().iter().enumerate() {
        if m.margins.is_empty() || !machine.watches(m.program_index) {
            continue;
        }
        let margins = &stack.evaluator.margins()[m.margins.clone()];
        if let Some(row) = margins.iter().position(|h| *h < -PASSED) {
            return Err(Fault::Limit { member, row });
        }
    }
    Ok(())
}
