//! Scenarios of missions: how one is executed in a simulated world, what happens there, and what is expected of it.

use mission::execution::Replan;
use mission::kind::course::Driven;
use mission::kind::{Event, Form, Replies, Run};
use serde::{Deserialize, Serialize};

use super::Unit;
use super::check::ensure;
use super::{ExpectationProgram, MissionProgram, Predicate, PredicateTable, ProgramError, WorkerProgram, error};

/// The most instants at which the expectations of a run are judged.
pub const MAX_INSTANTS: u32 = 200_000;

/// The longest run of a mission, in s.
pub const MAX_MISSION: f64 = 1e6;

/// The most that may happen in a scenario.
pub const MAX_EVENTS: usize = 200;

/// A mission that is executed in a world of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MissionScenarioProgram {
    /// Its name.
    pub name: String,
    /// Duration of the run, in s: above zero, at most [`MAX_MISSION`].
    pub duration: f64,
    /// The time from one instant at which it is judged to the next, in s.
    pub step: f64,
    /// Seed of everything random.
    pub seed: u64,
    /// True if durations of operations are drawn from their distributions or result from the controllers of working
    /// robots, false if they are as planned.
    pub sampled: bool,
    /// True if robots are kinematic bases that avoid each other, false if they are points.
    pub bases: bool,
    /// Reaction to a deviation from the plan.
    pub replan: Replan,
    /// Events, in order of time.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub happens: Vec<TimedEvent>,
    /// Feedback of people after their services, each person at most once.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub replies: Vec<Replies>,
    /// Numbers that are worked out at each instant.
    pub measures: Vec<MissionMeasure>,
    /// Predicates of the formulas. They read the table of [`MissionScenarioProgram::table`] and no state of a robot.
    pub predicates: Vec<Predicate>,
    /// Expectations, in the order written.
    pub expectations: Vec<ExpectationProgram>,
}

/// An event at a time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimedEvent {
    /// Time from the start of the mission, in s.
    pub at: f64,
    /// The event.
    pub what: Event,
}

/// A number that is computed at each instant; a truth value is 1 or -1.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MissionMeasure {
    /// A measure of the kind of mission.
    Value {
        /// Its name.
        name: String,
        /// Index of the member; none: of the mission.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        member: Option<usize>,
        /// Component of a point, 0 to 2; 0 for a number.
        axis: usize,
    },
    /// The controller that a member runs has broken down: index of the member.
    Faulted(usize),
    /// The machine that a member runs is in a state: index of the member, and of the state.
    In(usize, usize),
}

impl MissionMeasure {
    /// A number of the whole mission.
    pub fn of_mission(name: &str) -> MissionMeasure {
        MissionMeasure::Value { name: name.into(), member: None, axis: 0 }
    }
}

/// Returns true if a run of this duration (s) is a whole number of steps of this length (s).
pub fn ends_with_step(duration: f64, step: f64) -> bool {
    let steps = duration / step;
    steps.round() >= 1.0 && (steps - steps.round()).abs() <= 1e-6
}

/// The longest step up to this one, s, with which a run of this duration, s, ends.
pub fn step_within(duration: f64, longest: f64) -> f64 {
    if ends_with_step(duration, longest) { longest } else { duration / (duration / longest).ceil().max(1.0) }
}

/// The member that a controller drives.
fn driven(of: &WorkerProgram) -> Option<Driven> {
    of.drive().map(|drive| Driven { member: of.member, tolerance: drive.tolerance })
}

impl MissionScenarioProgram {
    /// The layout of the numbers that its predicates read.
    pub fn table(&self) -> PredicateTable {
        PredicateTable { signals: 0, measures: self.measures.len() }
    }

    /// Units of the predicates.
    pub fn units(&self) -> Vec<Unit> {
        self.predicates.iter().map(|p| p.unit).collect()
    }

    /// At how many instants it is judged: the first at the start, the last at the end.
    pub fn instants(&self) -> u32 {
        (self.duration / self.step).round().min(f64::from(MAX_INSTANTS)) as u32 + 1
    }

    /// Lets it run for another time, s, above 0. Steps become shorter where the last one would not end with it.
    pub fn last(&mut self, duration: f64) {
        (self.duration, self.step) = (duration, step_within(duration, self.step));
    }

