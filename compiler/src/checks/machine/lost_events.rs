//! Events that the machine raises itself and that no transition waits for at the next tick, the only one at which they
//! are seen.

use std::collections::BTreeSet;

use dsl::{Diagnostic, Help, Snippet};
use names::list;
use runtime::program::Trigger;

use super::Checked;

impl Checked<'_> {
    /// Warns of `emit` where the machine then is in no state that waits for the event.
    pub(super) fn lost_events(&self, diagnostics: &mut Vec<Diagnostic>) {
        for &s in &self.reached {
            let state = &self.machine.states[s];
            let entered = state.enter.iter().chain(&state.activities).map(|&a| (a, self.leaves(s).collect()));
            let left = state.exit.iter().map(|&a| (a, self.after_leaving(s)));
            for (action, next) in entered.chain(left).collect::<Vec<(usize, BTreeSet<usize>)>>() {
                let Some(event) = self.machine.actions[action].event else { continue };
                if next.is_empty() || next.iter().any(|&leaf| self.hears(leaf, event)) {
                    continue;
                }
                let name = &self.program.interface.events[event];
                let there = list(next.iter().map(|&l| self.name(l)), 4);
                let text = format!("the event `{name}` is lost: nothing waits for it when it is raised");
                let note = match next.len() {
                    1 => format!("it is seen at the next tick only, when the machine is in {there}"),
                    _ => format!("it is seen at the next tick only, when the machine is in one of {there}"),
                };
                let mut d = Diagnostic::warning("HQ0715", self.places.actions[action], text);
                if let Some(at) = self.waits_for(event) {
                    d = d.label(at, "this transition is not examined then");
                }
                diagnostics.push(d.note(note).help(Help::with(
                    "wait for it there, {}, or raise it on entering the state that waits for it",
                    [Snippet::transition(name, "STATE")],
                )));
            }
        }
    }

    /// Innermost states in which the machine can be at the tick after it has left `state`.
    fn after_leaving(&self, state: usize) -> BTreeSet<usize> {
        let m = self.machine;
        let mut next = BTreeSet::new();
        for leaf in self.leaves(state) {
            for source in m.path(leaf) {
                for (i, t) in m.states[source].transitions.iter().enumerate() {
                    // The innermost state that contains both the transition and its target is not left.
                    let stays = |s: usize| s != t.target && m.path(t.target).any(|p| p == s);
                    let kept = m.path(source).find(|&s| stays(s)).unwrap_or(0);
                    if !m.path(kept).any(|p| p == state) && !self.is_dead(source, i) {
                        next.insert(m.leaf(t.target));
                    }
                }
            }
        }
        next
    }

    /// True if a transition that is examined in this innermost state waits for the event.
    pub(super) fn hears(&self, leaf: usize, event: usize) -> bool {
        self.elsewhere.awaited.contains(&event) || self.machine.path(leaf).any(|s| self.on(s, event).is_some())
    }

    /// First transition of a state that waits for the event.
    pub(super) fn on(&self, state: usize, event: usize) -> Option<usize> {
        self.machine.states[state].transitions.iter().position(|t| t.trigger == Trigger::Event(event))
    }

    /// Trigger of the first transition that waits for the event.
    fn waits_for(&self, event: usize) -> Option<dsl::Span> {
        let of = |s: usize| self.on(s, event).map(|i| self.places.transitions[s][i].trigger);
        (0..self.machine.states.len()).find_map(of)
    }
}
