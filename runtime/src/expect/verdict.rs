//! What is said of an expectation at the end of a run.

use serde::{Deserialize, Serialize};

use super::value::Interval;
use crate::program::Unit;

/// Whether it held.
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
    /// The verdict that an interval allows.
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
    /// Whether it held.
    pub verdict: Verdict,
    /// The smallest robustness that the ticks after the end could have made of it.
    pub lower: f64,
    /// The largest; equal to `lower` unless the end cut off a window.
    pub upper: f64,
    /// What the robustness is, in SI units.
    pub unit: Unit,
    /// The tick that decides the robustness: of something that held or failed, its worst instant.
    pub worst: Option<u32>,
    /// The tick at which the verdict became certain: of something that failed, where it was first violated.
    pub decided: Option<u32>,
    /// The first tick at which a signal was no number, and therefore false.
    pub undefined: Option<u32>,
}

impl Outcome {
    /// From what the formula is worth at the first tick, in numbers and in truth values alone.
    pub(super) fn new(number: Interval, truth: Interval, unit: Unit, undefined: Option<u32>) -> Outcome {
        let verdict = Verdict::of(number);
        let (worst, decided) = match verdict {
            Verdict::Holds => (Some(number.lower.tick()), Some(truth.lower.tick())),
            Verdict::Fails => (Some(number.upper.tick()), Some(truth.upper.tick())),
            Verdict::Undecided => (None, None),
        };
        let (lower, upper) = (number.lower.robustness(), number.upper.robustness());
        Outcome { verdict, lower, upper, unit, worst, decided, undefined }
    }

    /// The margin, as far as it is proven: at least this where it holds, at most this (zero or less) where it fails. None
    /// where it is undecided, where no number had a say, and where quantities of several dimensions were compared.
    pub fn margin(&self) -> Option<f64> {
        let margin = match self.verdict {
            Verdict::Holds => self.lower,
            Verdict::Fails => self.upper,
            Verdict::Undecided => return None,
        };
        (margin.is_finite() && matches!(self.unit, Unit::Quantity(_))).then_some(margin)
    }
}

/// Both ways in which a formula is evaluated: the same algebra over other numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sense {
    /// Signals as they are: the robustness and its instant.
    Number,
    /// Signals as plus and minus infinity. As the earlier of equals is the stronger, the instant is the one at which the
    /// truth became certain.
    Truth,
}
