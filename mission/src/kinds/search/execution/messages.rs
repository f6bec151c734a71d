//! Messages between people and robots (srs sections 6 and 7.1), and the beliefs that they correct.
//!
//! The others believe an agent to be where the plan has it. A person may stray from the plan without telling anybody: then the
//! belief goes on along the plan, and the plan with it, until the person is seen or says where they are. Goals that are told are
//! kept until they are reached, and the plan is made around them. Rewards are those of what people truly do.

use crate::execution::ReplanPolicy;
use crate::kinds::search::geometry::{Point, Pose, along, distance, length};
use crate::kinds::search::ground::{Body, Ground};
use crate::kinds::search::reward::Motion;
use crate::kinds::search::ways::Way;

use super::SearchExecution;
use super::event::EventError;
use super::record::LogEntry;
use super::rewards::{rates, seat};

/// Two places nearer than this are one (m).
pub(super) const SAME_PLACE: f64 = 0.05;

/// A person who strays, and says to be at most this far from the truth (m), is found and follows the plan again. Ours.
pub(super) const FOUND: f64 = 1.0;

/// The way of a person who has left the plan, and then stays at its end.
#[derive(Clone, Debug)]
pub(super) struct Stray {
    pub way: Way,
    /// Time at which it began (s).
    pub since: f64,
    /// Reward rates of the sources at its end (1/s).
    pub there: Vec<f64>,
    /// Cell from which the person sees at its end.
    pub seat: Option<u32>,
    /// Distance covered before it (m).
    pub before: f64,
}

impl Stray {
    /// Share of the way at a time (s), 1 or more behind its end.
    fn share(&self, time: f64) -> f64 {
        if self.way.duration > 0.0 { (time - self.since) / self.way.duration } else { 1.0 }
    }

    /// Time at which it ends (s).
    pub fn ends(&self) -> f64 {
        self.since + self.way.duration
    }

    /// The motion between two times (s) that its end does not separate.
    pub fn motion(&self, from: f64, to: f64) -> Motion<'_> {
        if from >= self.ends() - 1e-9 {
            return Motion::Still {
                rates: &self.there,
                pose: along(&self.way.points, 1.0, 0.0),
                seat: self.seat,
                idle: false,
            };
        }
        Motion::Along { way: &self.way, shares: [self.share(from), self.share(to)], pace: 1.0 }
    }

    /// Distance covered (m) at a time, with that before it.
    pub fn travelled(&self, time: f64) -> f64 {
        self.before + self.share(time).min(1.0) * length(&self.way.points)
    }

    fn pose(&self, time: f64, heading: f64) -> Pose {
        along(&self.way.points, self.share(time).min(1.0), heading)
    }
}

/// Numbers of messages that were sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MessageCounts {
    /// *My pose*.
    pub poses: usize,
    /// *My goal*.
    pub goals: usize,
    /// *Robot goal*.
    pub robot_goals: usize,
    /// *Robot pose*.
    pub robot_poses: usize,
    /// *Replan*.
    pub replans: usize,
}

impl MessageCounts {
    /// Number of all messages.
    pub fn all(self) -> usize {
        self.poses + self.goals + self.robot_goals + self.robot_poses + self.replans
    }
}

/// Roles of people and robots: deciders of their goals, srs section 6.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The plan decides both (6.1).
    LeaderFollower,
    /// A person has told their goal (6.2).
    PeerToPeer,
    /// A person has told their goal and that of a robot (6.3).
    MasterSlave,
    /// A person has told the goal of a robot alone (6.4).
    LeaderLeader,
}

impl Role {
    /// All roles.
    pub const ALL: [Role; 4] = [Role::LeaderFollower, Role::PeerToPeer, Role::MasterSlave, Role::LeaderLeader];

    /// Name, as in the paper.
    pub fn name(self) -> &'static str {
        match self {
            Role::LeaderFollower => "leader-follower",
            Role::PeerToPeer => "peer-to-peer",
            Role::MasterSlave => "master-slave",
            Role::LeaderLeader => "leader-leader",
        }
    }
}

impl SearchExecution {
    /// The role that follows from the goals that are told at present.
    pub fn role(&self) -> Role {
        let told =
            |human: bool| self.problem.agents.iter().any(|who| who.human == human && who.told.is_some() && !who.lost);
        match (told(true), told(false)) {
            (false, false) => Role::LeaderFollower,
            (true, false) => Role::PeerToPeer,
            (true, true) => Role::MasterSlave,
            (false, true) => Role::LeaderLeader,
        }
    }

