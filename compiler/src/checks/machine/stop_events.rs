//! Events of the host that stop the robot in some states and are lost in others, in which it moves.

use std::collections::BTreeSet;

use dsl::{Diagnostic, Help, Snippet};
use runtime::program::{FaultPattern, Trigger};

use super::Checked;
use super::fault_answers::moves;

impl Checked<'_> {
    /// Warns of an event that leads where any fault leads, and that one state in which the robot moves does not wait for.
    pub(super) fn stop_events(&self, diagnostics: &mut Vec<Diagnostic>) {
        let m = self.machine;
        let of_faults: BTreeSet<usize> = (m.states.iter().flat_map(|s| &s.transitions))
            .filter(|t| t.trigger == Trigger::Fault(FaultPattern::Any))
            .map(|t| m.leaf(t.target))
            .collect();
        let raised: BTreeSet<usize> =
            m.actions.iter().flat_map(|a| a.outcomes.iter().map(|o| o.1).chain(a.event)).collect();
        let work = self.reached_without_faults();
        for event in (0..self.places.declared_events).filter(|e| !raised.contains(e)) {
            let waiting: Vec<(usize, usize)> =
                self.reached.iter().filter_map(|&s| Some((s, self.on(s, event)?))).collect();
            let stops = |&(s, i): &(usize, usize)| of_faults.contains(&m.leaf(m.states[s].transitions[i].target));
            let Some(&(s, i)) = waiting.first().filter(|_| waiting.iter().all(stops)) else { continue };
            let deaf = |&l: &usize| {
                let innermost = m.states[l].initial.is_none() && work.contains(&l) && !of_faults.contains(&l);
                innermost && !m.ends(l) && !self.hears(l, event)
            };
            let found = self.reached.iter().copied().filter(deaf);
            let mut moving = found.filter(|&l| m.stack(l).is_some_and(|stack| moves(self.program, self.stacks, stack)));
            // Several states without the event are no oversight.
            let (Some(missing), None) = (moving.next(), moving.next()) else { continue };
            let at = self.places.states[missing];
            if diagnostics.iter().any(|d| d.code == "HQ0716" && d.primary.span == at) {
                continue;
            }
            let name = &self.program.interface.events[event];
            let to = self.name(m.states[s].transitions[i].target);
            let text = format!("state `{}` does not wait for the event `{name}`", self.name(missing));
            diagnostics.push(
                Diagnostic::warning("HQ0716", at, text)
                    .label(self.places.transitions[s][i].trigger, format!("this stops the robot, in `{}`", self.name(s)))
                    .note(format!(
                        "`{name}` leads where every fault leads, to `{to}`; where no transition waits for it, it is lost, and the \
                         robot continues to move"
                    ))
                    .help(Help::with("write {} once, in the machine", [Snippet::transition(name, to)])),
            );
        }
    }
}
