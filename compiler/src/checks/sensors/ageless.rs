//! Warns of measured values without a time-out that the robot follows: the last reading counts for ever.
//!
//! A wrench is a measurement, so it always needs a time-out. A place can also be told once by an operator. Then it is
//! optional, or an event or a flag of the host ends the motion, and it is not reported.

use std::collections::BTreeSet;

use dsl::{Diagnostic, Help, Snippet};
use runtime::program::{SignalProgram, Trigger};

use crate::checks::reachability::in_stacks;
use crate::checks::{Checked, readings};

/// Warns of each such signal, once.
pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    let mut told: BTreeSet<usize> = BTreeSet::new();
    for task in in_stacks(c.program) {
        let t = &c.program.tasks[task];
        for (param, bound) in &t.params {
            for signal in readings::signals(c.program, bound) {
                let s = &c.program.interface.signals[signal];
                let ageless = s.timeout.is_none() && !s.is_of_person() && !s.is_variable();
                let measured = match s.kind.as_str() {
                    "wrench" => true,
                    "point" | "pose" | "orientation" => !s.optional && !ended_by_host(c, task),
                    _ => false,
                };
                if !ageless || !measured || !told.insert(signal) {
                    continue;
                }
                let Some(declared) = readings::signal(c.expanded, &s.name) else { continue };
                let uses = c.places.tasks[task].spans.get(param).copied().unwrap_or(c.places.tasks[task].span);
                out.push(
                    Diagnostic::warning(
                        "HQ0540",
                        declared.name.span.to(declared.ty.span),
                        format!("a reading of `{}` is valid for ever", s.name),
                    )
                    .here("no `timeout`")
                    .label(uses, format!("`{}` uses it", t.name))
                    .note(consequence(s))
                    .help(Help::with(
                        "write for instance {}: an older reading is absent, which is a fault where it is needed",
                        [Snippet::entry("timeout", "0.2 s")],
                    )),
                );
            }
        }
    }
}

fn consequence(s: &SignalProgram) -> &'static str {
    match s.kind.as_str() {
        "wrench" => "after a broken cable the robot yields to the last push without an end",
        _ => "when the sensor stops sending, the robot goes on to the last place that it saw",
    }
}

/// True if the task reads a flag of the host, or if a state that runs it is left because of an event or a flag of the host.
fn ended_by_host(c: &Checked, task: usize) -> bool {
    let has = |stack: usize| {
        c.program.stacks.get(stack).is_some_and(|s| s.levels.iter().flat_map(|l| &l.members).any(|m| m.task == task))
    };
    let flag = |number: &usize| {
        let signal = c.program.interface.signal_of(*number).and_then(|s| c.program.interface.signals.get(s));
        signal.is_some_and(|s| s.kind == "flag" && !s.is_variable())
    };
    if readings::of_task(c.program, task).iter().any(flag) {
        return true;
    }
    let (Some(machine), Some(places)) = (&c.program.machine, &c.places.machine) else { return false };
    let asks = |state: usize| {
        machine.states[state].transitions.iter().zip(&places.transitions[state]).any(|(t, place)| match t.trigger {
            Trigger::Event(event) => event < places.declared_events,
            _ => place.condition.is_some_and(|node| readings::of_nodes(c, &[node]).iter().any(flag)),
        })
    };
    let mut states = (0..machine.states.len()).filter(|&s| machine.states[s].stack.is_some_and(has));
    states.any(|state| machine.path(state).any(asks))
}
