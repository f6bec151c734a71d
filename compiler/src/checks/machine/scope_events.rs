//! Events of the host that all states beside one another wait for, to go to the same state, but for one of them.

use dsl::{Diagnostic, Help, Snippet};
use runtime::program::Trigger;
use stdlib_tasks::task::RowKind;

use super::Checked;

/// Number of states that wait for the event, from which on the state that does not is an exception.
const MANY: usize = 3;

impl Checked<'_> {
    /// Warns of a state in which the robot moves and that does not wait for an event, although all states beside it do.
    pub(super) fn scope_events(&self, diagnostics: &mut Vec<Diagnostic>) {
        let m = self.machine;
        let raised: Vec<usize> = m.actions.iter().flat_map(|a| a.outcomes.iter().map(|o| o.1).chain(a.event)).collect();
        for event in (0..self.program.interface.events.len()).filter(|e| !raised.contains(e)) {
            for scope in self.reached.iter().copied().filter(|&s| m.states[s].initial.is_some()) {
                if self.hears(scope, event) {
                    continue;
                }
                let children: Vec<usize> =
                    self.reached.iter().copied().filter(|&s| m.states[s].parent == Some(scope)).collect();
                let waiting: Vec<(usize, usize)> =
                    children.iter().filter_map(|&s| Some((s, self.on(s, event)?))).collect();
                let target = |&(s, i): &(usize, usize)| m.states[s].transitions[i].target;
                let Some(to) = waiting.first().map(target) else { continue };
                if waiting.len() < MANY || waiting.iter().any(|w| target(w) != to) {
                    continue;
                }
                let other = |s: &usize| !waiting.iter().any(|w| w.0 == *s) && *s != to && !m.states[*s].is_final;
                let mut others = children.iter().copied().filter(other);
                let (Some(missing), None) = (others.next(), others.next()) else { continue };
                let inside = |s: usize| m.states[s].transitions.iter().any(|t| t.trigger == Trigger::Event(event));
                if self.leaves(missing).any(|l| m.path(l).take_while(|&p| p != scope).any(inside))
                    || !self.leaves(missing).any(|l| m.stack(l).is_some_and(|stack| self.has_targets(stack)))
                {
                    continue;
                }
                let name = &self.program.interface.events[event];
                let (s, i) = waiting[0];
                let text = format!("state `{}` does not wait for the event `{name}`", self.name(missing));
                let outer = match scope {
                    0 => "the machine".to_string(),
                    _ => format!("`{}`", self.name(scope)),
                };
                diagnostics.push(
                    Diagnostic::warning("HQ0716", self.places.states[missing], text)
                        .label(
                            self.places.transitions[s][i].trigger,
                            format!("the {} states beside it do, and go to `{}`", waiting.len(), self.name(to)),
                        )
                        .note("an event that no transition waits for is lost, and the robot continues to move")
                        .help(Help::with(
                            &format!(
                                "write {{}} once, in {outer}; if the exception is meant, put the other states into a \
                                 state with this transition"
                            ),
                            [Snippet::transition(name, self.name(to))],
                        )),
                );
            }
        }
    }

    fn has_targets(&self, stack: usize) -> bool {
        let members = self.program.stacks[stack].levels.iter().flat_map(|l| &l.members);
        let kind = |task: usize| stdlib_tasks::find(&self.program.tasks[task].kind).map(|k| k.row_kind);
        members.into_iter().any(|m| kind(m.task) == Some(RowKind::Equality))
    }
}
