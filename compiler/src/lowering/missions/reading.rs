//! The values of a mission's keys: constant numbers, pairs, ranges and spreads, in SI and inside the ranges that the
//! table of keys gives, with what it gives where a key is left out.

use dsl::tree::{Block, Entry, Value, ValueKind};
use dsl::{Diagnostic, Span, Syntax};
use stdlib_tasks::dimension::Dimension;
use stdlib_tasks::params::{Presence, Quantity};

use mission::kinds::schedule::problem::Duration;
use mission::numbers::Range;

use super::super::Lowerer;
use crate::expr::constants::{Constants, with_units};
use crate::expr::dimension_check::one_unit;
use crate::expr::function;
use crate::forms::misspelt;
use crate::sections::{Holds, Key, Section};
use crate::units;

/// A block with the section whose keys it has, and what a message calls it.
#[derive(Clone, Copy)]
pub(super) struct Keys<'b> {
    /// The block.
    pub block: &'b Block,
    /// Its section.
    pub section: &'static Section,
    /// Where the entry is named, for keys that are missing.
    pub at: Span,
}

impl<'b> Keys<'b> {
    /// What was written behind a key.
    pub fn entry(&self, key: &str) -> Option<&'b Entry> {
        self.block.get(key)
    }

    /// Whether the key is written with a slip, which is reported as one.
    pub fn misspells(&self, key: &str) -> bool {
        misspelt(self.block, self.section, key)
    }

    /// The key in the table.
    fn key(&self, key: &str) -> Option<&'static Key> {
        self.section.key(key, Syntax::Native)
    }
}

/// The number in a default of the table, which is written in SI.
fn number_of_default(key: &Key) -> Option<f64> {
    match key.presence {
        Presence::Default(text) => text.split(' ').next()?.parse().ok(),
        Presence::Required | Presence::Optional => None,
    }
}

