//! Agents whose bases controllers of their own drive: where such an agent truly is, how far it has come along its way, and
//! when it is late.
//!
//! The plan has a driven agent on its way, at the point of it that its base has reached; its true position is that of the base.
//! Others know it. Rewards and hidden objects follow the base, of which a sample is taken ten times a second; while it stays, a
//! base that is no farther from the place than its tolerance is exactly there. A way ends when an event says that the base
//! has arrived. One that has not arrived a second after the expected end is late, by the time that the rest of the way takes.

use crate::execution::ReplanPolicy;
use crate::kind::course::{Course, GroundPose, covered};
use crate::kind::{Work, WorkState};
use crate::kinds::search::geometry::{Point, Pose, distance, length};
use crate::kinds::search::plan::Phase;
use crate::kinds::search::problem::{Problem, Travel};
use crate::kinds::search::reward::Motion;
use crate::kinds::search::ways::{Way, rate};

use super::SearchExecution;
use super::event::Event;
use super::record::LogEntry;
use super::rewards::seat;
use super::state::Member;

/// Time between two samples of the motion of a base (s). Ours.
const SAMPLE: f64 = 0.1;
/// Time (s) behind its expected end at which a way is late. Ours.
pub(super) const GRACE: f64 = 1.0;
/// Length (m) of the next part of a way on which the nearest point to a base is looked for. Ours.
const REACH: f64 = 1.0;
/// Distance (m) between two points of a way that was driven. Ours.
const STEP: f64 = 0.05;

/// The true motion of an agent from a time on.
#[derive(Clone, Debug)]
struct Sample {
    since: f64,
    pose: Pose,
    /// Reward rates of the sources (1/s).
    rates: Vec<f64>,
    /// Cell from which it sees.
    seat: Option<u32>,
}

/// The base of an agent.
#[derive(Clone, Debug)]
pub(super) struct DrivenBase {
    /// Distance from a place within which it is there (m).
    tolerance: f64,
    pub pose: Pose,
    pub travelled: f64,
    /// Its motion since rewards were settled last.
    samples: Vec<Sample>,
    /// The way that it has driven since its activity began (m).
    driven: Vec<Point>,
    /// Number of times that its way was late.
    late: usize,
}

impl DrivenBase {
    /// A base that stands at the start.
    pub fn new(problem: &Problem, agent: usize, pose: Pose, tolerance: f64) -> DrivenBase {
        let first = sample(problem, agent, problem.start, pose, Travel::REST);
        DrivenBase { tolerance, pose, travelled: 0.0, samples: vec![first], driven: vec![pose.at], late: 0 }
    }

    /// Times (s) at which its motion has a new sample.
    pub fn edges(&self) -> impl Iterator<Item = f64> + '_ {
        self.samples.iter().map(|sample| sample.since)
    }

    /// Forgets the motion before a time (s).
    pub fn settled(&mut self, until: f64) {
        let old = self.samples.partition_point(|sample| sample.since <= until);
        self.samples.drain(..old.saturating_sub(1));
    }

    /// An activity begins.
    pub fn begin(&mut self) {
        (self.driven, self.late) = (vec![self.pose.at], 0);
    }

    /// The way that it has driven since its activity began.
    pub fn take_driven(&mut self) -> Vec<Point> {
        let mut way = std::mem::replace(&mut self.driven, vec![self.pose.at]);
        way.push(self.pose.at);
        way
    }

    /// Returns true if it is at the end of a way already, which is no longer than its tolerance.
    pub fn has_driven(&self, way: &Way) -> bool {
        let end = way.points.last().copied().unwrap_or(self.pose.at);
        length(&way.points) <= self.tolerance && distance(self.pose.at, end) <= self.tolerance
    }

    fn sample_at(&self, time: f64) -> Option<&Sample> {
        let behind = self.samples.partition_point(|sample| sample.since <= time + 1e-9);
        self.samples.get(behind.saturating_sub(1))
    }
}

fn sample(problem: &Problem, agent: usize, since: f64, pose: Pose, travel: Travel) -> Sample {
    let rates = (0..problem.sources.len()).map(|source| rate(problem, agent, source, pose.at, travel)).collect();
    Sample { since, pose, rates, seat: seat(problem, agent, pose.at) }
}

