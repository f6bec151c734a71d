//! Monitor: evaluates a formula one tick at a time, in storage that is allocated before the first tick.
//!
//! The formula is evaluated twice, by one network of operations over the signals themselves, and by one over their
//! truth values. The first yields the robustness and its instant, the second the tick at which the verdict became
//! certain.

use super::network::{Network, Step};
use super::verdict::{Outcome, Sense, Verdict};
use crate::program::ProgramError;
use crate::program::{Formula, Unit};

/// Reason why a tick was rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PushError {
    /// The run has more ticks than the monitor was made for.
    #[error("the run has more ticks than the monitor was made for")]
    TooLong,
    /// A tick has another number of signals than the monitor was made for.
    #[error("a tick has another number of signals than the monitor was made for")]
    Signals,
}

/// Evaluates a formula during a run.
#[derive(Clone, Debug)]
pub struct Monitor {
    number: Network,
    truth: Network,
    /// Evaluates whether the condition of an implication ever held.
    antecedent: Option<Network>,
    signals: Vec<usize>,
    /// Number of numbers in a tick.
    width: usize,
    unit: Unit,
    undefined: Option<u32>,
    ticks: u32,
    most: u32,
}

impl Monitor {
    /// Creates a monitor for a run of at most `ticks`, whose ticks have one number for each of `units`.
    ///
    /// # Errors
    /// The formula does not pass [`Formula::check`], or would need too much memory.
    pub fn new(formula: &Formula, units: &[Unit], ticks: u32) -> Result<Monitor, ProgramError> {
        formula.check(units.len())?;
        let antecedent = formula.antecedent();
        let antecedent = antecedent.map(|f| Network::new(&f, Sense::Truth, ticks)).transpose()?;
        Ok(Monitor {
            number: Network::new(formula, Sense::Number, ticks)?,
            truth: Network::new(formula, Sense::Truth, ticks)?,
            antecedent,
            signals: formula.signals(),
            width: units.len(),
            unit: formula.unit(units),
            undefined: None,
            ticks: 0,
            most: ticks,
        })
    }

    /// Number of values that it keeps from tick to tick; a scenario may keep [`super::MAX_KEPT`] of them.
    pub fn kept(&self) -> usize {
        let antecedent = self.antecedent.as_ref().map_or(0, |a| a.kept);
        self.number.kept.max(self.truth.kept) + antecedent
    }

    /// Takes the next tick. Allocates nothing, and takes constant time on average.
    ///
    /// # Errors
    /// The tick does not belong to the run that the monitor was made for; it is ignored.
    pub fn push(&mut self, values: &[f64]) -> Result<(), PushError> {
        if values.len() != self.width {
            return Err(PushError::Signals);
        }
        if self.ticks == self.most {
            return Err(PushError::TooLong);
        }
        if self.undefined.is_none() && self.signals.iter().any(|&k| values[k].is_nan()) {
            self.undefined = Some(self.ticks);
        }
        let step = Step { values: Some(values), ticks: self.ticks + 1 };
        self.number.advance(&step);
        self.truth.advance(&step);
        if let Some(antecedent) = &mut self.antecedent {
            antecedent.advance(&step);
        }
        self.ticks += 1;
        Ok(())
    }

    /// Verdict as far as the ticks until now decide it. It never changes once it is decided.
    pub fn verdict(&mut self) -> Verdict {
        Verdict::of(self.number.value(false))
    }

    /// Outcome at the end of the run. Allocates nothing. Takes linear time in the number of ticks if an unbounded
    /// operator is nested in another temporal one.
    pub fn finish(mut self) -> Outcome {
        let step = Step { values: None, ticks: self.ticks };
        self.number.advance(&step);
        self.truth.advance(&step);
        let antecedent = self.antecedent.as_mut().map(|a| {
            a.advance(&step);
            a.value(true)
        });
        Outcome::new(self.number.value(true), self.truth.value(true), self.unit, self.undefined, antecedent)
    }
}
