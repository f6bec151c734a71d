//! Signals that tasks and conditions read, and the declarations of signals and people.

use std::collections::BTreeSet;

use dsl::Span;
use dsl::tree::{BlockKind, Entry, NamedBlock, Signal};
use runtime::program::{HumanProgram, Op, Program, SignalProgram};
use stdlib_tasks::bound::Bound;
use stdlib_tasks::task::RowKind;

use super::Checked;
use super::reachability::in_stacks;
use crate::expand::{Expanded, Named};

/// Numbers of the table of signals that a parameter reads, also through its time derivative.
pub(super) fn numbers(program: &Program, bound: &Bound) -> BTreeSet<usize> {
    let mut places: BTreeSet<usize> = bound.slots().into_iter().flat_map(|s| s.at..s.at + s.len).collect();
    if let Bound::Field(field) = bound {
        places.extend(program.fields.get(*field).into_iter().flat_map(|f| f.points.iter().flatten().copied()));
    }
    program.values.tape.only(&places).signals()
}

/// Signals of which a parameter reads the value, and not only the presence.
pub(super) fn signals(program: &Program, bound: &Bound) -> BTreeSet<usize> {
    let of = |number: usize| {
        let signal = program.interface.signal_of(number)?;
        let s = &program.interface.signals[signal];
        (s.at + 1..=s.at + s.len).contains(&number).then_some(signal)
    };
    numbers(program, bound).into_iter().filter_map(of).collect()
}

/// Numbers that the parameters of a task read.
pub(super) fn of_task(program: &Program, task: usize) -> BTreeSet<usize> {
    program.tasks[task].params.values().flat_map(|bound| numbers(program, bound)).collect()
}

/// Numbers that the safety fields read.
pub(super) fn of_fields(program: &Program) -> BTreeSet<usize> {
    (0..program.fields.len()).flat_map(|field| numbers(program, &Bound::Field(field))).collect()
}

/// Tasks that limit the motion because of a person or anything else: those with inequalities, and those that protect people.
pub(super) fn is_limit(program: &Program, task: usize) -> bool {
    let kind = stdlib_tasks::find(&program.tasks[task].kind);
    kind.is_some_and(|k| k.row_kind == RowKind::Inequality || k.person_velocity.is_some())
}

/// Limits of all stacks, each with the numbers of signals that it reads.
pub(super) fn limits(program: &Program) -> Vec<(usize, BTreeSet<usize>)> {
    let all = in_stacks(program).into_iter().filter(|&task| is_limit(program, task));
    all.map(|task| (task, of_task(program, task))).collect()
}

/// Numbers that the conditions of the machine read.
pub(super) fn of_conditions(c: &Checked) -> BTreeSet<usize> {
    let transitions = c.places.machine.iter().flat_map(|m| m.transitions.iter().flatten());
    transitions.filter_map(|t| t.condition).flat_map(|node| of_nodes(c, &[node])).collect()
}

/// Numbers of the table of signals that some nodes depend on.
pub(super) fn of_nodes(c: &Checked, nodes: &[usize]) -> BTreeSet<usize> {
    let read = |node: usize| match c.context.graph.ops()[node] {
        Op::Signal(k) => Some(k),
        _ => None,
    };
    c.context.needed(nodes).into_iter().filter_map(read).collect()
}

/// Numbers of the position of a point.
pub(super) fn position(signal: &SignalProgram) -> std::ops::RangeInclusive<usize> {
    signal.at + 1..=signal.at + signal.len
}

/// Signals of the points of a person.
pub(super) fn points<'p>(program: &'p Program, human: &'p HumanProgram) -> impl Iterator<Item = &'p SignalProgram> {
    human.points.iter().filter_map(|&s| program.interface.signals.get(s))
}

/// Declaration of a signal.
pub(super) fn signal<'e>(expanded: &'e Expanded, name: &str) -> Option<&'e Signal> {
    expanded.values.iter().find_map(|v| match v {
        Named::Signal(s) if s.name.value == name => Some(s),
        _ => None,
    })
}

/// Declaration of a human.
pub(super) fn human<'e>(expanded: &'e Expanded, name: &str) -> Option<&'e NamedBlock> {
    expanded.values.iter().find_map(|v| match v {
        Named::Block(b) if b.kind == BlockKind::Human && b.name.value == name => Some(b),
        _ => None,
    })
}

/// Span of an entry, from its key to its value.
pub(super) fn entry(e: &Entry) -> Span {
    e.key.span.to(e.value.span)
}
