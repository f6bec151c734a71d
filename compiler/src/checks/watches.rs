//! Warns of tasks that only watch (`method watch`) and whose outputs nothing reads, at all or while the robot moves.

use std::collections::BTreeSet;

use dsl::{Diagnostic, Help, Snippet};
use runtime::program::{Op, Program, Subject};
use stdlib_tasks::bound::Bound;

use super::reachability::in_stacks;
use super::{Checked, people, place, readings};

pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    for task in in_stacks(c.program) {
        if !only_watches(c.program, task) {
            continue;
        }
        let outputs = outputs(c.program, task);
        out.extend(match is_read(c, &outputs) {
            false => Some(unread(c, task)),
            true => unread_in_motion(c, task, &outputs),
        });
    }
}

/// True for a task that bounds nothing.
pub(super) fn only_watches(program: &Program, task: usize) -> bool {
    matches!(program.tasks[task].params.get("method"), Some(Bound::Choice(word)) if word == "watch")
}

/// True if an expression reads one of these numbers.
fn is_read(c: &Checked, outputs: &BTreeSet<usize>) -> bool {
    let ops = c.context.graph.ops();
    let output = |node: usize| matches!(ops.get(node), Some(Op::Signal(k)) if outputs.contains(k));
    // All outputs have nodes, so only those that others use count, or that are a condition by themselves.
    let conditions = c.places.machine.iter().flat_map(|m| m.transitions.iter().flatten().filter_map(|t| t.condition));
    let measured = c.places.scenarios.iter().flat_map(|s| s.nodes.iter().copied());
    let mut alone = conditions.chain(measured).chain(c.context.table.placed.iter().copied());
    alone.any(output) || ops.iter().any(|op| op.operands().into_iter().flatten().any(output))
}

/// Numbers of the table of signals that are outputs of a task.
fn outputs(program: &Program, task: usize) -> BTreeSet<usize> {
    let t = &program.tasks[task];
    let names: BTreeSet<String> = stdlib_tasks::find(&t.kind)
        .into_iter()
        .flat_map(|kind| kind.outputs)
        .map(|output| format!("{}.{}", t.name, output.name))
        .collect();
    let own = program.interface.signals.iter().filter(|s| names.contains(&s.name));
    own.flat_map(|s| s.at..s.at + s.width()).collect()
}

fn unread(c: &Checked, task: usize) -> Diagnostic {
    let name = &c.program.tasks[task].name;
    Diagnostic::warning(
        "HQ0562",
        place(c.places, task, "method"),
        format!("`{name}` only watches, and nothing reads it"),
    )
    .here("bounds no velocity")
    .note("with `method watch` the robot moves as if the task were not there; its outputs are for conditions")
    .help(Help::with(
        "write {} so that the task slows the robot down, or let a machine stop it: {}",
        [
            Snippet::entry("method", "slow"),
            Snippet::transition_when(&format!("{name}.distance < {name}.required"), "STATE"),
        ],
    ))
}

/// A watch that conditions of the machine read in states in which the robot stands, and in no state in which it moves.
fn unread_in_motion(c: &Checked, task: usize, outputs: &BTreeSet<usize>) -> Option<Diagnostic> {
    let (Subject::Machine, Some(machine), Some(places)) =
        (c.program.run.subject, &c.program.machine, &c.places.machine)
    else {
        return None;
    };
    // A target or a limit that depends on an output reacts to it.
    if in_stacks(c.program).into_iter().any(|t| !readings::of_task(c.program, t).is_disjoint(outputs)) {
        return None;
    }
    let reads = |state: usize| {
        let conditions = places.transitions[state].iter().filter_map(|t| t.condition);
        conditions.into_iter().find(|&node| !readings::of_nodes(c, &[node]).is_disjoint(outputs))
    };
    let holds = |stack: usize| c.program.stacks[stack].levels.iter().flat_map(|l| &l.members).any(|m| m.task == task);
    let moving: Vec<usize> = (0..machine.states.len())
        .filter(|&s| machine.states[s].initial.is_none())
        .filter(|&s| machine.stack(s).is_some_and(|stack| holds(stack) && people::moves(c, stack)))
        .collect();
    let first = *moving.first()?;
    if moving.iter().any(|&s| machine.path(s).any(|p| reads(p).is_some())) {
        return None;
    }
    let elsewhere = (0..machine.states.len()).find_map(|s| {
        let at = places.transitions[s]
            .iter()
            .find(|t| t.condition.is_some_and(|node| !readings::of_nodes(c, &[node]).is_disjoint(outputs)));
        Some((s, at?.trigger))
    });
    let (name, state) = (&c.program.tasks[task].name, &machine.states[first].name);
    let text = format!("no condition reads `{name}` while the robot moves in state `{state}`");
    let mut d = Diagnostic::warning("HQ0562", places.states[first], text);
    if let Some((other, at)) = elsewhere {
        d = d.label(at, format!("read in `{}`, where the robot stands", machine.states[other].name));
    }
    Some(d.note("the task only watches: in this state the robot moves as if it were not there").help(Help::with(
        "add a transition to the state: {}",
        [Snippet::transition_when(&format!("{name}.distance < {name}.required"), "STATE")],
    )))
}
