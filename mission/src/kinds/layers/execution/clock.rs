//! Steps that happen by themselves, and their times.

use crate::execution::DiscreteEvents;

use super::LayersExecution;
use super::record::Record;
use super::view::Doing;

/// Something that happens by itself, of an agent. Of what happens at the same time, the first comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Next {
    /// A task ends.
    Ends(usize),
    /// A task has not ended when it was expected to.
    Overdue(usize),
    /// An agent that begins when told has not begun.
    Waits(usize),
    /// A task begins.
    Begins(usize),
}

impl DiscreteEvents for LayersExecution {
    type Step = Next;

    fn now(&self) -> f64 {
        self.time
    }

    fn set_time(&mut self, time: f64) {
        self.time = time;
    }

    fn due(&self, _ticks: bool) -> Vec<(f64, Next)> {
        (0..self.agents.len()).filter_map(|agent| self.of_agent(agent)).collect()
    }

    fn perform(&mut self, step: Next) {
        self.happens(step);
    }
}

impl LayersExecution {
    /// Lets time pass until `to` (s), and returns the records of that time. A time before the present, or no finite number,
    /// lets nothing pass.
    pub fn advance(&mut self, to: f64) -> &[Record] {
        let from = self.log.records.len();
        self.run_until(to);
        &self.log.records[from..]
    }

    /// Time of the next step that happens by itself (s), as far as it is known: a task that ends when it is reported may end
    /// at any time. None: there is no such step.
    pub fn next(&self) -> Option<f64> {
        self.upcoming(false).map(|(time, _)| time)
    }

    fn of_agent(&self, agent: usize) -> Option<(f64, Next)> {
        let state = &self.agents[agent];
        match (&state.doing, &state.task) {
            (_, Some(task)) if task.ends <= task.expected => Some((task.ends, Next::Ends(agent))),
            (_, Some(task)) => Some((task.expected, Next::Overdue(agent))),
            (Doing::Idle, None) if self.settings.told.contains(&agent) => {
                let planned = self.ready(agent)?.start;
                Some((state.look.max(planned), Next::Waits(agent)))
            }
            (Doing::Idle, None) => self.ready(agent).map(|_| (self.time, Next::Begins(agent))),
            _ => None,
        }
    }
}
