//! Checks that the signals and the machine of a program can be executed.

use super::check::{ProgramError, ensure, error};
use super::{
    FaultPattern, Lost, MAX_MERGED, MAX_SIGNAL, MachineAction, MachineProgram, Measure, MeasuredProgram, Program,
    Reached, SignalProgram, StateProgram, Trigger, Velocity,
};

/// Largest number of states that may be nested.
const MAX_DEPTH: usize = 64;

impl Program {
    pub(super) fn check_interface(&self) -> Result<(), ProgramError> {
        let mut next = 0;
        for (i, s) in self.interface.signals.iter().enumerate() {
            let place = format!("interface.signals[{i}]");
            let of = s.age_of.map(|of| self.interface.signals.get(of));
            let fits = of.is_none_or(|of| s.len == 1 && s.is_variable() && of.is_some_and(|of| !of.is_variable()));
            ensure(fits, &place, "is the age of no signal")?;
            ensure(s.at == next, &place, "its numbers do not follow those of the signal before")?;
            ensure((1..=MAX_SIGNAL).contains(&s.len), &place, "has too many numbers, or none")?;
            ensure(s.timeout.is_none_or(|t| t > 0.0), &place, "its timeout is no positive time")?;
            if let Some(motion) = &s.motion {
                ensure(s.len == 3 || s.is_pose(), &place, "is neither a point nor a pose, and moves")?;
                ensure(!motion.person || (s.len == 3 && s.timeout.is_some()), &place, "is no point with a timeout")?;
                let sensor = s.conditioning.frame.is_some() || s.conditioning.bias.is_some();
                ensure(s.variable.is_none() && !sensor, &place, "a sensor's settings, and it moves")?;
                let cutoff = if let Velocity::Estimated(cutoff) = motion.velocity { cutoff } else { 1.0 };
                let growth = if let Lost::Hold(growth) = motion.lost { growth } else { 0.0 };
                let positive = |x: f64| x > 0.0 && x.is_finite();
                let good = positive(cutoff) && growth >= 0.0 && growth.is_finite();
                ensure(
                    good && [motion.max_speed, motion.max_angular_speed].into_iter().flatten().all(positive),
                    &place,
                    "a speed or a cutoff makes no sense",
                )?;
            }
            self.check_conditioning(s, &place)?;
            let held = s.variable.as_ref().map(|v| v.value.as_ref());
            if let Some(value) = held {
                let fits = |v: &Vec<f64>| v.len() == s.len && v.iter().all(|x| x.is_finite());
                ensure(value.map_or(s.optional, fits), &place, "what it holds at the start is no value of it")?;
                ensure(s.timeout.is_none() && s.conditioning.is_none(), &place, "a variable has settings of a sensor")?;
            }
            next += s.width();
        }
        for (i, h) in self.interface.humans.iter().enumerate() {
            let place = format!("interface.humans[{i}]");
            let moves = |s: &usize| self.interface.signals.get(*s).is_some_and(SignalProgram::is_of_person);
            ensure(!h.points.is_empty() && h.points.iter().all(moves), &place, "a point is no tracked point")?;
            let inside = |l: &(usize, usize)| l.0.max(l.1) < h.points.len();
            ensure(h.links.iter().all(inside), &place, "a link joins points that do not exist")?;
        }
        Ok(())
    }

    fn check_conditioning(&self, s: &SignalProgram, place: &str) -> Result<(), ProgramError> {
        let c = &s.conditioning;
        let turned = c.frame.is_some() || c.bias.is_some();
        ensure(!turned || (s.kind == "wrench" && s.len == 6), place, "only a wrench has axes and a bias")?;
        ensure(c.frame.is_none_or(|l| l.index() < self.robot.model.links.len()), place, "its link does not exist")?;
        ensure(c.bias.is_none_or(|b| b.iter().all(|x| x.is_finite())), place, "its bias is not finite")?;
        ensure(c.low_pass.is_none_or(|f| f.is_finite() && f > 0.0), place, "its cutoff is no positive frequency")
    }

