//! Table of values during layout: the places of parameters, and the captures.

use std::collections::BTreeMap;

use runtime::program::{Capture, CaptureSource, ValueRange};
use stdlib_tasks::bound::Slot;
use stdlib_tasks::expression::{Expression, Leaf};

/// Table of values during layout, with the node that computes each place.
#[derive(Debug, Default)]
pub struct Table {
    /// Node of each place.
    pub nodes: Vec<usize>,
    /// The same for the places of the program, once its table of values is made.
    pub placed: Vec<usize>,
    /// Captures, in the order of their inputs.
    pub captures: Vec<Capture>,
    /// Number of captured values.
    pub inputs: usize,
    /// Leaves of the robot's current state, each with the index of its first number.
    pub leaves: Vec<(usize, Leaf)>,
    /// Index of the first number of each leaf, by the leaf's text.
    known: BTreeMap<String, usize>,
    /// The first input of each captured expression, by its nodes.
    expressions: BTreeMap<Vec<usize>, usize>,
    /// Ranges of places that move; the controller checks them at run time.
    pub ranges: Vec<ValueRange>,
}

impl Table {
    pub(crate) fn place(&mut self, nodes: &[usize]) -> Slot {
        let at = self.nodes.len();
        self.nodes.extend_from_slice(nodes);
        Slot { at, len: nodes.len() }
    }

    /// Captures a value of a task, once for all uses; returns the first input.
    pub(super) fn capture(&mut self, source: CaptureSource, len: usize) -> usize {
        if let Some(c) = self.captures.iter().find(|c| c.source == source) {
            return c.at;
        }
        let at = self.inputs;
        self.captures.push(Capture { at, len, source });
        self.inputs += len;
        at
    }

    /// Captures an expression, once for all uses; returns the first input. `nodes` are the nodes of its value.
    pub(super) fn capture_nodes(&mut self, nodes: &[usize], expression: Expression) -> usize {
        if let Some(&at) = self.expressions.get(nodes) {
            return at;
        }
        let at = self.inputs;
        self.captures.push(Capture { at, len: nodes.len(), source: CaptureSource::State(expression) });
        self.inputs += nodes.len();
        self.expressions.insert(nodes.to_vec(), at);
        at
    }

    /// Node from which captured value `k` is taken, if the capture is an expression.
    pub fn captured(&self, k: usize) -> Option<usize> {
        self.expressions.iter().find_map(|(nodes, &at)| nodes.get(k.checked_sub(at)?).copied())
    }

    /// Reserves the numbers of a leaf, once for all uses; returns the first.
    pub(crate) fn leaf(&mut self, leaf: Leaf) -> usize {
        let key = format!("{leaf:?}");
        if let Some(&at) = self.known.get(&key) {
            return at;
        }
        let at = self.leaves.last().map_or(0, |(at, l)| at + l.width());
        self.leaves.push((at, leaf));
        self.known.insert(key, at);
        at
    }

    /// Leaf that contains number `k` of the state, with the index of its first number.
    pub fn leaf_of(&self, k: usize) -> Option<(usize, &Leaf)> {
        let i = self.leaves.partition_point(|(at, _)| *at <= k).checked_sub(1)?;
        self.leaves.get(i).map(|(at, l)| (*at, l))
    }
}
