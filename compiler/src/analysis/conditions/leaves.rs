//! Quantities that a value is made of, and whether it can take every value of its range: each quantity occurs once in it,
//! so that the interval of its operations is its range.

use std::collections::BTreeMap;

use runtime::program::{Interface, Op};

use super::{CLOCK, Key};
use crate::expr::Graph;

/// A quantity from outside of the graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Leaf {
    /// A number of a signal, by the signal and the number in the table of signals.
    Signal(usize, usize),
    /// A number of the robot's state.
    State(usize),
    /// The time since the entry of a state.
    Clock(usize),
    /// Anything else, such as the time since the start.
    Other,
}

/// The quantities that a value is made of.
#[derive(Clone, Debug, Default)]
pub(crate) struct Leaves {
    /// Each of them.
    pub all: Vec<Leaf>,
    /// True if the value is the result of continuous operations in which each occurs once.
    pub single: bool,
}

/// The quantities of a value.
pub(super) fn leaves(graph: &Graph, interface: &Interface, key: &Key) -> Leaves {
    let (terms, flag) = match key {
        Key::Present(signal) => {
            let number = interface.signals[*signal].at;
            return Leaves { all: vec![Leaf::Signal(*signal, number)], single: true };
        }
        Key::Flag(term) => (vec![*term], true),
        Key::Number(terms) => (terms.iter().map(|t| t.0).collect(), false),
    };
    let mut out = Leaves { all: Vec::new(), single: true };
    let mut paths: BTreeMap<usize, usize> = BTreeMap::new();
    for term in &terms {
        match term.node {
            CLOCK => out.all.push(Leaf::Clock(term.state.unwrap_or(0))),
            node => *paths.entry(node).or_insert(0) += 1,
        }
    }
    // Operands precede their users, so that all users of a node come before it.
    while let Some((node, count)) = paths.pop_last() {
        let op = graph.ops()[node];
        let leaf = match op {
            Op::Const(_) => continue,
            Op::Signal(k) if k >= interface.width() => Leaf::Other,
            Op::Signal(k) => interface.signal_of(k).map_or(Leaf::Other, |s| Leaf::Signal(s, k)),
            Op::State(k) => Leaf::State(k),
            Op::T | Op::Time | Op::Input(_) | Op::Trajectory(_) => Leaf::Other,
            _ => {
                let whole = !matches!(op, Op::Select(..) | Op::Less(..) | Op::LessEqual(..));
                out.single &= whole && !flag;
                let operands: Vec<usize> = op.operands().into_iter().flatten().collect();
                let square = matches!(op, Op::Mul(a, b) if a == b);
                for &o in operands.iter().take(if square { 1 } else { 3 }) {
                    let to = paths.entry(o).or_insert(0);
                    *to = to.saturating_add(count);
                }
                continue;
            }
        };
        out.single &= count == 1 && leaf != Leaf::Other;
        out.all.push(leaf);
    }
    out
}
