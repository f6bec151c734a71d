//! Steps that happen by themselves, and their times.

use crate::execution::World;
use crate::kinds::layers::plan::Activity;
use crate::kinds::layers::problem::Problem;

use super::record::LogEntry;
use super::settings::Settings;
use super::view::Doing;
use super::{LayersExecution, LayersWorld};

/// Something that happens by itself, of an agent. Of what happens at the same time, the first comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Next {
    /// A task ends.
    Ends(usize),
    /// A task has not ended when it was expected to.
    Overdue(usize),
    /// An agent that begins by an event has not begun.
    Waits(usize),
    /// A task begins.
    Begins(usize),
}

impl World for LayersWorld {
    type Problem = Problem;
    type Settings = Settings;
    type Activity = Activity;
    type LogEntry = LogEntry;
    type Step = Next;

    fn due(of: &LayersExecution, _ticks: bool) -> Vec<(f64, Next)> {
        (0..of.world.agents.len()).filter_map(|agent| of.of_agent(agent)).collect()
    }

    fn perform(of: &mut LayersExecution, step: Next) {
        of.happens(step);
    }
}

impl LayersExecution {
    fn of_agent(&self, agent: usize) -> Option<(f64, Next)> {
        let state = &self.world.agents[agent];
        match (&state.doing, &state.task) {
            (_, Some(task)) if task.ends <= task.expected => Some((task.ends, Next::Ends(agent))),
            (_, Some(task)) => Some((task.expected, Next::Overdue(agent))),
            (Doing::Idle, None) if self.settings.reporting.contains(&agent) => {
                let planned = self.ready(agent)?.start;
                Some((state.look.max(planned), Next::Waits(agent)))
            }
            (Doing::Idle, None) => self.ready(agent).map(|_| (self.time, Next::Begins(agent))),
            _ => None,
        }
    }
}
