//! A call of the controller: observe, decide, send.
//!
//! A call makes as many decisions as its command needs; see [`clock`](super::clock). A decision is a tick of the machine, and of the stack that runs.

use std::time::Instant;

use super::clock::Call;
use super::follow::Told;
use super::guard::{For, Robot, Sent};
use super::machine::{FaultResponse, StateChange};
use super::machine_actions::ObservedState;
use super::phase::{Phase, Why};
use super::{Controller, Observation};
use crate::fault::{Fault, PASSED};
use crate::program::Times;
use crate::signals::{NOT_UNIT, SignalValue};

/// What is known at a decision.
#[derive(Clone, Copy)]
pub(super) struct Now<'a> {
    /// Observed configuration, which may not be usable.
    pub q: &'a [f64],
    /// Motion time (s).
    pub time: f64,
    /// Fault of the observation.
    pub seen: Option<Fault>,
    /// Instant at which the budget is spent.
    pub until: Option<Instant>,
}

impl Controller {
    /// Takes an observation, makes the decisions that are due, and computes the command. Returns the fault, if there is one.
    pub(super) fn call(&mut self, o: &Observation, until: Option<Instant>) -> Option<Fault> {
        let call = self.clock.call(o.time);
        self.machine.requests.clear();
        self.drive.advance(&self.command, call.dt);
        let observed = self.look(o.q, &call);
        self.sense(o.q, call.host);
        self.elapsed += call.dt;
        if let Some(why) = self.holds(o.q) {
            self.seen = None;
            let fault = observed.or(self.hold_still(why, o.q, &call));
            // The machine stands still: a fault is told until the host resumes.
            self.fault = if self.is_enabled() { self.fault.or(fault) } else { None };
            self.send(o.q, &call, true);
            return self.fault;
        }
        // A fault between two decisions counts at the next one.
        let mut seen = observed.or(self.seen.take());
        self.clock.lead(&call, self.set_point.is_at_rest());
        let mut decided = false;
        while let Some(time) = self.clock.is_due() {
            self.fault = self.decide(Now { q: o.q, time, seen, until });
            self.clock.decided();
            self.signals.forget_events();
            // A lost reading is one for each decision of this call, a late call for one of them.
            seen = seen.filter(|_| !self.is_observed);
            decided = true;
        }
        self.seen = seen.filter(|_| !decided);
        self.send(o.q, &call, decided);
        self.fault
    }

    /// Reason for which the robot is held still, whatever its machine does: it takes no commands, or was told to stand and does.
    fn holds(&mut self, q: &[f64]) -> Option<Why> {
        let (is_enabled, resumes) = (self.is_enabled(), std::mem::take(&mut self.resumes));
        self.is_stopped &= !(resumes && is_enabled);
        match self.phase {
            _ if self.phase.halted().is_some() => None,
            Phase::Running | Phase::Stopping(_) if !is_enabled && self.is_only_unsure() => {
                // A message that is missing is no proof that the drives are off: a robot that moves comes to rest.
                if self.phase.why() != Some(Why::Disabled) {
                    self.begin_stop(Why::Disabled);
                }
                None
            }
            _ if !is_enabled => Some(Why::Disabled),
            Phase::Unstarted | Phase::Standing(_) if self.is_stopped => Some(Why::Told),
            Phase::Unstarted => {
                self.clock.begin_anew();
                if self.is_observed {
                    // A call that decides nothing yet commands the place of the robot.
                    self.reference.copy_from_slice(q);
                    self.set_point.rest(q);
                }
                None
            }
            Phase::Standing(why @ (Why::Told | Why::Disabled)) => {
                let goes_on = resumes || self.resumes_itself || why == Why::Told;
                if goes_on {
                    (self.phase, self.fault) = (Phase::Running, None);
                    // Its first decision begins with this call.
                    self.clock.begin_anew();
                }
                (!goes_on).then_some(why)
            }
            _ => None,
        }
    }

    /// Returns true if no one says that the robot takes no commands: at most, a signal that should say so is missing.
    fn is_only_unsure(&self) -> bool {
        let says_no = |s: &usize| self.signals.value(*s).first().is_some_and(|value| *value <= 0.0);
        self.is_enabled && !self.enabling.iter().any(says_no)
    }

