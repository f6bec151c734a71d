//! The visible state of an execution: poses, present activities and results so far.

use crate::kinds::search::geometry::{Pose, along, length};
use crate::kinds::search::plan::{Activity, Phase};
use crate::kinds::search::problem::Problem;

use super::SearchExecution;

/// The state of an agent, for pages and logs.
#[derive(Clone, Debug, PartialEq)]
pub struct AgentView {
    /// True pose.
    pub pose: Pose,
    /// Pose as the others believe it to be.
    pub believed: Pose,
    /// The current activity; none: it has nothing to do.
    pub doing: Option<Phase>,
    /// The source that it is for.
    pub source: Option<usize>,
    /// Number of the activity, for requests about it.
    pub number: usize,
    /// Since when (s).
    pub since: f64,
    /// Expected end (s).
    pub until: Option<f64>,
    /// It takes no part any more.
    pub lost: bool,
    /// Length of its way so far (m).
    pub travelled: f64,
}

impl SearchExecution {
    /// Reward that the first plan promised.
    pub fn promised(&self) -> f64 {
        self.world.promised
    }

    /// The end of the last activity so far (s).
    pub fn makespan(&self) -> f64 {
        self.world.members.iter().filter_map(|member| member.past.last()).map(|last| last.end).fold(0.0, f64::max)
    }

    /// The problem as it is now, with the agents where they were at the start.
    pub fn problem_from_start(&self) -> Problem {
        let mut problem = self.problem.clone();
        problem.agents.iter_mut().zip(&self.world.starts).for_each(|(who, start)| who.start = *start);
        problem
    }

    /// The state of an agent.
    pub fn agent(&self, agent: usize) -> Option<AgentView> {
        let member = self.world.members.get(agent)?;
        let activity = member.queue.get(member.next).filter(|_| member.current.is_some());
        let current = member.current.as_ref();
        let gone = current.and_then(|current| Some(current.share(self.time) * length(&current.way.as_ref()?.points)));
        Some(AgentView {
            pose: self.true_pose(agent, self.time),
            believed: self.pose(agent, self.time),
            doing: activity.map(|activity| activity.phase),
            source: activity.and_then(|activity| activity.source),
            number: member.past.len(),
            since: current.map_or(self.time, |current| current.began),
            until: current.and_then(|current| current.ends),
            lost: self.problem.agents.get(agent).is_some_and(|who| who.lost),
            travelled: match (&member.stray, &member.driven) {
                (Some(stray), _) => stray.travelled(self.time),
                (None, Some(base)) => base.travelled,
                (None, None) => member.travelled + gone.unwrap_or_default(),
            },
        })
    }

    /// The activities of everybody: those that have ended with their true times, and the rest as it is expected.
    pub fn activities(&self) -> Vec<Activity> {
        let mut rest = self.rest();
        for (member, own) in self.world.members.iter().zip(&mut rest) {
            if let (Some(current), Some(first)) = (&member.current, own.first_mut()) {
                first.start = current.began;
                if let Some(way) = &current.way {
                    first.way.clone_from(&way.points);
                }
            }
        }
        let past = self.world.members.iter().flat_map(|member| member.past.iter().cloned());
        past.chain(rest.into_iter().flatten()).collect()
    }

    pub(super) fn pose(&self, agent: usize, time: f64) -> Pose {
        let member = &self.world.members[agent];
        match &member.current {
            Some(current) => match &current.way {
                Some(way) => along(&way.points, current.share(time), member.pose.heading),
                None => member.pose,
            },
            None => member.pose,
        }
    }
}
