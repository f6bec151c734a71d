//! Motion to rest, and rest.
//!
//! The robot comes to rest in every state without a stack, and at every fault. The stack that moved it keeps its limits meanwhile:
//!
//! ```text
//! minimise  || u - a ||     subject to    the rows of its hard levels, and those of accelerations as well as these allow
//! ```
//!
//! with `a = 0`, or the velocity at the beginning, faded over a blend. Its targets stay where they were. Rows that are not met at rest, of
//! people who come closer or of a limit that was passed, are widened until rest meets them: they shape how the robot brakes, and never make
//! it flee. Rest then meets every hard level, so that this problem has a solution at any state; where a distance and a limit of an
//! acceleration contradict each other, the distance is kept. A task that cannot be evaluated, because of a signal that is lost, has no rows.
//! Source: ours.

use super::Controller;
use super::clock::Call;
use super::guard::Robot;
use super::phase::{Phase, Stop, Why};
use super::sag::SETTLES;
use super::tick::Now;
use crate::fault::Fault;
use crate::program::Times;
use crate::signals::SignalValue;

/// Distance from its reference, in rad or m, from which a robot that was called too late stops where it is, and not where its reference does.
const FAR: f64 = 0.05;

/// Time without a reading after which a robot at rest may be anywhere (s).
const UNSEEN: f64 = 0.1;

impl Controller {
    /// Brings the robot to rest, or keeps it there. `why` is the reason; the one before if there is none.
    pub(super) fn rest(&mut self, why: Option<Why>, now: Now) {
        let why = why.or(self.phase.why()).unwrap_or(Why::NoStack);
        self.waits_for = None;
        match &mut self.phase {
            Phase::Stopping(stop) => stop.why = why,
            Phase::Standing(before) => *before = why,
            Phase::Unstarted | Phase::Running => {
                let times = Times { t: now.time - self.machine.stack_entered(), time: now.time };
                let fade = if why == Why::NoStack { self.stacks.fade() } else { 0.0 };
                self.phase = Phase::Stopping(Stop { why, times, begun: now.time, fade });
                let is_late = matches!(why.fault(), Some(Fault::Deadline { .. })) && self.is_far();
                if is_late || matches!(why.fault(), Some(Fault::Tracking { .. } | Fault::Jump { .. })) {
                    // The robot stops where it is, from what it was told, and not where it was led.
                    self.motion.velocity.copy_from_slice(&self.command);
                    if self.is_observed {
                        self.reference.copy_from_slice(&self.ahead);
                        self.offset.fill(0.0);
                        self.is_anchored = true;
                        self.stacks.active_mut().count_limits_anew();
                    }
                }
                self.stop_from.copy_from_slice(&self.motion.velocity);
            }
        }
        if let Phase::Stopping(stop) = self.phase {
            if self.motion.velocity.iter().any(|v| *v != 0.0) {
                return self.slow_down(stop, now);
            }
            self.phase = Phase::Standing(why);
        }
        self.stand(why, now);
    }

    /// Returns true if the robot is far from its reference: nobody has told it anything for a while.
    fn is_far(&mut self) -> bool {
        self.model.difference(&self.ahead, &self.reference, &mut self.tracking);
        self.is_observed && self.tracking.iter().any(|e| e.abs() > FAR)
    }

    /// Decides the velocity of a motion to rest.
    fn slow_down(&mut self, stop: Stop, now: Now) {
        let Now { q, time, .. } = now;
        let is_observed = self.is_observed;
        let x = if stop.fade > 0.0 { ((time - stop.begun) / stop.fade).clamp(0.0, 1.0) } else { 1.0 };
        let left = 1.0 - x * x * (3.0 - 2.0 * x);
        self.aim.iter_mut().zip(&self.stop_from).for_each(|(aim, v)| *aim = left * v);
        let inputs = self.motion.inputs(stop.times, &self.signals);
        match self.stacks.moving_mut().filter(|_| !self.stops_at_once) {
            Some(stack) => {
                stack.slow_down(&self.reference, inputs, &self.aim, &mut self.next);
                // What the robot passes now is no further fault: it comes to rest already.
                let robot = Robot { q, ahead: &self.ahead };
                let _ = stack.measure(&self.reference, robot, q != self.reference && is_observed, inputs, 0.0);
            }
            None => self.next.fill(0.0),
        }
        self.set_point.decide(&self.reference, &self.motion.velocity, &self.next);
        self.motion.velocity.copy_from_slice(&self.next);
        self.motion.stack_velocity.copy_from_slice(&self.next);
        if let Some(stack) = self.stacks.moving_mut() {
            stack.evaluator.observe(&self.reference, &self.motion.velocity);
        }
        self.model.integrate(&mut self.reference, &self.motion.velocity, self.period);
    }

