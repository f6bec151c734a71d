//! Rewards of the team while it is under way: the motions since they were settled last, and what these yield.

use crate::kinds::search::geometry::{Point, along};
use crate::kinds::search::problem::{EMPTY, Problem, Travel};
use crate::kinds::search::reward::{Motion, Rewards};
use crate::kinds::search::ways::rate;

use super::SearchExecution;
use super::record::LogEntry;
use super::state::Current;

/// Reward rates of the sources (1/s) for an agent that stands at a place.
pub(super) fn rates(problem: &Problem, agent: usize, at: Point) -> Vec<f64> {
    (0..problem.sources.len()).map(|source| rate(problem, agent, source, at, Travel::REST)).collect()
}

/// Cell from which an agent sees at a place; none: it does not look for hidden objects.
pub(super) fn seat(problem: &Problem, agent: usize, at: Point) -> Option<u32> {
    problem.looks(agent)?;
    problem.sight().seat(at)
}

impl SearchExecution {
    /// Rewards up to now.
    pub fn rewards(&self) -> Rewards {
        let mut rewards = self.world.rewards.clone();
        self.collect(&mut rewards);
        rewards
    }

    /// The intervals since rewards were settled last, up to now. The end of the way of somebody who strays cuts them,
    /// and so do samples of the motion of bases.
    fn intervals(&self) -> Vec<[f64; 2]> {
        let until = self.time.min(self.problem.horizon);
        let from = self.world.settled;
        let ends = self.world.members.iter().filter_map(|member| Some(member.stray.as_ref()?.ends()));
        let samples =
            self.world.members.iter().filter_map(|member| member.driven.as_ref()).flat_map(|base| base.edges());
        let mut edges: Vec<f64> =
            ends.chain(samples).filter(|end| from < *end && *end < until).chain([from, until]).collect();
        edges.sort_by(f64::total_cmp);
        edges.windows(2).filter(|two| two[0] < two[1] && two[1] > from).map(|two| [two[0], two[1]]).collect()
    }

    /// Adds what was collected from sources since rewards were settled last, up to now.
    fn collect(&self, rewards: &mut Rewards) {
        for [from, to] in self.intervals() {
            let motions: Vec<Motion<'_>> =
                (0..self.world.members.len()).map(|agent| self.motion(agent, from, to)).collect();
            rewards.add(&self.problem, &motions, to - from, &mut Vec::new());
        }
    }

    /// The true motion of an agent between two times (s).
    pub(super) fn motion(&self, agent: usize, from: f64, until: f64) -> Motion<'_> {
        match &self.world.members[agent].stray {
            Some(stray) if !self.problem.agents[agent].lost => stray.motion(from, until),
            _ => self.believed_motion(agent, from, until),
        }
    }

    /// The motion of an agent between two times (s) as the others believe it: that of the plan.
    pub(super) fn believed_motion(&self, agent: usize, from: f64, until: f64) -> Motion<'_> {
        let member = &self.world.members[agent];
        if self.problem.agents[agent].lost {
            return Motion::Absent;
        }
        if let Some(motion) = self.driven_motion(agent, from) {
            return motion;
        }
        match &member.current {
            Some(current @ Current { way: Some(way), there, seat_there, .. }) => {
                let (begin, end) = (current.share(from), current.share(until));
                if end <= begin {
                    let pose = along(&way.points, end, member.pose.heading);
                    // Nobody has said that it has arrived.
                    return Motion::Still { rates: there, pose, seat: *seat_there, idle: true };
                }
                let pace = (until - from) / ((end - begin) * way.duration);
                Motion::Along { way, shares: [begin, end], pace }
            }
            current => {
                Motion::Still { rates: &member.rates, pose: member.pose, seat: member.seat, idle: current.is_none() }
            }
        }
    }

    /// Settles the rewards up to now.
    pub(super) fn settle(&mut self) {
        let until = self.time.min(self.problem.horizon);
        if until <= self.world.settled {
            return;
        }
        let mut rewards = self.world.rewards.clone();
        self.collect(&mut rewards);
        let before = std::mem::replace(&mut self.world.rewards, rewards);
        let intervals = self.intervals();
        self.world.settled = until;
        intervals.into_iter().for_each(|[from, to]| {
            self.learn(from, to);
            self.look(from, to);
        });
        self.world.members.iter_mut().filter_map(|member| member.driven.as_mut()).for_each(|base| base.settled(until));
        for source in 0..self.problem.sources.len() {
            if before.pools[source] > EMPTY && self.world.rewards.pools[source] <= EMPTY {
                self.record(LogEntry::Consumed { source });
            }
        }
    }
}
