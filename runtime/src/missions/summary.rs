//! What a scenario of a mission came to.

use mission::execution::PlanChange;
use mission::kinds::layers::execution::{self as layered, LayeredExecution};
use mission::kinds::schedule::execution::{Execution, Happening, Outcome as Numbers};
use serde::Serialize;

use super::layered_words::of_happening as of_layered;
use super::words::of_happening;
use super::{WorkerRecord, Workers};
use crate::expect::{Outcome, Verdict};
use crate::program::{MissionMeasure, MissionProgram, MissionScenarioProgram, OfAgent, OfLayers, OfMission};
use crate::record::expectations::{ExpectationRecord, records_of};

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "how")]
pub enum End {
    /// Everything was served that could be, and every robot was back; of layers: every task was done.
    Done {
        /// When, in s.
        at_s: f64,
    },
    /// The time of the scenario was over before.
    Unfinished,
    /// There was no plan any more.
    Stranded {
        /// Why, in a sentence.
        why: String,
    },
    /// There was no plan at all.
    Refused {
        /// Why, in a sentence.
        why: String,
    },
    /// Somebody stopped it.
    Interrupted,
}

impl End {
    /// How an execution stands at the end of its time.
    pub(super) fn of(execution: &Execution) -> End {
        if let Some(why) = execution.stranded() {
            return End::Stranded { why: why.to_string() };
        }
        let done = execution.records().iter().rev().find(|r| r.what == Happening::Done);
        match done.filter(|_| execution.done()) {
            Some(record) => End::Done { at_s: record.time },
            None => End::Unfinished,
        }
    }

    /// The same of a mission of layers.
    pub(super) fn of_layers(execution: &LayeredExecution) -> End {
        if let Some(why) = execution.stranded() {
            return End::Stranded { why: why.to_string() };
        }
        let done = execution.records().iter().rev().find(|r| r.what == layered::Happening::Done);
        match done.filter(|_| execution.done()) {
            Some(record) => End::Done { at_s: record.time },
            None => End::Unfinished,
        }
    }
}

/// Something that the scenario says and that could not happen when it should.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Untaken {
    /// When it should have happened, in s.
    pub at_s: f64,
    /// What, in words.
    pub event: String,
    /// Why it could not.
    pub why: String,
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Happened {
    /// When, in s.
    pub at_s: f64,
    /// What, in words.
    pub what: String,
    /// It came from outside, or changed who serves whom.
    #[serde(skip)]
    pub notable: bool,
}

fn is_notable(what: &Happening) -> bool {
    use Happening as H;
    matches!(
        what,
        H::Told { .. }
            | H::HeldUp { .. }
            | H::BrokenOff { .. }
            | H::Plan(PlanChange::Reallocated { .. })
            | H::Plan(PlanChange::Refused { .. })
            | H::Plan(PlanChange::Stranded { .. })
            | H::Done
    )
}

/// Working robots that broke down and whose loss no expectation speaks of.
fn broken(scenario: &MissionScenarioProgram, (execution, workers): (&Execution, &Workers)) -> Vec<(f64, String)> {
    let (agents, labels) = (&execution.problem().agents, &execution.problem().labels);
    let spoken = |name: &str| {
        let of = |measure: &MissionMeasure| match measure {
            MissionMeasure::Agent(i, OfAgent::Lost | OfAgent::Faulted) => {
                agents.get(*i).is_some_and(|a| a.name == name)
            }
            _ => false,
        };
        scenario.measures.iter().any(of)
    };
    let all = workers.records().into_iter().filter(|w| !spoken(&w.name));
    all.filter_map(|w| w.broke_down.map(|b| (b.at_s, format!("{} broke down: {}", labels.member(&w.name), b.why))))
        .collect()
}

fn is_notable_of_layers(what: &layered::Happening) -> bool {
    use layered::Happening as H;
    matches!(
        what,
        H::Told { .. }
            | H::Dropped { .. }
            | H::Plan(PlanChange::Reallocated { .. })
            | H::Plan(PlanChange::Refused { .. })
            | H::Plan(PlanChange::Stranded { .. })
            | H::Done
    )
}

/// What a scenario of a mission came to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MissionSummary {
    /// The mission.
    pub mission: String,
    /// The scenario.
    pub scenario: String,
    /// The seed.
    pub seed: u64,
    /// Simulated time, in s.
    pub duration_s: f64,
    /// Whether it went as expected; see [`MissionSummary::trouble`].
    pub ok: bool,
    /// How it ended.
    pub end: End,
    /// Makespan, waits, ways, energy, how often the plan changed; none where there was no plan.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outcome: Option<Numbers>,
    /// The same of a mission of layers: makespan, tasks, ways, energy, workload, how often the plan changed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub layers: Option<layered::Outcome>,
    /// What could not happen when it should.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub untaken: Vec<Untaken>,
    /// Working robots that ran controllers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub workers: Vec<WorkerRecord>,
    /// Working robots that broke down though nothing is expected of that: when, in s, and what.
    #[serde(skip)]
    pub broken: Vec<(f64, String)>,
    /// Expectations, in the order written.
    pub expectations: Vec<ExpectationRecord>,
    /// Everything that happened, in order.
    pub happened: Vec<Happened>,
}

