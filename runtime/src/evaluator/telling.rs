//! What tasks of a stack tell at a tick, as values of the machine: `separation.room`, `guard.scaling`.

use stdlib_tasks::task::{State, Task};

use super::{Evaluator, Member};
use crate::planning::Planning;
use crate::program::Program;

/// What one task tells.
pub(super) struct Telling {
    /// Its place among the tasks of the stack.
    member: usize,
    /// The signals that hold the numbers, where they are declared.
    signals: Vec<Option<usize>>,
    numbers: Vec<f64>,
}

impl Telling {
    /// What a member of a stack tells by itself; none where it tells nothing.
    pub fn new(program: &Program, member: usize, m: &Member) -> Option<Telling> {
        let kind = stdlib_tasks::find(m.kind).filter(|k| !k.tells.is_empty())?;
        let signals = kind.tells.iter().map(|t| program.interface.signal(&format!("{}.{}", m.name, t.name)));
        Some(Telling { member, signals: signals.collect(), numbers: vec![f64::NAN; kind.tells.len()] })
    }

    /// Asks the task. Never allocates.
    pub fn listen(&mut self, tasks: &[Box<dyn Task>], state: &State, v: &[f64]) {
        self.numbers.fill(f64::NAN);
        if let Some(task) = tasks.get(self.member) {
            task.told(state, v, &mut self.numbers);
        }
    }
}

impl Evaluator {
    /// The signals that hold what tasks of the stack tell.
    pub(crate) fn telling(&self) -> impl Iterator<Item = usize> {
        self.telling.iter().flat_map(|t| t.signals.iter().flatten().copied())
    }

    /// What tasks tell of this tick, in which the robot moves with `v`, `nv` numbers: each signal with its value, which is
    /// not finite where there is nothing to tell. What planners decided comes last. Never allocates.
    pub(crate) fn told(&self, v: &[f64]) -> impl Iterator<Item = (usize, f64)> {
        let own = self.telling.iter().flat_map(|t| t.signals.iter().zip(&t.numbers));
        let own = own.filter_map(|(signal, number)| Some(((*signal)?, *number)));
        own.chain(self.planners.iter().flat_map(move |p: &Planning| p.told(v)))
    }
}
