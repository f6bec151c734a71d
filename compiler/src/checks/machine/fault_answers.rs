//! Transitions for faults that lead into the state of the fault, or back into the work.

use std::collections::BTreeSet;

use dsl::{Diagnostic, Help, Snippet, Span};
use runtime::program::{FaultPattern, Program, Times, Trigger};
use runtime::{Evaluator, RestInputs};
use solver::Problem;
use stdlib_tasks::task::RowKind;

use super::{Checked, is_fault};
use crate::analysis::stacks::{Stacks, postures};

/// Times (s) since the entry of a state at which its targets are evaluated: a target can begin at rest and move later.
const MOMENTS: [f64; 3] = [0.0, 0.5, 2.0];

/// Number of random postures, beside home, at which a state is entered.
const POSTURES: usize = 3;

/// Velocities below this (rad/s or m/s) are the rounding of a target that is at rest.
const AT_REST: f64 = 1e-6;

impl Checked<'_> {
    /// Warns of transitions for faults whose target is always active already, and of those that resume the work.
    pub(super) fn fault_answers(&self, diagnostics: &mut Vec<Diagnostic>) {
        let (work, mut told) = (self.reached_without_faults(), BTreeSet::new());
        for &s in &self.reached {
            for (i, t) in self.machine.states[s].transitions.iter().enumerate() {
                let Trigger::Fault(pattern) = &t.trigger else { continue };
                let target = self.machine.leaf(t.target);
                let inside =
                    |l: &usize| self.machine.states[*l].initial.is_none() && self.machine.path(*l).any(|p| p == s);
                let leaves: Vec<usize> = self.reached.iter().copied().filter(inside).collect();
                let there = |l: &usize| self.machine.path(*l).any(|o| o == t.target);
                let moved: Vec<usize> = leaves.iter().copied().filter(|&l| self.machine.stack(l).is_some()).collect();
                let (place, name) = (&self.places.transitions[s][i], self.name(t.target));
                let moves = || self.machine.stack(target).is_some_and(|stack| moves(self.program, self.stacks, stack));
                let always = !leaves.is_empty() && leaves.iter().all(there);
                if always || (!moved.is_empty() && moved.iter().all(there) && moves()) {
                    let text = match always {
                        true => "this transition is never taken",
                        false => "this transition is never taken while the robot moves",
                    };
                    let label = format!("the machine is then in `{name}` already");
                    let note = format!(
                        "a fault does not re-enter a state: in `{name}` the robot stops, and stands still until another \
                         transition leaves it"
                    );
                    diagnostics.push(
                        Diagnostic::warning("HQ0714", place.trigger, text)
                            .label(place.target, label)
                            .note(note)
                            .help(stand()),
                    );
                } else if *pattern == FaultPattern::Any && work.contains(&target) && moves() {
                    let text = format!("every fault leads back into the work, to `{name}`");
                    let label = format!("the stack of `{}` moves the robot at once", self.name(target));
                    diagnostics.push(
                        Diagnostic::warning("HQ0714", place.trigger, text)
                            .label(self.places.stacks[target].unwrap_or(self.places.states[target]), label)
                            .note("after a fault, also one of a sensor or of the solver, the robot resumes its motion by itself")
                            .help(stand()),
                    );
                } else if !work.contains(&target)
                    && (self.machine.ends(target) || (*pattern == FaultPattern::Any && self.works(target, &work)))
                    && moves()
                {
                    let owner = self.machine.owner(target).unwrap_or(target);
                    if told.insert(target) {
                        diagnostics.push(self.moving_stop(target, owner, place.trigger));
                    }
                }
            }
        }
    }

    /// True for a state that has the stack of a state of the work.
    fn works(&self, leaf: usize, work: &BTreeSet<usize>) -> bool {
        let stack = self.machine.stack(leaf);
        let other = |&w: &usize| self.machine.states[w].initial.is_none() && self.machine.stack(w) == stack;
        stack.is_some() && work.iter().any(other)
    }

    /// Warning of a state for faults in which the robot moves.
    fn moving_stop(&self, target: usize, owner: usize, fault: Span) -> Diagnostic {
        let name = self.name(target);
        let at = self.places.stacks[owner].unwrap_or(self.places.states[owner]);
        let note = match self.machine.ends(target) {
            true => format!("the machine ends in `{name}`, so the robot moves there for good"),
            false => {
                "after a fault, also one of a sensor or of the solver, the robot moves as it does at work".to_string()
            }
        };
        Diagnostic::warning("HQ0714", at, format!("a fault leads to `{name}`, and this stack moves the robot there"))
            .label(fault, format!("leads to `{name}`"))
            .note(note)
            .help("give the state a stack that holds the robot, or no stack: then the robot stands")
    }

    /// States that the machine can be in although no fault has occurred.
    pub(super) fn reached_without_faults(&self) -> BTreeSet<usize> {
        self.connected_by(|trigger| !is_fault(trigger))
    }
}

fn stand() -> Help {
    Help::with("answer it with a state in which the robot stands: {}", [Snippet::transition("fault(any)", "stopped")])
}

/// True if a target of the stack certainly moves the robot: its velocity differs from zero at an entry at home or at another
/// configuration, with signals that are present and zero. A stack that holds the robot where it is entered does not.
pub(super) fn moves(program: &Program, stacks: &Stacks, stack: usize) -> bool {
    let rest = RestInputs::present(program);
    let moving = |evaluator: &mut Evaluator, problem: &mut Problem| {
        postures(program, POSTURES).iter().any(|q| {
            evaluator.enter(q, rest.at(Times::default()));
            MOMENTS.into_iter().any(|time| {
                if evaluator.update(q, rest.at(Times { t: time, time }), problem).is_err() {
                    return false;
                }
                let mut targets = evaluator.members().iter().filter(|m| m.row_kind == RowKind::Equality);
                targets.any(|m| {
                    let level = &problem.levels[m.level];
                    m.rows.clone().any(|r| level.lower[r] > AT_REST || level.upper[r] < -AT_REST)
                })
            })
        })
    };
    stacks.with(stack, moving).unwrap_or(false)
}