    pub(super) fn check_machine(&self) -> Result<(), ProgramError> {
        let Some(machine) = &self.machine else { return Ok(()) };
        let root = machine.states.first();
        ensure(root.is_some_and(|r| r.parent.is_none()), "machine.states", "the first state is not the root")?;
        for (i, state) in machine.states.iter().enumerate() {
            self.check_state(machine, i, state, &format!("machine.states[{i}]"))?;
        }
        self.check_merged(machine)?;
        for (i, action) in machine.actions.iter().enumerate() {
            let place = format!("machine.actions[{i}]");
            let events = action.outcomes.iter().map(|o| o.1).chain(action.event);
            for event in events {
                ensure(event < self.interface.events.len(), &place, "an event does not exist")?;
            }
            if let Some(own) = &action.own {
                self.check_own(own, &place)?;
            }
        }
        for (i, measured) in machine.measured.iter().enumerate() {
            self.check_measured(machine, measured, &format!("machine.measured[{i}]"))?;
        }
        for (i, reached) in machine.reached.iter().enumerate() {
            let place = format!("machine.reached[{i}]");
            let flag = self.interface.signals.get(reached.signal);
            let fits = flag.is_some_and(|s| s.is_variable() && s.optional && s.len == 1 && s.kind == "flag");
            ensure(fits, &place, "sets what is no flag that may be absent")?;
            self.check_reached(&reached.criterion, &place)?;
        }
        Ok(())
    }

    /// Checks that there is a stack for each combination of those of regions.
    fn check_merged(&self, machine: &MachineProgram) -> Result<(), ProgramError> {
        for (i, m) in machine.merged.iter().enumerate() {
            let place = format!("machine.merged[{i}]");
            let parts = self.stacks.get(m.stack).map_or(0, |s| s.parts.len());
            ensure(parts > 1 && parts == m.parts.len(), &place, "its stack does not exist, or has other parts")?;
            ensure(m.parts.iter().all(|p| *p < self.stacks.len()), &place, "a stack of a region does not exist")?;
        }
        for state in (0..machine.states.len()).filter(|&s| !machine.states[s].regions.is_empty()) {
            let place = format!("machine.states[{state}]");
            ensure(
                machine.count_merged(state) <= MAX_MERGED,
                &place,
                "its regions have too many combinations of stacks",
            )?;
            let all = machine.combinations(state);
            let runs = |owners: &Vec<usize>| owners.len() < 2 || machine.stack_of(owners).is_some();
            ensure(all.iter().all(runs), &place, "the stacks of its regions were not merged")?;
        }
        Ok(())
    }

    fn check_reached(&self, reached: &Reached, place: &str) -> Result<(), ProgramError> {
        ensure(reached.task < self.tasks.len(), place, "a task does not exist")?;
        ensure(reached.tolerances.iter().all(|x| *x >= 0.0), place, "a tolerance is negative")?;
        ensure(reached.speeds.iter().all(|s| s.most >= 0.0), place, "a bound of a speed is negative")
    }

    fn check_measured(&self, machine: &MachineProgram, m: &MeasuredProgram, place: &str) -> Result<(), ProgramError> {
        let set = self.interface.signals.get(m.signal);
        let fits = set.is_some_and(|s| s.is_variable() && s.optional && s.len == 1);
        ensure(fits, place, "sets what is no variable of one number that may be absent")?;
        let (dofs, links) = (self.robot.model.nv(), self.robot.model.links.len());
        let exists = match &m.measure {
            Measure::Speed(dof) | Measure::Acceleration(dof) => *dof < dofs,
            Measure::LargestSpeed(all) | Measure::LargestAcceleration(all) => all.iter().all(|dof| *dof < dofs),
            Measure::PointSpeed(link) | Measure::PointAcceleration(link) => link.index() < links,
            Measure::Reversals(all) => all.iter().all(|dof| *dof < dofs),
            Measure::Margin(_) | Measure::Error { .. } | Measure::In(_) | Measure::Fault(_) | Measure::Initial(_) => {
                false
            }
        };
        ensure(exists, place, "measures no motion of this robot")?;
        ensure(m.since.is_none_or(|s| s < machine.states.len()), place, "counts since a state that does not exist")
    }

