//! Transitions of a state while the machine is in it: their conditions, the times since which these hold, and the
//! transitions that are blocked until their trigger has been false.

use stdlib_tasks::expression::{Evaluation, Expression};

use crate::program::{MachineProgram, Program, TransitionProgram, Trigger};
use crate::values::ValueTable;

/// Runtime data of a transition of an active state.
pub(super) struct Guard {
    /// Its condition, if it has one.
    pub condition: Option<Evaluation>,
    /// Time since which the condition has held (s); NaN while it does not.
    pub since: f64,
    /// True if the transition re-enters the state that defines it, and would be taken again at once if its trigger
    /// still holds.
    pub restarts: bool,
    /// True if the transition is blocked: it restarts its state and has held at every tick since that state was
    /// entered, or it is a time that was taken since then.
    pub waits: bool,
}

/// Transitions of a state.
pub(super) struct Guards {
    /// Values that the conditions read.
    pub values: ValueTable,
    /// Transitions in the order written.
    pub ways: Vec<Guard>,
    /// True if a condition reads the state of the robot.
    pub state: bool,
}

fn condition(trigger: &Trigger) -> Option<&Expression> {
    match trigger {
        Trigger::When { condition, .. } => Some(condition),
        _ => None,
    }
}

impl Guards {
    /// Prepares the transitions of a state of a checked machine.
    pub fn new(program: &Program, machine: &MachineProgram, state: usize) -> Guards {
        let transitions = &machine.states[state].transitions;
        let all = || transitions.iter().filter_map(|t| condition(&t.trigger));
        let wanted = all().flat_map(|e| e.inputs.iter().copied()).collect();
        let guard = |t: &TransitionProgram| Guard {
            condition: condition(&t.trigger).map(|e| Evaluation::new(e, &program.robot.model)),
            since: f64::NAN,
            restarts: machine.restarts(state, t),
            waits: false,
        };
        Guards {
            values: ValueTable::new(&program.values, &wanted, &program.interface),
            state: all().any(|e| !e.leaves.is_empty()),
            ways: transitions.iter().map(guard).collect(),
        }
    }

    /// Resets the transitions at the entry of the state.
    pub fn enter(&mut self) {
        self.ways.iter_mut().for_each(|w| (w.since, w.waits) = (f64::NAN, w.restarts));
    }
}
