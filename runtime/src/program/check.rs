//! Checks that a program can be executed: every index is valid, every number is usable.
//!
//! Programs from the compiler always pass. A program that was read from a file may have been edited; after this check
//! the controller never reads outside a table.

use stdlib_tasks::bound::{Bound, Geometry, Slot};

use crate::velocity;

use super::{CaptureSource, FORMAT, MOST_BEHIND, Op, Program, RunProgram, Subject, overshoots};

/// Reason why a program cannot be executed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}{}{message}", if .place.is_empty() { "" } else { ": " })]
pub struct ProgramError {
    /// Part of the program, as a path such as `stacks[0].levels[2]`; empty if the program is not what is wrong.
    pub place: String,
    /// Description of the error.
    pub message: String,
}

pub(crate) fn error(place: impl Into<String>, message: impl Into<String>) -> ProgramError {
    ProgramError { place: place.into(), message: message.into() }
}

pub(super) fn ensure(good: bool, place: &str, message: &str) -> Result<(), ProgramError> {
    if good { Ok(()) } else { Err(error(place, message)) }
}

impl Program {
    /// Checks all indices and numbers.
    ///
    /// # Errors
    /// The first part that cannot be executed.
    pub fn check(&self) -> Result<(), ProgramError> {
        ensure(
            self.format == FORMAT,
            "format",
            "this program was compiled by another version; compile the spec again",
        )?;
        self.check_robot()?;
        self.check_interface()?;
        self.check_values()?;
        for (i, field) in self.fields.iter().enumerate() {
            let good = field.check(&self.robot.model, self.values.initial.len());
            good.map_err(|message| error(format!("fields[{i}]"), message))?;
        }
        for (i, task) in self.tasks.iter().enumerate() {
            let place = format!("tasks[{i}]");
            ensure(stdlib_tasks::find(&task.kind).is_some(), &place, "no such task type")?;
            for bound in task.params.values() {
                self.check_bound(bound, &place)?;
            }
        }
        for (i, stack) in self.stacks.iter().enumerate() {
            let place = format!("stacks[{i}]");
            ensure(stack.locked.iter().all(|&d| d < self.robot.model.nv()), &place, "a locked joint does not exist")?;
            let equal = stack.parts.iter().flat_map(|p| &p.equal).all(|e| e.task.max(e.member) < self.tasks.len());
            ensure(equal, &place, "a task of a part does not exist")?;
            for (k, level) in stack.levels.iter().enumerate() {
                let place = format!("{place}.levels[{k}]");
                ensure(level.damping.is_finite() && level.damping >= 0.0, &place, "damping is negative or not finite")?;
                for m in &level.members {
                    ensure(m.task < self.tasks.len(), &place, "a task does not exist")?;
                    ensure(m.weight.is_finite() && m.weight > 0.0, &place, "a weight is not positive")?;
                    let fits = m.parts.is_empty() == stack.parts.is_empty() && m.parts.is_sorted();
                    ensure(fits && m.parts.iter().all(|p| *p < stack.parts.len()), &place, "a part does not exist")?;
                }
            }
        }
        self.check_machine()?;
        self.check_run(&self.run, "run")?;
        self.check_scenarios()
    }

