//! Satisfaction of people.

use crate::kinds::schedule::adapt::Satisfaction;

use super::ScheduleExecution;

impl ScheduleExecution {
    /// How satisfied this agent is, from what it has said so far; all zero for one who has said nothing, or whom nobody
    /// heeds.
    pub fn satisfaction(&self, agent: usize) -> Satisfaction {
        self.world.satisfied.get(agent).copied().flatten().unwrap_or_default()
    }
}
