//! The table of values at a tick: the moving ones, from the tape, for those who read them.

use std::collections::BTreeSet;

use crate::fault::Fault;
use crate::program::{Interface, Lost, SignalProgram, Tape, Times, ValueRange, Values};

/// The part of the table of values that some tasks or conditions read.
pub(crate) struct ValueTable {
    tape: Tape,
    ranges: Vec<ValueRange>,
    /// Captured numbers.
    pub inputs: Vec<f64>,
    /// For each captured number, the first place that follows from it.
    reads: Vec<Option<usize>>,
    /// Signals that must be present: those that are read, but for those whose presence is asked for.
    needs: Vec<usize>,
    /// The number that says whether each of them may be used.
    presence: Vec<usize>,
    registers: Vec<f64>,
    /// Values, in the places of [`Values::initial`].
    pub current: Vec<f64>,
    /// Their time derivatives.
    pub rates: Vec<f64>,
}

impl ValueTable {
    /// The part of a program's values that stands in the wanted places.
    pub fn new(values: &Values, wanted: &BTreeSet<usize>, interface: &Interface) -> Self {
        let tape = values.tape.only(wanted);
        let read = tape.signals();
        // One that is held is needed all the same: asking whether it is seen says nothing of who never was.
        let held = |s: &SignalProgram| s.motion.is_some_and(|m| matches!(m.lost, Lost::Hold(_)));
        let asked = |at: &usize| {
            let signal = interface.signal_of(*at).map(|s| &interface.signals[s]);
            signal.is_none_or(|s| {
                read.contains(&s.at) && (!held(s) || read.range(s.at + 1..s.at + s.width()).next().is_none())
            })
        };
        let needs: BTreeSet<usize> =
            read.iter().filter(|at| !asked(at)).filter_map(|at| interface.signal_of(*at)).collect();
        ValueTable {
            ranges: values.ranges.iter().filter(|r| wanted.contains(&r.at)).copied().collect(),
            inputs: vec![0.0; tape.inputs],
            reads: tape.readers(),
            presence: needs.iter().map(|&s| interface.signals[s].known_at()).collect(),
            needs: needs.into_iter().collect(),
            registers: vec![0.0; tape.ops.len()],
            current: values.initial.clone(),
            rates: vec![0.0; values.initial.len()],
            tape,
        }
    }

    /// Whether something follows from a captured number.
    pub fn is_read(&self, input: usize) -> bool {
        self.reads.get(input).is_some_and(Option::is_some)
    }

    /// Signals that must be present.
    pub fn needs(&self) -> &[usize] {
        &self.needs
    }

    /// Works out the moving values. Never allocates.
    pub fn evaluate(&mut self, times: Times, signals: &[f64]) {
        let ValueTable { tape, inputs, registers, current, rates, .. } = self;
        tape.evaluate(times, inputs, signals, registers, current, rates);
    }

    /// Whether the values may be used.
    ///
    /// # Errors
    /// A signal is absent, or a value is not finite or out of its range.
    pub fn check(&mut self, signals: &[f64]) -> Result<(), Fault> {
        // Told of before a `min` or an `if` can hide it.
        let absent = self.presence.iter().zip(&self.needs).find(|(at, _)| signals[**at] < 0.0);
        if let Some((_, &signal)) = absent {
            return Err(Fault::Stale { signal });
        }
        let mut lost = self.inputs.iter().zip(&self.reads).filter(|(x, _)| !x.is_finite());
        if let Some(at) = lost.find_map(|(_, at)| *at) {
            self.current[at] = f64::NAN;
            return Err(Fault::Value { at });
        }
        let bad = self.ranges.iter().find(|r| !r.contains(self.current[r.at]) || !self.rates[r.at].is_finite());
        bad.map_or(Ok(()), |r| Err(Fault::Value { at: r.at }))
    }
}
