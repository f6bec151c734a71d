//! Where a stack is entered: at the home configuration, or wherever another state has left the robot.
//!
//! A limit is judged at home for a stack that a run can begin with: a stack by itself, and the stack of a machine's initial
//! state and of states that are reached from it before the robot has moved. The entry of any other state depends on the
//! run. There the controller judges: a hard level that cannot be met is the fault `infeasible`.

use std::collections::BTreeSet;

use runtime::program::{MachineProgram, Op, Program, StackProgram, Subject, Trigger};
use stdlib_tasks::expression::Expression;

/// A sum of periods is a little off: as much as the controller lets pass, in s.
const SLACK: f64 = 5e-7;

/// Whether a run can enter a stack at the home configuration.
pub(crate) fn at_home(program: &Program, stack: usize) -> bool {
    let Some(machine) = &program.machine else { return true };
    let in_a_state = machine.states.iter().any(|s| s.stack == Some(stack));
    !in_a_state
        || program.run.subject == Subject::Stack(stack)
        || first_states(machine, program.robot.period).iter().any(|&s| machine.stack(s) == Some(stack))
}

/// The initial state, and the states that are entered from it at the following ticks in any case.
fn first_states(machine: &MachineProgram, period: f64) -> BTreeSet<usize> {
    let mut found = BTreeSet::new();
    let mut next = Some(machine.leaf(0));
    while let Some(state) = next.filter(|s| found.insert(*s)) {
        // The first transition that is looked at: those of inner states come first.
        let transitions = machine.path(state).flat_map(|s| &machine.states[s].transitions);
        let first = transitions.into_iter().find(|t| !matches!(t.trigger, Trigger::Fault(_)));
        next = first.filter(|t| is_immediate(&t.trigger, period)).map(|t| machine.leaf(t.target));
    }
    found
}

/// Whether a transition is taken at the first tick at which it is looked at, whatever happens.
fn is_immediate(trigger: &Trigger, period: f64) -> bool {
    match trigger {
        Trigger::After(d) => *d <= period + SLACK,
        Trigger::When { condition, hold } => *hold <= SLACK && holds_always(condition),
        _ => false,
    }
}

/// Whether a condition is the constant `true`.
fn holds_always(condition: &Expression) -> bool {
    let value = condition.outputs.first().and_then(|&o| condition.ops.get(o));
    matches!(value, Some(Op::Const(x)) if *x > 0.0)
}

/// Whether a place of the table of values has the same number at `t = 0` wherever and whenever the stack is entered.
pub(crate) fn is_certain(program: &Program, at: usize) -> bool {
    let from_elsewhere =
        |op: &Op| matches!(op, Op::Input(_) | Op::State(_) | Op::Time | Op::Signal(_) | Op::Trajectory(_));
    !program.values.tape.only(&BTreeSet::from([at])).ops.iter().any(from_elsewhere)
}

/// The program with one more stack: what is certain of the hard levels of another one, at any place. Limits and targets of
/// joint velocities are; all other rows depend on where the robot stands.
pub(crate) fn anywhere(program: &Program, stack: usize) -> Program {
    let mut program = program.clone();
    let certain = |task: usize| {
        let task = &program.tasks[task];
        let mut slots = task.params.values().flat_map(|b| b.slots());
        matches!(task.kind.as_str(), "joint_velocity" | "joint_velocity_limits")
            && slots.all(|s| (s.at..s.at + s.len).all(|at| is_certain(&program, at)))
    };
    let mut reduced = StackProgram { ..program.stacks[stack].clone() };
    for level in &mut reduced.levels {
        level.members.retain(|m| level.hard && certain(m.task));
    }
    program.stacks.push(reduced);
    program
}