impl SearchExecution {
    /// The base of a driven agent is at a pose, at a time (s) between the present and the next step.
    pub(crate) fn drive(&mut self, agent: usize, time: f64, to: GroundPose) {
        let pose = Pose { at: to.at, heading: to.heading };
        let Some(member) = self.world.members.get_mut(agent) else { return };
        let Some(base) = &mut member.driven else { return };
        base.travelled += distance(base.pose.at, pose.at);
        base.pose = pose;
        if base.driven.last().is_none_or(|last| distance(*last, pose.at) >= STEP) {
            base.driven.push(pose.at);
        }
        let last = base.samples.last().map_or((f64::NEG_INFINITY, pose.at), |last| (last.since, last.pose.at));
        if time - last.0 >= SAMPLE - 1e-9 {
            let speed = distance(last.1, pose.at) / (time - last.0);
            let heading = f64::atan2(pose.at[1] - last.1[1], pose.at[0] - last.1[0]);
            base.samples.push(sample(&self.problem, agent, time, pose, Travel { speed, heading }));
        }
        if let Some(current) = &mut member.current
            && let (Some(way), Some(share)) = (&current.way, &mut current.driven)
        {
            *share = covered(&way.points, *share, pose.at, REACH);
        }
    }

    /// Returns true if an agent is on a way that a controller drives.
    pub(super) fn drives(&self, agent: usize) -> bool {
        let current = self.world.members.get(agent).and_then(|member| member.current.as_ref());
        current.is_some_and(|current| current.driven.is_some())
    }

    /// The way of a driven agent.
    pub(crate) fn course(&self, agent: usize) -> Option<Course<'_>> {
        let member = self.world.members.get(agent)?;
        member.driven.as_ref()?;
        let state = self.driven_work(agent)?.state;
        let standing = Course {
            state,
            points: std::slice::from_ref(&member.pose.at),
            times: &[],
            share: 1.0,
            from: [1.0, self.time],
            ends: self.time,
            heading: member.pose.heading,
        };
        let Some(current) = &member.current else { return Some(standing) };
        let (Some(way), Some(share), Some(ends)) = (&current.way, current.driven, current.ends) else {
            return Some(standing);
        };
        Some(Course { points: &way.points, share, from: current.from, ends, ..standing })
    }

    /// The work of a driven agent.
    pub(crate) fn driven_work(&self, agent: usize) -> Option<Work> {
        let (member, who) = (self.world.members.get(agent)?, self.problem.agents.get(agent)?);
        member.driven.as_ref()?;
        let state = match &member.current {
            _ if who.lost => WorkState::Lost,
            Some(current) if current.driven.is_some() => WorkState::Works,
            None if member.next >= member.queue.len() => WorkState::Over,
            _ => WorkState::Waits,
        };
        Some(Work { state, since: member.current.as_ref().map_or(self.time, |current| current.began) })
    }

    /// The motion of a driven agent between two times (s) that no sample separates; none: nobody drives it.
    pub(super) fn driven_motion(&self, agent: usize, from: f64) -> Option<Motion<'_>> {
        let member: &Member = &self.world.members[agent];
        let base = member.driven.as_ref()?;
        let sample = base.sample_at(from)?;
        let activity = member.queue.get(member.next).filter(|_| member.current.is_some());
        let stays = activity.is_none_or(|activity| activity.phase != Phase::Going);
        let idle = activity.is_none();
        Some(match stays && distance(sample.pose.at, member.pose.at) <= base.tolerance {
            true => Motion::Still { rates: &member.rates, pose: member.pose, seat: member.seat, idle },
            false => Motion::Still { rates: &sample.rates, pose: sample.pose, seat: sample.seat, idle },
        })
    }

    /// The base of an agent has not arrived at the expected end of its way.
    pub(super) fn overdue(&mut self, agent: usize) {
        let (now, speed) = (self.time, self.problem.agents[agent].speed);
        let Some(current) = &self.world.members[agent].current else { return };
        let rest = current.way.as_ref().map_or(0.0, |way| (1.0 - current.share(now)) * length(&way.points)) / speed;
        let ends = current.ends.unwrap_or(now);
        let count = self.world.members[agent].driven.as_mut().map_or(1, |base| {
            base.late += 1;
            base.late
        });
        // A base that is held up near the end is late less and less often.
        let by = now + rest.max(GRACE * (count - 1) as f64) - ends;
        self.record(LogEntry::Handled { event: Event::Late { agent, by } });
        self.late(agent, by);
        self.update(ReplanPolicy::while_late(count));
    }
}
