//! Results of a scenario of a mission.

use serde::Serialize;

use mission::kind::Execution;

use super::{MissionWorld, RunEnd, WorkerRecord, Workers};
use crate::expect::{Outcome, Verdict};
use crate::program::{AllowedWarning, MissionMeasure, MissionProgram, MissionScenarioProgram};
use crate::record::expectations::{ExpectationRecord, records_of};

/// End of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "how")]
pub enum End {
    /// The mission was done: all operations that can be served were served and all robots were home, or all tasks of
    /// the layers were done.
    Done {
        /// Time of the end, in s.
        at_s: f64,
    },
    /// The duration of the scenario was over before the mission was done.
    Unfinished,
    /// No plan was feasible any more.
    Stranded {
        /// Reason, as a sentence.
        why: String,
    },
    /// The mission had no plan at the start.
    Refused {
        /// Reason, as a sentence.
        why: String,
    },
    /// The run was interrupted.
    Interrupted,
}

impl End {
    /// The end of an execution whose time is over.
    pub(super) fn of(execution: &dyn Execution) -> End {
        match (execution.stranded(), execution.done()) {
            (Some(why), _) => End::Stranded { why },
            (None, Some(at_s)) => End::Done { at_s },
            (None, None) => End::Unfinished,
        }
    }
}

/// Event of the scenario that the mission rejected.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RejectedEvent {
    /// Time of the event, in s.
    pub at_s: f64,
    /// Description of the event.
    pub event: String,
    /// Reason of the rejection.
    pub why: String,
}

/// Entry of the log of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LogEntry {
    /// Time of the entry, in s.
    pub at_s: f64,
    /// Text of the entry.
    pub what: String,
    /// True for an event from outside, and for a change of an assignment.
    #[serde(skip)]
    pub notable: bool,
}

/// Members whose controllers broke down although no expectation measures their loss.
fn broken(mission: &MissionProgram, scenario: &MissionScenarioProgram, workers: &Workers) -> Vec<(f64, String)> {
    let (members, labels) = (mission.kind.members(), mission.kind.labels());
    let spoken = |name: &str| {
        let of = |measure: &MissionMeasure| match measure {
            MissionMeasure::Value { name: lost, member: Some(member), .. } if lost == "lost" => Some(*member),
            MissionMeasure::Faulted(member) => Some(*member),
            _ => None,
        };
        let mut of = scenario.measures.iter().filter_map(of);
        of.any(|member| members.get(member).is_some_and(|member| member.name == name))
    };
    let all = workers.records().into_iter().filter(|w| !spoken(&w.name));
    all.filter_map(|w| w.broke_down.map(|b| (b.at_s, format!("{} broke down: {}", labels.member(&w.name), b.why))))
        .collect()
}

/// Results of a scenario of a mission.
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
    /// True if all expectations hold and [`MissionSummary::trouble`] is empty.
    pub ok: bool,
    /// End of the run.
    pub end: End,
    /// Results of the kind of mission, such as makespan, paths and energy; `None` without a plan.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outcome: Option<serde_json::Value>,
    /// The same as text, with the numbers of repairs and of new plans.
    #[serde(skip)]
    pub results: Option<mission::kind::Outcome>,
    /// Events of the scenario that the mission rejected.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rejected_events: Vec<RejectedEvent>,
    /// Working robots that ran controllers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub workers: Vec<WorkerRecord>,
    /// Working robots that broke down although no expectation measures it: time in s, and description.
    #[serde(skip)]
    pub broken: Vec<(f64, String)>,
    /// Expectations, in the order written.
    pub expectations: Vec<ExpectationRecord>,
    /// Warnings of the compiler that the spec allows.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub allowed: Vec<AllowedWarning>,
    /// Everything that log, in order.
    pub log: Vec<LogEntry>,
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
            results: None,
            rejected_events: Vec::new(),
            workers: Vec::new(),
            broken: Vec::new(),
            expectations: records_of(&scenario.expectations, &outcomes, scenario.step),
            allowed: mission.allowed.clone(),
            log: Vec::new(),
        }
    }

    /// Of a world at the end of its run.
    pub(super) fn new(
        mission: &MissionProgram,
        scenario: &MissionScenarioProgram,
        world: MissionWorld,
        run: RunEnd,
    ) -> MissionSummary {
        let MissionWorld { execution, workers, rejected_events, .. } = world;
        let RunEnd { end, instants, outcomes } = run;
        let said = workers.notes.iter().map(|(at_s, what)| LogEntry { at_s: *at_s, what: what.clone(), notable: true });
        let entry = |e: mission::kind::Entry| LogEntry { at_s: e.time, what: e.text, notable: e.notable };
        let mut log: Vec<LogEntry> = said.chain(execution.log().into_iter().map(entry)).collect();
        log.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
        let expectations = records_of(&scenario.expectations, &outcomes, scenario.step);
        let good_end = match &end {
            End::Done { .. } => true,
            End::Refused { .. } | End::Interrupted => false,
            // The expectations of a scenario decide if an early end is a failure.
            End::Unfinished => !scenario.expectations.is_empty(),
            End::Stranded { .. } => {
                let measured = |name| scenario.measures.contains(&MissionMeasure::of_mission(name));
                measured("stranded") || measured("done")
            }
        };
        let held = expectations.iter().all(|e| e.verdict == Verdict::Holds);
        let broken = broken(mission, scenario, &workers);
        let results = execution.outcome();
        MissionSummary {
            mission: mission.name.clone(),
            scenario: scenario.name.clone(),
            seed: scenario.seed,
            duration_s: f64::from(instants.saturating_sub(1)) * scenario.step,
            ok: held && good_end && rejected_events.is_empty() && broken.is_empty(),
            end,
            outcome: Some(results.data.clone()),
            results: Some(results),
            rejected_events,
            workers: workers.records(),
            broken,
            expectations,
            allowed: mission.allowed.clone(),
            log,
        }
    }

    /// Failures other than those of expectations, each as a sentence, with its time if it has one.
    pub fn trouble(&self) -> Vec<(Option<f64>, String)> {
        let end = match &self.end {
            End::Done { .. } => None,
            End::Unfinished if !self.expectations.is_empty() => None,
            End::Unfinished => Some(format!("the mission was not done after {} s", self.duration_s)),
            End::Stranded { why } => Some(format!("there is no plan any more: {why}")),
            End::Refused { why } => Some(format!("there is no plan: {why}")),
            End::Interrupted => Some("it was interrupted".to_string()),
        };
        let rejected_events =
            self.rejected_events.iter().map(|u| (Some(u.at_s), format!("could not happen: {}, as {}", u.event, u.why)));
        let broken = self.broken.iter().map(|(at, text)| (Some(*at), text.clone()));
        broken.chain(rejected_events).chain(end.map(|text| (None, text))).collect()
    }
}
