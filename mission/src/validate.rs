//! Constraints that a plan breaks, as the validators of all kinds report them.
//!
//! A validator is independent of the planners of its kind; the validators share their tolerance and the form of their
//! answer.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Tolerance of a time (s), and its increase per second; a kind that checks a speed or a cost uses it for these too.
pub const TOLERANCE: f64 = 1e-6;
const ROUNDING: f64 = 1e-12;

/// Returns the tolerance of this time (s).
pub(crate) fn tolerance(time: f64) -> f64 {
    TOLERANCE + ROUNDING * time.abs()
}

/// A constraint of a kind whose plans consist of pieces of work `T`.
pub trait Constraint<T> {
    /// Returns the constraint as a sentence.
    fn text(&self) -> &'static str;

    /// Returns the words for a piece of work.
    fn work(work: &T) -> String;
}

/// A constraint `R` that a plan breaks, of pieces of work `T`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Violation<R, T> {
    /// The broken constraint.
    pub rule: R,
    /// The piece of work; `None` if the plan as a whole is wrong.
    pub at: Option<T>,
    /// The other piece of work, for a rule about two.
    pub other: Option<T>,
    /// Size of the violation in the unit of the rule: seconds, metres per second for a speed, the difference for a cost;
    /// 0 if it has no size.
    pub by: f64,
}

impl<R, T> Violation<R, T> {
    /// A violation by one piece of work, or by the plan as a whole.
    pub(crate) fn of(rule: R, at: Option<T>, by: f64) -> Violation<R, T> {
        Violation { rule, at, other: None, by }
    }
}

impl<R: Constraint<T>, T> fmt::Display for Violation<R, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "not so: {}", self.rule.text())?;
        if let Some(at) = &self.at {
            write!(f, "; {}", R::work(at))?;
        }
        if let Some(other) = &self.other {
            write!(f, " and {}", R::work(other))?;
        }
        if self.by != 0.0 { write!(f, ", by {}", self.by) } else { Ok(()) }
    }
}