    /// Checks the observation before anything is computed from it.
    fn look(&mut self, q: &[f64], call: &Call) -> Option<Fault> {
        let length = self.reference.len();
        self.is_observed = q.len() == length && q.iter().all(|x| x.is_finite());
        if !self.is_observed {
            let index = q.iter().position(|x| !x.is_finite()).unwrap_or(q.len()).min(length);
            self.following.miss(call.dt);
            return Some(call.fault.unwrap_or(Fault::Observation { index: Some(index) }));
        }
        let far_from_unit =
            |at: usize| (q[at..at + 4].iter().map(|x| x * x).sum::<f64>().sqrt() - 1.0).abs() > NOT_UNIT;
        let floating = self.model.bases.iter().filter(|base| base.kind == robot::Base::Floating);
        let turned = floating.map(|base| base.first_coordinate + 3).find(|&at| far_from_unit(at));
        if let Some(index) = turned {
            self.is_observed = false;
            self.following.miss(call.dt);
            return Some(call.fault.unwrap_or(Fault::Observation { index: Some(index) }));
        }
        if std::mem::take(&mut self.relocates) {
            self.following.restart();
            self.model.copy_bases(q, &mut self.reference);
            self.set_point.relocate(&self.model, q);
        }
        let stands = self.waits_for_resume() && self.is_enabled();
        let told =
            Told { command: self.drive.mean(), reference: &self.fed, off: &self.off, waits: self.waits_for, stands };
        let fault = self.following.look(&self.model, q, told, call.dt);
        if let Some(Fault::Jump { .. }) = fault {
            // Nothing is computed from a place that no joint can have reached, until the robot is seen there for longer.
            self.is_observed = false;
            return call.fault.or(fault);
        }
        self.ahead.copy_from_slice(q);
        if !self.drive.is_ideal() {
            self.model.integrate(&mut self.ahead, self.drive.coast(), 1.0);
        }
        call.fault.or(fault)
    }

    /// Makes a decision: runs the machine, and the active stack.
    fn decide(&mut self, now: Now) -> Option<Fault> {
        self.outputs_written = false;
        let fault = if self.phase.why().is_some_and(|why| why.holds_machine()) {
            self.rest(None, now);
            self.phase.halted().or(now.seen)
        } else {
            self.run_machine(now)
        };
        if !self.outputs_written {
            // Outputs of an earlier tick must not keep a condition true.
            for signal in self.stacks.active().evaluator.output_signals() {
                self.signals.forget(signal);
            }
        }
        if let Some(measured) = &mut self.measured {
            measured.tick(&mut self.signals, self.machine.entries(), now.q, &self.motion.velocity, now.time);
        }
        fault
    }

    /// Runs the machine, and what its state asks for.
    fn run_machine(&mut self, now: Now) -> Option<Fault> {
        let Now { q, time, .. } = now;
        self.machine.begin();
        let first = self.phase == Phase::Unstarted;
        if first {
            self.started = time;
            self.motion.velocity.fill(0.0);
            self.machine.start(time);
            self.stacks.restart();
            self.phase = Phase::Running;
            self.is_anchored = false;
            self.enter(StateChange { blend: 0.0, stack: true, anew: true });
        }
        self.machine.observe_targets(&mut self.signals, self.stacks.active(), first);
        let seen = now.seen.or_else(|| self.stale(time));
        match seen.or(self.raised.take()) {
            Some(fault) => {
                // A robot that is not where it was led goes on from where it is, in the state that handles the fault.
                if matches!(fault, Fault::Tracking { .. } | Fault::Jump { .. }) {
                    self.is_anchored = false;
                }
                match self.machine.fault(&fault, self.stacks.active(), time) {
                    FaultResponse::Transition(change) => self.enter(change),
                    FaultResponse::AlreadyInTarget => self.stopped_by = Some(fault),
                    FaultResponse::Unhandled => {
                        self.rest(Some(Why::Halted(fault)), now);
                        return Some(fault);
                    }
                }
            }
            None if !first => {
                let inputs = self.motion.inputs(Times { t: 0.0, time }, &self.signals);
                let stack = self.stacks.active();
                if let Some(change) = self.machine.step(q, self.signals.events(), inputs, stack) {
                    self.enter(change);
                }
            }
            None => {}
        }
        let state = ObservedState { q, velocity: &self.motion.velocity, time };
        let done = self.machine.perform(&mut self.signals, state);
        // The machine has moved on, but no stack can be run at a configuration that is not known.
        if let Some(fault) = seen.filter(|_| !self.is_observed) {
            self.raised = done.err();
            self.rest(Some(Why::Raised(fault)), now);
            return seen;
        }
        if self.machine.stands() {
            self.raised = done.err();
            let stopped_by = self.raised.or(seen).or(self.stopped_by);
            self.rest(stopped_by.map(Why::InTarget), now);
            return stopped_by;
        }
        let run = match done {
            Ok(()) if self.machine.stack().is_none() => {
                self.rest(Some(Why::NoStack), now);
                Ok(())
            }
            Ok(()) if self.waits(now) => Ok(()),
            Ok(()) => self.run(now),
            Err(fault) => Err(fault),
        };
        if let Err(fault) = run {
            self.raised = Some(fault);
            self.rest(Some(Why::Raised(fault)), now);
        }
        self.raised.or(seen)
    }

