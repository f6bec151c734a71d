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
    /// What is done to a value before it stands in the table.
    #[serde(default, skip_serializing_if = "Conditioning::is_none")]
    pub conditioning: Conditioning,
    /// For a variable, which the machine sets and not the host, what it holds at the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub variable: Option<Initial>,
}

/// What a variable holds at the start: its numbers, or nothing for one that is absent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Initial {
    /// The numbers.
    pub value: Option<Vec<f64>>,
}

/// What is done to the value of a signal at a tick, in this order: the bias is taken away, then the wrench is turned into
/// the axes of the world, then it is filtered.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Conditioning {
    /// The link in whose axes the host gives a wrench; none for those of the world.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<robot::LinkId>,
    /// What a sensor shows that nothing touches: force in N, then moment in Nm, in the axes of `frame`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bias: Option<[f64; 6]>,
    /// Cutoff frequency of a filter of first order, in Hz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low_pass: Option<f64>,
}

impl Conditioning {
    /// True where a value is taken as it comes.
    pub fn is_none(&self) -> bool {
        *self == Conditioning::default()
    }
}

impl SignalProgram {
    /// True for a variable of the machine.
    pub fn is_variable(&self) -> bool {
        self.variable.is_some()
    }
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
