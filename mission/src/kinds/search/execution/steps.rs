//! Steps that happen by themselves: activities begin and end.

use crate::execution::{Durations, World};
use crate::kinds::search::geometry::{Point, Pose, along, distance, length};
use crate::kinds::search::plan::{Activity, Phase};
use crate::kinds::search::problem::{Agent, Problem};
use crate::kinds::search::ways::Way;
use crate::random::{normal_above, stream};

use super::driven::GRACE;
use super::finds::LOOK;
use super::messages::SAME_PLACE;
use super::record::LogEntry;
use super::rewards::{rates, seat};
use super::settings::Settings;
use super::state::{Current, Member};
use super::{SearchExecution, SearchWorld};

/// Least factor of a sampled duration.
const LEAST: f64 = 0.1;

/// A step of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Step {
    /// The activity under way of an agent ends.
    Ends(usize),
    /// It is checked which hidden objects are detected.
    Look,
    /// A simulated person decides where to go.
    Decides(usize),
    /// A simulated person sends *My pose*.
    Sends(usize),
    /// A person is reminded to do so.
    Reminds(usize),
}

impl World for SearchWorld {
    type Problem = Problem;
    type Settings = Settings;
    type Activity = Activity;
    type LogEntry = LogEntry;
    type Step = Step;

    fn due(of: &SearchExecution, ticks: bool) -> Vec<(f64, Step)> {
        // The activity of somebody who reports goes on behind its expected end, at which only rewards are counted.
        let by_itself = |(agent, member): (usize, &Member)| {
            let ends = member.current.as_ref()?.ends?;
            if of.drives(agent) {
                let late = ends + GRACE;
                return (late <= of.problem.horizon).then_some((late, Step::Ends(agent)));
            }
            let reports = of.settings.reporting.contains(&agent);
            (!reports || (of.world.settled < ends && ends <= of.problem.horizon)).then_some((ends, Step::Ends(agent)))
        };
        let look = (of.world.settled / LOOK + 1e-9).floor() * LOOK + LOOK;
        // Bases are driven to the next step, whose effects they must not precede.
        let steps = ticks || of.world.members.iter().any(|member| member.driven.is_some());
        let looks = steps && of.problem.is_searching() && look <= of.problem.horizon;
        let ends = of.world.members.iter().enumerate().filter_map(by_itself);
        let own = ends.chain(looks.then_some((look, Step::Look)));
        let people = steps.then(|| of.steps_of_people().into_iter().chain(of.steps_of_reminders()));
        own.chain(people.into_iter().flatten()).collect()
    }

    fn perform(of: &mut SearchExecution, step: Step) {
        of.settle();
        match step {
            Step::Ends(agent) if of.drives(agent) => of.overdue(agent),
            Step::Ends(agent) if of.settings.reporting.contains(&agent) => {}
            Step::Ends(agent) => {
                of.end(agent, true);
                of.start(agent);
            }
            Step::Look => {}
            // Messages are events, which plan by themselves.
            Step::Decides(agent) => return of.decide(agent),
            Step::Sends(agent) => return of.send_pose(agent),
            Step::Reminds(agent) => of.remind(agent),
        }
        of.follow();
        of.wake();
    }
}

impl SearchExecution {
    /// Ends the current activity of an agent where it is, or at the end of its way.
    pub(super) fn end(&mut self, agent: usize, whole: bool) {
        let now = self.time;
        let pose = if whole {
            let member = &self.world.members[agent];
            let way = member.current.as_ref().and_then(|current| current.way.as_ref());
            way.map_or(member.pose, |way| along(&way.points, 1.0, member.pose.heading))
        } else {
            self.pose(agent, now)
        };
        let member = &mut self.world.members[agent];
        let Some(current) = member.current.take() else { return };
        let mut reached = None;
        if let Some(activity) = member.queue.get(member.next) {
            let mut activity = activity.clone();
            reached = activity.way.last().copied().filter(|_| whole && activity.phase == Phase::Going);
            (activity.start, activity.end, activity.begun) = (current.began, now, true);
            if let Some(way) = &current.way {
                let share = if whole { 1.0 } else { current.share(now) };
                member.travelled += share * length(&way.points);
                activity.way = part(&way.points, [0.0, share]);
                if let Some(base) = &mut member.driven {
                    activity.way = base.take_driven();
                }
            }
            // An activity that a new plan ended at once was never performed.
            if now > current.began || whole {
                member.past.push(activity);
            }
        }
        member.next += 1;
        member.arrivals += usize::from(reached.is_some());
        self.stand(agent, pose);
        if let (Some(told), Some(at)) = (self.problem.agents[agent].told, reached)
            && distance(told, at) <= SAME_PLACE
        {
            let before = self.role();
            self.problem.agents[agent].told = None;
            self.record(LogEntry::GoalReached { agent });
            self.record_role(before);
        }
    }