    pub(super) fn check_run(&self, run: &RunProgram, place: &str) -> Result<(), ProgramError> {
        let at = |part: &str| format!("{place}.{part}");
        match run.subject {
            Subject::Stack(stack) => ensure(stack < self.stacks.len(), &at("subject"), "no such stack")?,
            Subject::Machine => ensure(self.machine.is_some(), &at("subject"), "there is no machine")?,
        }
        ensure(run.duration.is_finite() && run.duration > 0.0, &at("duration"), "not a positive time")?;
        ensure(run.duration / self.robot.period >= 0.5, &at("duration"), "shorter than one tick")?;
        let budget = run.tick_budget.is_none_or(|b| b > 0.0 && b <= self.robot.period);
        ensure(budget, &at("tick_budget"), "not between nothing and a period")?;
        ensure(run.duration / self.robot.period <= 1e9, &at("duration"), "more than a thousand million ticks")?;
        let s = &run.simulator;
        ensure(
            s.lag.is_finite() && s.lag >= 0.0 && s.noise.is_finite() && s.noise >= 0.0,
            &at("simulator"),
            "negative or not finite",
        )?;
        if let Some(ros) = &run.ros {
            ros.check(self).map_err(|message| error(at("ros"), message))?;
        }
        if let Some(plant) = &s.plant {
            let at = at("simulator.plant");
            let positive = |x: f64| x.is_finite() && x > 0.0;
            ensure(positive(plant.response) && positive(plant.step), &at, "a time is not positive")?;
            ensure(plant.friction.is_finite() && plant.friction >= 0.0, &at, "the friction is negative or not finite")?;
            ensure(positive(plant.person_radius), &at, "the radius of people is not positive")?;
            let sound = plant.payload.as_ref().is_none_or(|p| {
                p.link.index() < self.robot.model.links.len() && positive(p.mass) && p.at.iter().all(|x| x.is_finite())
            });
            ensure(sound, &at, "the payload has no link, or no finite mass")?;
        }
        let positive = |x: Option<f64>| x.is_none_or(|x| x.is_finite() && x > 0.0);
        ensure(
            positive(s.speed) && positive(s.acceleration),
            &at("simulator"),
            "a limit is not positive, or not finite",
        )
    }

    fn check_robot(&self) -> Result<(), ProgramError> {
        let r = &self.robot;
        ensure(r.period.is_finite() && r.period > 0.0, "robot.period", "not a positive time")?;
        ensure(r.model.nv() > 0, "robot.model", "nothing of this robot moves")?;
        ensure(r.home.len() == r.model.nq(), "robot.home", "has another length than the configuration")?;
        ensure(r.home.iter().all(|x| x.is_finite()), "robot.home", "holds a number that is not finite")?;
        for d in &r.model.dofs {
            // Comparisons with NaN are false.
            ensure(d.velocity >= 0.0, "robot.model", "the speed limit of a joint is negative or no number")?;
            ensure(d.lower <= d.upper, "robot.model", "the limits of a joint are upside down or no numbers")?;
        }
        ensure(r.deadline > r.period, "robot.deadline", "not longer than the period")?;
        ensure(r.tracking_gain.is_finite() && r.tracking_gain >= 0.0, "robot.tracking_gain", "negative or not finite")?;
        ensure(!overshoots(r.tracking_gain, r.period), "robot.tracking_gain", "overshoots within one period")?;
        for (time, place) in [(r.lag, "robot.lag"), (r.dead_time, "robot.dead_time")] {
            ensure((0.0..=MOST_BEHIND).contains(&time), place, "negative, too long or not finite")?;
        }
        let is_flag = |s: &usize| self.interface.signals.get(*s).is_some_and(|s| s.kind == "flag" && !s.is_variable());
        ensure(r.enabling.iter().all(is_flag), "robot.enabling", "is no signal that is true or false")?;
        for g in &r.geometries {
            self.check_geometry(g, "robot.geometries")?;
        }
        Ok(())
    }

