//! Outputs of the tasks of a stack at a tick, as values of the machine: `separation.room`, `guard.scaling`.

use stdlib_tasks::task::{State, Task};

use super::{Evaluator, Member};
use crate::planning::Planning;
use crate::program::Program;
use crate::signals::SignalValue;

/// Outputs of one task.
pub(super) struct TaskOutputs {
    /// Index of the task in the stack.
    pub member: usize,
    /// Signals that store the outputs, if they are declared.
    signals: Vec<Option<usize>>,
    numbers: Vec<f64>,
}

impl TaskOutputs {
    /// Prepares the outputs of a member of a stack; `None` if it has none.
    pub fn new(program: &Program, member: usize, m: &Member) -> Option<TaskOutputs> {
        let kind = stdlib_tasks::find(m.kind).filter(|k| !k.outputs.is_empty())?;
        let signals = kind.outputs.iter().map(|t| program.interface.signal(&format!("{}.{}", m.name, t.name)));
        Some(TaskOutputs { member, signals: signals.collect(), numbers: vec![f64::NAN; kind.outputs.len()] })
    }

    /// Reads the outputs of the task. Never allocates.
    pub fn update(&mut self, tasks: &[Box<dyn Task>], state: &State, v: &[f64]) {
        self.numbers.fill(f64::NAN);
        if let Some(task) = tasks.get(self.member) {
            task.write_outputs(state, v, &mut self.numbers);
        }
    }
}

impl Evaluator {
    /// Signals that store the outputs of tasks of the stack.
    pub(crate) fn output_signals(&self) -> impl Iterator<Item = usize> {
        self.outputs.iter().flat_map(|t| t.signals.iter().flatten().copied())
    }

    /// Outputs of the tasks at this tick, in which the robot moves with `v`, `nv` numbers: the value of
    /// each signal. Decisions of planners come last. Never allocates.
    pub(crate) fn output_values(&self, v: &[f64]) -> impl Iterator<Item = SignalValue> {
        let own = self.outputs.iter().flat_map(|t| t.signals.iter().zip(&t.numbers));
        let own = own.filter_map(|(signal, number)| Some(SignalValue { signal: (*signal)?, value: *number }));
        own.chain(self.planners.iter().flat_map(move |p: &Planning| p.outputs(v)))
    }
}
