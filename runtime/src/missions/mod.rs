//! Scenarios of missions: a mission is executed while what the scenario says happens, people answer as it says, working
//! robots run their controllers, and its expectations are judged at instants that are one step apart.
//!
//! The same scenario with the same seed gives the same records, unless a planner was ended by its wall time. Nothing here
//! panics: what cannot be planned, or cannot happen when it should, is said in the summary.

pub mod csv;
mod gauge;
mod judge;
mod layered;
pub mod layered_csv;
mod layered_words;
mod summary;
mod words;
mod workers;

use mission::kinds::layers::execution::LayeredExecution;
use mission::kinds::schedule::execution::{Event, EventError, Execution, Happening, Stage};
use mission::kinds::schedule::problem::Problem;
use mission::plan::{Plan, Target};

use crate::program::{MissionKind, MissionProgram, MissionScenarioProgram, Occurrence, ProgramError};
use gauge::Gauge;
use judge::MissionJudge;

pub use layered_words::{doing as layered_doing, of_event as of_layered_event, of_happening as of_layered_happening};
pub use summary::{End, Happened, MissionSummary, Untaken};
pub use words::{of_event, of_happening};
pub use workers::{BrokeDown, WorkerRecord, Workers};

/// An instant of a run.
pub struct Instant<'r> {
    /// Since the start of the mission, in s.
    pub time: f64,
    /// The execution as it stands.
    pub execution: &'r Execution,
    /// Total waits of the agents so far, in s.
    pub waited: &'r [f64],
    /// Working robots that run controllers.
    pub workers: &'r Workers,
}

/// Something that is shown every instant of a run.
pub trait MissionRecorder {
    /// An instant.
    ///
    /// # Errors
    /// It cannot be written down.
    fn instant(&mut self, instant: &Instant) -> std::io::Result<()>;

    /// An instant of a mission of layers, `time` s after its start.
    ///
    /// # Errors
    /// It cannot be written down.
    fn layered(&mut self, _time: f64, _execution: &LayeredExecution) -> std::io::Result<()> {
        Ok(())
    }
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
    /// The problem of a schedule as it was at the start; none of a mission of layers.
    pub problem: Option<Problem>,
    /// The problem of layers; none of a schedule.
    pub layers: Option<mission::kinds::layers::problem::Problem>,
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
    let schedule = match &mission.kind {
        MissionKind::Schedule(schedule) => schedule,
        MissionKind::Layers(layers) => return layered::run((mission, layers), scenario, recorder, go_on),
    };
    let mut judge = MissionJudge::new(scenario)?;
    let workers = Workers::new(schedule, scenario)?;
    let problem = schedule.problem.clone();
    let execution = match Execution::new(problem.clone(), scenario.settings(schedule)) {
        Ok(execution) => execution,
        Err(why) => {
            let summary = MissionSummary::refused(mission, scenario, why.to_string(), judge.finish());
            return Ok(MissionRun { summary, problem: Some(problem), layers: None, planned: None, executed: None });
        }
    };
    let planned = execution.plan().clone();
    let mut world = World::new(scenario, execution, workers);
    let (mut instants, mut interrupted) = (0, false);
    for k in 0..scenario.instants() {
        if !go_on(k) {
            interrupted = true;
            break;
        }
        let time = f64::from(k) * scenario.step;
        world.drive(time);
        let World { execution, gauge, workers, .. } = &mut world;
        gauge.look(execution);
        judge.instant(time, &|measure| gauge.value(measure, execution, workers)).map_err(std::io::Error::other)?;
        recorder.instant(&Instant { time, execution, waited: gauge.waited(), workers })?;
        instants = k + 1;
    }
    let World { execution, untaken, workers, .. } = world;
    let outcomes = judge.finish();
    let end = if interrupted { End::Interrupted } else { End::of(&execution) };
    let summary = MissionSummary::new(mission, scenario, (&execution, end, instants), (untaken, &workers), outcomes);
    let executed = Some(execution.plan().clone());
    Ok(MissionRun { summary, problem: Some(problem), layers: None, planned: Some(planned), executed })
}

/// What happens beside the mission itself.
struct World<'s> {
    scenario: &'s MissionScenarioProgram,
    execution: Execution,
    workers: Workers,
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
    fn new(scenario: &'s MissionScenarioProgram, execution: Execution, mut workers: Workers) -> World<'s> {
        let agents = execution.problem().agents.len();
        workers.look(&execution);
        World {
            scenario,
            gauge: Gauge::new(agents),
            execution,
            workers,
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
            let now = self.execution.time();
            // What follows at once from what was told comes before anything else.
            self.advance(now);
            // A service that ends on the way is answered when it ends.
            let stop = self.execution.next().filter(|t| *t > now && *t < target).unwrap_or(target);
            if self.work(stop, false) {
                continue;
            }
            self.advance(stop);
            if stop < target {
                continue;
            }
            match scripted {
                Some(happens) => {
                    self.happened += 1;
                    self.occurs(happens.what);
                    self.listen();
                }
                // What is known at an instant is what controllers came to at it.
                None if self.work(to, true) => {}
                None => return,
            }
        }
    }

    /// Lets controllers tick until a time, or until one of them has something for the mission: true then, and it is told.
    fn work(&mut self, until: f64, inclusive: bool) -> bool {
        let Some((at, event)) = self.workers.work(until, inclusive) else { return false };
        self.advance(at);
        self.tell(event);
        self.listen();
        true
    }

    fn advance(&mut self, to: f64) {
        self.execution.advance(to);
        self.listen();
    }

    fn occurs(&mut self, what: Occurrence) {
        let (robot, becomes) = match what {
            Occurrence::Event(event) => return self.tell(event),
            Occurrence::FailedBy { robot } => (robot, "fails"),
            Occurrence::LateBy { robot, .. } => (robot, "takes longer"),
            // Of a mission of layers, which a checked program does not have here.
            Occurrence::Layered(_) => return,
        };
        let view = self.execution.robot(robot).filter(|view| view.stage == Stage::Serving);
        match (view.and_then(|view| view.target), what) {
            (Some(Target { agent, .. }), Occurrence::LateBy { by, .. }) => self.tell(Event::Late { agent, by }),
            (Some(Target { agent, .. }), _) => self.tell(Event::Failed { agent }),
            (None, _) => {
                let name = self.execution.problem().robot_label(robot).unwrap_or_default();
                let (event, why) =
                    (format!("the service that {name} gives {becomes}"), format!("{name} serves nobody"));
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

    /// Lets people who were served say what it was like, and working robots know what goes on.
    fn listen(&mut self) {
        let from = self.heard;
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
        if self.heard > from {
            self.workers.look(&self.execution);
        }
    }
}
