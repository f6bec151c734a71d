//! Recoveries that lead back into the work by themselves, after a time or a motion, however often the fault occurs.

use std::collections::BTreeSet;

use dsl::{Diagnostic, Help, Snippet};
use runtime::program::{FaultPattern, MachineAction, Trigger};

use super::Checked;
use super::fault_answers::moves;
use crate::analysis::conditions::Leaf;
use crate::analysis::exploration::Way;

impl Checked<'_> {
    /// Warns of a time or a reached target that resumes the work after any fault, if nothing counts the attempts.
    pub(super) fn recoveries(&self, diagnostics: &mut Vec<Diagnostic>) {
        let work = self.reached_without_faults();
        let mut told = BTreeSet::new();
        for &s in &self.reached {
            for (i, t) in self.machine.states[s].transitions.iter().enumerate() {
                let recovery = self.machine.leaf(t.target);
                // A fault that leads straight into the work is reported as such.
                if t.trigger != Trigger::Fault(FaultPattern::Any) || work.contains(&recovery) {
                    continue;
                }
                let Some((way, resumed)) = self.resumes(recovery, s, &work) else { continue };
                let place = &self.places.transitions[way.state][way.index];
                if !told.insert((way.state, way.index)) {
                    continue;
                }
                let text =
                    format!("every fault leads back into the work, to `{}`, after a recovery", self.name(resumed));
                diagnostics.push(
                    Diagnostic::warning("HQ0725", place.trigger, text)
                        .label(self.places.transitions[s][i].trigger, format!("leads to `{}`", self.name(recovery)))
                        .note(
                            "a fault that lasts, such as that of a sensor, occurs again: the robot starts and stops without end, \
                             and nobody is asked",
                        )
                        .help(Help::with(
                            "let a person resume the work, {}, or count the attempts in a variable and give up after some",
                            [Snippet::transition("restart", self.name(resumed))],
                        )),
                );
            }
        }
    }

    /// The first transition that leads from a recovery into a state of the work where the robot moves and the fault transition
    /// of `scope` applies, through states that only times and reached targets leave.
    fn resumes(&self, recovery: usize, scope: usize, work: &BTreeSet<usize>) -> Option<(Way, usize)> {
        let (mut open, mut seen) = (vec![recovery], BTreeSet::new());
        while let Some(leaf) = open.pop() {
            if !seen.insert(leaf) || self.decides(leaf) {
                continue;
            }
            for state in self.machine.path(leaf) {
                for (index, t) in self.machine.states[state].transitions.iter().enumerate() {
                    let alone = matches!(t.trigger, Trigger::After(_) | Trigger::Reached(_));
                    if !alone || self.is_dead(state, index) {
                        continue;
                    }
                    let next = self.machine.leaf(t.target);
                    let watched = self.machine.path(next).any(|p| p == scope);
                    let runs = self.machine.stack(next).is_some_and(|stack| moves(self.program, self.stacks, stack));
                    if work.contains(&next) && watched && runs && !self.counts_at(next) {
                        return Some((Way { state, index }, next));
                    }
                    if !work.contains(&next) {
                        open.push(next);
                    }
                }
            }
        }
        None
    }

    /// True for a state that counts, or that decides by a variable, a signal or an answer.
    fn decides(&self, leaf: usize) -> bool {
        let by = |t: &Trigger| match t {
            Trigger::When { .. } | Trigger::Event(_) => true,
            Trigger::After(_) | Trigger::Reached(_) | Trigger::Ended(_) | Trigger::Fault(_) => false,
        };
        let inside = || self.machine.path(leaf).filter(|&p| p != 0);
        self.counts_at(leaf) || inside().any(|p| self.machine.states[p].transitions.iter().any(|t| by(&t.trigger)))
    }

    /// True for a state whose actions change a variable that a condition reads.
    fn counts_at(&self, leaf: usize) -> bool {
        let read: BTreeSet<usize> = (self.conditions.variables.iter())
            .flat_map(|v| &v.leaves.all)
            .filter_map(|l| if let Leaf::Signal(s, _) = l { Some(*s) } else { None })
            .collect();
        self.machine.path(leaf).any(|p| {
            let state = &self.machine.states[p];
            let all = state.enter.iter().chain(&state.activities).chain(&state.exit);
            all.into_iter().any(|&a| match &self.machine.actions[a].own {
                Some(MachineAction::Set { variable, .. } | MachineAction::Clear(variable)) => read.contains(variable),
                _ => false,
            })
        })
    }
}
