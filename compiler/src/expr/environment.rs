//! Declared parameters and other named values.

use std::collections::{BTreeMap, BTreeSet};

use dsl::Span;

use crate::expr::{Meaning, Symbol, TRAJECTORIES, function};
use crate::forms::target;

/// True for a reserved name of the language.
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
        "age",
        "field",
    ];
    words.contains(&name) || function(name).is_some() || TRAJECTORIES.iter().any(|t| t.name == name)
}

/// A human with tracked points.
#[derive(Clone, Debug, PartialEq)]
pub struct Human {
    /// Names of the points, each with the numbers of its presence and of its uncertainty.
    pub points: Vec<(String, usize, usize)>,
    /// Segments between two points, by the indices of the points.
    pub links: Vec<(usize, usize)>,
    /// True if its points keep their positions when their readings stop.
    pub held: bool,
}

/// Declared parameters and other named values.
#[derive(Debug, Default)]
pub struct Params {
    /// Values, by name.
    pub symbols: BTreeMap<String, Symbol>,
    /// Names whose value is wrong. They were reported, so their uses are not.
    pub failed: BTreeSet<String>,
    /// Named expressions of the robot's state, until the robot is bound.
    pub later: BTreeSet<String>,
    /// Used names.
    pub used: BTreeSet<String>,
    /// Signals, with the number of their presence in the table of signals.
    pub presence: BTreeMap<String, usize>,
    /// For the signals whose ages are read, the first number of the age in the table of signals.
    pub ages: BTreeMap<String, usize>,
    /// Signals of type wrench.
    pub wrenches: BTreeSet<String>,
    /// Humans. The points of a human are symbols under names that users cannot write.
    pub humans: BTreeMap<String, Human>,
    /// Safety fields. The value of a field is a symbol under a name that users cannot write.
    pub fields: BTreeSet<String>,
    /// Obstacles. They have no value.
    pub obstacles: BTreeSet<String>,
    /// Events that the host raises, with the spans of their declarations.
    pub events: BTreeMap<String, Span>,
}

impl Params {
    /// Meaning of a name, if it is a declared value.
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
            None if self.obstacles.contains(name) => {
                self.used.insert(name.to_string());
                Meaning::Obstacle
            }
            None if self.events.contains_key(name) => Meaning::Event,
            None => Meaning::Unknown,
        }
    }

    /// Number of a signal's presence in the table of signals.
    pub fn presence(&mut self, name: &str) -> Option<usize> {
        let name = target(name);
        let at = self.presence.get(name).copied()?;
        self.used.insert(name.to_string());
        Some(at)
    }

    /// First number of the age of a signal in the table of signals.
    pub fn age(&mut self, name: &str) -> Option<usize> {
        let name = target(name);
        let at = self.ages.get(name).copied()?;
        self.used.insert(name.to_string());
        Some(at)
    }

    /// True if the name is that of a value.
    pub fn knows(&self, name: &str) -> bool {
        let name = target(name);
        self.wrenches.contains(name)
            || self.humans.contains_key(name)
            || self.fields.contains(name)
            || self.obstacles.contains(name)
            || self.symbols.contains_key(name)
            || self.failed.contains(name)
            || self.later.contains(name)
    }

    /// All names of values that users can write; an event has no value.
    pub fn names(&self) -> Vec<String> {
        self.symbols
            .keys()
            .chain(self.humans.keys())
            .chain(&self.wrenches)
            .chain(&self.fields)
            .chain(&self.later)
            .chain(&self.failed)
            .filter(|n| !n.contains('.'))
            .cloned()
            .collect()
    }
}
