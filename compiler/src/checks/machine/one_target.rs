//! Success and failure that lead to the same state: the failure of an action, and a time-out of a measured condition before an
//! action that relies on it. A time-out beside a reached target is usual: the robot is then nearly there.

use std::collections::BTreeSet;

use dsl::Diagnostic;
use runtime::program::Trigger;

use super::Checked;
use crate::analysis::conditions::Leaf;

/// Verbs of actions on objects: the next state relies on their success.
pub(super) const ON_OBJECTS: [&str; 3] = ["gripper", "tool", "capture"];

impl Checked<'_> {
    /// Warns of failures and time-outs that lead where success leads.
    pub(super) fn one_target(&self, diagnostics: &mut Vec<Diagnostic>) {
        for &s in &self.reached {
            self.failed_as_done(s, diagnostics);
            self.late_as_measured(s, diagnostics);
        }
    }

    /// Warns of an action on an object whose failure leads to the same state as its success.
    fn failed_as_done(&self, s: usize, diagnostics: &mut Vec<Diagnostic>) {
        let state = &self.machine.states[s];
        for &action in state.enter.iter().chain(&state.activities) {
            let asked = &self.machine.actions[action];
            let [(_, done), (_, failed)] = asked.outcomes.as_slice() else { continue };
            if !ON_OBJECTS.contains(&asked.verb.as_str()) {
                continue;
            }
            let own = self.own(s);
            let on = |event: usize| own.iter().find_map(|&p| Some((p, self.on(p, event)?)));
            let (Some((at, i)), Some((other, k))) = (on(*done), on(*failed)) else { continue };
            let target = self.machine.leaf(self.machine.states[at].transitions[i].target);
            if self.machine.leaf(self.machine.states[other].transitions[k].target) != target || !self.relies(target) {
                continue;
            }
            let (success, failure) = (&self.program.interface.events[*done], &self.program.interface.events[*failed]);
            let text = format!("`{failure}` counts as `{success}`: both lead to `{}`", self.name(target));
            diagnostics.push(
                Diagnostic::warning("HQ0723", self.places.transitions[other][k].trigger, text)
                    .label(self.places.transitions[at][i].trigger, "success leads there")
                    .label(self.places.actions[action], "this action may fail")
                    .note(format!("`{}` goes on as if the action had succeeded", self.name(target)))
                    .help(
                        "let the failure lead to a state that handles it; if it does not matter, lead there through a state \
                         that says so, with `log`",
                    ),
            );
        }
    }

    /// Warns of a time that leads to the same state as a measured condition, if that state then acts on an object.
    fn late_as_measured(&self, s: usize, diagnostics: &mut Vec<Diagnostic>) {
        let transitions = &self.machine.states[s].transitions;
        for (k, late) in transitions.iter().enumerate().filter(|(_, t)| matches!(t.trigger, Trigger::After(_))) {
            let target = self.machine.leaf(late.target);
            if self.is_dead(s, k) || !self.relies(target) || !self.acts(target) {
                continue;
            }
            let same = |i: &usize| self.machine.leaf(transitions[*i].target) == target && !self.is_dead(s, *i);
            let Some(i) = (0..transitions.len()).filter(same).find(|&i| self.measures(s, i)) else { continue };
            let place = &self.places.transitions[s];
            let name = self.name(target);
            let text = format!("a time-out counts as success: this time leads to `{name}` too");
            diagnostics.push(
                Diagnostic::warning("HQ0723", place[k].trigger, text)
                    .label(place[i].trigger, "success leads there")
                    .note(format!("`{name}` acts as if this had happened, also where it has not"))
                    .help("let the time lead to a state that handles the missing success"),
            );
        }
    }

    /// True for a state that relies on the success of what led to it: it is not final, and does not examine a signal itself.
    fn relies(&self, leaf: usize) -> bool {
        let examines = |p: usize| (0..self.machine.states[p].transitions.len()).any(|i| self.measures(p, i));
        !self.machine.ends(leaf) && !self.machine.path(leaf).filter(|&p| p != 0).any(examines)
    }

    /// True for a state that asks for an action on an object.
    fn acts(&self, leaf: usize) -> bool {
        let asked = self.machine.path(leaf).flat_map(|p| {
            let state = &self.machine.states[p];
            state.enter.iter().chain(&state.activities)
        });
        asked.into_iter().any(|&a| ON_OBJECTS.contains(&self.machine.actions[a].verb.as_str()))
    }

    /// True for a transition at a condition on a number or a truth value that the controller does not set itself.
    pub(super) fn measures(&self, state: usize, index: usize) -> bool {
        let transition = &self.machine.states[state].transitions[index];
        let Some(formula) = &self.conditions.triggers[state][index] else { return false };
        let mut read = Vec::new();
        formula.variables(&mut read);
        matches!(transition.trigger, Trigger::When { .. }) && read.into_iter().any(|v| self.is_measured(v))
    }

    /// True for a value of a condition that depends on a signal of the host, or on an output of a task.
    pub(super) fn is_measured(&self, variable: usize) -> bool {
        let set = self.assigned();
        self.conditions.variables[variable].leaves.all.iter().any(|leaf| match leaf {
            Leaf::Signal(signal, _) => {
                let of = &self.program.interface.signals[*signal];
                of.variable.as_ref().is_none_or(|initial| initial.value.is_none() && !set.contains(signal))
            }
            _ => false,
        })
    }

    /// Variables that actions change.
    pub(super) fn assigned(&self) -> BTreeSet<usize> {
        use runtime::program::MachineAction::{Clear, Set, Tare};
        let own = self.machine.actions.iter().filter_map(|a| a.own.as_ref());
        own.filter_map(|own| match own {
            Set { variable, .. } | Clear(variable) => Some(*variable),
            Tare(_) => None,
        })
        .collect()
    }
}