    /// An agent stands at a place.
    pub(super) fn stand(&mut self, agent: usize, pose: Pose) {
        let (rates, seat) = (rates(&self.problem, agent, pose.at), seat(&self.problem, agent, pose.at));
        let member = &mut self.world.members[agent];
        (member.pose, member.rates, member.seat) = (pose, rates, seat);
    }

    /// Begins the next activity of an agent.
    pub(super) fn start(&mut self, agent: usize) {
        let member = &self.world.members[agent];
        let Some(activity) = member.queue.get(member.next).filter(|_| !self.problem.agents[agent].lost) else { return };
        let planned = activity.end - activity.start;
        let (phase, source) = (activity.phase, activity.source);
        let way = (phase == Phase::Going).then(|| Way::new(&self.problem, agent, activity.way.clone()));
        // A new plan may have a way to where the base stands already.
        let drives = match (&member.driven, &way) {
            (Some(base), Some(way)) => !base.has_driven(way),
            _ => false,
        };
        let factor = match (self.settings.durations, phase) {
            _ if drives => 1.0,
            (Durations::Sampled { seed }, Phase::Going) if self.problem.agents[agent].spread > 0.0 => {
                let name = &self.problem.agents[agent].name;
                let mut random = stream(seed, &["way", name, &member.ways.to_string()]);
                normal_above(&mut random, 1.0, self.problem.agents[agent].spread, LEAST)
            }
            _ => 1.0,
        };
        let now = self.time;
        let end = way.as_ref().and_then(|way| way.points.last());
        let there = end.map(|end| rates(&self.problem, agent, *end)).unwrap_or_default();
        let seat_there = end.and_then(|end| seat(&self.problem, agent, *end));
        let member = &mut self.world.members[agent];
        member.ways += usize::from(phase == Phase::Going);
        let ends = (phase != Phase::Waiting).then_some(now + factor * planned);
        if let Some(base) = &mut member.driven {
            base.begin();
        }
        let driven = drives.then_some(0.0);
        member.current = Some(Current { began: now, ends, way, there, seat_there, from: [0.0, now], driven });
        self.record(LogEntry::Begun { agent, phase, source });
    }

    /// Lets those go on whose wait is over, and notices that everything is done.
    pub(super) fn wake(&mut self) {
        loop {
            let over = (0..self.world.members.len()).find(|agent| {
                let member = &self.world.members[*agent];
                let activity = member.queue.get(member.next).filter(|_| member.current.is_some());
                let awaited =
                    activity.filter(|activity| activity.phase == Phase::Waiting).map(|activity| activity.awaits);
                awaited.is_some_and(|awaited| awaited.is_none_or(|of| self.has_ended(of.agent, of.number)))
            });
            let Some(agent) = over else { break };
            self.end(agent, true);
            self.start(agent);
        }
        let idle = |(member, who): (&Member, &Agent)| {
            who.lost || (member.current.is_none() && member.next >= member.queue.len())
        };
        let over = self.world.members.iter().zip(&self.problem.agents).all(idle);
        let somebody = self.problem.agents.iter().any(|agent| !agent.lost);
        if over && somebody {
            self.finish(LogEntry::Done);
        }
    }

    fn has_ended(&self, agent: usize, number: usize) -> bool {
        let gone = self.problem.agents.get(agent).is_none_or(|who| who.lost);
        gone || self.world.members.get(agent).is_none_or(|member| member.next > number || member.queue.len() <= number)
    }
}

/// The part of a polyline between two shares of its length.
pub(super) fn part(points: &[Point], [from, to]: [f64; 2]) -> Vec<Point> {
    let whole = length(points);
    let mut cut = vec![along(points, from, 0.0).at];
    let mut gone = 0.0;
    for two in points.windows(2) {
        gone += distance(two[0], two[1]);
        if gone > from * whole + 1e-9 && gone < to * whole - 1e-9 {
            cut.push(two[1]);
        }
    }
    cut.push(along(points, to, 0.0).at);
    cut
}
