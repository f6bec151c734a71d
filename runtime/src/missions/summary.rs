//! What a scenario of a mission came to.

use mission::execution::{Execution, Happening, Outcome as Numbers};
use serde::Serialize;

use super::words::of_happening;
use crate::expect::{Outcome, Verdict};
use crate::program::{MissionMeasure, MissionProgram, MissionScenarioProgram, OfMission};
use crate::record::expectations::{ExpectationRecord, records_of};

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "how")]
pub enum End {
    /// Everything was served that could be, and every robot was back.
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
        H::Told { .. } | H::BrokenOff { .. } | H::Reallocated { .. } | H::Refused { .. } | H::Stranded { .. } | H::Done
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
    /// What could not happen when it should.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub untaken: Vec<Untaken>,
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
            untaken: Vec::new(),
            expectations: records_of(&scenario.expectations, &outcomes, scenario.step),
            happened: Vec::new(),
        }
    }

    /// Of an execution that was judged at so many instants.
    pub(super) fn new(
        mission: &MissionProgram,
        scenario: &MissionScenarioProgram,
        (execution, end, instants): (&Execution, End, u32),
        untaken: Vec<Untaken>,
        outcomes: Vec<Outcome>,
    ) -> MissionSummary {
        let expectations = records_of(&scenario.expectations, &outcomes, scenario.step);
        let of_end = |of| scenario.measures.contains(&MissionMeasure::Mission(of));
        let good_end = match &end {
            End::Done { .. } => true,
            End::Refused { .. } | End::Interrupted => false,
            // Who expects something speaks of the end where it matters.
            End::Unfinished => !scenario.expectations.is_empty(),
            End::Stranded { .. } => of_end(OfMission::Stranded) || of_end(OfMission::Done),
        };
        let held = expectations.iter().all(|e| e.verdict == Verdict::Holds);
        let happened = execution.records().iter().map(|r| Happened {
            at_s: r.time,
            what: of_happening(&r.what, execution.problem()),
            notable: is_notable(&r.what),
        });
        MissionSummary {
            mission: mission.name.clone(),
            scenario: scenario.name.clone(),
            seed: scenario.seed,
            duration_s: f64::from(instants.saturating_sub(1)) * scenario.step,
            ok: held && good_end && untaken.is_empty(),
            end,
            outcome: Some(execution.statistics()),
            untaken,
            expectations,
            happened: happened.collect(),
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
        untaken.chain(end.map(|text| (None, text))).collect()
    }
}