impl MissionSummary {
    /// Of a mission that has no plan.
    pub(super) fn refused(
        mission: &MissionProgram,
        scenario: &MissionScenarioProgram,
        why: String,
        outcomes: Vec<Outcome>,
    ) -> MissionSummary {
        MissionSummary {
            mission: mission.name.clone(),
            scenario: scenario.name.clone(),
            seed: scenario.seed,
            duration_s: 0.0,
            ok: false,
            end: End::Refused { why },
            outcome: None,
            layers: None,
            untaken: Vec::new(),
            workers: Vec::new(),
            broken: Vec::new(),
            expectations: records_of(&scenario.expectations, &outcomes, scenario.step),
            happened: Vec::new(),
        }
    }

    /// Of an execution that was judged at so many instants.
    pub(super) fn new(
        mission: &MissionProgram,
        scenario: &MissionScenarioProgram,
        (execution, end, instants): (&Execution, End, u32),
        (untaken, workers): (Vec<Untaken>, &Workers),
        outcomes: Vec<Outcome>,
    ) -> MissionSummary {
        let said = workers.notes.iter().map(|(at_s, what)| Happened { at_s: *at_s, what: what.clone(), notable: true });
        let done = execution.records().iter().map(|r| Happened {
            at_s: r.time,
            what: of_happening(&r.what, execution.problem()),
            notable: is_notable(&r.what),
        });
        let mut happened: Vec<Happened> = said.chain(done).collect();
        happened.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
        let summary = MissionSummary::of(mission, scenario, (end, instants), (untaken, outcomes), happened);
        let broken = broken(scenario, (execution, workers));
        let (ok, workers) = (summary.ok && broken.is_empty(), workers.records());
        MissionSummary { ok, workers, broken, outcome: Some(execution.statistics()), ..summary }
    }

    /// Of an execution of layers that was judged at so many instants.
    pub(super) fn layered(
        mission: &MissionProgram,
        scenario: &MissionScenarioProgram,
        (execution, end, instants): (&LayeredExecution, End, u32),
        untaken: Vec<Untaken>,
        outcomes: Vec<Outcome>,
    ) -> MissionSummary {
        let happened = execution.records().iter().map(|r| Happened {
            at_s: r.time,
            what: of_layered(&r.what, execution.problem()),
            notable: is_notable_of_layers(&r.what),
        });
        let happened = happened.collect();
        let summary = MissionSummary::of(mission, scenario, (end, instants), (untaken, outcomes), happened);
        MissionSummary { layers: Some(execution.statistics()), ..summary }
    }

    /// Without the numbers of the kind of mission.
    fn of(
        mission: &MissionProgram,
        scenario: &MissionScenarioProgram,
        (end, instants): (End, u32),
        (untaken, outcomes): (Vec<Untaken>, Vec<Outcome>),
        happened: Vec<Happened>,
    ) -> MissionSummary {
        let expectations = records_of(&scenario.expectations, &outcomes, scenario.step);
        let measured = |measure| scenario.measures.contains(&measure);
        let good_end = match &end {
            End::Done { .. } => true,
            End::Refused { .. } | End::Interrupted => false,
            // Who expects something speaks of the end where it matters.
            End::Unfinished => !scenario.expectations.is_empty(),
            End::Stranded { .. } => {
                let schedule = [OfMission::Stranded, OfMission::Done].map(MissionMeasure::Mission);
                let layers = [OfLayers::Stranded, OfLayers::Done].map(MissionMeasure::Layers);
                schedule.into_iter().chain(layers).any(measured)
            }
        };
        let held = expectations.iter().all(|e| e.verdict == Verdict::Holds);
        MissionSummary {
            mission: mission.name.clone(),
            scenario: scenario.name.clone(),
            seed: scenario.seed,
            duration_s: f64::from(instants.saturating_sub(1)) * scenario.step,
            ok: held && good_end && untaken.is_empty(),
            end,
            outcome: None,
            layers: None,
            untaken,
            workers: Vec::new(),
            broken: Vec::new(),
            expectations,
            happened,
        }
    }

    /// What went wrong beside the expectations, each in a sentence with the time if there is one.
    pub fn trouble(&self) -> Vec<(Option<f64>, String)> {
        let end = match &self.end {
            End::Done { .. } => None,
            End::Unfinished if !self.expectations.is_empty() => None,
            End::Unfinished => Some(format!("the mission was not done after {} s", self.duration_s)),
            End::Stranded { why } => Some(format!("there is no plan any more: {why}")),
            End::Refused { why } => Some(format!("there is no plan: {why}")),
            End::Interrupted => Some("it was interrupted".to_string()),
        };
        let untaken =
            self.untaken.iter().map(|u| (Some(u.at_s), format!("could not happen: {}, as {}", u.event, u.why)));
        let broken = self.broken.iter().map(|(at, text)| (Some(*at), text.clone()));
        broken.chain(untaken).chain(end.map(|text| (None, text))).collect()
    }
}
