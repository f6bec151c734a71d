//! Two states that are left at one threshold of a measured value, each for the other one: the noise of the value crosses it in
//! both directions.

use std::collections::BTreeSet;

use dsl::{Diagnostic, Help, Snippet};
use runtime::program::Trigger;

use super::Checked;
use crate::analysis::conditions::{Formula, Key, Relation};
use crate::analysis::exploration::{Cycle, Way};

/// A comparison that alone triggers a transition.
struct Threshold {
    variable: usize,
    above: bool,
    at: f64,
}

impl Checked<'_> {
    /// Warns of pairs of transitions without a gap between their thresholds. Those of `cycles` are reported as such.
    pub(super) fn hysteresis(&self, cycles: &[Cycle], diagnostics: &mut Vec<Diagnostic>) {
        let cyclic: BTreeSet<Way> = cycles.iter().flat_map(|c| c.steps.iter().map(|s| s.1)).collect();
        for &s in &self.reached {
            for i in 0..self.machine.states[s].transitions.len() {
                let Some(there) = self.threshold(s, i) else { continue };
                let target = self.machine.leaf(self.machine.states[s].transitions[i].target);
                let back = self.machine.path(target).filter(|&p| p != 0).find_map(|p| {
                    let all = 0..self.machine.states[p].transitions.len();
                    all.into_iter().find(|&k| self.leads_back(p, k, s, &there)).map(|k| (p, k))
                });
                let Some((p, k)) = back.filter(|(p, k)| (s, i) < (*p, *k)) else { continue };
                if cyclic.contains(&Way { state: s, index: i }) {
                    continue;
                }
                let text = format!("`{}` and `{}` are left at the same threshold", self.name(s), self.name(target));
                diagnostics.push(
                    Diagnostic::warning("HQ0724", self.places.transitions[s][i].trigger, text)
                        .here(format!("leads to `{}`", self.name(target)))
                        .label(self.places.transitions[p][k].trigger, format!("leads back to `{}`", self.name(s)))
                        .note(
                            "a measured value is noisy: near the threshold the machine changes its state with nearly every \
                             reading",
                        )
                        .help(Help::with(
                            "leave a gap between both thresholds (hysteresis), or let one of the conditions hold for a time, {}",
                            [Snippet::each("when CONDITION for 0.5 s -> STATE", "{ when: CONDITION, for: 0.5 s, to: STATE }")],
                        )),
                );
            }
        }
    }

    /// True for a transition into `state` at the opposite side of the same threshold.
    fn leads_back(&self, from: usize, index: usize, state: usize, there: &Threshold) -> bool {
        let leaf = self.machine.leaf(self.machine.states[from].transitions[index].target);
        self.machine.path(leaf).any(|p| p == state)
            && self
                .threshold(from, index)
                .is_some_and(|back| back.variable == there.variable && back.at == there.at && back.above != there.above)
    }

    /// The comparison of a measured number that triggers a transition at once.
    fn threshold(&self, state: usize, index: usize) -> Option<Threshold> {
        let at_once =
            matches!(self.machine.states[state].transitions[index].trigger, Trigger::When { hold, .. } if hold == 0.0);
        let (formula, turned) = match self.conditions.triggers[state][index].as_ref()? {
            Formula::Not(inner) => (inner.as_ref(), true),
            other => (other, false),
        };
        let Formula::Compare(variable, relation, at) = formula else { return None };
        let is_number = matches!(self.conditions.variables[*variable].key, Key::Number(_));
        let above = matches!(relation, Relation::Greater | Relation::GreaterEqual) != turned;
        (at_once && is_number && self.is_measured(*variable)).then_some(Threshold {
            variable: *variable,
            above,
            at: *at,
        })
    }
}
