//! What became of expectations, in the words and units of a summary.

use serde::Serialize;

use crate::expect::{Outcome, Verdict};
use crate::program::Unit;
use crate::program::{ExpectationProgram, Measure, ScenarioProgram};

/// What became of an expectation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ExpectationRecord {
    /// What the spec calls it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// As it is written.
    pub text: String,
    /// Whether it held.
    pub verdict: Verdict,
    /// By how much at least it held, or at least failed: then it is zero or less. None where truth values alone have a
    /// say, where quantities of several units were compared, and where nothing was decided.
    pub margin: Option<f64>,
    /// The SI unit of the margin.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// When it came nearest to failing, or failed by most, in s.
    pub worst_s: Option<f64>,
    /// When it was certain that it held or failed, in s.
    pub decided_s: Option<f64>,
    /// When something that it speaks of first had no value, and was false, in s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub undefined_s: Option<f64>,
}

impl ExpectationRecord {
    /// Its label, or its text.
    pub fn title(&self) -> &str {
        self.label.as_deref().unwrap_or(&self.text)
    }
}

/// The records of a scenario. `outcomes` are those of [`crate::Judge::finish`].
pub fn records(scenario: &ScenarioProgram, outcomes: &[Outcome], period: f64) -> Vec<ExpectationRecord> {
    records_of(&scenario.expectations, outcomes, period)
}

/// The records of expectations, each with what became of it; `period` is the time from a tick to the next, in s.
pub fn records_of(expectations: &[ExpectationProgram], outcomes: &[Outcome], period: f64) -> Vec<ExpectationRecord> {
    let at = |tick: Option<u32>| tick.map(|t| f64::from(t) * period);
    let one = |(e, o): (&ExpectationProgram, &Outcome)| ExpectationRecord {
        label: e.label.clone(),
        text: e.text.clone(),
        verdict: o.verdict,
        margin: o.margin(),
        unit: match o.unit {
            Unit::Quantity(d) if o.margin().is_some() => Some(d.to_string()),
            _ => None,
        },
        worst_s: at(o.worst),
        decided_s: at(o.decided),
        undefined_s: at(o.undefined),
    };
    expectations.iter().zip(outcomes).map(one).collect()
}

/// Whether a run of the scenario went as expected: every expectation held, and every fault was answered. Where the
/// expectations themselves speak of faults, they alone decide on those; where there are none, no margin may have been
/// passed either.
pub fn is_good(scenario: &ScenarioProgram, records: &[ExpectationRecord], summary: &super::summary::Summary) -> bool {
    if scenario.expectations.is_empty() {
        return summary.ok;
    }
    let of_faults = scenario.measures.iter().any(|m| matches!(m, Measure::Fault(_)));
    records.iter().all(|r| r.verdict == Verdict::Holds) && (of_faults || !summary.halted)
}
