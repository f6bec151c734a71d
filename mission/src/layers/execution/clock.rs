//! What happens next.

use super::LayeredExecution;
use super::record::Record;
use super::view::Doing;

/// Something that happens by itself, of an agent. Of what happens at the same time, the first comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Next {
    /// A task ends.
    Ends(usize),
    /// A task has not ended when it was expected to.
    Overdue(usize),
    /// An agent that begins when told has not begun.
    Waits(usize),
    /// A task begins.
    Begins(usize),
}

impl LayeredExecution {
    /// Lets time pass until `to` (s), and gives what happens by then. A time that is not after the present, or no finite
    /// number, lets nothing pass.
    pub fn advance(&mut self, to: f64) -> &[Record] {
        let from = self.records.len();
        if to.is_finite() && to >= self.time {
            while let Some((time, next)) = self.upcoming().filter(|(time, _)| *time <= to) {
                self.time = time;
                self.perform(next);
            }
            self.time = to;
        }
        &self.records[from..]
    }

    /// When something happens next by itself (s), as far as that is known: a task that ends when it is told ends any time.
    /// None: nothing does.
    pub fn next(&self) -> Option<f64> {
        self.upcoming().map(|(time, _)| time)
    }

    fn upcoming(&self) -> Option<(f64, Next)> {
        let all = (0..self.agents.len()).filter_map(|agent| self.of_agent(agent));
        let all = all.map(|(time, next)| (time.max(self.time), next));
        all.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
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
