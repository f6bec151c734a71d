//! Results of expectations, in the words and units of a summary.

use serde::Serialize;

use crate::expect::{Outcome, Verdict};
use crate::program::Unit;
use crate::program::{ExpectationProgram, Measure, ScenarioProgram};

/// Result of an expectation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ExpectationRecord {
    /// Its label in the spec.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// Its text in the spec.
    pub text: String,
    /// Verdict on it.
    pub verdict: Verdict,
    /// Proven margin: at least this if it held, at most this (zero or less) if it failed. `None` if only truth values
    /// determine it, if quantities of several units were compared, or if nothing was decided.
    pub margin: Option<f64>,
    /// The SI unit of the margin.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Time at which it came nearest to failing, or failed by most, in s.
    pub worst_s: Option<f64>,
    /// Time at which the verdict became certain, in s.
    pub decided_s: Option<f64>,
    /// Time at which one of its numbers first had no value, and counted as false, in s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub undefined_s: Option<f64>,
    /// True if it holds only because its condition was never true.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub untested: bool,
}

impl ExpectationRecord {
    /// Its label, or its text.
    pub fn title(&self) -> &str {
        self.label.as_deref().unwrap_or(&self.text)
    }
}

/// Records of a scenario. `outcomes` are those of [`crate::ExpectationMonitors::finish`].
pub fn records(scenario: &ScenarioProgram, outcomes: &[Outcome], period: f64) -> Vec<ExpectationRecord> {
    records_of(&scenario.expectations, outcomes, period)
}

/// Records of expectations, each with its outcome; `period` is the time from a tick to the next, in s.
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
        untested: o.untested,
    };
    expectations.iter().zip(outcomes).map(one).collect()
}

/// Returns true if a run of the scenario went as expected: every expectation held, and every fault was answered. If
/// the expectations themselves refer to faults, they alone decide about those. If there are no expectations, no margin
/// may have been violated either. A run that diverged never went as expected.
pub fn is_good(scenario: &ScenarioProgram, records: &[ExpectationRecord], summary: &super::summary::Summary) -> bool {
    if scenario.expectations.is_empty() || summary.diverged.is_some() {
        return summary.ok;
    }
    let of_faults = scenario.measures.iter().any(|m| matches!(m, Measure::Fault(_)));
    records.iter().all(|r| r.verdict == Verdict::Holds) && (of_faults || summary.faults.iter().all(|f| f.answered))
}
