//! Final states: transitions out of them, which are never taken, and final states in which the robot moves although a
//! transition of a state around them answers an event or a condition.

use dsl::{Diagnostic, Help, Snippet};
use runtime::program::{Subject, TransitionProgram, Trigger};

use super::Checked;
use super::fault_answers::moves;

impl Checked<'_> {
    /// Warns of transitions out of final states, and of motion in final states that nothing interrupts.
    pub(super) fn finals(&self, diagnostics: &mut Vec<Diagnostic>) {
        if self.program.run.subject != Subject::Machine {
            return;
        }
        for (s, state) in self.machine.states.iter().enumerate().filter(|(s, _)| self.machine.ends(*s)) {
            for (i, t) in state.transitions.iter().enumerate().filter(|(_, t)| !self.machine.permits(s, s, t)) {
                diagnostics.push(self.never_leaves(s, i, t));
            }
            if self.reached.contains(&s) && state.initial.is_none() {
                diagnostics.extend(self.moving_end(s));
            }
        }
    }

    /// Warns of transitions out of the final states of a region.
    pub(super) fn region_finals(&self, diagnostics: &mut Vec<Diagnostic>) {
        for &s in &self.elsewhere.ends {
            for (i, t) in self.machine.states[s].transitions.iter().enumerate() {
                if !self.ends(self.machine.leaf(t.target)) {
                    diagnostics.push(self.never_leaves(s, i, t));
                }
            }
        }
    }

    /// Warning of a transition of a final state to one that is not.
    fn never_leaves(&self, s: usize, i: usize, t: &TransitionProgram) -> Diagnostic {
        let place = &self.places.transitions[s][i];
        let of = self.machine.path(s).find(|&p| self.machine.states[p].is_final).unwrap_or(s);
        let text = format!("`{}` is final, and a final state is left only for another one", self.name(of));
        Diagnostic::warning("HQ0706", place.trigger, "this transition is never taken")
            .label(place.target, format!("`{}` is not final", self.name(t.target)))
            .note(text)
            .help("remove it, or remove `final`")
    }

    /// Warning of an innermost final state in which the robot moves, and where transitions of states around it are not
    /// taken. A fault without a transition stops the robot; times and targets do not protect anybody.
    fn moving_end(&self, leaf: usize) -> Option<Diagnostic> {
        let m = self.machine;
        let answers = |t: &TransitionProgram| matches!(t.trigger, Trigger::Event(_) | Trigger::When { .. });
        let mut around = m.path(leaf).filter(|&s| !m.ends(s)).flat_map(|s| {
            let all = m.states[s].transitions.iter().enumerate();
            let lost = all.filter(move |(i, t)| answers(t) && !m.permits(leaf, s, t) && !self.is_dead(s, *i));
            lost.map(move |(i, t)| (self.places.transitions[s][i].trigger, t.target))
        });
        let (trigger, target) = around.next()?;
        let stack = m.stack(leaf).filter(|&stack| moves(self.program, self.stacks, stack))?;
        let at = m.owner(leaf).and_then(|owner| self.places.stacks[owner]).unwrap_or(self.places.states[leaf]);
        let (name, stack) = (self.name(leaf), &self.program.stacks[stack].name);
        Some(
            Diagnostic::warning("HQ0728", at, format!("`{name}` is final, and `{stack}` moves the robot there"))
                .label(trigger, format!("not taken in `{name}`: `{}` is not final", self.name(target)))
                .note("a final state is left only for another final state, so this reaction ends with the machine")
                .help(Help::with(
                    "let the robot arrive in a state that is not final, and end the machine after it: {}",
                    [Snippet::transition("reached(TASK, TOLERANCE)", name)],
                )),
        )
    }
}
