//! Scenarios of missions: a mission is executed while what the scenario says happens, people answer as it says, working
//! robots run their controllers, and its expectations are judged at instants that are one step apart.
//!
//! The same scenario with the same seed gives the same records, unless a planner was ended by its wall time. Nothing here
//! panics: what cannot be planned, or cannot happen when it should, is said in the summary.

pub mod csv;
mod monitors;
mod summary;
mod workers;

use mission::chart::Chart;
use mission::kind::{Event, Execution};
use mission::labels::Labels;
use mission::map::Map;

use crate::program::{MissionMeasure, MissionProgram, MissionScenarioProgram, ProgramError};
use monitors::MissionJudge;

pub use summary::{End, Happened, MissionSummary, Untaken};
pub use workers::{BrokeDown, WorkerRecord, Workers};

/// An instant of a run.
pub struct Instant<'r> {
    /// Since the start of the mission, in s.
    pub time: f64,
    /// The execution as it is now.
    pub execution: &'r dyn Execution,
    /// Members that run controllers.
    pub workers: &'r Workers,
}

/// Something that is shown every instant of a run.
pub trait MissionRecorder {
    /// The run begins; `running` are the names of the members that run controllers.
    ///
    /// # Errors
    /// It cannot be written down.
    fn begin(&mut self, _execution: &dyn Execution, _running: &[String]) -> std::io::Result<()> {
        Ok(())
    }

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
    /// Its results.
    pub summary: MissionSummary,
    /// Text that people read in place of names.
    pub labels: Labels,
    /// The chart of the plan before anything happened; none: there was no plan.
    pub planned: Option<Chart>,
    /// The chart of activities that were done or are still planned; none: there was no plan.
    pub executed: Option<Chart>,
    /// The map of these; none: there was no plan.
    pub map: Option<Map>,
}

/// Why a run cannot be made, or was not finished.
#[derive(Debug, thiserror::Error)]
pub enum MissionError {
    /// The expectations cannot be judged, which the compiler excludes.
    #[error(transparent)]
    Program(#[from] ProgramError),
    /// A recorder could not write.
    #[error("cannot write what happened: {0}")]
    Record(#[from] std::io::Error),
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
    let workers = Workers::new(mission, scenario)?;
    let labels = mission.kind.labels().clone();
    let execution = match mission.kind.execute(&scenario.run(mission)) {
        Ok(execution) => execution,
        Err(why) => {
            let summary = MissionSummary::refused(mission, scenario, why, judge.finish());
            return Ok(MissionRun { summary, labels, planned: None, executed: None, map: None });
        }
    };
    let planned = execution.chart();
    let mut world = World::new(scenario, execution, workers);
    recorder.begin(&*world.execution, &world.workers.names())?;
    let (mut instants, mut interrupted) = (0, false);
    for k in 0..scenario.instants() {
        if !go_on(k) {
            interrupted = true;
            break;
        }
        let time = f64::from(k) * scenario.step;
        world.drive(time);
        let World { execution, workers, .. } = &world;
        judge.instant(time, &|measure| value(measure, &**execution, workers)).map_err(std::io::Error::other)?;
        recorder.instant(&Instant { time, execution: &**execution, workers })?;
        instants = k + 1;
    }
    let outcomes = judge.finish();
    let end = if interrupted { End::Interrupted } else { End::of(&*world.execution) };
    let map = Some(world.execution.map());
    let executed = Some(world.execution.chart());
    let summary = MissionSummary::new(mission, scenario, world, RunEnd { end, instants, outcomes });
    Ok(MissionRun { summary, labels, planned: Some(planned), executed, map })
}

/// The end of a run.
struct RunEnd {
    end: End,
    /// Number of instants that were judged.
    instants: u32,
    /// Results of the expectations.
    outcomes: Vec<crate::expect::Outcome>,
}

/// The value of a measure at the present instant; NaN for a measure of nobody.
fn value(measure: &MissionMeasure, execution: &dyn Execution, workers: &Workers) -> f64 {
    let truth = |holds: bool| if holds { 1.0 } else { -1.0 };
    match measure {
        MissionMeasure::Value { name, member, axis } => {
            execution.measure(name, *member).get(*axis).copied().unwrap_or(f64::NAN)
        }
        MissionMeasure::Faulted(member) => truth(workers.has_faulted(*member)),
        // If operations take as long as planned, no machine is in any state.
        MissionMeasure::In(member, state) => truth(workers.is_in(*member, *state).unwrap_or(false)),
    }
}

/// The mission with everything beside it that makes events.
struct World<'s> {
    scenario: &'s MissionScenarioProgram,
    execution: Box<dyn Execution>,
    workers: Workers,
    /// Number of events of the script that have happened.
    happened: usize,
    /// Length of the log that the workers know.
    seen: usize,
    untaken: Vec<Untaken>,
}

impl<'s> World<'s> {
    fn new(scenario: &'s MissionScenarioProgram, execution: Box<dyn Execution>, mut workers: Workers) -> World<'s> {
        workers.look(&*execution);
        World { scenario, execution, workers, happened: 0, seen: 0, untaken: Vec::new() }
    }

    /// Lets time pass, with everything that happens on the way.
    fn drive(&mut self, to: f64) {
        loop {
            let scripted = self.scenario.happens.get(self.happened).filter(|h| h.at <= to);
            let target = scripted.map_or(to, |h| h.at);
            let now = self.execution.time();
            // An event may have steps that follow at the same time, and these come before anything else.
            self.advance(now);
            // The mission stops at each of its steps: people answer at the time of the step that they answer to.
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
                    self.handle(&happens.what);
                }
                // An instant is judged after the ticks of the controllers at its time.
                None if self.work(to, true) => {}
                None => return,
            }
        }
    }

    /// Lets controllers tick until a time, or until one of them reports an event, which is handled; true then.
    fn work(&mut self, until: f64, inclusive: bool) -> bool {
        let Some((at, event)) = self.workers.work(until, inclusive) else { return false };
        self.advance(at);
        self.handle(&event);
        true
    }

    fn advance(&mut self, to: f64) {
        self.execution.advance(to);
        self.listen();
    }

    fn handle(&mut self, event: &Event) {
        if let Err(why) = self.execution.handle(event) {
            let event = self.execution.describe(event);
            self.untaken.push(Untaken { at_s: self.execution.time(), event, why });
        }
        self.listen();
    }

    /// Lets members that run controllers know what goes on.
    fn listen(&mut self) {
        let rejected = self.execution.take_rejected().into_iter();
        self.untaken.extend(rejected.map(|r| Untaken { at_s: r.time, event: r.event, why: r.why }));
        let log = self.execution.log_len();
        if std::mem::replace(&mut self.seen, log) < log {
            self.workers.look(&*self.execution);
        }
    }
}
