//! What is known of declared parameters, and of other named values.

use std::collections::{BTreeMap, BTreeSet};

use dsl::Span;

use crate::expr::{FUNCTIONS, Meaning, Symbol, TRAJECTORIES};
use crate::forms::target;

/// True for a name that the language gives a meaning of its own.
pub fn is_word(name: &str) -> bool {
    let words = [
        "pi",
        "t",
        "time",
        "true",
        "false",
        "auto",
        "initial",
        "frame",
        "joint",
        "com",
        "and",
        "or",
        "not",
        "present",
        "uncertainty",
        "field",
    ];
    words.contains(&name) || FUNCTIONS.iter().any(|f| f.name == name) || TRAJECTORIES.iter().any(|t| t.name == name)
}

/// A human: points that are tracked.
#[derive(Clone, Debug, PartialEq)]
pub struct Human {
    /// The names of its points, each with the number that says whether it is present, and that of its uncertainty.
    pub points: Vec<(String, usize, usize)>,
    /// Segments between two points, by the points' places.
    pub links: Vec<(usize, usize)>,
    /// Whether its points are held when their readings stop.
    pub held: bool,
}

/// What is known of the declared parameters, and of other named values.
#[derive(Debug, Default)]
pub struct Params {
    /// Values by name.
    pub symbols: BTreeMap<String, Symbol>,
    /// Those whose value is wrong. They were reported, and who uses one stays silent.
    pub failed: BTreeSet<String>,
    /// Named expressions of what the robot does, until the robot is known.
    pub later: BTreeSet<String>,
    /// Those that something used.
    pub used: BTreeSet<String>,
    /// Signals with the number of the table of signals that says whether they are present.
    pub presence: BTreeMap<String, usize>,
    /// Signals that are wrenches.
    pub wrenches: BTreeSet<String>,
    /// Humans. A point stands among the symbols under a name that cannot be written.
    pub humans: BTreeMap<String, Human>,
    /// Safety fields. The value of one stands among the symbols under a name that cannot be written.
    pub fields: BTreeSet<String>,
    /// Events that the host raises, and where they were declared.
    pub events: BTreeMap<String, Span>,
}

impl Params {
    /// What a name means, where it is a parameter.
    pub fn meaning(&mut self, name: &str) -> Meaning {
        let name = target(name);
        if self.failed.contains(name) {
            return Meaning::Failed;
        }
        if self.later.contains(name) {
            return Meaning::Later;
        }
        match self.symbols.get(name) {
            Some(symbol) => {
                self.used.insert(name.to_string());
                Meaning::Value(symbol.clone())
            }
            None if self.wrenches.contains(name) => Meaning::Wrench,
            None if self.humans.contains_key(name) => {
                self.used.insert(name.to_string());
                Meaning::Human(self.humans[name].clone())
            }
            None if self.fields.contains(name) => {
                self.used.insert(name.to_string());
                Meaning::Field
            }
            None if self.events.contains_key(name) => Meaning::Event,
            None => Meaning::Unknown,
        }
    }

    /// The number that says whether a signal is present.
    pub fn presence(&mut self, name: &str) -> Option<usize> {
        let name = target(name);
        let at = self.presence.get(name).copied()?;
        self.used.insert(name.to_string());
        Some(at)
    }

    /// True for the name of a value.
    pub fn knows(&self, name: &str) -> bool {
        let name = target(name);
        self.wrenches.contains(name)
            || self.humans.contains_key(name)
            || self.fields.contains(name)
            || self.symbols.contains_key(name)
            || self.failed.contains(name)
            || self.later.contains(name)
    }

    /// All names that can be written.
    pub fn names(&self) -> Vec<String> {
        self.symbols
            .keys()
            .chain(self.humans.keys())
            .chain(&self.fields)
            .chain(&self.failed)
            .filter(|n| !n.contains('.'))
            .cloned()
            .collect()
    }
}