    /// Stands still instead of entering a stack that lacks a signal that may still be late. Returns false if there is nothing to wait for; the stack
    /// then begins anew, if it was waited for.
    fn waits(&mut self, now: Now) -> bool {
        let since = now.time - self.started;
        let awaited = self.stacks.due().and_then(|stack| self.signals.awaited(stack.evaluator.needs(), since));
        if let Some(signal) = awaited {
            self.rest(Some(Why::Awaiting(signal)), now);
            return true;
        }
        if self.awaited().is_some() {
            // Its time begins when it is entered.
            self.machine.begin_stack(now.time);
            self.stacks.enter_anew();
        }
        false
    }

    /// Updates the signals for a call at a time of the host (s). A sensor whose axes are not known has no value.
    fn sense(&mut self, q: &[f64], time: f64) {
        if let Some(observed) = self.observed.as_deref_mut().filter(|_| self.is_observed) {
            observed.0.forward(q, &mut observed.1);
        }
        let data = self.observed.as_deref().filter(|_| self.is_observed).map(|o| &o.1);
        self.signals.at(time, |link| data.map(|d| d.pose(link).rotation));
    }

    /// Returns the fault of a signal of the machine that is stale.
    fn stale(&self, time: f64) -> Option<Fault> {
        // A signal is stale only after its timeout has passed since the first tick.
        let since = time - self.started;
        let signals = &self.signals;
        let patience = |s: usize| signals.interface().signals[s].timeout.unwrap_or(f64::INFINITY);
        let is_stale =
            |s: usize| !signals.interface().signals[s].optional && !signals.is_known(s) && since > patience(s);
        self.machine.stale(is_stale)
    }

    /// Selects the stack of the current state and requests its entry.
    fn enter(&mut self, change: StateChange) {
        if change.stack {
            self.stacks.select(&self.machine, change);
            // A task that does not run has no outputs.
            for signal in self.stacks.output_signals() {
                self.signals.forget(signal);
            }
        }
    }

