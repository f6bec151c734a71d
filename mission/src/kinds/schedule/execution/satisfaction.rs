//! Satisfaction of people.

use crate::kinds::schedule::adapt::Satisfaction;

use super::ScheduleExecution;

impl ScheduleExecution {
    /// Satisfaction of an agent by its feedback so far; zero for one without feedback, and for one whose feedback is
    /// not used.
    pub fn satisfaction(&self, agent: usize) -> Satisfaction {
        self.world.satisfied.get(agent).copied().flatten().unwrap_or_default()
    }
}
