//! Scenarios of missions: a mission is executed while what the scenario says happens, people answer as it says, and its
//! expectations are judged at instants that are one step apart.
//!
//! The same scenario with the same seed gives the same records, unless a planner was ended by its wall time. Nothing here
//! panics: what cannot be planned, or cannot happen when it should, is said in the summary.

pub mod csv;
mod gauge;
mod judge;
mod summary;
mod words;

use mission::execution::{Event, EventError, Execution, Happening, Stage};
use mission::plan::{Plan, Target};
use mission::schedule::problem::Problem;

use crate::program::{MissionProgram, MissionScenarioProgram, Occurrence, ProgramError, error};
use gauge::Gauge;
use judge::MissionJudge;

pub use summary::{End, Happened, MissionSummary, Untaken};
pub use words::{of_event, of_happening};

/// An instant of a run.
pub struct Instant<'r> {
    /// Since the start of the mission, in s.
    pub time: f64,
    /// The execution as it stands.
    pub execution: &'r Execution,
    /// Total waits of the agents so far, in s.
    pub waited: &'r [f64],
}

/// Something that is shown every instant of a run.
pub trait MissionRecorder {
    /// An instant.
    ///
    /// # Errors
    /// It cannot be written down.
    fn instant(&mut self, instant: &Instant) -> std::io::Result<()>;
}

/// A recorder of nothing.
pub struct Nothing;

impl MissionRecorder for Nothing {
    fn instant(&mut self, _: &Instant) -> std::io::Result<()> {
        Ok(())
    }
}

/// A run of a scenario.
#[derive(Clone, Debug)]
pub struct MissionRun {
    /// What it came to.
    pub summary: MissionSummary,
    /// The problem as it was at the start.
    pub problem: Problem,
    /// The plan that was made before anything happened; none where there was none.
    pub planned: Option<Plan>,
    /// What was done, and what is still planned; none where there was no plan.
    pub executed: Option<Plan>,
}

/// Why a run cannot be made, or was not finished.
#[derive(Debug)]
pub enum MissionError {
    /// The expectations cannot be judged, which the compiler excludes.
    Program(ProgramError),
    /// A recorder could not write.
    Record(std::io::Error),
}

impl std::fmt::Display for MissionError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            MissionError::Program(e) => e.fmt(f),
            MissionError::Record(e) => write!(f, "cannot write what happened: {e}"),
        }
    }
}

impl std::error::Error for MissionError {}

impl From<ProgramError> for MissionError {
    fn from(e: ProgramError) -> MissionError {
        MissionError::Program(e)
    }
}

impl From<std::io::Error> for MissionError {
    fn from(e: std::io::Error) -> MissionError {
        MissionError::Record(e)
    }
}

/// Runs a scenario of a mission to its end, or until `go_on` says no at an instant; `recorder` is shown every instant.
///
/// # Errors
/// The expectations cannot be judged, which the compiler excludes; or a recorder cannot write. A mission that cannot be
/// planned is no error but a [`End::Refused`] in the summary.
pub fn run(
    mission: &MissionProgram,
    scenario: &MissionScenarioProgram,
    recorder: &mut dyn MissionRecorder,
    go_on: &mut dyn FnMut(u32) -> bool,
) -> Result<MissionRun, MissionError> {
    let mut judge = MissionJudge::new(scenario)?;
    let Some(schedule) = mission.schedule() else {
        return Err(error("scenarios", "only a schedule is executed").into());
    };
    let problem = schedule.problem.clone();
    let execution = match Execution::new(problem.clone(), scenario.settings(schedule)) {
        Ok(execution) => execution,
        Err(why) => {
            let summary = MissionSummary::refused(mission, scenario, why.to_string(), judge.finish());
            return Ok(MissionRun { summary, problem, planned: None, executed: None });
        }
    };
    let planned = execution.plan().clone();
    let mut world = World::new(scenario, execution);
    let (mut instants, mut interrupted) = (0, false);
    for k in 0..scenario.instants() {
        if !go_on(k) {
            interrupted = true;
            break;
        }
        let time = f64::from(k) * scenario.step;
        world.drive(time);
        let World { execution, gauge, .. } = &mut world;
        gauge.look(execution);
        judge.instant(time, execution, gauge).map_err(std::io::Error::other)?;
        recorder.instant(&Instant { time, execution, waited: gauge.waited() })?;
        instants = k + 1;
    }
    let World { execution, untaken, .. } = world;
    let outcomes = judge.finish();
    let end = if interrupted { End::Interrupted } else { End::of(&execution) };
    let summary = MissionSummary::new(mission, scenario, (&execution, end, instants), untaken, outcomes);
    Ok(MissionRun { summary, problem, planned: Some(planned), executed: Some(execution.plan().clone()) })
}

