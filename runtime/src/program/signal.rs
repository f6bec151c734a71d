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
    /// Of a tracked point of a person: how it moves between readings, and what becomes of it without them. Its velocity,
    /// whether it counts, its uncertainty and the rate of that follow its value in the table.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<Tracking>,
    /// What is done to a value before it stands in the table.
    #[serde(default, skip_serializing_if = "Conditioning::is_none")]
    pub conditioning: Conditioning,
    /// For a variable, which the machine sets and not the host, what it holds at the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub variable: Option<Initial>,
}

/// How a tracked point of a person moves.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tracking {
    /// Where its velocity comes from.
    pub velocity: Velocity,
    /// The largest speed that is believed, in m/s; none for any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_speed: Option<f64>,
    /// What becomes of it when its readings stop.
    pub lost: Lost,
}

/// Where the velocity of a tracked point comes from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Velocity {
    /// Differences of positions behind a first-order low-pass with this cutoff, in Hz.
    Estimated(f64),
    /// The host sends it behind the position, in m/s.
    Measured,
    /// It is taken to stand between readings.
    None,
}

/// What becomes of a tracked point when its readings stop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Lost {
    /// It is absent, which is the fault `stale` where it is needed.
    Fault,
    /// Its last position counts on, at rest, ever less certain: by so many m/s.
    Hold(f64),
}

impl SignalProgram {
    /// How many numbers it has in the table.
    pub fn width(&self) -> usize {
        1 + self.len + if self.motion.is_some() { 6 } else { 0 }
    }

    /// How many numbers the host sends.
    pub fn sent(&self) -> usize {
        self.len + if self.motion.is_some_and(|m| m.velocity == Velocity::Measured) { 3 } else { 0 }
    }

    /// The first of the three numbers of its velocity, of a tracked point.
    pub fn velocity_at(&self) -> usize {
        self.at + 1 + self.len
    }

    /// The number that says whether its value may be used, 1 or -1: whether it is present, or is held.
    pub fn known_at(&self) -> usize {
        if self.motion.is_some() { self.velocity_at() + 3 } else { self.at }
    }

    /// The number of its uncertainty in m, of a tracked point; its rate in m/s follows.
    pub fn uncertainty_at(&self) -> usize {
        self.velocity_at() + 4
    }
}

/// A person: points that are tracked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HumanProgram {
    /// The name.
    pub name: String,
    /// The signals of the points, which are called `HUMAN.POINT`.
    pub points: Vec<usize>,
    /// Segments between two points, by their places in `points`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub links: Vec<(usize, usize)>,
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
    /// People, whose points stand among the signals.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub humans: Vec<HumanProgram>,
    /// Names of events: those that the host raises, outcomes of actions, and those that the machine raises itself.
    pub events: Vec<String>,
}

impl Interface {
    /// How many numbers the table of signals has.
    pub fn width(&self) -> usize {
        self.signals.last().map_or(0, |s| s.at + s.width())
    }

    /// Declares a number that only the controller sets, absent at the start, and returns its index in `signals`; `kind` is
    /// its type in the words of the language.
    pub fn tell(&mut self, name: String, kind: &str) -> usize {
        let at = self.width();
        self.signals.push(SignalProgram {
            name,
            kind: kind.to_string(),
            at,
            len: 1,
            optional: true,
            timeout: None,
            motion: None,
            conditioning: Conditioning::default(),
            variable: Some(Initial { value: None }),
        });
        self.signals.len() - 1
    }

    /// The signal that a number of the table belongs to.
    pub fn signal_of(&self, number: usize) -> Option<usize> {
        self.signals.partition_point(|s| s.at <= number).checked_sub(1)
    }

    /// A table in which every signal is absent.
    pub fn absent(&self) -> Vec<f64> {
        let mut table = vec![f64::NAN; self.width()];
        for s in &self.signals {
            table[s.at] = -1.0;
            table[s.known_at()] = -1.0;
            if let Some(value) = s.variable.as_ref().and_then(|v| v.value.as_ref()) {
                table[s.at] = 1.0;
                table[s.at + 1..=s.at + s.len].copy_from_slice(value);
            }
        }
        table
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
