//! Targets that are half a turn away where a later state of the machine begins.
//!
//! The robot is followed through the machine: a state ends where the search arrives at its targets, and the states that it
//! leads to begin there. A state that is entered from somewhere unknown, such as after a fault or a motion that signals lead,
//! is taken to begin at home. The first states are those of a stack that is entered at home, which is examined with its
//! other targets.

use std::collections::{BTreeSet, VecDeque};

use dsl::Diagnostic;
use runtime::Member;
use runtime::program::{MachineProgram, MemberProgram, Op, Program, StackProgram, Trigger};
use stdlib_tasks::dimension::ANGLE;
use stdlib_tasks::task::RowKind;

use super::report;
use crate::analysis::postures::{FixedValue, Parts, PostureSearch};
use crate::checks::Checked;

/// Largest number of entries that are examined.
const ENTRIES: usize = 256;

/// Largest number of states whose end is searched.
const SEARCHES: usize = 64;

/// Entry of a state.
struct Entry {
    state: usize,
    /// Where it begins.
    q: Vec<f64>,
    /// The state before, if the state begins where the targets of that one lead.
    from: Option<usize>,
}

/// Warns of targets half a turn away at the entry of states after the first ones, but for tasks that have a warning (`told`).
pub(super) fn check(c: &Checked, told: &mut BTreeSet<usize>, out: &mut Vec<Diagnostic>) {
    let program = c.program;
    let Some(machine) = &program.machine else { return };
    let home = &program.robot.home;
    let mut open = VecDeque::from([Entry { state: machine.leaf(0), q: home.clone(), from: None }]);
    let (mut seen, mut left, mut examined) = (BTreeSet::new(), BTreeSet::new(), 0);
    let mut later = |entry: &Entry, told: &mut BTreeSet<usize>, out: &mut Vec<Diagnostic>| {
        examined += 1;
        if examined <= ENTRIES {
            entered(c, machine, entry, told, out);
        }
    };
    while let Some(entry) = open.pop_front() {
        if entry.from.is_some() {
            later(&entry, told, out);
        }
        if left.len() >= SEARCHES || !left.insert(entry.state) {
            continue;
        }
        let end = match machine.stack(entry.state) {
            Some(_) if machine.region(entry.state).is_some() => None,
            Some(stack) => arrive(c, stack, &entry.q),
            None => Some(entry.q.clone()),
        };
        let all = |s: usize| machine.states[s].transitions.iter().filter(move |t| machine.permits(entry.state, s, t));
        for transition in machine.path(entry.state).flat_map(all) {
            // A fault may come anywhere.
            let known = end.clone().filter(|_| !matches!(transition.trigger, Trigger::Fault(_)));
            let state = machine.leaf(transition.target);
            if let Some(q) = known.filter(|_| seen.insert((entry.state, state))) {
                open.push_back(Entry { state, q, from: Some(entry.state) });
            }
        }
    }
    for state in (0..machine.states.len()).filter(|&s| machine.leaf(s) == s && !left.contains(&s)) {
        later(&Entry { state, q: home.clone(), from: None }, told, out);
    }
}

/// Warns of targets half a turn away at the entry of a state.
fn entered(
    c: &Checked,
    machine: &MachineProgram,
    entry: &Entry,
    told: &mut BTreeSet<usize>,
    out: &mut Vec<Diagnostic>,
) {
    let Some(stack) = machine.stack(entry.state) else { return };
    let turns = |m: &&MemberProgram| {
        let members = c.stacks.members(stack).iter().filter(|known| known.program_index == m.task);
        members.flat_map(|known| &known.measure_info).any(|measure| measure.dimension == ANGLE)
    };
    let members: Vec<MemberProgram> = targets(c.program, &c.program.stacks[stack]).filter(turns).cloned().collect();
    for member in members.iter().filter(|m| !told.contains(&m.task)).collect::<Vec<_>>() {
        let fixed = goals(c, member.task);
        let parts = Parts { stack, limits: &[], targets: std::slice::from_ref(member), fixed: &fixed };
        let Some(mut search) = PostureSearch::new(c.program, &parts) else { continue };
        search.enter(&entry.q);
        if search.half_turn(&entry.q, 0.0).is_some() {
            told.insert(member.task);
            let name = |state: usize| machine.states[state].name.as_str();
            out.push(report::half_turn_in_state(c, member.task, name(entry.state), entry.from.map(name)));
        }
    }
}

/// Targets of a stack whose numbers do not follow signals or the robot's state.
fn targets<'p>(program: &'p Program, stack: &'p StackProgram) -> impl Iterator<Item = &'p MemberProgram> {
    stack.levels.iter().flat_map(|l| &l.members).filter(|m| is_target(program, m.task) && !is_led(program, m.task))
}

fn is_target(program: &Program, task: usize) -> bool {
    let kind = program.tasks.get(task).and_then(|t| stdlib_tasks::find(&t.kind));
    kind.is_some_and(|kind| kind.row_kind == RowKind::Equality)
}

/// Returns true if a parameter of a task follows a signal.
fn is_led(program: &Program, task: usize) -> bool {
    let slots = program.tasks[task].params.values().flat_map(|b| b.slots());
    let read = program.values.tape.only(&slots.flat_map(|s| s.at..s.at + s.len).collect());
    read.ops.iter().any(|op| matches!(op, Op::Signal(_)))
}

/// Numbers of a task that trajectories lead to constants, at their goals.
fn goals(c: &Checked, task: usize) -> Vec<FixedValue> {
    let (graph, placed) = (c.context.graph, &c.context.table.placed);
    let params = c.program.tasks[task].params.iter().filter(|(name, _)| *name != "gain");
    let mut fixed = Vec::new();
    for slot in params.flat_map(|(_, bound)| bound.slots()) {
        let nodes = placed.get(slot.at..slot.at + slot.len).unwrap_or_default();
        let ends = graph.goal(nodes);
        let ends: Option<Vec<f64>> = ends.iter().map(|&n| graph.constant(n)).collect();
        let moves = nodes.iter().any(|&n| graph.constant(n).is_none());
        if let Some(ends) = ends.filter(|ends| moves && ends.len() == slot.len) {
            fixed.extend((slot.at..).zip(ends).map(|(at, value)| FixedValue { at, value }));
        }
    }
    fixed
}

/// Posture where a state ends that is entered at `q`: at its targets, those of higher levels first, at the end of the run.
/// Limits are left out. `None` if signals lead a target, or the search fails.
fn arrive(c: &Checked, stack: usize, q: &[f64]) -> Option<Vec<f64>> {
    let program = c.program;
    let mut own = program.stacks[stack].clone();
    if own.levels.iter().flat_map(|l| &l.members).any(|m| is_target(program, m.task) && is_led(program, m.task)) {
        return None;
    }
    // A target of a velocity leads to no posture.
    let has_error = |m: &Member| m.row_kind == RowKind::Equality && !m.measures.is_empty();
    let arriving: BTreeSet<usize> =
        c.stacks.members(stack).iter().filter(|m| has_error(m)).map(|m| m.program_index).collect();
    for level in &mut own.levels {
        (level.hard, level.exact, level.damping) = (false, false, 0.0);
        level.members.retain(|m| arriving.contains(&m.task));
        level.members.iter_mut().for_each(|m| m.idle.clear());
    }
    own.levels.retain(|l| !l.members.is_empty());
    if own.levels.is_empty() {
        return Some(q.to_vec());
    }
    let mut search = PostureSearch::of_stack(program, own, &[])?;
    search.enter(q);
    search.descend(q.to_vec(), program.run.duration).map(|end| end.q)
}