    /// Runs the active stack for one tick.
    fn run(&mut self, now: Now) -> Result<(), Fault> {
        let Now { q, time, until, .. } = now;
        if !std::mem::replace(&mut self.is_anchored, true) {
            self.reference.copy_from_slice(&self.ahead);
            self.offset.fill(0.0);
            self.stacks.active_mut().count_limits_anew();
        }
        let robot = Robot { q, ahead: &self.ahead };
        self.model.slip(robot.ahead, &mut self.reference, SLIPPED);
        self.model.difference(robot.ahead, &self.reference, &mut self.tracking);
        // Obstacles are foreseen by declared drives: a robot that is measured meets them where they are.
        let apart = q != self.reference || !self.drive.is_ideal();
        let times = Times { t: time - self.machine.stack_entered(), time };
        if self.stacks.is_entry_due() {
            self.motion.stack_velocity.copy_from_slice(&self.motion.velocity);
        }
        let entry = self.stacks.begin_entry(&self.machine);
        self.stacks.move_by_active();
        let inputs = self.motion.inputs(times, &self.signals);
        let stack = self.stacks.active_mut();
        if let Some(entry) = entry {
            stack.enter(&self.reference, inputs, entry.blend, entry.common);
            stack.enter_beside(robot, inputs);
        }
        stack.solve(&self.reference, inputs, until)?;
        self.next.copy_from_slice(stack.velocity());
        let waits = wait(&self.tracking, &mut self.next);
        self.waits_for = waits.map(|waits| waits.dof);
        if self.waits_for.is_some() {
            stack.hold_back(&self.reference, inputs, &mut self.next)?;
        }
        let measured = stack.measure(&self.reference, robot, apart, inputs, std::mem::take(&mut self.elapsed));
        if self.machine.looks_at_tasks() {
            stack.complete(inputs.signals, &self.next);
        }
        self.set_point.decide(&self.reference, &self.motion.velocity, &self.next);
        self.motion.velocity.copy_from_slice(&self.next);
        self.motion.stack_velocity.copy_from_slice(&stack.solution.x);
        stack.evaluator.observe(&self.reference, &self.motion.velocity);
        for SignalValue { signal, value } in stack.evaluator.output_values(&self.motion.velocity) {
            if !self.signals.assign(signal, &[value]) {
                self.signals.forget(signal);
            }
        }
        self.outputs_written = true;
        self.phase = Phase::Running;
        self.sag.restart(0.0);
        let late = waits.map_or(0.0, |waits| waits.part);
        stack.evaluator.advance(1.0 - late);
        if late > 0.0 {
            // What runs by the clock waits with the reference: it would be far ahead of it when it goes on.
            stack.evaluator.wait(late * self.period);
            self.machine.wait(late * self.period);
        }
        self.model.integrate(&mut self.reference, &self.motion.velocity, self.period);
        // Both are evaluated: the second one updates its record of the limits that hold.
        let hard = stack.passed(PASSED);
        watched(stack, &self.machine).and(hard.map_or(Ok(()), Err)).and(measured)
    }

    /// Computes the command until the next call: the velocity of the ramp with the correction of the tracking law, within the hard limits where the
    /// robot is, and the place of the set point then. `is_current` is true if the hard limits were looked at in this call.
    fn send(&mut self, q: &[f64], call: &Call, is_current: bool) {
        let end = self.clock.on_ramp(self.clock.covered());
        let hold = self.clock.held(call);
        self.lasts = hold;
        self.sent.copy_from_slice(&self.command);
        self.set_point.velocity(end, &mut self.command);
        self.fed.copy_from_slice(&self.command);
        self.set_point.place(&self.model, self.clock.on_ramp(call.time), hold, &mut self.present);
        let corrects = self.is_observed && self.corrects();
        if self.is_observed {
            if let Some(stack) = self.stacks.moving_mut().filter(|stack| !is_current && stack.guard.is_apart()) {
                stack.go_on(Robot { q, ahead: &self.ahead });
            }
            if self.is_anchored {
                self.lead_back(call.dt);
            }
        }
        self.position.copy_from_slice(&self.present);
        self.model.integrate(&mut self.position, &self.command, hold);
        self.model.integrate(&mut self.position, &self.offset, 1.0);
        if corrects {
            // Discrete form of the gain for a command that is held: it never overshoots.
            let gain = if hold > 0.0 { -(-self.tracking_gain * hold).exp_m1() / hold } else { 0.0 };
            for ((c, e), d) in self.command.iter_mut().zip(&self.off).zip(&self.model.dofs) {
                *c = (*c + gain * e).clamp(-d.velocity, d.velocity);
            }
        }
        let why = self.phase.why();
        let is_off = why == Some(Why::Disabled) && self.has_stopped() && !self.is_only_unsure();
        if why.is_some() && (self.stops_at_once || is_off) {
            return;
        }
        let sent = Sent { velocity: &self.sent, dt: call.dt, stops: why.is_some() };
        // The ramp is within the limits of accelerations; the correction need not be, nor its end.
        let is_ramp = why.is_none() && self.is_observed && self.off.iter().all(|e| *e == 0.0);
        if let Some(stack) = self.stacks.moved().filter(|_| !is_ramp) {
            stack.soften(sent, &mut self.command);
        }
        if let Some(stack) = self.stacks.moving_mut().filter(|stack| self.is_observed && stack.guard.is_apart()) {
            stack.guard.protect(&self.model, sent, self.signals.table(), For::Command, &mut self.command);
        }
    }

