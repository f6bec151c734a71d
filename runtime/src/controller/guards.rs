//! The transitions of a state while the machine is in it: their conditions, since when those hold, and which of them wait
//! until they have been false.

use stdlib_tasks::expression::{Evaluation, Expression};

use crate::program::{MachineProgram, Program, TransitionProgram, Trigger};
use crate::values::ValueTable;

/// What is known of a transition of a state that the machine is in.
pub(super) struct Guard {
    /// Its condition, where it has one.
    pub condition: Option<Evaluation>,
    /// Since when the condition has held, in s; NaN while it does not.
    pub since: f64,
    /// It enters anew the state in which it stands, and would be taken again at once where it goes on holding.
    pub restarts: bool,
    /// It is passed over: it restarts its state and has held at every tick since that was entered, or it is a time that was
    /// taken since.
    pub waits: bool,
}

/// The transitions of a state.
pub(super) struct Guards {
    /// What their conditions read.
    pub values: ValueTable,
    /// For each transition, in order.
    pub ways: Vec<Guard>,
    /// Whether a condition reads what the robot does.
    pub state: bool,
}

fn condition(trigger: &Trigger) -> Option<&Expression> {
    match trigger {
        Trigger::When { condition, .. } => Some(condition),
        _ => None,
    }
}

impl Guards {
    /// Makes the transitions of a state of a checked machine ready.
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

    /// Begins anew with the entry of the state.
    pub fn enter(&mut self) {
        self.ways.iter_mut().for_each(|w| (w.since, w.waits) = (f64::NAN, w.restarts));
    }
}
