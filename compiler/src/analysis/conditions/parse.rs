//! Reads conditions from the graph: logic, comparisons in their normal form, flags.

use std::collections::{BTreeMap, BTreeSet};

use runtime::program::{Interface, Op};

use super::{CLOCK, Conditions, Formula, Key, Relation, Term, Truth, Variable};
use crate::expr::{Graph, Interval};
use crate::source_map::Property;

/// Relative difference up to which two thresholds are the same constant, written in two ways.
const SAME: f64 = 1e-12;

/// Largest depth of a condition that is read; a part below it is a flag.
const DEPTH: usize = 64;

/// Largest number of parts of the conditions of a state that are read; further ones are flags.
pub(super) const EFFORT: usize = 10_000;

/// Reads the conditions of a state.
pub(super) struct Parser<'p> {
    pub conditions: &'p mut Conditions,
    pub graph: &'p Graph,
    pub interface: &'p Interface,
    pub state: usize,
    /// Parts that may still be read.
    pub left: usize,
}

/// A sum of terms with factors, and a constant.
#[derive(Default)]
struct Sum {
    terms: BTreeMap<usize, f64>,
    constant: f64,
    /// Nodes that it depends on, also where they cancel out.
    nodes: BTreeSet<usize>,
}

impl Parser<'_> {
    /// Reads a truth value.
    pub fn truth(&mut self, node: usize) -> Formula {
        self.truth_within(node, DEPTH)
    }

    fn truth_within(&mut self, node: usize, depth: usize) -> Formula {
        self.left = self.left.saturating_sub(1);
        let Some(depth) = depth.checked_sub(1).filter(|_| self.left > 0) else { return self.flag(node) };
        match self.graph.ops()[node] {
            Op::Const(x) if x > 0.0 => Formula::Constant(Truth::Yes),
            Op::Const(x) if x < 0.0 => Formula::Constant(Truth::No),
            Op::Const(_) => Formula::Constant(Truth::Absent),
            Op::Neg(a) => Formula::Not(Box::new(self.truth_within(a, depth))),
            Op::Select(a, b, c) if c == a => Formula::And(Box::new([a, b].map(|n| self.truth_within(n, depth)))),
            Op::Select(a, b, c) if b == a => Formula::Or(Box::new([a, c].map(|n| self.truth_within(n, depth)))),
            Op::Select(a, b, c) => Formula::If(Box::new([a, b, c].map(|n| self.truth_within(n, depth)))),
            Op::Less(a, b) => self.compare(a, b, true).unwrap_or_else(|| self.flag(node)),
            Op::LessEqual(a, b) => self.compare(a, b, false).unwrap_or_else(|| self.flag(node)),
            Op::Signal(at) => match self.signal_of(at).filter(|&s| self.is_presence(s, at)) {
                Some(signal) => Formula::Flag(self.conditions.presence(signal)),
                None => self.flag(node),
            },
            _ => self.flag(node),
        }
    }

    /// Reads a property.
    pub fn property(&mut self, property: &Property) -> Formula {
        match property {
            Property::Value(node) => Formula::Holds(Box::new(self.truth(*node))),
            Property::Not(a) => Formula::Not(Box::new(self.property(a))),
            Property::And(both) => Formula::And(Box::new([self.property(&both[0]), self.property(&both[1])])),
            Property::Or(both) => Formula::Or(Box::new([self.property(&both[0]), self.property(&both[1])])),
        }
    }

    /// Signal of a number; `None` for the measures of a run behind the signals.
    fn signal_of(&self, number: usize) -> Option<usize> {
        self.interface.signal_of(number).filter(|_| number < self.interface.width())
    }

    /// The condition that a time has passed since the state was entered.
    pub fn since(&mut self, time: f64) -> Formula {
        let clock = Term { node: CLOCK, state: Some(self.state) };
        let key = Key::Number(vec![(clock, 1.0_f64.to_bits())]);
        let number = self.conditions.variable(key, |key| Variable {
            range: Interval::new(0.0, f64::INFINITY),
            total: true,
            ..Variable::new(key.clone())
        });
        self.against(number, Relation::GreaterEqual, time)
    }

    fn is_presence(&self, signal: usize, at: usize) -> bool {
        let s = &self.interface.signals[signal];
        at == s.at && !s.is_of_person()
    }

    fn flag(&mut self, node: usize) -> Formula {
        let (term, reads) = (self.term(node), self.reads(&BTreeSet::from([node])));
        let measured = matches!(self.graph.ops()[node], Op::Signal(at) if at >= self.interface.width());
        let total = measured || matches!(self.graph.ops()[node], Op::Signal(_)) && reads.len() == 1;
        let make = |key: &Key| Variable { reads, total, ..Variable::new(key.clone()) };
        Formula::Flag(self.conditions.variable(Key::Flag(term), make))
    }

    /// `a < b`, or `a <= b`; `None` if the comparison has no number that varies.
    fn compare(&mut self, a: usize, b: usize, strict: bool) -> Option<Formula> {
        let mut sum = Sum::default();
        self.add(a, 1.0, &mut sum, DEPTH);
        self.add(b, -1.0, &mut sum, DEPTH);
        self.below_zero(sum, strict)
    }

    /// The condition that a number is zero or more.
    pub fn at_least_zero(&mut self, node: usize) -> Formula {
        let mut sum = Sum::default();
        self.add(node, -1.0, &mut sum, DEPTH);
        match self.graph.constant(node) {
            Some(x) => Formula::Constant(if x >= 0.0 { Truth::Yes } else { Truth::No }),
            None => self.below_zero(sum, false).unwrap_or_else(|| self.flag(node)),
        }
    }

    /// The condition that a sum is below zero, or at most zero.
    fn below_zero(&mut self, mut sum: Sum, strict: bool) -> Option<Formula> {
        sum.terms.retain(|_, factor| *factor != 0.0);
        let first = *sum.terms.values().next()?;
        let terms: Vec<(usize, f64)> = sum.terms.iter().map(|(&n, f)| (n, f / first)).collect();
        let than = -sum.constant / first;
        if !than.is_finite() || terms.iter().any(|t| !t.1.is_finite()) {
            return None;
        }
        let key = Key::Number(terms.iter().map(|&(n, f)| (self.term(n), f.to_bits())).collect());
        let reads = self.reads(&sum.nodes);
        let total = sum.nodes.iter().all(|&n| self.is_plain(n));
        let range =
            terms.iter().fold(Interval::point(0.0), |sum, &(n, f)| sum.plus(self.range(n).by(Interval::point(f))));
        let number =
            self.conditions.variable(key, |key| Variable { range, reads, total, ..Variable::new(key.clone()) });
        let relation = match (first > 0.0, strict) {
            (true, true) => Relation::Less,
            (true, false) => Relation::LessEqual,
            (false, true) => Relation::Greater,
            (false, false) => Relation::GreaterEqual,
        };
        Some(self.against(number, relation, than))
    }

    /// Comparison with a constant, which becomes a threshold.
    fn against(&mut self, number: usize, relation: Relation, than: f64) -> Formula {
        let known = &mut self.conditions.variables[number].thresholds;
        let same = known.iter().copied().find(|t| (t - than).abs() <= SAME * t.abs().max(than.abs()));
        if same.is_none() {
            known.push(than);
        }
        Formula::Compare(number, relation, same.unwrap_or(than))
    }

    /// Adds `factor` times a node.
    fn add(&self, node: usize, factor: f64, sum: &mut Sum, depth: usize) {
        let constant = |n: usize| self.graph.constant(n);
        let deeper = depth.checked_sub(1);
        match (self.graph.ops()[node], deeper) {
            (Op::Const(x), _) => sum.constant += factor * x,
            (Op::Add(a, b), Some(depth)) => {
                self.add(a, factor, sum, depth);
                self.add(b, factor, sum, depth);
            }
            (Op::Sub(a, b), Some(depth)) => {
                self.add(a, factor, sum, depth);
                self.add(b, -factor, sum, depth);
            }
            (Op::Neg(a), Some(depth)) => self.add(a, -factor, sum, depth),
            (Op::Mul(a, b), Some(depth)) if constant(a).is_some() => {
                self.add(b, factor * constant(a).unwrap_or(f64::NAN), sum, depth);
            }
            (Op::Mul(a, b), Some(depth)) if constant(b).is_some() => {
                self.add(a, factor * constant(b).unwrap_or(f64::NAN), sum, depth);
            }
            (Op::Div(a, b), Some(depth)) if constant(b).is_some() => {
                self.add(a, factor / constant(b).unwrap_or(f64::NAN), sum, depth);
            }
            _ => {
                *sum.terms.entry(node).or_insert(0.0) += factor;
                sum.nodes.insert(node);
            }
        }
    }

    /// The identity of a node in a condition of this state.
    fn term(&self, node: usize) -> Term {
        let mut timed = false;
        self.visit(&BTreeSet::from([node]), |op| {
            timed |= op == Op::T;
            true
        });
        match self.graph.ops()[node] {
            Op::T => Term { node: CLOCK, state: Some(self.state) },
            _ => Term { node, state: timed.then_some(self.state) },
        }
    }

    /// True for a value that is a number whenever its signals are present: a signal or a time, and sums, products and norms
    /// of such.
    fn is_plain(&self, node: usize) -> bool {
        let mut plain = true;
        let mut operands = Vec::new();
        self.visit(&BTreeSet::from([node]), |op| {
            operands.push(op);
            true
        });
        for op in operands {
            plain &= match op {
                Op::T | Op::Time | Op::Const(_) | Op::Add(..) | Op::Sub(..) | Op::Mul(..) | Op::Neg(_) | Op::Abs(_) => {
                    true
                }
                Op::Sqrt(a) => self.range(a).low >= 0.0,
                Op::Div(_, b) => self.graph.constant(b).is_some_and(|b| b != 0.0),
                Op::Signal(at) => self.signal_of(at).is_some_and(|s| !self.interface.signals[s].is_of_person()),
                _ => false,
            };
        }
        plain
    }

    /// Signals without which the nodes have no value.
    fn reads(&self, nodes: &BTreeSet<usize>) -> Vec<usize> {
        let mut reads = BTreeSet::new();
        self.visit(nodes, |op| {
            if let Op::Signal(at) = op
                && let Some(signal) = self.signal_of(at)
                && !self.interface.signals[signal].is_of_person()
                && at != self.interface.signals[signal].at
            {
                reads.insert(signal);
            }
            // A choice, a minimum or a maximum, and a field, may have a value although an operand has none.
            !matches!(op, Op::Select(..) | Op::Min(..) | Op::Max(..) | Op::State(_) | Op::Trajectory(_))
        });
        reads.into_iter().collect()
    }

    /// Calls `f` for the operations that the nodes depend on, and goes on to their operands where it returns true.
    fn visit(&self, nodes: &BTreeSet<usize>, mut f: impl FnMut(Op) -> bool) {
        let (mut open, mut seen) = (nodes.iter().copied().collect::<Vec<_>>(), BTreeSet::new());
        while let Some(node) = open.pop() {
            if seen.insert(node) && f(self.graph.ops()[node]) {
                open.extend(self.graph.reads(node));
            }
        }
    }

    /// Range of a node that follows from its operations alone. The robot may leave its limits, and a condition may
    /// watch for this, so that no limit narrows it.
    fn range(&self, node: usize) -> Interval {
        let mut needed = BTreeSet::new();
        let mut open = vec![node];
        while let Some(n) = open.pop() {
            if needed.insert(n) {
                open.extend(self.graph.ops()[n].operands().into_iter().flatten());
            }
        }
        let mut known: BTreeMap<usize, Interval> = BTreeMap::new();
        for n in needed {
            let at = |a: usize| known.get(&a).copied().unwrap_or(Interval::ALL);
            let leaf = |op| match op {
                Op::T | Op::Time => Interval::new(0.0, f64::INFINITY),
                _ => Interval::ALL,
            };
            let range = Interval::of(self.graph.ops()[n], at, leaf);
            known.insert(n, range);
        }
        known.get(&node).copied().unwrap_or(Interval::ALL)
    }
}
