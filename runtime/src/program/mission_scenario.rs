//! Scenarios of missions: how one is executed in a simulated world, what happens there, and what is expected of it.

use std::time::Duration;

use mission::engine::Budget;
use mission::execution::{Durations, Replan};
use mission::kinds::layers;
use mission::kinds::schedule::choose::Options;
use mission::kinds::schedule::execution::{Event, Potentials, Settings, Travel};
use mission::kinds::schedule::problem::{AgentKind, Problem};
use mission::numbers::MAX_NUMBER;
use serde::{Deserialize, Serialize};

use super::Unit;
use super::check::ensure;
use super::layers_scenario::{OfLayers, OfTeammate};
use super::{ExpectationProgram, Predicate, PredicateTable, ProgramError, ScheduleProgram, WorkerProgram, error};

/// The most instants at which the expectations of a run are judged.
pub const MAX_INSTANTS: u32 = 200_000;

/// The longest run of a mission, in s.
pub const MAX_MISSION: f64 = 1e6;

/// The most that may happen in a scenario.
pub const MAX_HAPPENINGS: usize = 200;

/// How much work a plan may be, the first one and each that is made anew. The count of nodes ends it at the same place in
/// every run: a second on a usual machine. The time, which would not, is far beyond that.
const BUDGET: Budget = Budget { time: Duration::from_secs(60), nodes: 300, gap: 1e-4 };

/// A mission that is executed in a world of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MissionScenarioProgram {
    /// Its name.
    pub name: String,
    /// How long it runs, in s: above zero, at most [`MAX_MISSION`].
    pub duration: f64,
    /// The time from one instant at which it is judged to the next, in s.
    pub step: f64,
    /// Seed of everything random.
    pub seed: u64,
    /// Whether operations take as long as drawn from their distributions, or as the controllers of working robots take, and
    /// not as long as planned.
    pub sampled: bool,
    /// Whether robots are kinematic bases that avoid each other, and not points that pass through each other.
    pub bases: bool,
    /// What the plan does when something differs from it.
    pub replan: Replan,
    /// What happens, by time.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub happens: Vec<Happens>,
    /// What people say after they were served, each person at most once.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub replies: Vec<Replies>,
    /// Numbers that are worked out at each instant.
    pub measures: Vec<MissionMeasure>,
    /// What formulas are made of; they read the table of [`MissionScenarioProgram::table`], and nothing of a robot's
    /// state.
    pub predicates: Vec<Predicate>,
    /// What must hold, in the order written.
    pub expectations: Vec<ExpectationProgram>,
}

/// Something that happens at a time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Happens {
    /// When, in s from the start of the mission.
    pub at: f64,
    /// What.
    pub what: Occurrence,
}

/// What can happen.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Occurrence {
    /// The execution is told this.
    Event(Event),
    /// The service that this robot gives fails, whomever it serves then.
    FailedBy {
        /// Index of the robot.
        robot: usize,
    },
    /// The service that this robot gives takes longer, whomever it serves then.
    LateBy {
        /// Index of the robot.
        robot: usize,
        /// By how much (s); less than 0: it takes shorter.
        by: f64,
    },
    /// The execution of layers is told this.
    Layered(layers::execution::Event),
}

/// What a person says after each service.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Replies {
    /// Index of the agent, a person.
    pub agent: usize,
    /// One for each service, none for silence; the last one repeats.
    pub services: Vec<Option<Reply>>,
}

/// The five steps of thesis Fig. 5.5, each -2 to 2, as [`Event::Said`] has them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reply {
    /// The wait: too short (-2) to too long (2).
    pub wait: i8,
    /// The robot's approach: very fast (-2) to very slow (2).
    pub approach: i8,
    /// How far away it waited: very far (-2) to very close (2).
    pub distance: i8,
}

impl Reply {
    /// As an event of this agent.
    pub fn of(self, agent: usize) -> Event {
        let Reply { wait, approach, distance } = self;
        Event::Said { agent, wait, approach, distance }
    }
}

/// A number that is worked out at each instant; a truth value is 1 or -1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MissionMeasure {
    /// Of the mission.
    Mission(OfMission),
    /// Of an agent, by index.
    Agent(usize, OfAgent),
    /// Of a robot that serves, by index.
    Robot(usize, OfRobot),
    /// That the machine of a working robot is in a state: index of the agent, and of the state.
    In(usize, usize),
    /// Of a mission of layers.
    Layers(OfLayers),
    /// Of an agent of a mission of layers, by index.
    Teammate(usize, OfTeammate),
}

/// What is measured of a mission.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OfMission {
    /// Everything is served that can be, and every robot is back.
    Done,
    /// There is no plan any more.
    Stranded,
    /// From the start to the end of the last service so far, in s.
    Makespan,
    /// What the plan costs, as it stands.
    Cost,
    /// The energy of all robots so far, in J.
    Energy,
    /// How often times of the plan moved.
    Reschedules,
    /// How often was planned anew.
    Reallocations,
}

/// What is measured of an agent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OfAgent {
    /// Its waits so far, the one under way with them, in s.
    Waited,
    /// How many of its operations have been served.
    Served,
    /// It is at work.
    Working,
    /// It has left.
    Lost,
    /// The controller that it runs has broken down.
    Faulted,
    /// Where it works, in m.
    X,
    /// See `X`.
    Y,
    /// Adaptation index of its waits, thesis Algorithm 5.
    Adaptation,
    /// Adaptation index of the speeds of robots that came.
    SpeedAdaptation,
    /// How satisfied it is with its waits, -1 to 1.
    WaitSatisfaction,
    /// How satisfied it is with approaches, -1 to 1.
    ApproachSatisfaction,
}

