//! Warns of signals that may be absent in states whose stacks need them.

use std::collections::{BTreeMap, BTreeSet};

use dsl::{Diagnostic, Help, Snippet};
use runtime::program::MachineAction;

use super::Checked;

impl Checked<'_> {
    /// Computes, for each state, the signals that are present at every entry: those that all paths to it demand.
    fn certain(&self) -> BTreeMap<usize, BTreeSet<usize>> {
        let m = self.machine;
        let all: BTreeSet<usize> = (0..self.program.interface.signals.len()).collect();
        let leaves: Vec<usize> = self.reached.iter().copied().filter(|&s| m.states[s].initial.is_none()).collect();
        let mut certain: BTreeMap<usize, BTreeSet<usize>> = leaves.iter().map(|&l| (l, all.clone())).collect();
        let given = self.program.interface.signals.iter().enumerate();
        let given = given.filter(|(_, s)| s.variable.as_ref().is_some_and(|v| v.value.is_some())).map(|(i, _)| i);
        certain.insert(m.leaf(0), self.changed(given.collect(), None, m.leaf(0), m.leaf(0)));
        let mut changed = true;
        while changed {
            changed = false;
            for &from in &leaves {
                let here = certain[&from].clone();
                for s in m.path(from).collect::<Vec<_>>() {
                    for (i, t) in m.states[s].transitions.iter().enumerate() {
                        if self.is_dead(s, i) {
                            continue;
                        }
                        let demanded = self.places.transitions[s][i].demands.iter().copied();
                        let there: BTreeSet<usize> = here.iter().copied().chain(demanded).collect();
                        let there = self.changed(there, Some(from), t.target, m.leaf(t.target));
                        let Some(known) = certain.get_mut(&m.leaf(t.target)) else { continue };
                        let both: BTreeSet<usize> = known.intersection(&there).copied().collect();
                        changed |= both.len() < known.len();
                        *known = both;
                    }
                }
            }
        }
        certain
    }

    /// Updates the set of present variables by the actions of a transition to `leaf`, entered through `target`.
    fn changed(&self, mut there: BTreeSet<usize>, from: Option<usize>, target: usize, leaf: usize) -> BTreeSet<usize> {
        let m = self.machine;
        let left: Vec<usize> = from.map_or(Vec::new(), |f| m.path(f).collect());
        let exits = left.iter().flat_map(|&s| &m.states[s].exit);
        let entered: Vec<usize> = m.path(leaf).collect();
        let enters = entered.iter().flat_map(|&s| m.states[s].enter.iter().chain(&m.states[s].activities));
        for &a in exits.chain(enters) {
            if let Some(MachineAction::Clear(variable)) = m.actions[a].own {
                there.remove(&variable);
            }
        }
        // A state that encloses both is not entered.
        let certain = entered.iter().filter(|s| **s == target || !left.contains(s));
        for &a in certain.flat_map(|&s| m.states[s].enter.iter().chain(&m.states[s].activities)) {
            if let Some(MachineAction::Set { variable, .. }) = m.actions[a].own {
                there.insert(variable);
            }
        }
        there
    }

    pub(super) fn absent(&self, diagnostics: &mut Vec<Diagnostic>) {
        if self.program.interface.signals.iter().all(|s| !s.optional) {
            return;
        }
        let certain = self.certain();
        let mut told = BTreeSet::new();
        for (&leaf, known) in &certain {
            let Some((owner, stack)) = self.machine.owner(leaf).zip(self.machine.stack(leaf)) else { continue };
            for signal in self.stacks.needs(stack) {
                let s = &self.program.interface.signals[signal];
                if !s.optional || known.contains(&signal) || !told.insert((owner, signal)) {
                    continue;
                }
                let what = if s.is_variable() { "variable" } else { "signal" };
                let text = format!("in state `{}` the {what} `{}` may be absent", self.name(owner), s.name);
                let at = self.places.stacks[owner].unwrap_or(self.places.states[owner]);
                diagnostics.push(
                    Diagnostic::warning("HQ0710", at, text)
                        .note("its stack needs the value; without it the fault is `stale`")
                        .help(Help::with(
                            "enter it only if the value is known: {}",
                            [Snippet::transition_when(&format!("present({})", s.name), self.name(owner))],
                        )),
                );
            }
        }
    }
}
