//! States between which the machine goes back and forth at every tick while no value changes.

use std::collections::BTreeMap;

use dsl::{Diagnostic, Help, Snippet};
use names::list;

use super::Checked;
use crate::analysis::conditions::{Conditions, Key, Leaf, Value};
use crate::analysis::exploration::{Cycle, Way};
use crate::analysis::value_ranges::{RangeContext, Ranges};
use crate::analysis::wording::described;
use crate::expr::{Graph, Interval};

/// Ranges of the values of conditions that depend on the robot's state, within the limits of its joints.
pub(super) fn ranges(conditions: &Conditions, context: &RangeContext) -> BTreeMap<usize, Interval> {
    let mut out = BTreeMap::new();
    for (v, of) in conditions.variables.iter().enumerate() {
        let (Key::Number(terms), true) = (&of.key, of.leaves.all.iter().any(|l| matches!(l, Leaf::State(_)))) else {
            continue;
        };
        let nodes: Vec<usize> = terms.iter().map(|t| t.0.node).filter(|&n| n < context.graph.ops().len()).collect();
        let ranges = Ranges::new(context, &nodes, &BTreeMap::new());
        let sum = terms.iter().filter(|t| nodes.contains(&t.0.node)).fold(Interval::point(0.0), |sum, (t, factor)| {
            sum.plus(ranges.at(t.node).by(Interval::point(f64::from_bits(*factor))))
        });
        out.insert(v, sum);
    }
    out
}

impl Checked<'_> {
    /// Warns of cycles of transitions that all hold at the same values.
    pub(super) fn flips(&self, cycles: &[Cycle], graph: &Graph, diagnostics: &mut Vec<Diagnostic>) {
        for cycle in cycles {
            let names: Vec<String> = cycle.steps.iter().map(|s| format!("`{}`", self.name(s.0))).collect();
            let text = match names.as_slice() {
                [one] => format!("{one} is entered again at every tick"),
                [a, b] => format!("the machine goes back and forth between {a} and {b} at every tick"),
                _ => format!(
                    "the machine goes round {} at every tick",
                    list(cycle.steps.iter().map(|s| self.name(s.0)), 6)
                ),
            };
            let at = |way: Way| self.places.transitions[way.state][way.index].trigger;
            let (first, others) = (cycle.steps[0], &cycle.steps[1..]);
            let leads = |way: Way| {
                let target = self.machine.states[way.state].transitions[way.index].target;
                format!("leads to `{}`", self.name(self.machine.leaf(target)))
            };
            let mut d = Diagnostic::warning("HQ0720", at(first.1), text).here(leads(first.1));
            for (_, way) in others {
                d = d.label(at(*way), leads(*way));
            }
            // The presence of a signal follows from its value.
            let present = |v: usize, x: Value| {
                let key = &self.conditions.variables[v].key;
                matches!(key, Key::Present(_)) && x == Value::Truth(true) && cycle.values.len() > 1
            };
            let values: Option<Vec<String>> = (cycle.values.iter())
                .filter(|&&(v, x)| x != Value::Absent && !present(v, x))
                .map(|&(v, x)| described(&self.conditions.variables[v].key, x, graph, self.program))
                .collect();
            let when = match values.filter(|v| !v.is_empty()) {
                None if cycle.values.is_empty() => {
                    "each happens at the tick after the other, at any values".to_string()
                }
                None => "these conditions can hold together".to_string(),
                Some(values) => format!("these conditions hold together, for instance for {}", values.join(", ")),
            };
            diagnostics.push(d.note(format!("{when}: the stack, its blend and `t` restart at every tick")).help(Help::with(
                "leave a gap between the conditions (hysteresis), let one of them hold for a time, {}, or wait for an event",
                [Snippet::each("when CONDITION for 0.5 s -> STATE", "{ when: CONDITION, for: 0.5 s, to: STATE }")],
            )));
        }
    }
}
