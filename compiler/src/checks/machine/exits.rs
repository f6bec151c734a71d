//! States that can be entered and never left, although they have transitions: in all that the machine can do, none of
//! them is taken.

use dsl::{Diagnostic, Help, Snippet};
use runtime::program::Trigger;

use super::{Checked, is_fault};
use crate::analysis::exploration::{Refusal, Way};

/// Largest number of transitions that are explained.
const EXPLAINED: usize = 4;

impl Checked<'_> {
    /// Warns of innermost states that are entered and whose transitions are never taken.
    pub(super) fn no_exit_possible(&self, diagnostics: &mut Vec<Diagnostic>) {
        let Some(explored) = self.exploration else { return };
        for leaf in explored.leaves() {
            let left = explored.nodes_of(leaf).any(|n| {
                let exits = explored.steps[n].iter();
                exits.into_iter().any(|s| !is_fault(self.trigger(s.way)))
            });
            // A state without a transition that could hold was reported.
            if self.ends(leaf) || left || !self.has_exit(leaf) {
                continue;
            }
            let text = format!("state `{}` is entered and never left", self.name(leaf));
            let mut d = Diagnostic::warning("HQ0719", self.places.states[leaf], text);
            let ways = explored.ways(leaf).into_iter().filter(|w| !is_fault(self.trigger(*w)));
            for way in ways.take(EXPLAINED) {
                let at = self.places.transitions[way.state][way.index].trigger;
                d = d.label(at, self.reason(leaf, way, explored.refusal(leaf, way)));
            }
            diagnostics.push(d.note("none of its transitions can be taken while the machine is in it").help(
                Help::with(
                    "correct a transition, add a time, {}, or declare the state as final",
                    [Snippet::each("after 10 s -> STATE", "{ after: 10 s, to: STATE }")],
                ),
            ));
        }
    }

    fn trigger(&self, way: Way) -> &Trigger {
        &self.machine.states[way.state].transitions[way.index].trigger
    }

    /// Reason why a transition is not taken in an innermost state.
    fn reason(&self, leaf: usize, way: Way, refusal: Refusal) -> String {
        match (refusal, self.trigger(way)) {
            (Refusal::Event, Trigger::Event(e)) => {
                format!("nothing raises `{}` here", self.program.interface.events[*e])
            }
            (Refusal::Active, _) => {
                let target = self.machine.states[way.state].transitions[way.index].target;
                format!("the machine is in `{}` already", self.name(target))
            }
            (Refusal::Task, _) => format!("the task does not run in `{}`", self.name(leaf)),
            (Refusal::Condition, _) => "this never holds here".to_string(),
            _ => "another transition always takes precedence".to_string(),
        }
    }
}