    fn check_own(&self, own: &MachineAction, place: &str) -> Result<(), ProgramError> {
        let signal = |i: usize| self.interface.signals.get(i);
        match own {
            MachineAction::Set { variable, value } => {
                let known = signal(*variable).filter(|s| s.is_variable());
                value.check(&self.robot.model, self.values.initial.len()).map_err(|text| error(place, text))?;
                ensure(
                    known.is_some_and(|s| s.len == value.outputs.len()),
                    place,
                    "sets what is no variable of its kind",
                )
            }
            MachineAction::Clear(variable) => {
                let known = signal(*variable).is_some_and(|s| s.is_variable() && s.optional);
                ensure(known, place, "clears what is no variable that may be absent")
            }
            MachineAction::Tare(i) => {
                ensure(signal(*i).is_some_and(|s| s.kind == "wrench"), place, "tares what is no wrench")
            }
        }
    }

    fn check_state(&self, m: &MachineProgram, i: usize, s: &StateProgram, place: &str) -> Result<(), ProgramError> {
        // Parents come before children, so that a walk up to the root ends.
        ensure(i == 0 || s.parent.is_some_and(|p| p < i), place, "its parent does not come before it")?;
        ensure(m.path(i).take(MAX_DEPTH + 1).count() <= MAX_DEPTH, place, "stands inside too many others")?;
        let inside = |c: usize| c > i && m.states.get(c).is_some_and(|c| c.parent == Some(i));
        ensure(s.initial.is_none_or(inside), place, "its initial state does not stand in it")?;
        let first = |r: &usize| s.initial == Some(*r);
        ensure(s.regions.first().is_none_or(first), place, "its first region is not its initial state")?;
        ensure(s.regions.iter().all(|r| inside(*r)), place, "a region does not stand in it")?;
        ensure(
            s.regions.is_empty() || (i > 0 && m.region(i).is_none()),
            place,
            "has regions, and is the machine or in one",
        )?;
        let own = |c: usize| m.states[c].parent != Some(i) || s.regions.contains(&c);
        ensure(s.regions.is_empty() || (0..m.states.len()).all(own), place, "has a state beside its regions")?;
        ensure(s.stack.is_none_or(|k| k < self.stacks.len()), place, "its stack does not exist")?;
        let actions = s.enter.iter().chain(&s.activities).chain(&s.exit);
        for &a in actions {
            ensure(a < m.actions.len(), place, "an action does not exist")?;
        }
        for (k, t) in s.transitions.iter().enumerate() {
            let place = format!("{place}.transitions[{k}]");
            ensure(t.target < m.states.len(), &place, "its target does not exist")?;
            ensure(t.target != 0, &place, "leads to the machine itself")?;
            ensure(t.blend.is_finite() && t.blend >= 0.0, &place, "its blend is negative or not finite")?;
            ensure(!m.are_beside(i, t.target), &place, "leads into another region of the same state")?;
            if let Trigger::Ended(regions) = &t.trigger {
                let known = |r: &usize| m.states.get(*r).is_some() && m.region(*r) == Some(*r);
                ensure(!regions.is_empty() && regions.iter().all(known), &place, "waits for what is no region")?;
            }
            self.check_trigger(&t.trigger, &place)?;
        }
        Ok(())
    }

    fn check_trigger(&self, trigger: &Trigger, place: &str) -> Result<(), ProgramError> {
        let task = |t: &usize| ensure(*t < self.tasks.len(), place, "a task does not exist");
        match trigger {
            Trigger::Event(e) => ensure(*e < self.interface.events.len(), place, "an event does not exist"),
            Trigger::When { condition, hold } => {
                let model = &self.robot.model;
                condition.check(model, self.values.initial.len()).map_err(|text| error(place, text))?;
                ensure(condition.outputs.len() == 1, place, "a condition is no single number")?;
                ensure(hold.is_finite() && *hold >= 0.0, place, "a time is negative or not finite")
            }
            Trigger::After(d) => ensure(d.is_finite() && *d >= 0.0, place, "a time is negative or not finite"),
            Trigger::Reached(reached) => self.check_reached(reached, place),
            Trigger::Ended(_) => Ok(()),
            Trigger::Fault(FaultPattern::StaleAmong(all)) => {
                ensure(all.iter().all(|s| *s < self.interface.signals.len()), place, "a signal does not exist")
            }
            Trigger::Fault(FaultPattern::Stale(s)) => {
                ensure(*s < self.interface.signals.len(), place, "a signal does not exist")
            }
            Trigger::Fault(FaultPattern::Limit(t)) => task(t),
            Trigger::Fault(FaultPattern::Any | FaultPattern::Kind(_) | FaultPattern::Infeasible(_)) => Ok(()),
        }
    }
}
