//! Entry of a stack: at the home configuration, or at the configuration that another state has reached.
//!
//! Limits are checked at home for every stack with which a run can begin: a stack by itself, and the stack of a
//! machine's initial state and of states that are reached from it before the robot has moved. The entry of any other
//! state depends on the run, so the controller judges there: a hard level that cannot be met is the fault `infeasible`.

use std::collections::BTreeSet;

use runtime::program::{MachineProgram, Op, Program, StackProgram, Subject, Trigger};
use stdlib_tasks::expression::Expression;

/// Tolerance of times (s), the same as in the controller: a sum of periods has rounding errors.
const SLACK: f64 = 5e-7;

/// Returns true if a run can enter a stack at the home configuration.
pub(crate) fn at_home(program: &Program, stack: usize) -> bool {
    let Some(machine) = &program.machine else { return true };
    let in_a_state = !machine.naming(stack).is_empty();
    !in_a_state
        || program.run.subject == Subject::Stack(stack)
        || first_states(machine, program.robot.period).iter().any(|&s| machine.stack(s) == Some(stack))
}

/// Returns the initial state, and the states that always follow it within the first ticks.
fn first_states(machine: &MachineProgram, period: f64) -> BTreeSet<usize> {
    let mut found = BTreeSet::new();
    let mut next = Some(machine.leaf(0));
    while let Some(state) = next.filter(|s| found.insert(*s)) {
        // First transition to be examined; those of inner states come first.
        let transitions = machine.path(state).flat_map(|s| &machine.states[s].transitions);
        let first =
            transitions.filter(|t| machine.permits(state, state, t)).find(|t| !matches!(t.trigger, Trigger::Fault(_)));
        next = first.filter(|t| is_immediate(&t.trigger, period)).map(|t| machine.leaf(t.target));
    }
    found
}

/// Returns true if a transition is always taken at the first tick at which it is examined.
fn is_immediate(trigger: &Trigger, period: f64) -> bool {
    match trigger {
        Trigger::After(d) => *d <= period + SLACK,
        Trigger::When { condition, hold } => *hold <= SLACK && holds_always(condition),
        _ => false,
    }
}

/// Returns true if a condition is the constant `true`.
fn holds_always(condition: &Expression) -> bool {
    let value = condition.outputs.first().and_then(|&o| condition.ops.get(o));
    matches!(value, Some(Op::Const(x)) if *x > 0.0)
}

/// Returns true if a place of the table of values has the same number at `t = 0` for every entry of the stack.
pub(crate) fn is_certain(program: &Program, at: usize) -> bool {
    let from_elsewhere =
        |op: &Op| matches!(op, Op::Input(_) | Op::State(_) | Op::Time | Op::Signal(_) | Op::Trajectory(_));
    !program.values.tape.only(&BTreeSet::from([at])).ops.iter().any(from_elsewhere)
}

/// Returns the part of the hard levels of a stack that holds at every configuration. Only limits and targets of joint
/// velocities do; all other rows depend on the configuration.
pub(crate) fn anywhere(program: &Program, stack: usize) -> StackProgram {
    let certain = |task: usize| {
        let task = &program.tasks[task];
        let mut slots = task.params.values().flat_map(|b| b.slots());
        matches!(task.kind.as_str(), "joint_velocity" | "joint_velocity_limits")
            && slots.all(|s| (s.at..s.at + s.len).all(|at| is_certain(program, at)))
    };
    let mut reduced = program.stacks[stack].clone();
    for level in &mut reduced.levels {
        level.members.retain(|m| level.hard && certain(m.task));
    }
    reduced
}

/// Returns the part of a stack whose tasks read no signals, with all of its levels.
pub(crate) fn without_signals(program: &Program, stack: usize) -> StackProgram {
    let reads_signals = |task: usize| {
        let slots = program.tasks[task].params.values().flat_map(|b| b.slots());
        let read = program.values.tape.only(&slots.flat_map(|s| s.at..s.at + s.len).collect());
        read.ops.iter().any(|op| matches!(op, Op::Signal(_)))
    };
    let mut reduced = program.stacks[stack].clone();
    for level in &mut reduced.levels {
        level.members.retain(|m| !reads_signals(m.task));
    }
    reduced
}
