//! Predicates and conditions that may hold, or may fail, at some tick of a scenario.

use std::collections::BTreeSet;

use runtime::program::{Op, Unit};

use super::Played;
use crate::analysis::value_ranges::Ranges;
use crate::expr::Interval;

/// Possible results of a condition in a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Truths {
    /// It may be true.
    pub holds: bool,
    /// It may be false.
    pub fails: bool,
}

impl Truths {
    /// Nothing is known.
    pub const OPEN: Truths = Truths { holds: true, fails: true };
}

impl Played<'_> {
    /// Possible results of a predicate. One without a value is false.
    pub fn predicate(&self, predicate: usize) -> Truths {
        let (Some(&node), Some(of)) = (self.places.nodes.get(predicate), self.scenario.predicates.get(predicate))
        else {
            return Truths::OPEN;
        };
        if of.unit == Unit::Truth {
            let truths = self.condition(node);
            return Truths { fails: truths.fails || self.lacks(node), ..truths };
        }
        if self.lacks(node) {
            return Truths { holds: false, fails: true };
        }
        let range = self.range(node);
        // A signal may be absent at times; a person who is played has a true position at every tick.
        Truths { holds: range.high >= 0.0, fails: range.low < 0.0 || self.reads_signals(node) }
    }

    /// Range of a number at all ticks.
    pub fn range(&self, node: usize) -> Interval {
        Ranges::new(self.context, &[node], &self.pins).at(node)
    }

    /// Possible results of a truth value of the machine; one without a value neither holds nor fails.
    pub(super) fn condition(&self, node: usize) -> Truths {
        match self.context.graph.ops()[node] {
            Op::Neg(a) => {
                let of = self.condition(a);
                Truths { holds: of.fails, fails: of.holds }
            }
            Op::Select(a, b, c) if c == a => {
                let (a, b) = (self.condition(a), self.condition(b));
                Truths { holds: a.holds && b.holds, fails: a.fails || (a.holds && b.fails) }
            }
            Op::Select(a, b, c) if b == a => {
                let (a, c) = (self.condition(a), self.condition(c));
                Truths { holds: a.holds || (a.fails && c.holds), fails: a.fails && c.fails }
            }
            Op::Less(..) | Op::LessEqual(..) if self.lacks(node) => Truths { holds: false, fails: false },
            _ => {
                let range = self.range(node);
                Truths { holds: range.high > 0.0, fails: range.low <= 0.0 }
            }
        }
    }

    /// True if a number has no value at any tick: a signal that it needs is never sent.
    fn lacks(&self, node: usize) -> bool {
        self.needed(node).into_iter().any(|signal| !self.sent[signal])
    }

    /// Signals whose value a number needs. A choice, a minimum or a maximum may have a value without one of its operands.
    pub fn needed(&self, node: usize) -> BTreeSet<usize> {
        let interface = &self.program.interface;
        let (mut open, mut seen, mut out) = (vec![node], BTreeSet::new(), BTreeSet::new());
        while let Some(n) = open.pop() {
            if !seen.insert(n) {
                continue;
            }
            match self.context.graph.ops()[n] {
                Op::Signal(k) if k < interface.width() => {
                    let of = interface.signal_of(k).map(|s| (s, &interface.signals[s]));
                    out.extend(of.filter(|(_, of)| k != of.at && k != of.known_at()).map(|(s, _)| s));
                }
                Op::Select(..) | Op::Min(..) | Op::Max(..) | Op::Trajectory(_) => {}
                Op::State(_) => open.extend(self.context.graph.reads(n)),
                op => open.extend(op.operands().into_iter().flatten()),
            }
        }
        out
    }

    /// True if a number depends on a signal that is no point of a person.
    fn reads_signals(&self, node: usize) -> bool {
        let interface = &self.program.interface;
        self.context.needed(&[node]).into_iter().any(|n| match self.context.graph.ops()[n] {
            Op::Signal(k) if k < interface.width() => {
                interface.signal_of(k).is_none_or(|s| !interface.signals[s].is_of_person())
            }
            _ => false,
        })
    }
}
