//! Result of an expectation at the end of a run.

use serde::{Deserialize, Serialize};

use super::value::Interval;
use crate::program::Unit;

/// Verdict on an expectation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It holds, whatever would have come after the end.
    Holds,
    /// It fails, whatever would have come after the end.
    Fails,
    /// The run ended before it was decided.
    Undecided,
}

impl Verdict {
    /// Verdict that follows from an interval.
    pub fn of(value: Interval) -> Verdict {
        match (value.lower.is_true(), value.upper.is_true()) {
            (true, _) => Verdict::Holds,
            (_, false) => Verdict::Fails,
            _ => Verdict::Undecided,
        }
    }
}

/// The result of an expectation. Ticks count from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Verdict on it.
    pub verdict: Verdict,
    /// Smallest robustness that is possible with any ticks after the end.
    pub lower: f64,
    /// Largest robustness that is possible; equal to `lower` unless the end cut off a window.
    pub upper: f64,
    /// Unit of the robustness, in SI units.
    pub unit: Unit,
    /// Tick that determines the robustness: the worst instant of an expectation that held or failed.
    pub worst: Option<u32>,
    /// Tick at which the verdict became certain: for an expectation that failed, its first violation.
    pub decided: Option<u32>,
    /// First tick at which a signal was NaN, and therefore false.
    pub undefined: Option<u32>,
    /// True if it holds only because its condition was never true: `always (a implies b)` without a tick at which `a`
    /// held.
    pub untested: bool,
}

impl Outcome {
    /// Combines the values of the formula at the first tick, in numbers and in truth values alone.
    ///
    /// `antecedent` is the value of [`crate::program::Formula::antecedent`], if there is one.
    pub(super) fn new(
        number: Interval,
        truth: Interval,
        unit: Unit,
        undefined: Option<u32>,
        antecedent: Option<Interval>,
    ) -> Outcome {
        let verdict = Verdict::of(number);
        let (worst, decided) = match verdict {
            Verdict::Holds => (Some(number.lower.tick()), Some(truth.lower.tick())),
            Verdict::Fails => (Some(number.upper.tick()), Some(truth.upper.tick())),
            Verdict::Undecided => (None, None),
        };
        let (lower, upper) = (number.lower.robustness(), number.upper.robustness());
        let untested = verdict == Verdict::Holds && antecedent.is_some_and(|a| !a.lower.is_true());
        Outcome { verdict, lower, upper, unit, worst, decided, undefined, untested }
    }

    /// Margin, as far as it is proven: at least this if the expectation holds, at most this (zero or less) if it fails.
    /// `None` if it is undecided, if no number determines it, or if quantities of several dimensions were compared.
    pub fn margin(&self) -> Option<f64> {
        let margin = match self.verdict {
            Verdict::Holds => self.lower,
            Verdict::Fails => self.upper,
            Verdict::Undecided => return None,
        };
        (margin.is_finite() && matches!(self.unit, Unit::Quantity(_))).then_some(margin)
    }
}

/// Both evaluations of a formula: the same algebra over different numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sense {
    /// Signals as they are: yields the robustness and its instant.
    Number,
    /// Signals as plus and minus infinity. Since the earlier of equal values is the stronger, the instant is the one at
    /// which the truth value became certain.
    Truth,
}