    fn check_values(&self) -> Result<(), ProgramError> {
        let v = &self.values;
        for (i, op) in v.tape.ops.iter().enumerate() {
            let place = format!("values.tape.ops[{i}]");
            ensure(op.operands().iter().flatten().all(|&o| o < i), &place, "reads an operation that comes later")?;
            if let Op::Input(k) = op {
                ensure(*k < v.tape.inputs, &place, "reads a captured value that does not exist")?;
            }
            if let Op::Signal(k) = op {
                ensure(*k < self.interface.width(), &place, "reads a signal that does not exist")?;
            }
            ensure(!matches!(op, Op::State(_)), &place, "reads the robot's state, and only tasks do")?;
        }
        // Every captured value belongs to a capture, so that a file cannot request more memory than it describes.
        let captured = v.captures.iter().fold(0_usize, |n, c| n.saturating_add(c.len));
        ensure(v.tape.inputs <= captured, "values.tape.inputs", "more captured values than captures")?;
        v.tape.check_trajectories()?;
        for o in &v.tape.outputs {
            let good = o.at < v.initial.len() && o.value < v.tape.ops.len() && o.rate < v.tape.ops.len();
            ensure(good, "values.tape.outputs", "an output points nowhere")?;
        }
        ensure(v.ranges.iter().all(|r| r.at < v.initial.len()), "values.ranges", "a range belongs to no value")?;
        let held = |max: Option<f64>| max.is_some_and(|max| !overshoots(max, self.robot.period));
        let gains = v.ranges.iter().filter(|r| r.gain).all(|r| held(r.max));
        ensure(gains, "values.ranges", "a gain that moves may overshoot within one period")?;
        for (i, c) in v.captures.iter().enumerate() {
            let place = format!("values.captures[{i}]");
            let end = c.at.saturating_add(c.len);
            ensure(end <= v.tape.inputs && c.len <= 7, &place, "fills inputs that do not exist")?;
            match &c.source {
                CaptureSource::Velocity(t, _, width) => {
                    ensure(*t < self.tasks.len(), &place, "reads a task that does not exist")?;
                    let good = matches!(width, 1 | 3 | 4 | 7) && velocity::width(*width) == c.len;
                    ensure(good, &place, "a velocity has another number of numbers")?;
                }
                CaptureSource::Task(t, _) => ensure(*t < self.tasks.len(), &place, "reads a task that does not exist")?,
                CaptureSource::State(e) => {
                    e.check(&self.robot.model, 0).map_err(|text| error(&place, text))?;
                    ensure(e.outputs.len() == c.len, &place, "reads more or fewer numbers than it fills")?;
                }
            }
        }
        Ok(())
    }

    fn check_bound(&self, bound: &Bound, place: &str) -> Result<(), ProgramError> {
        let links = self.robot.model.links.len() as u32;
        let link = |l: &robot::LinkId| ensure(l.0 < links, place, "a frame does not exist");
        let slot = |s: &Slot| {
            let end = s.at.saturating_add(s.len);
            ensure(end <= self.values.initial.len(), place, "a parameter has no place in the table of values")
        };
        let dof = |d: &usize| ensure(*d < self.robot.model.nv(), place, "a joint does not exist");
        let arm = |a: &stdlib_tasks::bound::Arm| {
            [Some(&a.tip), a.shoulder.as_ref(), a.elbow.as_ref(), a.wrist.as_ref()]
                .into_iter()
                .flatten()
                .try_for_each(link)
        };
        match bound {
            Bound::Value(s) => slot(s),
            Bound::Frame(_, l) => link(l),
            Bound::Frames(list) => list.iter().try_for_each(|(_, l)| link(l)),
            Bound::Arm(a) => arm(a),
            Bound::Geometries(list) => list.iter().try_for_each(|g| self.check_geometry(g, place)),
            Bound::Obstacles(list) => list.iter().try_for_each(|o| {
                o.check(&self.robot.model).map_err(|text| error(place, text))?;
                o.slots().collect::<Vec<_>>().iter().try_for_each(slot)
            }),
            Bound::Pairs(list) => list.iter().flat_map(|pair| &pair.links).try_for_each(link),
            Bound::Joints(list) => list.iter().try_for_each(dof),
            Bound::PerJoint(list) => list.iter().try_for_each(|(d, s)| dof(d).and_then(|()| slot(s))),
            Bound::PerArm(list) => list.iter().try_for_each(|(a, s)| arm(a).and_then(|()| slot(s))),
            Bound::Choice(_) => Ok(()),
            Bound::Axes(chosen) => ensure(chosen.contains(&true), place, "no axis is chosen"),
            Bound::Task(t) => ensure(*t < self.tasks.len(), place, "a task does not exist"),
            Bound::Field(f) => ensure(*f < self.fields.len(), place, "a safety field does not exist"),
            Bound::Expression(e) => {
                e.check(&self.robot.model, self.values.initial.len()).map_err(|text| error(place, text))
            }
            Bound::Group(map) => map.values().try_for_each(|b| self.check_bound(b, place)),
        }
    }

    fn check_geometry(&self, g: &Geometry, place: &str) -> Result<(), ProgramError> {
        ensure(g.link.0 < self.robot.model.links.len() as u32, place, "a point belongs to no link")?;
        ensure(g.shape.is_sound(), place, "a shape has a negative or infinite size")
    }
}