    /// Measures how far the robot is from its set point, and returns true if it is led back to it: while it moves by its stack, and on the way to rest and
    /// at rest in a state without one. A fault, and a stop by the host, end the correction.
    fn corrects(&mut self) -> bool {
        self.model.difference(&self.ahead, &self.present, &mut self.off);
        let Some(why) = self.phase.why() else { return true };
        if !why.leads_back() || !self.has_stopped() {
            return why.leads_back();
        }
        let most = self.off.iter().fold(0.0_f64, |most, off| most.max(off.abs()));
        // From one distance to the other: noise must not move a robot at rest for ever.
        self.is_led = most > if self.is_led { 0.5 * STILL } else { STILL };
        self.is_led
    }

    /// Moves the offset between the position command and the reference by what the hard limits take from the velocity of the reference where the
    /// robot is: a servo that sags below a limit is lifted above it, slowly. It fades where no limit needs it.
    fn lead_back(&mut self, dt: f64) {
        let stops = self.phase.why().is_some();
        let Controller { stacks, model, signals, fed, nudged, offset, .. } = self;
        // At rest it stays: nothing would lift the robot again.
        let Some(stack) = stacks.moving_mut().filter(|stack| stack.guard.is_apart()) else { return };
        let keep = (-dt / OFFSET_FADES).exp();
        offset.iter_mut().for_each(|offset| *offset *= keep);
        nudged.copy_from_slice(fed);
        // Around the velocity of the reference, whose accelerations are within their limits already.
        let sent = Sent { velocity: fed, dt, stops };
        if stack.guard.protect(model, sent, signals.table(), For::Offset, nudged) {
            for ((offset, nudged), fed) in offset.iter_mut().zip(nudged).zip(fed) {
                *offset = (*offset + (*nudged - *fed) * dt).clamp(-MOST_OFFSET, MOST_OFFSET);
            }
        }
    }
}

/// Largest offset of a position command from the reference, in rad or m, and the time constant with which it fades (s).
const MOST_OFFSET: f64 = 0.02;
const OFFSET_FADES: f64 = 5.0;

/// Distance from its set point, in rad or m, beyond which a robot at rest is led back to it, until half of it is left.
const STILL: f64 = 2e-3;

/// Distance in m by which a base that cannot move sideways may be beside its reference before this follows it.
const SLIPPED: f64 = 1e-3;

/// Distance in rad or m between the robot and its reference from which the reference waits, and the same for each rad/s or m/s of its speed: the
/// lag of a drive that nobody declared.
const AHEAD: f64 = 0.05;
const AHEAD_BY_SPEED: f64 = 0.1;

/// A reference that waits.
#[derive(Clone, Copy)]
struct Waits {
    /// Degree of freedom that is waited for.
    dof: usize,
    /// Part of the motion away from the robot that was taken.
    part: f64,
}

/// Takes from the velocity `v` of the reference the part that lengthens its way from the robot, `e`, where this is longer than it may be.
fn wait(e: &[f64], v: &mut [f64]) -> Option<Waits> {
    let excess = |e: f64, v: f64| e - e.clamp(-AHEAD - AHEAD_BY_SPEED * v.abs(), AHEAD + AHEAD_BY_SPEED * v.abs());
    let (mut most, mut square, mut along, mut slowest) = (0.0_f64, 0.0, 0.0, None);
    for (i, (e, v)) in e.iter().zip(&*v).enumerate() {
        let x = excess(*e, *v);
        if x.abs() > most {
            (most, slowest) = (x.abs(), Some(i));
        }
        square += x * x;
        along += x * v;
    }
    if square == 0.0 || along <= 0.0 {
        return None;
    }
    // From once to twice the distance, the reference comes to a stand.
    let part = (most / AHEAD).min(1.0);
    e.iter().zip(v).for_each(|(e, v)| *v -= part * along / square * excess(*e, *v));
    slowest.map(|dof| Waits { dof, part })
}

/// Returns the fault of the first violated limit that a transition watches.
fn watched(stack: &super::StackController, machine: &super::machine::Machine) -> Result<(), Fault> {
    for (member, m) in stack.evaluator.members().iter().enumerate() {
        if m.margins.is_empty() || !machine.watches(m.program_index) {
            continue;
        }
        let margins = &stack.measured().margins()[m.margins.clone()];
        if let Some(row) = margins.iter().position(|h| *h < -PASSED) {
            return Err(Fault::Limit { member, row });
        }
    }
    Ok(())
}