/// What happens beside the mission itself.
struct World<'s> {
    scenario: &'s MissionScenarioProgram,
    execution: Execution,
    gauge: Gauge,
    /// How much of the script has happened.
    happened: usize,
    /// Records that were looked at for services.
    heard: usize,
    /// How often each person has answered.
    answers: Vec<usize>,
    untaken: Vec<Untaken>,
}

impl<'s> World<'s> {
    fn new(scenario: &'s MissionScenarioProgram, execution: Execution) -> World<'s> {
        let agents = execution.problem().agents.len();
        World {
            scenario,
            gauge: Gauge::new(agents),
            execution,
            happened: 0,
            heard: 0,
            answers: vec![0; agents],
            untaken: Vec::new(),
        }
    }

    /// Lets time pass, with everything that happens on the way.
    fn drive(&mut self, to: f64) {
        loop {
            let scripted = self.scenario.happens.get(self.happened).filter(|h| h.at <= to);
            let target = scripted.map_or(to, |h| h.at);
            // A service that ends on the way is answered when it ends.
            let now = self.execution.time();
            let stop = self.execution.next().filter(|t| *t > now && *t < target).unwrap_or(target);
            self.execution.advance(stop);
            self.listen();
            if stop < target {
                continue;
            }
            let Some(happens) = scripted else { return };
            self.happened += 1;
            self.occurs(happens.what);
            self.listen();
        }
    }

    fn occurs(&mut self, what: Occurrence) {
        let event = match what {
            Occurrence::Event(event) => Ok(event),
            Occurrence::FailedBy { robot } => {
                let view = self.execution.robot(robot).filter(|view| view.stage == Stage::Serving);
                match view.and_then(|view| view.target) {
                    Some(Target { agent, .. }) => Ok(Event::Failed { agent }),
                    None => Err(robot),
                }
            }
        };
        match event {
            Ok(event) => self.tell(event),
            Err(robot) => {
                let name = self.execution.problem().robots.get(robot).map_or("", |m| &m.name);
                let (event, why) = (format!("the service that {name} gives fails"), format!("{name} serves nobody"));
                self.untaken.push(Untaken { at_s: self.execution.time(), event, why });
            }
        }
    }

    fn tell(&mut self, event: Event) {
        let told: Result<(), EventError> = self.execution.tell(event).map(|_| ());
        if let Err(why) = told {
            let event = of_event(&event, self.execution.problem());
            self.untaken.push(Untaken { at_s: self.execution.time(), event, why: why.to_string() });
        }
    }

    /// Lets people who were served say what it was like.
    fn listen(&mut self) {
        while let Some(record) = self.execution.records().get(self.heard) {
            self.heard += 1;
            let Happening::Served { agent, .. } = record.what else { continue };
            let Some(replies) = self.scenario.replies.iter().find(|r| r.agent == agent) else { continue };
            let Some(count) = self.answers.get_mut(agent) else { continue };
            let reply = replies.services.get(*count).or(replies.services.last());
            *count += 1;
            if let Some(Some(reply)) = reply {
                self.tell(reply.of(agent));
            }
        }
    }
}
