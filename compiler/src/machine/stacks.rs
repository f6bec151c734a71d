//! What changes between the stacks of a machine: limits that are dropped, and velocities that jump.

use std::collections::{BTreeMap, BTreeSet};

use dsl::Diagnostic;
use runtime::program::Program;
use stdlib_tasks::task::Nature;

use super::{Checked, is_dead, is_fault};
use crate::accelerations::AccelerationBounds;
use crate::names::list;

impl Checked<'_> {
    pub(super) fn stacks(&self, diagnostics: &mut Vec<Diagnostic>) {
        self.dropped(diagnostics);
        self.jumps(diagnostics);
    }

    /// Limits of hard levels that some states keep and others do not.
    fn dropped(&self, diagnostics: &mut Vec<Diagnostic>) {
        let owners: Vec<usize> =
            self.reached.iter().copied().filter(|&s| self.machine.states[s].stack.is_some()).collect();
        let kept = |s: usize| -> BTreeSet<usize> {
            let Some(stack) = self.machine.states[s].stack else { return BTreeSet::new() };
            let levels = self.program.stacks[stack].levels.iter().filter(|l| l.hard);
            let tasks = levels.flat_map(|l| &l.members).map(|m| m.task);
            tasks.filter(|&t| self.nature(t) == Some(Nature::Limit)).collect()
        };
        let all: BTreeSet<usize> = owners.iter().flat_map(|&s| kept(s)).collect();
        let mut told: Vec<usize> = Vec::new();
        for &s in &owners {
            let Some(stack) = self.machine.states[s].stack.filter(|k| !told.contains(k)) else { continue };
            let held = |t: &usize| self.holds(stack, *t) || self.alike(stack, *t);
            let missing: Vec<&str> =
                all.iter().filter(|t| !held(t)).map(|&t| self.program.tasks[t].name.as_str()).collect();
            if missing.is_empty() {
                continue;
            }
            told.push(stack);
            let text = format!("state `{}` drops limits that others keep: {}", self.name(s), list(missing, 6));
            let at = self.places.stacks[s].unwrap_or(self.places.states[s]);
            diagnostics.push(
                Diagnostic::warning("HQ0708", at, text)
                    .note("in this state nothing keeps the robot inside them")
                    .help("let the stack hold them too: `stack B from A { replace .. }` keeps what it does not name"),
            );
        }
    }

    /// Whether a stack holds a task that says the same under another name.
    fn alike(&self, stack: usize, task: usize) -> bool {
        let members = self.program.stacks[stack].levels.iter().filter(|l| l.hard).flat_map(|l| &l.members);
        members.into_iter().any(|m| self.program.alike(m.task, task))
    }

    fn nature(&self, task: usize) -> Option<Nature> {
        stdlib_tasks::find(&self.program.tasks[task].kind).map(|k| k.nature)
    }

    /// Transitions to another stack that takes over at once.
    fn jumps(&self, diagnostics: &mut Vec<Diagnostic>) {
        let (mut found, mut entered) = (Vec::new(), BTreeMap::new());
        for &s in &self.reached {
            for (i, t) in self.machine.states[s].transitions.iter().enumerate() {
                if is_fault(&t.trigger) || is_dead(self.places, s, i) || self.places.transitions[s][i].blend {
                    continue;
                }
                let to = self.machine.leaf(t.target);
                let inside = self.reached.iter().copied().filter(|&l| self.machine.path(l).any(|p| p == s));
                let from: BTreeSet<Option<usize>> = inside.map(|l| self.machine.stack(l)).collect();
                let other = from.iter().any(|f| f.is_some() && *f != self.machine.stack(to));
                let Some(stack) = self.machine.stack(to).filter(|_| other) else { continue };
                let entered = entered.entry(stack).or_insert_with(|| AccelerationBounds::of(self.program, stack));
                if !is_bounded_or_reported(self.program, entered, &from, stack) {
                    found.push(self.places.transitions[s][i].target);
                }
            }
        }
        let Some(&first) = found.first() else { return };
        let text = match found.len() {
            1 => "here the velocity may jump".to_string(),
            2 => "here the velocity may jump, and at one other transition".to_string(),
            n => format!("here the velocity may jump, and at {} other transitions", n - 1),
        };
        diagnostics.push(
            Diagnostic::warning("HQ0709", first, text)
                .note("another stack takes over at once, and asks for another velocity")
                .help("write `blend 0.3 s` in the machine, in a state or behind a transition; `blend 0 s` where it is meant"),
        );
    }
}

/// Returns true if the stack `to` bounds the accelerations of all joints that are free in it or in one of the stacks before it,
/// or is warned of itself (HQ0525).
fn is_bounded_or_reported(
    program: &Program,
    entered: &AccelerationBounds,
    from: &BTreeSet<Option<usize>>,
    to: usize,
) -> bool {
    let free = |stack: usize, dof: usize| !program.stacks[stack].locked.contains(&dof);
    let all = (0..program.robot.model.nv()).filter(|&d| free(to, d) || from.iter().flatten().any(|&f| free(f, d)));
    entered.may_jump() || entered.bounds(all)
}
