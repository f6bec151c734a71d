//! Conditions of a machine as formulas over abstract values.
//!
//! A comparison is brought to the form `x < c`, where `x` is a number with its factors, `norm(a) - 2 b`, and `c` a
//! constant. The constants with which the conditions of a question compare `x` divide its axis into points and open
//! intervals, the cells of `x`; within a cell no comparison changes. A truth value that is no comparison is a flag. A number or a flag
//! may be absent as well, as at run time: a comparison with it is then neither true nor false, and a condition that is
//! not true does not hold.
//!
//! Numbers that differ are taken as independent, so that a set of conditions that no valuation satisfies is proven to
//! be contradictory.

mod leaves;
mod parse;
mod search;
mod substitute;

pub(crate) use leaves::{Leaf, Leaves};
pub(crate) use search::{Claim, Search};

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
    /// True if it holds, false if not, also where a value is absent.
    Holds(Box<Formula>),
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
            Formula::Not(a) | Formula::Holds(a) => a.variables(out),
            Formula::And(both) | Formula::Or(both) => both.iter().for_each(|f| f.variables(out)),
            Formula::If(all) => all.iter().for_each(|f| f.variables(out)),
        }
    }
}

/// Part of a number: a node of the graph; if it depends on the time since the entry of a state, also that state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Term {
    /// The node; [`CLOCK`] for that time itself.
    pub node: usize,
    /// The state.
    pub state: Option<usize>,
}

/// Node of a [`Term`] that is the time since the entry of its state.
pub(crate) const CLOCK: usize = usize::MAX;

/// Identity of an abstract value.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Key {
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
    /// Its identity.
    pub key: Key,
    /// Constants with which conditions compare it.
    thresholds: Vec<f64>,
    /// All its values can be in this interval.
    range: Interval,
    /// Quantities that it is made of.
    pub leaves: Leaves,
    /// True if it may have no value; of a presence, true if the signal may be absent.
    may_lack: bool,
    /// Signals that must be present for it to have a value.
    pub reads: Vec<usize>,
    /// True if it has a value whenever these signals are present.
    total: bool,
    /// Presences of these signals.
    presences: Vec<usize>,
}

/// Node of a predicate of a run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PredicateNode {
    /// The node.
    pub node: usize,
    /// True for a truth value, false for a number that is zero or more if the predicate holds.
    pub is_truth: bool,
}

/// All conditions of a machine.
pub(crate) struct Conditions {
    /// The values that they read.
    pub variables: Vec<Variable>,
    by_key: BTreeMap<Key, usize>,
    /// For each state, the conditions of its transitions; `None` for triggers that are no condition.
    pub triggers: Vec<Vec<Option<Formula>>>,
    /// Properties of the machine; `None` for one that speaks of other ticks.
    pub properties: Vec<Option<Formula>>,
    /// For each of the conditions, that its state has been active for as long as the condition must have held.
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
        let (triggers, lasting, properties) = (Vec::new(), Vec::new(), Vec::new());
        let mut conditions = Conditions { variables, by_key, triggers, lasting, properties };
        for (s, state) in machine.states.iter().enumerate() {
            let mut parser =
                parse::Parser { conditions: &mut conditions, graph, interface, state: s, left: parse::EFFORT };
            let (mut triggers, mut lasting) = (Vec::new(), Vec::new());
            for (place, t) in places.transitions[s].iter().zip(&state.transitions) {
                triggers.push(match &t.trigger {
                    Trigger::When { .. } => place.condition.map(|node| parser.truth(node)),
                    Trigger::After(time) => Some(parser.since(*time)),
                    Trigger::Event(_) | Trigger::Reached(_) | Trigger::Ended(_) | Trigger::Fault(_) => None,
                });
                lasting.push(match t.trigger {
                    Trigger::When { hold, .. } if hold > 0.0 => parser.since(hold),
                    _ => Formula::Constant(Truth::Yes),
                });
            }
            conditions.triggers.push(triggers);
            conditions.lasting.push(lasting);
        }
        for property in &places.properties {
            let mut parser = parse::Parser {
                conditions: &mut conditions,
                graph,
                interface,
                state: property.state,
                left: parse::EFFORT,
            };
            let formula = property.formula.as_ref().ok().map(|p| parser.property(p));
            conditions.properties.push(formula);
        }
        conditions.finish(graph, interface);
        conditions
    }

    /// Reads predicates as conditions of no state; they are the properties of the result.
    pub fn of_predicates(graph: &Graph, interface: &Interface, predicates: &[PredicateNode]) -> Conditions {
        let (variables, by_key) = (Vec::new(), BTreeMap::new());
        let (triggers, lasting, properties) = (Vec::new(), Vec::new(), Vec::new());
        let mut conditions = Conditions { variables, by_key, triggers, lasting, properties };
        for of in predicates {
            let mut parser =
                parse::Parser { conditions: &mut conditions, graph, interface, state: 0, left: parse::EFFORT };
            let formula = if of.is_truth { parser.truth(of.node) } else { parser.at_least_zero(of.node) };
            // One without a value is false.
            conditions.properties.push(Some(Formula::Holds(Box::new(formula))));
        }
        conditions.finish(graph, interface);
        conditions
    }

    /// Relates values to the presence of their signals.
    fn finish(&mut self, graph: &Graph, interface: &Interface) {
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
            v.leaves = leaves::leaves(graph, interface, &v.key);
            v.may_lack = match v.key {
                Key::Present(signal) => !always(signal),
                Key::Flag(_) | Key::Number(_) => !(v.total && v.reads.iter().all(|&s| always(s))),
            };
        }
    }

    /// Time since the entry of a state, if a condition depends on it.
    pub fn clock(&self, state: usize) -> Option<usize> {
        let clock = Term { node: CLOCK, state: Some(state) };
        self.by_key.get(&Key::Number(vec![(clock, 1.0_f64.to_bits())])).copied()
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
            leaves: Leaves::default(),
            may_lack: true,
            reads: Vec::new(),
            total: false,
            presences: Vec::new(),
        }
    }
}
