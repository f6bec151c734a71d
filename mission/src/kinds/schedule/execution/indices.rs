//! Adaptation index of a person: their next planned service before and after their feedback is applied; see
//! [`adaptation_index`].

use crate::kinds::schedule::adaptation_index::{Quantity, adaptation_index};
use crate::kinds::schedule::cost;

use super::ScheduleExecution;

/// Adaptation indices of a person.
#[derive(Clone, Copy, Debug)]
pub(super) struct Indices {
    pub wait: f64,
    pub speed: f64,
}

impl Indices {
    /// Of a person who has asked for nothing.
    pub const NONE: Indices = Indices { wait: 1.0, speed: 1.0 };

    /// After a feedback about wait and speed. `before` and `after` are wait (s) and speed (m/s) of the next service.
    pub fn after(self, wait: f64, speed: f64, before: (f64, f64), after: (f64, f64)) -> Indices {
        Indices {
            wait: adaptation_index(self.wait, Quantity::Wait, wait, before.0, after.0),
            speed: adaptation_index(self.speed, Quantity::Speed, speed, before.1, after.1),
        }
    }
}

impl ScheduleExecution {
    /// Wait (s) and speed (m/s) of the next service of an agent in the plan; none if there is none.
    pub(super) fn next_wait_and_speed(&self, agent: usize) -> Option<(f64, f64)> {
        let at = self.service(agent, self.world.agents[agent].operation)?;
        let time = at.times.serving - at.times.proximity;
        let speed = if time > 0.0 { self.problem.lengths(agent, at.robot).proximity / time } else { 0.0 };
        Some((cost::wait(&self.world.schedule, at).max(0.0), speed))
    }
}
