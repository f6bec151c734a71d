//! Checks that the scenarios of a program can be run.

use super::check::{ProgramError, ensure, error};
use super::{Force, HumanScript, Measure, Program, ScenarioProgram, Sending, SignalScript, Track};

/// Returns true if a time is finite and not negative.
fn is_time(x: f64) -> bool {
    x.is_finite() && x >= 0.0
}

impl Program {
    pub(super) fn check_scenarios(&self) -> Result<(), ProgramError> {
        for (i, scenario) in self.scenarios.iter().enumerate() {
            let place = format!("scenarios[{i}]");
            self.check_run(&scenario.run, &format!("{place}.run"))?;
            ensure(
                scenario.start.len() == self.robot.model.nq() && scenario.start.iter().all(|x| x.is_finite()),
                &format!("{place}.start"),
                "is no configuration of the robot",
            )?;
            self.check_world(scenario, &format!("{place}.world"))?;
            self.check_expectations(scenario, &place)?;
        }
        Ok(())
    }

    fn check_expectations(&self, scenario: &ScenarioProgram, place: &str) -> Result<(), ProgramError> {
        let task = |t: usize| t < self.tasks.len();
        let width = scenario.table(self).width();
        for (i, measure) in scenario.measures.iter().enumerate() {
            let good = match measure {
                Measure::Margin(t) | Measure::Error { task: t, .. } => task(*t),
                Measure::In(s) => self.machine.as_ref().is_some_and(|m| *s < m.states.len()),
                Measure::Speed(d) => self.robot.model.dofs.get(*d).is_some_and(|d| d.q_index.is_some()),
                Measure::LargestSpeed(dofs) | Measure::LargestAcceleration(dofs) => {
                    dofs.iter().all(|d| *d < self.robot.model.nv())
                }
                Measure::PointSpeed(link) | Measure::PointAcceleration(link) => {
                    (link.0 as usize) < self.robot.model.links.len()
                }
                Measure::Acceleration(d) => *d < self.robot.model.nv(),
                Measure::Reversals(dofs) => dofs.iter().all(|d| *d < self.robot.model.nv()),
                Measure::Fault(_) => true,
                Measure::Initial(e) => e.check(&self.robot.model, width).is_ok() && e.outputs.len() == 1,
            };
            ensure(good, &format!("{place}.measures[{i}]"), "measures something that does not exist")?;
        }
        for (i, p) in scenario.predicates.iter().enumerate() {
            let place = format!("{place}.predicates[{i}]");
            p.value.check(&self.robot.model, width).map_err(|text| error(&place, text))?;
            ensure(p.value.outputs.len() == 1, &place, "is no single number")?;
        }
        for (i, e) in scenario.expectations.iter().enumerate() {
            let at = |e: ProgramError| error(format!("{place}.expectations[{i}].{}", e.place), e.message);
            e.formula.check(scenario.predicates.len()).map_err(at)?;
        }
        Ok(())
    }

    fn check_world(&self, scenario: &ScenarioProgram, place: &str) -> Result<(), ProgramError> {
        let world = &scenario.world;
        let wide = |signal: usize, values: &[f64]| {
            let len = self.interface.signals.get(signal).map(|s| s.len);
            let good = len == Some(values.len()) && values.iter().all(|x| x.is_finite());
            ensure(good, place, "a value does not fit its signal, or the signal does not exist")
        };
        for script in &world.signals {
            self.check_signal_script(script, place)?;
            script.path.iter().try_for_each(|(_, value)| wide(script.signal, value))?;
        }
        for script in &world.humans {
            self.check_human(script, place)?;
        }
        for truth in &world.obstacles {
            ensure(truth.obstacle < self.obstacles.len(), place, "an obstacle does not exist")?;
            let mut numbers = truth.position.iter().flatten().chain(truth.orientation.iter().flatten());
            ensure(numbers.all(|x| x.is_finite()), place, "the place of an obstacle is not finite")?;
        }
        let mut seen: Vec<usize> = world.humans.iter().map(|h| h.human).collect();
        seen.sort_unstable();
        ensure(seen.windows(2).all(|w| w[0] != w[1]), place, "a person is in two places at once")?;
        for (event, times) in &world.events {
            ensure(*event < self.interface.events.len(), place, "an event does not exist")?;
            ensure(times.iter().all(|t| is_time(*t)), place, "a time is negative or not finite")?;
        }
        let mut told = world.stops.iter().chain(&world.resumes);
        ensure(told.all(|t| is_time(*t)), place, "a time is negative or not finite")?;
        for outcome in world.outcomes.iter().flat_map(|o| &o.requests) {
            ensure(is_time(outcome.after), place, "a time is negative or not finite")?;
            outcome.sets.iter().try_for_each(|(signal, value)| wide(*signal, value))?;
        }
        ensure(world.outcomes.iter().all(|o| !o.requests.is_empty()), place, "an action has no outcome")?;
        for push in &world.pushes {
            ensure(is_time(push.from) && push.to.is_none_or(is_time), place, "a time is negative or not finite")?;
            match &push.force {
                Force::Constant(wrench) => wide(push.signal, wrench)?,
                Force::Towards { link, point, stiffness, damping, most } => {
                    wide(push.signal, &[0.0; 6])?;
                    ensure(link.index() < self.robot.model.links.len(), place, "a link does not exist")?;
                    let good = [*stiffness, *damping, *most].into_iter().all(is_time);
                    ensure(good && point.iter().all(|x| x.is_finite()), place, "a push is negative or not finite")?;
                }
            }
        }
        let late = |&(at, by): &(f64, f64)| is_time(at) && is_time(by);
        ensure(world.late.iter().all(late), place, "a time is negative or not finite")?;
        for lost in &world.lost {
            let known = self.robot.model.dofs.get(lost.dof).is_some_and(|d| d.q_index.is_some());
            ensure(known && is_time(lost.from) && is_time(lost.to), place, "a lost reading has no joint or no time")?;
        }
        Ok(())
    }

    fn check_human(&self, script: &HumanScript, place: &str) -> Result<(), ProgramError> {
        let points = self.interface.humans.get(script.human).map(|h| h.points.len());
        ensure(points == Some(script.tracks.len()), place, "a person does not exist, or has other points")?;
        for Track(path) in &script.tracks {
            let rising = path.windows(2).all(|w| w[0].0 < w[1].0) && path.iter().all(|p| is_time(p.0));
            let finite = path.iter().flat_map(|p| p.1).all(f64::is_finite);
            ensure(
                !path.is_empty() && rising && finite,
                place,
                "a person's way is empty, or its instants do not rise",
            )?;
        }
        let s = &script.sending;
        ensure(s.gaps.iter().all(|g| is_time(g.0) && is_time(g.1)), place, "a time is negative or not finite")?;
        self.check_sending(s, place)
    }

    fn check_signal_script(&self, s: &SignalScript, place: &str) -> Result<(), ProgramError> {
        ensure(!s.path.is_empty(), place, "a script sends no value")?;
        let rising = s.path.windows(2).all(|w| w[0].0 < w[1].0) && s.path.iter().all(|p| is_time(p.0));
        ensure(rising, place, "the instants of a path do not rise")?;
        self.check_sending(&s.sending(), place)
    }

    fn check_sending(&self, s: &Sending, place: &str) -> Result<(), ProgramError> {
        let times = [s.from, s.delay, s.period, s.noise].into_iter().all(is_time) && s.to.is_none_or(is_time);
        ensure(times, place, "a time is negative or not finite")?;
        ensure((0.0..=1.0).contains(&s.drop), place, "a share lies between 0 and 1")
    }
}
