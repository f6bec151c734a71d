//! Signals: typed values that the host sends to the controller, and events.

use serde::{Deserialize, Serialize};

/// A value that comes from outside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SignalProgram {
    /// Its name.
    pub name: String,
    /// What it is, in the words of the language: `point`, `length`, `wrench`.
    pub kind: String,
    /// Its first number in the table of signals: whether it is present, 1 or -1. Its value follows.
    pub at: usize,
    /// How many numbers its value has.
    pub len: usize,
    /// May be absent.
    pub optional: bool,
    /// How long a value counts after it was received, in s; none for ever.
    pub timeout: Option<f64>,
}

/// The most numbers that the value of a signal has.
pub const MAX_SIGNAL: usize = 7;

/// What comes from outside.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Interface {
    /// Values, in the order declared.
    pub signals: Vec<SignalProgram>,
    /// Names of events: those that the host raises, outcomes of actions, and those that the machine raises itself.
    pub events: Vec<String>,
}

impl Interface {
    /// How many numbers the table of signals has.
    pub fn width(&self) -> usize {
        self.signals.last().map_or(0, |s| s.at + 1 + s.len)
    }

    /// The signal that a number of the table belongs to.
    pub fn signal_of(&self, number: usize) -> Option<usize> {
        self.signals.partition_point(|s| s.at <= number).checked_sub(1)
    }

    /// The index of a signal.
    pub fn signal(&self, name: &str) -> Option<usize> {
        self.signals.iter().position(|s| s.name == name)
    }

    /// The index of an event.
    pub fn event(&self, name: &str) -> Option<usize> {
        self.events.iter().position(|e| e == name)
    }
}
