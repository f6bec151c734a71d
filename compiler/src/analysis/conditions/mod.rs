//! Conditions of a machine as formulas over abstract values.
//!
//! A comparison is brought to the form `x < c`, where `x` is a number with its factors, `norm(a) - 2 b`, and `c` a
//! constant. The constants with which all conditions compare `x` divide its axis into points and open intervals, the
//! cells of `x`; within a cell no comparison changes. A truth value that is no comparison is a flag. A number or a flag
//! may be absent as well, as at run time: a comparison with it is then neither true nor false, and a condition that is
//! not true does not hold.
//!
//! Numbers that differ are taken as independent, so that a set of conditions that no valuation satisfies is proven to
//! be contradictory.

mod parse;
mod search;

use std::collections::BTreeMap;

use runtime::program::{Interface, Trigger};

use crate::expr::{Graph, Interval};
use crate::source_map::MachinePlaces;

/// Truth value of a formula: at run time 1, -1 and NaN.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Truth {
    /// It holds.
    Yes,
    /// It does not hold.
    No,
    /// A value that it depends on is absent.
    Absent,
}

/// An abstract value: the representative of a cell, a truth value, or none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Value {
    /// Number within a cell.
    Number(f64),
    /// Truth value.
    Truth(bool),
    /// No value.
    Absent,
}

/// A comparison with a constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Relation {
    /// Less.
    Less,
    /// Less or equal.
    LessEqual,
    /// Greater.
    Greater,
    /// Greater or equal.
    GreaterEqual,
}

/// A condition over abstract values.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Formula {
    /// It never changes.
    Constant(Truth),
    /// Truth value of a flag.
    Flag(usize),
    /// Comparison of a number with a constant.
    Compare(usize, Relation, f64),
    /// Negation.
    Not(Box<Formula>),
    /// The second if the first holds, otherwise the first.
    And(Box<[Formula; 2]>),
    /// The first if it holds, the second if it does not.
    Or(Box<[Formula; 2]>),
    /// The second if the first holds, the third if it does not.
    If(Box<[Formula; 3]>),
}

impl Formula {
    /// Adds the values that it reads.
    pub fn variables(&self, out: &mut Vec<usize>) {
        match self {
            Formula::Constant(_) => {}
            Formula::Flag(v) | Formula::Compare(v, ..) => {
                if !out.contains(v) {
                    out.push(*v);
                }
            }
            Formula::Not(a) => a.variables(out),
            Formula::And(both) | Formula::Or(both) => both.iter().for_each(|f| f.variables(out)),
            Formula::If(all) => all.iter().for_each(|f| f.variables(out)),
        }
    }
}

/// Part of a number: a node of the graph; if it depends on the time since the entry of a state, also that state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Term {
    node: usize,
    state: Option<usize>,
}

/// Identity of an abstract value.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Key {
    /// Terms with the bits of their factors.
    Number(Vec<(Term, u64)>),
    /// Truth value of a node.
    Flag(Term),
    /// Presence of a signal.
    Present(usize),
}

/// A value that conditions read.
#[derive(Clone, Debug)]
pub(crate) struct Variable {
    key: Key,
    /// Constants with which it is compared.
    thresholds: Vec<f64>,
    /// All its values can be in this interval.
    range: Interval,
    /// Its possible values.
    domain: Vec<Value>,
    /// Signals that must be present for it to have a value.
    pub reads: Vec<usize>,
    /// True if it has a value whenever these signals are present.
    total: bool,
    /// Presences of these signals.
    presences: Vec<usize>,
}

/// All conditions of a machine.
pub(crate) struct Conditions {
    /// The values that they read.
    pub variables: Vec<Variable>,
    by_key: BTreeMap<Key, usize>,
    /// For each state, the conditions of its transitions; `None` for triggers that are no condition.
    pub triggers: Vec<Vec<Option<Formula>>>,
    /// For each of them, that its state has been active for as long as the condition must have held.
    pub lasting: Vec<Vec<Formula>>,
}