    /// The settings of its run.
    pub fn run(&self, mission: &MissionProgram) -> Run {
        Run {
            sampled: self.sampled.then_some(self.seed),
            bases: self.bases,
            replan: self.replan,
            reporting: self.running(mission).iter().filter(|w| w.drive().is_none()).map(|w| w.member).collect(),
            driven: self.running(mission).iter().filter_map(driven).collect(),
            replies: self.replies.clone(),
        }
    }

    /// The members that run their controllers in it.
    pub fn running<'m>(&self, mission: &'m MissionProgram) -> &'m [WorkerProgram] {
        if self.sampled { &mission.running.workers } else { &[] }
    }

    /// Makes sure that it can be run; what the compiler gives always can.
    pub(super) fn check(&self, mission: &MissionProgram, place: &str) -> Result<(), ProgramError> {
        self.check_times(place)?;
        mission.kind.check_run(&self.run(mission)).map_err(|why| error(place, why))?;
        self.check_happens(place)?;
        let replies = self.replies.iter().flat_map(|replies| replies.services.iter().flatten());
        for event in self.happens.iter().map(|happens| &happens.what).chain(replies) {
            let of = format!("{place}.happens");
            mission.kind.check_event(event).map_err(|why| error(&of, why.text))?;
            let info = mission.kind.kind().event(&event.event);
            let driven = self.running(mission).iter().any(|w| w.drive().is_some() && Some(w.member) == event.member);
            let why = info.and_then(|info| info.not_driven).filter(|_| driven);
            why.map_or(Ok(()), |why| Err(error(&of, format!("`{}` is not possible: {why}", event.event))))?;
        }
        let members = mission.kind.members();
        let kind = mission.kind.kind();
        self.check_expectations(place, &|measure| match measure {
            MissionMeasure::Value { name, member, axis } => {
                let role = member.map(|member| members.get(member).map(|member| member.role));
                let exists = role != Some(None);
                let found = kind.measure(role.flatten(), name);
                exists && found.is_some_and(|m| *axis == 0 || (m.form == Form::Point && *axis < 3))
            }
            MissionMeasure::Faulted(member) | MissionMeasure::In(member, _) => *member < members.len(),
        })
    }

    /// Checks duration and step.
    fn check_times(&self, place: &str) -> Result<(), ProgramError> {
        let inside = |x: f64, most: f64| x > 0.0 && x <= most;
        ensure(inside(self.duration, MAX_MISSION), &format!("{place}.duration"), "is above 0 and at most 1e6 s")?;
        let fine = inside(self.step, MAX_MISSION) && self.duration / self.step <= f64::from(MAX_INSTANTS) + 0.5;
        let step = format!("{place}.step");
        ensure(fine, &step, "is above 0, and not so small that there are more than 200000 instants")?;
        ensure(ends_with_step(self.duration, self.step), &step, "goes into the duration a whole number of times")
    }

    /// Checks the number and order of events.
    fn check_happens(&self, place: &str) -> Result<(), ProgramError> {
        ensure(self.happens.len() <= MAX_EVENTS, &format!("{place}.happens"), "more happens than 200 times")?;
        let rising = self.happens.windows(2).all(|w| w[0].at <= w[1].at);
        let times = self.happens.iter().all(|h| h.at.is_finite() && h.at >= 0.0);
        ensure(rising && times, &format!("{place}.happens"), "its times are zero or more, and rise")
    }

    /// Checks measures, predicates and formulas; `known` returns true if the subject of a measure exists.
    fn check_expectations(&self, place: &str, known: &dyn Fn(&MissionMeasure) -> bool) -> Result<(), ProgramError> {
        for (i, measure) in self.measures.iter().enumerate() {
            ensure(known(measure), &format!("{place}.measures[{i}]"), "measures somebody who does not exist")?;
        }
        let width = self.table().width();
        for (i, p) in self.predicates.iter().enumerate() {
            let place = format!("{place}.predicates[{i}]");
            p.value.check_alone(width).map_err(|text| error(&place, text))?;
            ensure(p.value.outputs.len() == 1, &place, "is no single number")?;
        }
        for (i, e) in self.expectations.iter().enumerate() {
            let at = |e: ProgramError| error(format!("{place}.expectations[{i}].{}", e.place), e.message);
            e.formula.check(self.predicates.len()).map_err(at)?;
        }
        Ok(())
    }
}
