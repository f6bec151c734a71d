//! What the host tells the controller between ticks: values of signals, each with the time at which it was received, and
//! events.

use crate::program::Interface;

/// A quaternion whose length differs from 1 by more is no orientation.
pub const NOT_UNIT: f64 = 1e-3;

/// Brings a quaternion to length 1; false where it is none.
fn normalised(q: &mut [f64]) -> bool {
    let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    let good = (length - 1.0).abs() <= NOT_UNIT;
    if good {
        q.iter_mut().for_each(|x| *x /= length);
    }
    good
}

/// The signals of a controller.
///
/// A value counts until its signal's timeout has passed; then it is absent, as it is before the first one was received. A
/// value that is not finite makes its signal absent at once, and so does an orientation whose quaternion is further than
/// [`NOT_UNIT`] from length 1; closer ones are normalised.
pub struct Signals {
    interface: Interface,
    /// For each signal when its value was received, in s; never is minus infinity.
    received: Vec<f64>,
    /// The table: for each signal whether it is present, 1 or -1, and its value, NaN where absent.
    table: Vec<f64>,
    /// The last value of each, in the places of the table.
    last: Vec<f64>,
    /// Events since the last tick.
    raised: Vec<bool>,
}

impl Signals {
    pub(crate) fn new(interface: &Interface) -> Self {
        let mut signals = Signals {
            received: vec![f64::NEG_INFINITY; interface.signals.len()],
            table: vec![f64::NAN; interface.width()],
            last: vec![f64::NAN; interface.width()],
            raised: vec![false; interface.events.len()],
            interface: interface.clone(),
        };
        signals.at(0.0);
        signals
    }

    /// What signals and events there are.
    pub fn interface(&self) -> &Interface {
        &self.interface
    }

    /// Gives a signal a value that was received at a time, in s. Never allocates.
    ///
    /// False where there is no such signal, or it has another number of numbers.
    pub fn set(&mut self, signal: usize, value: &[f64], time: f64) -> bool {
        let Some(s) = self.interface.signals.get(signal).filter(|s| s.len == value.len()) else { return false };
        let last = &mut self.last[s.at + 1..s.at + 1 + s.len];
        last.copy_from_slice(value);
        let turned = match s.kind.as_str() {
            "orientation" => normalised(last),
            "pose" => last.get_mut(3..).is_some_and(normalised),
            _ => true,
        };
        let good = turned && value.iter().all(|x| x.is_finite());
        self.received[signal] = if good { time } else { f64::NEG_INFINITY };
        true
    }

    /// Makes a signal absent.
    pub fn clear(&mut self, signal: usize) {
        if let Some(received) = self.received.get_mut(signal) {
            *received = f64::NEG_INFINITY;
        }
    }

    /// Raises an event; false where there is none. It is seen at the next tick, and gone after it.
    pub fn raise(&mut self, event: usize) -> bool {
        self.raised.get_mut(event).map(|r| *r = true).is_some()
    }

    /// Whether a signal is present at the last tick.
    pub fn is_present(&self, signal: usize) -> bool {
        self.interface.signals.get(signal).is_some_and(|s| self.table[s.at] > 0.0)
    }

    /// The value of a signal at the last tick; NaN where absent.
    pub fn value(&self, signal: usize) -> &[f64] {
        self.interface.signals.get(signal).map_or(&[], |s| &self.table[s.at + 1..s.at + 1 + s.len])
    }

    /// The table of signals at the last tick.
    pub fn table(&self) -> &[f64] {
        &self.table
    }

    pub(crate) fn events(&self) -> &[bool] {
        &self.raised
    }

    pub(crate) fn forget_events(&mut self) {
        self.raised.fill(false);
    }

    /// Works out the table for a tick.
    pub(crate) fn at(&mut self, time: f64) {
        for (s, &received) in self.interface.signals.iter().zip(&self.received) {
            let known = received > f64::NEG_INFINITY;
            let present = known && s.timeout.is_none_or(|t| time - received <= t);
            self.table[s.at] = if present { 1.0 } else { -1.0 };
            for i in s.at + 1..s.at + 1 + s.len {
                self.table[i] = if present { self.last[i] } else { f64::NAN };
            }
        }
    }
}
