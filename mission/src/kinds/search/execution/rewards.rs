//! Rewards of the team while it is under way: the motions since they were settled last, and what these yield.

use crate::kinds::search::geometry::{Point, along};
use crate::kinds::search::problem::{EMPTY, Problem};
use crate::kinds::search::reward::{Motion, Rewards};
use crate::kinds::search::ways::rate;

use super::SearchExecution;
use super::record::LogEntry;
use super::state::Current;

/// Reward rates of the sources (1/s) for an agent that stands at a place.
pub(super) fn rates(problem: &Problem, agent: usize, at: Point) -> Vec<f64> {
    (0..problem.sources.len()).map(|source| rate(problem, agent, source, at, 0.0)).collect()
}

impl SearchExecution {
    /// Rewards up to now.
    pub fn rewards(&self) -> Rewards {
        let mut rewards = self.world.rewards.clone();
        let until = self.time.min(self.problem.horizon);
        if until > self.world.settled {
            rewards.add(&self.problem, &self.motions(until), until - self.world.settled, &mut Vec::new());
        }
        rewards
    }

    /// Motions since rewards were settled last.
    fn motions(&self, until: f64) -> Vec<Motion<'_>> {
        (0..self.world.members.len()).map(|agent| self.motion(agent, until)).collect()
    }

    fn motion(&self, agent: usize, until: f64) -> Motion<'_> {
        let member = &self.world.members[agent];
        match &member.current {
            _ if self.problem.agents[agent].lost => Motion::Absent,
            Some(current @ Current { way: Some(way), there, .. }) => {
                let (from, to) = (current.share(self.world.settled), current.share(until));
                if to <= from {
                    let pose = along(&way.points, to, member.pose.heading);
                    // Nobody has said that it has arrived.
                    return Motion::Still { rates: there, pose, idle: true };
                }
                let pace = (until - self.world.settled) / ((to - from) * way.duration);
                Motion::Along { way, shares: [from, to], pace }
            }
            current => Motion::Still { rates: &member.rates, pose: member.pose, idle: current.is_none() },
        }
    }

    /// Settles the rewards up to now.
    pub(super) fn settle(&mut self) {
        let until = self.time.min(self.problem.horizon);
        if until <= self.world.settled {
            return;
        }
        let mut rewards = self.world.rewards.clone();
        rewards.add(&self.problem, &self.motions(until), until - self.world.settled, &mut Vec::new());
        let before = std::mem::replace(&mut self.world.rewards, rewards);
        self.world.settled = until;
        for source in 0..self.problem.sources.len() {
            if before.pools[source] > EMPTY && self.world.rewards.pools[source] <= EMPTY {
                self.record(LogEntry::Consumed { source });
            }
        }
    }
}
