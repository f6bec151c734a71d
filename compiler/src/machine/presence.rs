//! Signals that may be absent, in states whose stacks need them.

use std::collections::{BTreeMap, BTreeSet};

use dsl::Diagnostic;
use runtime::Controller;

use super::{Checked, is_dead};

impl Checked<'_> {
    /// For each state the signals that are present whenever it is entered: those that every way there demands.
    fn certain(&self) -> BTreeMap<usize, BTreeSet<usize>> {
        let m = self.machine;
        let all: BTreeSet<usize> = (0..self.program.interface.signals.len()).collect();
        let leaves: Vec<usize> = self.reached.iter().copied().filter(|&s| m.states[s].initial.is_none()).collect();
        let mut certain: BTreeMap<usize, BTreeSet<usize>> = leaves.iter().map(|&l| (l, all.clone())).collect();
        certain.insert(m.leaf(0), BTreeSet::new());
        let mut changed = true;
        while changed {
            changed = false;
            for &from in &leaves {
                let here = certain[&from].clone();
                for s in m.path(from).collect::<Vec<_>>() {
                    for (i, t) in m.states[s].transitions.iter().enumerate() {
                        if is_dead(self.places, s, i) {
                            continue;
                        }
                        let demanded = self.places.transitions[s][i].demands.iter().copied();
                        let there: BTreeSet<usize> = here.iter().copied().chain(demanded).collect();
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

    pub(super) fn absent(&self, diagnostics: &mut Vec<Diagnostic>) {
        if self.program.interface.signals.iter().all(|s| !s.optional) {
            return;
        }
        let certain = self.certain();
        let mut told = BTreeSet::new();
        for (&leaf, known) in &certain {
            let Some((owner, stack)) = self.machine.owner(leaf).zip(self.machine.stack(leaf)) else { continue };
            let Ok(controller) = Controller::for_stack(self.program, stack) else { continue };
            for &signal in controller.evaluator().needs() {
                let s = &self.program.interface.signals[signal];
                if !s.optional || known.contains(&signal) || !told.insert((owner, signal)) {
                    continue;
                }
                let text = format!("in state `{}` the signal `{}` may be absent", self.name(owner), s.name);
                let at = self.places.stacks[owner].unwrap_or(self.places.states[owner]);
                diagnostics.push(
                    Diagnostic::warning("HQ0710", at, text)
                        .note("its stack needs the value, and would be the fault `stale` without it")
                        .help(format!("come here only `when present({0})`, as in `when present({0}) -> ..`", s.name)),
                );
            }
        }
    }
}