impl Lowerer<'_> {
    /// The number behind a key, or what stands for it. `Err` where it is wrong or missing, and was reported; `Ok(None)`
    /// where it is left out and nothing stands for it.
    pub(super) fn key_number(&mut self, keys: Keys, name: &str) -> Result<Option<f64>, ()> {
        let Some(key) = keys.key(name) else { return Err(()) };
        match (keys.entry(name), &key.holds) {
            (Some(e), Holds::Number(q)) => self.number_within(&e.value, name, q).map(Some).ok_or(()),
            (Some(_), _) => Err(()),
            (None, _) if key.presence == Presence::Required => {
                self.lacks(keys, name);
                Err(())
            }
            (None, _) => Ok(number_of_default(key)),
        }
    }

    /// A whole number behind a key that has a default.
    pub(super) fn key_count(&mut self, keys: Keys, name: &str) -> Result<usize, ()> {
        let x = self.key_number(keys, name)?.ok_or(())?;
        if x.fract() != 0.0 {
            let at = keys.entry(name).map_or(keys.at, |e| e.value.span);
            let d = Diagnostic::error("HQ0308", at, format!("`{name}` is a whole number, and this is {x}"));
            self.push(d.help("leave out what stands behind the point"));
            return Err(());
        }
        // Beyond what can be counted it is refused as too many.
        Ok(x as usize)
    }

    /// A constant number inside its range.
    pub(super) fn number_within(&mut self, value: &Value, name: &str, q: &Quantity) -> Option<f64> {
        if let Some(items) = with_units(value) {
            self.not_one(value, name, &items, q);
            return None;
        }
        let x = self.constant_number(value, q.dimension)?;
        if q.contains(x) {
            return Some(x);
        }
        let (range, unit) = (q.describe(), units::written(q.dimension));
        let range = if q.dimension == stdlib_tasks::dimension::NONE { range } else { format!("{range} {unit}") };
        let text = format!("`{name}` is {range}, and this is {}", units::shown(x, q.dimension));
        self.push(Diagnostic::error("HQ0308", value.span, text).help(format!("write a number that is {range}")));
        None
    }

    /// Reports a list in the place of one number; of a speed that is one number the greatest counts.
    fn not_one(&mut self, value: &Value, name: &str, items: &[Value], q: &Quantity) {
        let mut constants = Constants { graph: &mut self.graph, params: &mut self.params };
        let mut numbers = items.iter().filter_map(|item| constants.scalar(item, q.dimension, &mut Vec::new()));
        let (which, x) = match name {
            "speed" => ("the greatest one", numbers.reduce(f64::max)),
            _ => ("one of them", numbers.next()),
        };
        let text = format!("`{name}` is one number, and this list has {}", items.len());
        let d = Diagnostic::error("HQ0310", value.span, text);
        self.push(match x.filter(|x| q.contains(*x)) {
            Some(x) => d.help(format!("write {which}, `{name} {}`", units::shown(x, q.dimension))),
            None => d.help("write one number without brackets"),
        });
    }

    fn constant_number(&mut self, value: &Value, dimension: Dimension) -> Option<f64> {
        let mut constants = Constants { graph: &mut self.graph, params: &mut self.params };
        constants.scalar(value, dimension, self.diagnostics)
    }

    /// Several constant numbers of a dimension, from a list with or without a unit behind it.
    fn constant_list(&mut self, value: &Value, items: &[Value], dimension: Dimension) -> Option<Vec<f64>> {
        let before = self.diagnostics.len();
        let all: Vec<Option<f64>> = items.iter().map(|item| self.constant_number(item, dimension)).collect();
        one_unit(self.diagnostics, before, value, items.len());
        all.into_iter().collect()
    }

    /// Exactly two constant numbers.
    fn two(&mut self, value: &Value, items: &[Value], dimension: Dimension, example: &str) -> Option<[f64; 2]> {
        if items.len() != 2 {
            let text = format!("two numbers are needed here, and these are {}", items.len());
            self.push(Diagnostic::error("HQ0310", value.span, text).help(format!("write for instance `{example}`")));
            return None;
        }
        let numbers = self.constant_list(value, items, dimension)?;
        Some([*numbers.first()?, *numbers.get(1)?])
    }

    /// A point of the ground behind a key that must be there.
    pub(super) fn key_pair(&mut self, keys: Keys, name: &str) -> Option<[f64; 2]> {
        let Some(Holds::Pair(dimension)) = keys.key(name).map(|k| &k.holds) else { return None };
        let Some(e) = keys.entry(name) else {
            self.lacks(keys, name);
            return None;
        };
        match with_units(&e.value) {
            Some(items) => self.two(&e.value, &items, *dimension, &example(name)),
            None if matches!(e.value.kind, ValueKind::Missing) => None,
            None => {
                let text = format!("`{name}` is a point of the ground, two numbers");
                let d = Diagnostic::error("HQ0304", e.value.span, text);
                self.push(d.help(format!("write for instance `{}`", example(name))));
                None
            }
        }
    }

    /// A range of speeds behind a key.
    pub(super) fn key_range(&mut self, keys: Keys, name: &str) -> Result<Option<Range>, ()> {
        let Some(key) = keys.key(name) else { return Err(()) };
        let Holds::Range(q) = &key.holds else { return Err(()) };
        let Some(e) = keys.entry(name) else {
            if key.presence == Presence::Required {
                self.lacks(keys, name);
                return Err(());
            }
            return Ok(None);
        };
        let range = match with_units(&e.value) {
            Some(items) => {
                self.two(&e.value, &items, q.dimension, &example(name)).map(|[low, high]| Range::new(low, high))
            }
            None => self.constant_number(&e.value, q.dimension).map(Range::point),
        };
        range.map(Some).ok_or(())
    }

    /// How long something takes, behind a key that must be there.
    pub(super) fn key_spread(&mut self, keys: Keys, name: &str) -> Option<Duration> {
        let Some(Holds::Spread(q)) = keys.key(name).map(|k| &k.holds) else { return None };
        let Some(e) = keys.entry(name) else {
            self.lacks(keys, name);
            return None;
        };
        let ValueKind::Call(called, args) = &e.value.kind else {
            return Some(Duration { mean: self.number_within(&e.value, name, q)?, sigma: 0.0 });
        };
        if called.value != "normal" && function(&called.value).is_none() {
            let text = format!("there is no distribution `{}`", called.value);
            let d = Diagnostic::error("HQ0201", called.span, text);
            self.push(d.help("a duration is a time, or `normal(mean, deviation)`"));
            return None;
        }
        if called.value != "normal" {
            return Some(Duration { mean: self.number_within(&e.value, name, q)?, sigma: 0.0 });
        }
        let [mean, sigma] = args.as_slice() else {
            let text =
                format!("`normal` needs two numbers, a mean and a standard deviation, and here is {}", args.len());
            let d = Diagnostic::error("HQ0310", e.value.span, text);
            self.push(d.help("write for instance `normal(204 s, 20 s)`"));
            return None;
        };
        let mean = self.number_within(mean, "the mean", q);
        let sigma = self.number_within(sigma, "the standard deviation", &Quantity::at_least(q.dimension, 0.0));
        Some(Duration { mean: mean?, sigma: sigma? })
    }

    /// Weights for so many operations, one for all or one for each; empty where left out.
    pub(super) fn key_weights(&mut self, keys: Keys, name: &str, operations: usize) -> Option<Vec<f64>> {
        let Some(Holds::Numbers(q)) = keys.key(name).map(|k| &k.holds) else { return None };
        let Some(e) = keys.entry(name) else { return Some(Vec::new()) };
        match with_units(&e.value) {
            Some(items) => {
                let all: Vec<Option<f64>> = items.iter().map(|v| self.number_within(v, name, q)).collect();
                all.into_iter().collect()
            }
            None => {
                let weight = self.number_within(&e.value, name, q)?;
                // None at all is one for each.
                let count =
                    if weight == 1.0 { 0 } else { operations.min(mission::kinds::schedule::check::MAX_OPERATIONS) };
                Some(vec![weight; count])
            }
        }
    }

    /// Reports a key that must be there.
    pub(super) fn lacks(&mut self, keys: Keys, name: &str) {
        if keys.misspells(name) {
            return;
        }
        let d = Diagnostic::error("HQ0206", keys.at, format!("{} needs `{name}`", keys.section.name));
        self.push(d.help(format!("write for instance `{}`", example(name))));
    }
}

/// A key with a value that fits.
fn example(name: &str) -> String {
    let value = match name {
        "speed" | "proximity_speed" => "[0.05, 0.2] m/s",
        "duration" => "normal(204 s, 20 s)",
        "serve" => "20 s",
        "spec" => "\"picker.hq\"",
        "go" => "box_in_place",
        "done" => "waiting",
        "skills" => "{ pick_and_place 2 s }",
        "at" => "[0.4, 0, 0.1] m",
        _ => "[4, -1.5] m",
    };
    format!("{name} {value}")
}