    /// Messages that people have sent.
    pub fn messages(&self) -> MessageCounts {
        self.world.sent
    }

    /// The goal of an agent that somebody has told (m).
    pub fn told_goal(&self, agent: usize) -> Option<Point> {
        self.problem.agents.get(agent).and_then(|who| who.told)
    }

    /// The true pose of an agent.
    pub fn true_pose(&self, agent: usize, time: f64) -> Pose {
        let member = &self.world.members[agent];
        match (&member.stray, &member.driven) {
            (Some(stray), _) => stray.pose(time, member.pose.heading),
            (None, Some(base)) => base.pose,
            (None, None) => self.pose(agent, time),
        }
    }

    /// An agent is believed to be at a place from now on, and planned for from there.
    pub(super) fn believe(&mut self, agent: usize, at: Point) {
        if distance(self.pose(agent, self.time).at, at) <= SAME_PLACE {
            // The plan has it there already.
            return self.update(ReplanPolicy::IfCostly);
        }
        self.place(agent, at);
        self.update(ReplanPolicy::IfInfeasible);
    }

    /// An agent stands at a place, where no activity of the plan begins.
    pub(super) fn place(&mut self, agent: usize, at: Point) {
        self.end(agent, false);
        let heading = self.world.members[agent].pose.heading;
        self.stand(agent, Pose { at, heading });
        self.world.members[agent].displace(true);
        self.reopen();
        // A goal is dropped that cannot be reached from there.
        if let Some(told) = self.told_goal(agent)
            && self.check_place(agent, told, Some(at)).is_err()
        {
            let before = self.role();
            self.problem.agents[agent].told = None;
            self.record_role(before);
        }
    }

    /// A goal is told, or withdrawn: everything is planned anew around it.
    pub(super) fn tell_goal(&mut self, agent: usize, goal: Option<Point>) {
        let before = self.role();
        self.problem.agents[agent].told = goal;
        let at = self.pose(agent, self.time).at;
        self.place(agent, at);
        self.record_role(before);
        self.update(ReplanPolicy::IfInfeasible);
    }

    /// Notes that the role has changed since `before`.
    pub(super) fn record_role(&mut self, before: Role) {
        let role = self.role();
        if role != before {
            self.record(LogEntry::Role { role });
        }
    }

    /// A person leaves the plan for a place, and tells nobody.
    pub(super) fn let_stray(&mut self, agent: usize, to: Point) {
        let from = self.true_pose(agent, self.time).at;
        let ground = Ground::new(&self.problem, &Body::of(&self.problem.agents[agent]));
        let raster = ground.raster();
        // The check has found this way.
        let points = raster.reached(from).way(to).unwrap_or_else(|| vec![from, to]);
        let way = Way::new(&self.problem, agent, points);
        let (there, seat) = (rates(&self.problem, agent, to), seat(&self.problem, agent, to));
        let before = self.agent(agent).map_or(0.0, |view| view.travelled);
        self.world.members[agent].stray = Some(Stray { way, since: self.time, there, seat, before });
    }

    /// A person follows the plan again, from where the person truly is: the caller places the person there.
    pub(super) fn end_stray(&mut self, agent: usize) {
        let time = self.time;
        if let Some(stray) = self.world.members[agent].stray.take() {
            let at = stray.pose(time, 0.0).at;
            self.place(agent, at);
            self.world.members[agent].travelled = stray.travelled(time);
        }
    }

    /// Checks that an agent fits at a place, and reaches it from `from` if that is given.
    pub(super) fn check_place(&self, agent: usize, to: Point, from: Option<Point>) -> Result<(), EventError> {
        let who = &self.problem.agents[agent];
        let name = || self.problem.agent_label(agent).to_string();
        let ground = Ground::new(&self.problem, &Body::of(who));
        if !ground.fits(to) {
            return Err(EventError::NotFree { name: name(), at: to });
        }
        let Some(from) = from else { return Ok(()) };
        match ground.clear(from, to) || ground.raster().reached(from).reaches(to) {
            true => Ok(()),
            false => Err(EventError::NoWay { name: name(), at: to }),
        }
    }

    /// Checks a goal: it is another one than that told before, free, and can be reached.
    pub(super) fn check_goal(&self, agent: usize, to: Point) -> Result<(), EventError> {
        if self.told_goal(agent).is_some_and(|told| distance(told, to) <= SAME_PLACE) {
            return Err(EventError::SameGoal { name: self.problem.agent_label(agent).to_string() });
        }
        self.check_place(agent, to, Some(self.pose(agent, self.time).at))
    }
}
