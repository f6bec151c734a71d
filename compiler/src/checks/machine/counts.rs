//! Conditions that no value of the variables meets in any state where they are examined: a number of attempts that is reset
//! before it is compared.

use std::collections::BTreeSet;

use dsl::Diagnostic;
use names::list;
use runtime::program::{MachineAction, Trigger};
use runtime::text::number;

use super::{Checked, is_fault};
use crate::analysis::conditions::{Key, Leaf, Value};
use crate::analysis::exploration::{Exploration, Refusal, Way};

/// Largest number of values that are named.
const NAMED: usize = 4;

impl Checked<'_> {
    /// Warns of conditions on variables that all assignments of the machine exclude.
    pub(super) fn counts(&self, diagnostics: &mut Vec<Diagnostic>) {
        for &state in &self.reached {
            for index in 0..self.machine.states[state].transitions.len() {
                if let Some(values) = self.excluded(Way { state, index }) {
                    diagnostics.push(self.never_met(Way { state, index }, &values));
                }
            }
        }
    }

    /// For a condition on variables alone that is never met although the machine can leave the states where it is examined:
    /// the value that it reads, if it is a number, at all visits. `None` for other transitions.
    pub(super) fn excluded(&self, way: Way) -> Option<Vec<f64>> {
        let explored = self.exploration?;
        let transition = &self.machine.states[way.state].transitions[way.index];
        let Some(formula) = &self.conditions.triggers[way.state][way.index] else { return None };
        if !matches!(transition.trigger, Trigger::When { .. }) || self.is_dead(way.state, way.index) {
            return None;
        }
        let mut read = Vec::new();
        formula.variables(&mut read);
        let set = self.assigned();
        let of_set = |v: usize| {
            let leaves = &self.conditions.variables[v].leaves.all;
            !leaves.is_empty() && leaves.iter().all(|l| matches!(l, Leaf::Signal(s, _) if set.contains(s)))
        };
        let counts = read.iter().any(|&v| matches!(self.conditions.variables[v].key, Key::Number(_)));
        if !counts || !read.iter().all(|&v| of_set(v)) {
            return None;
        }
        let leaves: Vec<usize> =
            explored.leaves().into_iter().filter(|&l| self.machine.path(l).any(|p| p == way.state)).collect();
        let mut numbers = BTreeSet::new();
        for &leaf in &leaves {
            if explored.nodes_of(leaf).any(|n| explored.steps[n].iter().any(|s| s.way == way))
                || explored.refusal(leaf, way) != Refusal::Condition
                || !self.is_left(explored, leaf)
            {
                return None;
            }
            for n in explored.nodes_of(leaf) {
                for &v in &read {
                    match explored.values_at(n)[v] {
                        Some(Value::Number(x)) => {
                            numbers.insert(x.to_bits());
                        }
                        Some(_) => {}
                        None => return None,
                    }
                }
            }
        }
        (!leaves.is_empty()).then(|| {
            let mut values: Vec<f64> = numbers.into_iter().map(f64::from_bits).collect();
            values.sort_by(f64::total_cmp);
            values
        })
    }

    /// True for an innermost state that the machine leaves; one that it does not is reported as a whole.
    fn is_left(&self, explored: &Exploration, leaf: usize) -> bool {
        let trigger = |way: Way| &self.machine.states[way.state].transitions[way.index].trigger;
        explored.nodes_of(leaf).any(|n| explored.steps[n].iter().any(|s| !is_fault(trigger(s.way))))
    }

    fn never_met(&self, way: Way, values: &[f64]) -> Diagnostic {
        let place = &self.places.transitions[way.state][way.index];
        let mut d = Diagnostic::warning("HQ0706", place.trigger, "this condition never holds");
        let formula = self.conditions.triggers[way.state][way.index].as_ref();
        let mut read = Vec::new();
        formula.into_iter().for_each(|f| f.variables(&mut read));
        let signals: BTreeSet<usize> = (read.iter())
            .flat_map(|&v| &self.conditions.variables[v].leaves.all)
            .filter_map(|l| if let Leaf::Signal(s, _) = l { Some(*s) } else { None })
            .collect();
        for (a, action) in self.machine.actions.iter().enumerate() {
            if let Some(MachineAction::Set { variable, .. } | MachineAction::Clear(variable)) = &action.own
                && signals.contains(variable)
            {
                let name = &self.program.interface.signals[*variable].name;
                d = d.label(self.places.actions[a], format!("changes `{name}`"));
            }
        }
        let state = self.name(way.state);
        let note = match values {
            [] => format!("all ways to `{state}` give the variables other values"),
            [one] => format!("in `{state}` the compared value is always {}", number(*one)),
            all => {
                let words: Vec<String> = all.iter().map(|x| number(*x)).collect();
                format!("in `{state}` the compared value is one of {}", list(words.iter().map(String::as_str), NAMED))
            }
        };
        d.note(note)
            .help("change the variable where no loop passes again before the comparison, or correct the comparison")
    }
}