    /// Keeps the robot at rest.
    fn stand(&mut self, why: Why, now: Now) {
        if why == Why::NoStack
            && let Some(entry) = self.stacks.begin_entry(&self.machine)
        {
            let inputs = self.motion.inputs(Times { t: 0.0, time: now.time }, &self.signals);
            self.stacks.active_mut().enter(&self.reference, inputs, 0.0, entry.common);
        }
        self.stacks.rest();
        self.motion.velocity.fill(0.0);
        self.motion.stack_velocity.fill(0.0);
        if self.is_observed {
            self.drag(self.period);
        }
        self.set_point.rest(&self.reference);
        match why {
            Why::NoStack => {
                // A stack without levels, whose answer is rest.
                let inputs = self
                    .motion
                    .inputs(Times { t: now.time - self.machine.stack_entered(), time: now.time }, &self.signals);
                let _ = self.stacks.active_mut().solve(&self.reference, inputs, None);
                self.evaluate_at_rest(now.time);
            }
            Why::InTarget(_) => self.evaluate_at_rest(now.time),
            // Margins and errors of velocities must be those of a robot at rest.
            // The numbers of this tick are those that the fault is told with.
            Why::Raised(_) => self.stacks.active_mut().evaluator.observe(&self.reference, &self.motion.velocity),
            // What a robot at rest has passed is no further fault.
            Why::Awaiting(_) | Why::Halted(_) | Why::Told | Why::Disabled => _ = self.look_on(now.q, now.time, 0.0),
        }
    }

    /// Evaluates the active stack for a robot that stands, as far as it can be, at a motion time (s): what comes near it changes its margins. `dt` is
    /// the time since the last look (s).
    ///
    /// # Errors
    /// The robot has passed a hard limit.
    fn look_on(&mut self, q: &[f64], time: f64, dt: f64) -> Result<(), Fault> {
        let inputs = self.motion.inputs(Times { t: time - self.machine.stack_entered(), time }, &self.signals);
        let apart = self.is_observed && q != self.reference;
        let robot = Robot { q, ahead: &self.ahead };
        self.stacks.active_mut().look(&self.reference, robot, apart, inputs, dt)
    }

    /// Keeps a robot at rest that takes no commands, or that was told to stand: the machine and motion time stand still with it. Returns the fault
    /// of a robot that takes commands and does not stand, or passes a limit.
    pub(super) fn hold_still(&mut self, why: Why, q: &[f64], call: &Call) -> Option<Fault> {
        let is_enabled = self.is_enabled();
        self.clock.pause(call.dt);
        self.waits_for = None;
        if self.phase != Phase::Unstarted {
            self.phase = Phase::Standing(why);
        }
        self.stacks.rest();
        self.motion.velocity.fill(0.0);
        self.motion.stack_velocity.fill(0.0);
        if self.is_observed && !is_enabled {
            // Commands that were sent before do not move it either.
            self.following.forget();
            self.drive.rest();
            self.sag.restart(SETTLES);
            self.offset.fill(0.0);
            self.reference.copy_from_slice(q);
            self.is_anchored = true;
        } else if self.is_observed {
            self.drag(call.dt);
        }
        // The reference is where encoders see the robot, which at a limit is beyond it by their noise.
        self.stacks.active_mut().count_limits_anew();
        self.set_point.rest(&self.reference);
        self.signals.forget_events();
        if self.phase != Phase::Unstarted && !self.stacks.is_entry_due() {
            return self.look_on(q, self.clock.now(), call.dt).err().filter(|_| is_enabled);
        }
        None
    }

    /// Moves the reference of a robot at rest to where it comes to rest, without its [`sag`](super::sag). `dt` is the time since the last time (s).
    fn drag(&mut self, dt: f64) {
        if !std::mem::replace(&mut self.is_anchored, true) || self.following.gap() > UNSEEN {
            self.reference.copy_from_slice(&self.ahead);
            self.offset.fill(0.0);
            self.sag.restart(SETTLES);
            return;
        }
        self.model.difference(&self.reference, &self.ahead, &mut self.tracking);
        if self.sag.follow(&mut self.tracking, self.following.moved(), dt) {
            self.model.integrate(&mut self.reference, &self.tracking, 1.0);
        }
    }

    /// Evaluates the active stack for a robot that stands after a fault, so that conditions can read its outputs.
    fn evaluate_at_rest(&mut self, time: f64) {
        if self.stacks.is_entry_due() {
            return;
        }
        let inputs = self.motion.inputs(Times { t: time - self.machine.stack_entered(), time }, &self.signals);
        let stack = self.stacks.active_mut();
        // A fault of the stack must not hide the transitions that lead out of the state, and the robot stands already.
        if stack.stand(&self.reference, inputs).is_err() {
            return;
        }
        stack.evaluator.observe(&self.reference, &self.motion.velocity);
        for SignalValue { signal, value } in stack.evaluator.output_values(&self.motion.velocity) {
            if !self.signals.assign(signal, &[value]) {
                self.signals.forget(signal);
            }
        }
        self.outputs_written = true;
    }
}
