//! Signals: typed values that the host sends to the controller, and events.

use serde::{Deserialize, Serialize};

/// Value that comes from outside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SignalProgram {
    /// Its name.
    pub name: String,
    /// Its type, in the words of the language: `point`, `length`, `wrench`.
    pub kind: String,
    /// Index of its first number in the table of signals, which is 1 if the signal is present and -1 otherwise. Its
    /// value follows.
    pub at: usize,
    /// Number of numbers in its value.
    pub len: usize,
    /// True if it may be absent.
    pub optional: bool,
    /// Time for which a value is valid after it was received, in s; `None` for ever.
    pub timeout: Option<f64>,
    /// Motion of a tracked point or pose between readings and without them; `None` for other signals. In the table,
    /// the value is followed by its rates, one for each number, by a number that is 1 while the value counts, and by
    /// the uncertainty and its rate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<Tracking>,
    /// Processing of a value before it is stored in the table.
    #[serde(default, skip_serializing_if = "Conditioning::is_none")]
    pub conditioning: Conditioning,
    /// Initial value of a variable, which the machine sets instead of the host.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub variable: Option<Initial>,
    /// Signal whose age it is: the time in s since the last valid reading of it, infinite before the first. The controller
    /// sets it; the number before it, which is 1, is also its rate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub age_of: Option<usize>,
}

/// Motion of a tracked point or pose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tracking {
    /// True for a point of a person, false for a signal of its own.
    pub person: bool,
    /// Source of its velocity.
    pub velocity: Velocity,
    /// Its place between two readings.
    #[serde(default, skip_serializing_if = "Between::is_hold")]
    pub between: Between,
    /// Largest speed that is plausible, in m/s; `None` for any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_speed: Option<f64>,
    /// Largest angular speed of a pose that is plausible, in rad/s; `None` for any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_angular_speed: Option<f64>,
    /// Treatment of the point after its readings stop.
    pub lost: Lost,
}

/// Source of the velocity of a tracked point or pose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Velocity {
    /// Differences of readings, filtered by a first-order low-pass with this cutoff, in Hz.
    Estimated(f64),
    /// The host sends it after the value: in m/s, and then of a pose the angular velocity in rad/s, along the axes of the
    /// world.
    Measured,
    /// The point is assumed to be at rest between readings.
    None,
}

/// Place of a tracked point or pose between two readings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Between {
    /// That of the last reading.
    #[default]
    Hold,
    /// It goes on from the last reading with its velocity.
    Extrapolate,
}

impl Between {
    fn is_hold(&self) -> bool {
        *self == Between::Hold
    }
}

/// Treatment of a tracked point after its readings stop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Lost {
    /// It is absent, which is the fault `stale` if it is needed.
    Fault,
    /// Its last position remains valid, at rest, with an uncertainty that grows at this rate, in m/s.
    Hold(f64),
}

impl SignalProgram {
    /// Number of its numbers in the table.
    pub fn width(&self) -> usize {
        1 + self.len + if self.motion.is_some() { self.len + 3 } else { 0 }
    }

    /// Number of numbers that the host sends.
    pub fn sent(&self) -> usize {
        match self.motion {
            Some(Tracking { velocity: Velocity::Measured, .. }) => self.len + if self.is_pose() { 6 } else { 3 },
            _ => self.len,
        }
    }

    /// Returns true for a position with an orientation.
    pub fn is_pose(&self) -> bool {
        self.len == 7
    }

    /// Returns true for a tracked point of a person.
    pub fn is_of_person(&self) -> bool {
        self.motion.is_some_and(|m| m.person)
    }

    /// Index of the first rate of a tracked value, of as many as it has numbers.
    pub fn velocity_at(&self) -> usize {
        self.at + 1 + self.len
    }

    /// Index of the number that is 1 if its value may be used, because it is present or held, and -1 otherwise.
    pub fn known_at(&self) -> usize {
        if self.motion.is_some() { self.velocity_at() + self.len } else { self.at }
    }