/// What is measured of a robot that serves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OfRobot {
    /// Where it is, in m.
    X,
    /// See `X`.
    Y,
    /// How fast it is, in m/s; never negative.
    Speed,
    /// Way that it has gone, in ways that have ended, in m.
    Travelled,
    /// Energy that these took, in J.
    Energy,
    /// It is under way, or serves.
    Busy,
    /// How many operations it has served.
    Served,
    /// It has broken down.
    Lost,
}

/// Whether a run of this duration, s, ends with a step of this length, s.
pub fn ends_with_step(duration: f64, step: f64) -> bool {
    let steps = duration / step;
    steps.round() >= 1.0 && (steps - steps.round()).abs() <= 1e-6
}

/// The longest step up to this one, s, with which a run of this duration, s, ends.
pub fn step_within(duration: f64, longest: f64) -> f64 {
    if ends_with_step(duration, longest) { longest } else { duration / (duration / longest).ceil().max(1.0) }
}

impl MissionScenarioProgram {
    /// The layout of the numbers that its predicates read.
    pub fn table(&self) -> PredicateTable {
        PredicateTable { signals: 0, measures: self.measures.len() }
    }

    /// What the numbers of its predicates are.
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

    /// How its mission is executed.
    pub fn settings(&self, mission: &ScheduleProgram) -> Settings {
        Settings {
            durations: if self.sampled { Durations::Sampled { seed: self.seed } } else { Durations::Planned },
            travel: if self.bases { Travel::Bases(Potentials::default()) } else { Travel::Planned },
            adaptation: mission.adaptation,
            reallocate_above: mission.reallocate_above,
            replan: self.replan,
            planning: Options { batch: mission.batch, budget: BUDGET, ..Options::default() },
            told: self.running(mission).iter().map(|w| w.agent).collect(),
        }
    }

    /// The working robots that run their controllers in it.
    pub fn running<'m>(&self, mission: &'m ScheduleProgram) -> &'m [WorkerProgram] {
        if self.sampled { &mission.running.workers } else { &[] }
    }

    /// Makes sure that it can be run; what the compiler gives always can.
    pub(super) fn check(&self, problem: &Problem, place: &str) -> Result<(), ProgramError> {
        self.check_times(place)?;
        let wrong = |e: mission::kinds::schedule::execution::Refusal| error(place, e.to_string());
        let schedule = ScheduleProgram {
            problem: problem.clone(),
            adaptation: Default::default(),
            reallocate_above: 0.0,
            batch: 1,
            running: Default::default(),
        };
        self.settings(&schedule).check(problem).map_err(wrong)?;
        self.check_script(problem, place)?;
        self.check_expectations(place, &|measure| match measure {
            MissionMeasure::Mission(_) => true,
            MissionMeasure::Agent(a, _) | MissionMeasure::In(a, _) => *a < problem.agents.len(),
            MissionMeasure::Robot(r, _) => *r < problem.robots.len(),
            MissionMeasure::Layers(_) | MissionMeasure::Teammate(..) => false,
        })
    }

    /// How long it runs, and how finely it is judged.
    pub(super) fn check_times(&self, place: &str) -> Result<(), ProgramError> {
        let inside = |x: f64, most: f64| x > 0.0 && x <= most;
        ensure(inside(self.duration, MAX_MISSION), &format!("{place}.duration"), "is above 0 and at most 1e6 s")?;
        let fine = inside(self.step, MAX_MISSION) && self.duration / self.step <= f64::from(MAX_INSTANTS) + 0.5;
        let step = format!("{place}.step");
        ensure(fine, &step, "is above 0, and not so small that there are more than 200000 instants")?;
        ensure(ends_with_step(self.duration, self.step), &step, "goes into the duration a whole number of times")
    }

    /// How much happens, and when.
    pub(super) fn check_happens(&self, place: &str) -> Result<(), ProgramError> {
        ensure(self.happens.len() <= MAX_HAPPENINGS, &format!("{place}.happens"), "more happens than 200 times")?;
        let rising = self.happens.windows(2).all(|w| w[0].at <= w[1].at);
        let times = self.happens.iter().all(|h| h.at.is_finite() && h.at >= 0.0);
        ensure(rising && times, &format!("{place}.happens"), "its times are zero or more, and rise")
    }

    fn check_script(&self, problem: &Problem, place: &str) -> Result<(), ProgramError> {
        self.check_happens(place)?;
        for happens in &self.happens {
            let known = match happens.what {
                Occurrence::FailedBy { robot } => robot < problem.robots.len(),
                Occurrence::LateBy { robot, by } => robot < problem.robots.len() && by.abs() <= MAX_NUMBER,
                Occurrence::Event(Event::Moved { place, .. }) => place.iter().all(|x| x.abs() <= MAX_NUMBER),
                Occurrence::Event(_) => true,
                Occurrence::Layered(_) => false,
            };
            ensure(
                known,
                &format!("{place}.happens"),
                "something happens to a robot, or at a place, that does not exist",
            )?;
        }
        let mut seen = Vec::new();
        for replies in &self.replies {
            let person = problem.agents.get(replies.agent).is_some_and(|a| a.kind == AgentKind::Human);
            let again = seen.contains(&replies.agent);
            seen.push(replies.agent);
            let good = person && !again && !replies.services.is_empty();
            ensure(good, &format!("{place}.replies"), "they are those of people, of each once")?;
        }
        Ok(())
    }

    /// What is expected; `known` tells of a measure whether there is what it is of.
    pub(super) fn check_expectations(
        &self,
        place: &str,
        known: &dyn Fn(&MissionMeasure) -> bool,
    ) -> Result<(), ProgramError> {
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
