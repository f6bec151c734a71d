//! Warns of optional sensors whose force is to stop a motion: while the sensor is absent the comparison is false, and the
//! motion goes on without it.

use std::collections::BTreeSet;

use dsl::{Diagnostic, Help, Snippet};
use runtime::program::{MachineProgram, Subject};

use super::rising;
use crate::checks::people::moves;
use crate::checks::{Checked, readings};

pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    let (Subject::Machine, Some(machine), Some(places)) =
        (c.program.run.subject, &c.program.machine, &c.places.machine)
    else {
        return;
    };
    let mut told: BTreeSet<usize> = BTreeSet::new();
    for state in 0..machine.states.len() {
        for (transition, place) in places.transitions[state].iter().enumerate() {
            let Some(node) = place.condition else { continue };
            let watched: BTreeSet<usize> = rising::comparisons(c, node).iter().map(|r| r.signal).collect();
            for signal in watched {
                let s = &c.program.interface.signals[signal];
                let unanswered = s.optional && !s.is_variable() && !told.contains(&signal);
                if !unanswered || answers(c, machine, state, signal) || !in_motion(c, machine, state, signal) {
                    continue;
                }
                told.insert(signal);
                let target = machine.states[state].transitions.get(transition).map_or(0, |t| t.target);
                let name = &s.name;
                out.push(
                    Diagnostic::warning("HQ0547", place.trigger, format!("without `{name}` this never holds, and the robot moves on"))
                        .here(format!("false while `{name}` is absent"))
                        .note(format!(
                            "`{name}` is optional, so its loss is no fault, and nothing leads to `{}` then",
                            machine.states[target].name
                        ))
                        .help(Help::with(
                            &format!("write `{name} : wrench` without `?`, and let {{}} answer; or test `not present({name})` too"),
                            [Snippet::entry("on", format!("fault(stale({name})) -> .."))],
                        )),
                );
            }
        }
    }
}

/// True if a condition of the state, or of one around it, asks for the presence of a signal.
fn answers(c: &Checked, machine: &MachineProgram, state: usize, signal: usize) -> bool {
    let Some(places) = &c.places.machine else { return false };
    let presence = c.program.interface.signals[signal].at;
    let inside = (0..machine.states.len()).filter(|&s| s == state || machine.is_around(state, s));
    inside.chain(machine.path(state)).any(|s| {
        let conditions = places.transitions[s].iter().filter_map(|t| t.condition);
        conditions.into_iter().any(|node| readings::of_nodes(c, &[node]).contains(&presence))
    })
}

/// True if the stack of the state moves, and none of its tasks needs the signal.
fn in_motion(c: &Checked, machine: &MachineProgram, state: usize, signal: usize) -> bool {
    let leaf = machine.leaf(state);
    let Some(stack) = machine.stack(leaf) else { return false };
    let numbers = readings::position(&c.program.interface.signals[signal]);
    let mut tasks = c.program.stacks[stack].levels.iter().flat_map(|l| &l.members).map(|m| m.task);
    let needs = tasks.any(|task| readings::of_task(c.program, task).iter().any(|n| numbers.contains(n)));
    !needs && moves(c, stack)
}
