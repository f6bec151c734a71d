//! Conditions on outputs of tasks, in states whose stacks do not contain the task.

use std::collections::BTreeSet;

use dsl::Diagnostic;
use runtime::program::Trigger;

use super::Checked;

impl Checked<'_> {
    /// Returns the task whose output is this signal; `None` for other signals.
    pub(super) fn task_of_output(&self, signal: usize) -> Option<usize> {
        let (task, output) = self.program.interface.signals.get(signal)?.name.rsplit_once('.')?;
        self.program.tasks.iter().position(|t| {
            t.name == task && stdlib_tasks::find(&t.kind).is_some_and(|k| k.outputs.iter().any(|o| o.name == output))
        })
    }

    /// Warns of task outputs that are absent in every state in which a transition waits for them.
    pub(super) fn task_outputs(&self, diagnostics: &mut Vec<Diagnostic>) {
        for &s in &self.reached {
            let leaves = self.reached.iter().copied().filter(|&l| self.machine.states[l].initial.is_none());
            let inside: Vec<usize> = leaves.filter(|&l| self.machine.path(l).any(|p| p == s)).collect();
            let runs = |task: usize| inside.iter().any(|&l| self.runs(l, task));
            for (i, t) in self.machine.states[s].transitions.iter().enumerate() {
                let Trigger::When { condition, .. } = &t.trigger else { continue };
                let read: BTreeSet<usize> = condition.inputs.iter().copied().collect();
                let signals = self.program.values.tape.only(&read).signals();
                let tasks =
                    signals.into_iter().filter_map(|at| self.task_of_output(self.program.interface.signal_of(at)?));
                let silent = tasks.into_iter().find(|&task| !runs(task) && !inside.is_empty());
                let Some(task) = silent else { continue };
                let name = &self.program.tasks[task].name;
                let text = format!("`{name}` does not run in state `{}`, so it has no outputs there", self.name(s));
                let mut d = Diagnostic::warning("HQ0713", self.places.transitions[s][i].trigger, text);
                if let Some(at) = self.places.stacks[s] {
                    d = d.label(at, format!("this stack does not contain `{name}`"));
                }
                diagnostics.push(
                    d.note("a comparison with an absent value is false")
                        .help(format!("add `{name}` to the state's stack, on the level where the other stack has it")),
                );
            }
        }
    }
}
