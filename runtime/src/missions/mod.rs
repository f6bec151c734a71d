//! Scenarios of missions: executes a mission with the events and replies of a scenario and the controllers of working
//! robots, and evaluates the expectations at instants one step apart.
//!
//! The same scenario with the same seed gives the same records, unless a planner reached its limit of wall time. Nothing
//! here panics: the summary reports a mission without a plan and events that are rejected.

pub mod csv;
mod drive;
mod monitors;
mod snapshots;
mod summary;
mod workers;

use mission::chart::Chart;
use mission::kind::{Event, Execution, ReportPart};
use mission::labels::Labels;
use mission::map::Map;

use crate::program::{MissionMeasure, MissionProgram, MissionScenarioProgram, ProgramError};
use monitors::MissionMonitors;
use snapshots::Snapshots;

pub use drive::DriveRecord;
pub use snapshots::MapAt;
pub use summary::{End, LogEntry, MissionSummary, RejectedEvent};
pub use workers::{BrokeDown, WorkerRecord, Workers};

/// An instant of a run.
pub struct Instant<'r> {
    /// Time since the start of the mission, in s.
    pub time: f64,
    /// The execution as it is now.
    pub execution: &'r dyn Execution,
    /// Members that run controllers.
    pub workers: &'r Workers,
}

/// Recorder of the instants of a run.
pub trait MissionRecorder {
    /// Called at the start of the run; `running` are the names of the members that run controllers.
    ///
    /// # Errors
    /// Writing failed.
    fn begin(&mut self, _execution: &dyn Execution, _running: &[String]) -> std::io::Result<()> {
        Ok(())
    }

    /// Called at every instant.
    ///
    /// # Errors
    /// Writing failed.
    fn instant(&mut self, instant: &Instant) -> std::io::Result<()>;

    /// Called once after the last instant, with the execution as it ended.
    fn end(&mut self, _execution: &dyn Execution) {}
}

/// Recorder that stores nothing.
pub struct NullRecorder;

impl MissionRecorder for NullRecorder {
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
    /// Maps of a few instants, by time, if the ground of the map changes.
    pub maps: Vec<MapAt>,
    /// Further parts of its report.
    pub parts: Vec<ReportPart>,
}

/// Error of a run.
#[derive(Debug, thiserror::Error)]
pub enum MissionError {
    /// The expectations cannot be judged, which the compiler excludes.
    #[error(transparent)]
    Program(#[from] ProgramError),
    /// A recorder could not write.
    #[error("cannot write what happened: {0}")]
    Record(#[from] std::io::Error),
}

/// Runs a scenario of a mission to its end, or until `go_on` returns false; `recorder` receives every instant.
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
    let mut monitors = MissionMonitors::new(scenario)?;
    let workers = Workers::new(mission, scenario)?;
    let labels = mission.kind.labels().clone();
    let execution = match mission.kind.execute(&scenario.run(mission)) {
        Ok(execution) => execution,
        Err(why) => {
            let summary = MissionSummary::refused(mission, scenario, why, monitors.finish());
            return Ok(MissionRun {
                summary,
                labels,
                planned: None,
                executed: None,
                map: None,
                maps: Vec::new(),
                parts: Vec::new(),
            });
        }
    };
    let planned = execution.chart();
    let mut world = MissionWorld::new(scenario, execution, workers);
    recorder.begin(&*world.execution, &world.workers.names())?;
    let (mut instants, mut interrupted) = (0, false);
    let mut snapshots = mission.kind.map_changes().then(Snapshots::new);
    for k in 0..scenario.instants() {
        if !go_on(k) {
            interrupted = true;
            break;
        }
        let time = f64::from(k) * scenario.step;
        world.drive(time);
        let MissionWorld { execution, workers, .. } = &world;
        monitors.instant(time, &|measure| value(measure, &**execution, workers)).map_err(std::io::Error::other)?;
        if let Some(snapshots) = &mut snapshots {
            snapshots.instant(k, time, &**execution);
        }
        recorder.instant(&Instant { time, execution: &**execution, workers })?;
        instants = k + 1;
    }
    recorder.end(&*world.execution);
    let outcomes = monitors.finish();
    let end = if interrupted { End::Interrupted } else { End::of(&*world.execution) };
    let map = Some(world.execution.map());
    let maps = snapshots.map_or_else(Vec::new, Snapshots::finish);
    let (executed, parts) = (Some(world.execution.chart()), world.execution.report_parts());
    let summary = MissionSummary::new(mission, scenario, world, RunEnd { end, instants, outcomes });
    Ok(MissionRun { summary, labels, planned: Some(planned), executed, map, maps, parts })
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

/// Mission under execution, with its sources of events.
struct MissionWorld<'s> {
    scenario: &'s MissionScenarioProgram,
    execution: Box<dyn Execution>,
    workers: Workers,
    /// Index of the next event of the script.
    next_event: usize,
    /// Length of the log when the workers last saw it.
    seen: usize,
    rejected_events: Vec<RejectedEvent>,
}

impl<'s> MissionWorld<'s> {
    fn new(
        scenario: &'s MissionScenarioProgram,
        execution: Box<dyn Execution>,
        mut workers: Workers,
    ) -> MissionWorld<'s> {
        workers.look(&*execution);
        MissionWorld { scenario, execution, workers, next_event: 0, seen: 0, rejected_events: Vec::new() }
    }

    /// Advances to a time and handles all events until then.
    fn drive(&mut self, to: f64) {
        loop {
            let scripted = self.scenario.happens.get(self.next_event).filter(|h| h.at <= to);
            let target = scripted.map_or(to, |h| h.at);
            let now = self.execution.time();
            // Steps that an event causes at the same time come before anything else.
            self.advance(now);
            // The mission stops at each of its steps, so that replies have the time of the step that they reply to.
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
                    self.next_event += 1;
                    self.handle(&happens.what);
                }
                // An instant is judged after the ticks of the controllers at its time.
                None if self.work(to, true) => {}
                None => return,
            }
        }
    }

    /// Runs the controllers until a time, or until one of them reports an event, which is handled. Returns true then.
    fn work(&mut self, until: f64, inclusive: bool) -> bool {
        let Some((at, event)) = self.workers.work(until, inclusive, &mut *self.execution) else { return false };
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
            self.rejected_events.push(RejectedEvent { at_s: self.execution.time(), event, why });
        }
        self.listen();
    }

    /// Collects rejected events and passes new log entries to the members that run controllers.
    fn listen(&mut self) {
        let rejected = self.execution.take_rejected().into_iter();
        self.rejected_events.extend(rejected.map(|r| RejectedEvent { at_s: r.time, event: r.event, why: r.why }));
        let log = self.execution.log_len();
        if std::mem::replace(&mut self.seen, log) < log {
            self.workers.look(&*self.execution);
        }
    }
}