    /// Index of the uncertainty of a tracked point in m; its rate in m/s follows.
    pub fn uncertainty_at(&self) -> usize {
        self.velocity_at() + self.len + 1
    }
}

/// A person, as a set of tracked points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HumanProgram {
    /// Name of the person.
    pub name: String,
    /// Signals of the points, which are named `HUMAN.POINT`.
    pub points: Vec<usize>,
    /// Segments between two points, by their indices in `points`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub links: Vec<(usize, usize)>,
}

/// Initial value of a variable.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Initial {
    /// The numbers; `None` for a variable that is absent.
    pub value: Option<Vec<f64>>,
}

/// Processing of the value of a signal at a tick, in this order: the bias is subtracted, the wrench is rotated into the
/// axes of the world, and the result is filtered.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Conditioning {
    /// Link in whose axes the host sends a wrench; `None` for the axes of the world.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<robot::LinkId>,
    /// Reading of the sensor without contact: force in N, then moment in Nm, in the axes of `frame`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bias: Option<[f64; 6]>,
    /// Cutoff frequency of a first-order low-pass filter, in Hz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low_pass: Option<f64>,
}

impl Conditioning {
    /// Returns true if a value is used as it is received.
    pub fn is_none(&self) -> bool {
        *self == Conditioning::default()
    }
}

impl SignalProgram {
    /// Returns true for a variable of the machine.
    pub fn is_variable(&self) -> bool {
        self.variable.is_some()
    }
}

/// Largest number of numbers in the value of a signal.
pub const MAX_SIGNAL: usize = 7;

/// Signals, people and events of a program.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Interface {
    /// Signals, in the order declared.
    pub signals: Vec<SignalProgram>,
    /// People, whose points are among the signals.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub humans: Vec<HumanProgram>,
    /// Names of events: those that the host raises, outcomes of actions, and those that the machine raises itself.
    pub events: Vec<String>,
}

impl Interface {
    /// Length of the table of signals.
    pub fn width(&self) -> usize {
        self.signals.last().map_or(0, |s| s.at + s.width())
    }

    /// Declares a number that only the controller sets and that is absent at the start. Returns its index in `signals`.
    /// `kind` is its type in the words of the language.
    pub fn declare_output(&mut self, name: String, kind: &str) -> usize {
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
            age_of: None,
        });
        self.signals.len() - 1
    }

    /// Declares the age of a signal. Returns its index in `signals`.
    pub fn declare_age(&mut self, of: usize) -> usize {
        let name = self.signals.get(of).map_or("", |s| s.name.as_str());
        let age = self.declare_output(format!("age({name})"), "duration");
        self.signals[age].age_of = Some(of);
        age
    }

    /// Signal that a number of the table belongs to.
    pub fn signal_of(&self, number: usize) -> Option<usize> {
        self.signals.partition_point(|s| s.at <= number).checked_sub(1)
    }

    /// Table in which every signal is absent, except variables with an initial value.
    pub fn absent(&self) -> Vec<f64> {
        let mut table = vec![f64::NAN; self.width()];
        for s in &self.signals {
            table[s.at] = -1.0;
            table[s.known_at()] = -1.0;
            if let Some(value) = s.variable.as_ref().and_then(|v| v.value.as_ref()) {
                table[s.at] = 1.0;
                table[s.at + 1..=s.at + s.len].copy_from_slice(value);
            }
            if s.age_of.is_some() {
                (table[s.at], table[s.at + 1]) = (1.0, f64::INFINITY);
            }
        }
        table
    }

    /// Index of a signal, by its name.
    pub fn signal(&self, name: &str) -> Option<usize> {
        self.signals.iter().position(|s| s.name == name)
    }

    /// Index of an event, by its name.
    pub fn event(&self, name: &str) -> Option<usize> {
        self.events.iter().position(|e| e == name)
    }
}