impl Conditions {
    /// Reads the conditions of a machine.
    pub fn new(
        graph: &Graph,
        interface: &Interface,
        machine: &runtime::program::MachineProgram,
        places: &MachinePlaces,
    ) -> Conditions {
        let (variables, by_key) = (Vec::new(), BTreeMap::new());
        let mut conditions = Conditions { variables, by_key, triggers: Vec::new(), lasting: Vec::new() };
        for (s, state) in machine.states.iter().enumerate() {
            let mut parser =
                parse::Parser { conditions: &mut conditions, graph, interface, state: s, left: parse::EFFORT };
            let (mut triggers, mut lasting) = (Vec::new(), Vec::new());
            for (place, t) in places.transitions[s].iter().zip(&state.transitions) {
                triggers.push(match &t.trigger {
                    Trigger::When { .. } => place.condition.map(|node| parser.truth(node)),
                    Trigger::After(time) => Some(parser.since(*time)),
                    Trigger::Event(_) | Trigger::Reached { .. } | Trigger::Fault(_) => None,
                });
                lasting.push(match t.trigger {
                    Trigger::When { hold, .. } if hold > 0.0 => parser.since(hold),
                    _ => Formula::Constant(Truth::Yes),
                });
            }
            conditions.triggers.push(triggers);
            conditions.lasting.push(lasting);
        }
        conditions.finish(interface);
        conditions
    }

    /// Sets the domains of all values, after all thresholds are known.
    fn finish(&mut self, interface: &Interface) {
        for v in 0..self.variables.len() {
            // Only signals that are read by several values, or whose presence is a condition, relate values.
            let reads = self.variables[v].reads.clone();
            let present = reads.iter().map(|&signal| self.presence(signal)).collect();
            self.variables[v].presences = present;
        }
        for v in &mut self.variables {
            let always = |signal: usize| {
                let s = &interface.signals[signal];
                s.variable.as_ref().is_some_and(|i| i.value.is_some()) && !s.optional
            };
            v.domain = match v.key {
                Key::Present(signal) if always(signal) => vec![Value::Truth(true)],
                Key::Present(_) => vec![Value::Truth(true), Value::Truth(false)],
                Key::Flag(_) => vec![Value::Truth(true), Value::Truth(false)],
                Key::Number(_) => cells(&v.thresholds, v.range),
            };
            let never_absent = v.total && v.reads.iter().all(|&s| always(s));
            if !matches!(v.key, Key::Present(_)) && !never_absent {
                v.domain.push(Value::Absent);
            }
        }
    }

    /// Index of the presence of a signal.
    fn presence(&mut self, signal: usize) -> usize {
        self.variable(Key::Present(signal), |_| Variable::new(Key::Present(signal)))
    }

    fn variable(&mut self, key: Key, make: impl FnOnce(&Key) -> Variable) -> usize {
        if let Some(&v) = self.by_key.get(&key) {
            return v;
        }
        self.variables.push(make(&key));
        self.by_key.insert(key, self.variables.len() - 1);
        self.variables.len() - 1
    }
}

impl Variable {
    fn new(key: Key) -> Variable {
        Variable {
            key,
            thresholds: Vec::new(),
            range: Interval::ALL,
            domain: Vec::new(),
            reads: Vec::new(),
            total: false,
            presences: Vec::new(),
        }
    }
}

/// A representative of each cell between thresholds that has numbers in `range`.
fn cells(thresholds: &[f64], range: Interval) -> Vec<Value> {
    let mut sorted = thresholds.to_vec();
    sorted.sort_by(f64::total_cmp);
    let mut out = Vec::new();
    let mut low = f64::NEG_INFINITY;
    for high in sorted.into_iter().chain([f64::INFINITY]) {
        let (a, b) = (low.max(range.low), high.min(range.high));
        let inside = match (a.is_finite(), b.is_finite()) {
            (true, true) => a + 0.5 * (b - a),
            (true, false) => a + a.abs().max(1.0),
            (false, true) => b - b.abs().max(1.0),
            (false, false) => 0.0,
        };
        // The ends of the cell are cells of their own, those of the range are not.
        if a <= b && low < inside && inside < high {
            out.push(Value::Number(inside));
        }
        if high.is_finite() && range.low <= high && high <= range.high {
            out.push(Value::Number(high));
        }
        low = high;
    }
    out
}
