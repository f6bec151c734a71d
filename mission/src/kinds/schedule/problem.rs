//! The problem of a schedule as data: robots, agents, lengths, weights, and what has begun already.
//!
//! Notation of thesis Table 5.1. Robots and agents are named by index; operations of an agent count from 0. Lengths are
//! in metres, times in seconds, speeds in metres a second. [`Problem::check`](super::check) says what cannot be planned.

use serde::{Deserialize, Serialize};

use crate::labels::Labels;
use crate::numbers::{Energy, Range};

/// A service robot `m`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Robot {
    /// Its name.
    pub name: String,
    /// Base position `x_m^d` (m): where it starts and where every service ends.
    pub depot: [f64; 2],
    /// Cruising speeds `v_min^c .. v_max^c` (m/s).
    pub speed: Range,
    /// Speeds `v_min^p .. v_max^p` near an agent that says nothing of its own (m/s); none: 0.8 of the team's least and
    /// 0.75 of its greatest cruising speed. Both ends are clamped into `speed`.
    pub proximity: Option<Range>,
    /// Time to serve an agent `delta_m^s` (s). Zero or more.
    pub serve: f64,
    /// Time of what is done at the depot after a service `delta_m^d` (s). Zero or more.
    pub deposit: f64,
    /// Physical factor `mu_m`: larger is more massive. More than 0.
    pub factor: f64,
    /// Coefficients of its power.
    pub energy: Energy,
}

/// What kind of agent is served.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AgentKind {
    /// A person: waits are weighted by `alpha`, feedback is listened to.
    Human,
    /// A working robot: waits are weighted by `beta`.
    Worker,
}

/// How long an operation takes: normal with this mean and standard deviation (s).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Duration {
    /// `phi_a` (s). More than 0.
    pub mean: f64,
    /// `sigma_a` (s). Zero or more.
    pub sigma: f64,
}

/// What an agent wants of one robot's approach instead of the defaults.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Approach {
    /// Index of the robot.
    pub robot: usize,
    /// Speeds from the waiting place to the agent (m/s); none: the robot's.
    pub speed: Option<Range>,
    /// Waiting distance `l_{a,m}^p` (m); none: the agent's.
    pub wait_distance: Option<f64>,
}

/// A working agent `a`: a person or a working robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Agent {
    /// Its name.
    pub name: String,
    /// A person or a robot.
    pub kind: AgentKind,
    /// Where it is served `x_a^s` (m).
    pub place: [f64; 2],
    /// Number of operations `q_a`. Zero: it is part of the team and needs nothing.
    pub operations: usize,
    /// How long one takes.
    pub duration: Duration,
    /// Severity of its working conditions `rho_a^s`, 0 to 1.
    pub severity: f64,
    /// Where a robot waits: this far from the place `l_{a,m}^p` (m). Zero or more.
    pub wait_distance: f64,
    /// What differs for single robots, each robot at most once.
    pub approaches: Vec<Approach>,
    /// `alpha_{a,i}` of the wait after each operation, of a person only: one for each operation, or empty: all 1.
    pub wait_weights: Vec<f64>,
    /// How long a wait may become where what people say makes waits count less (s): what goes beyond counts at least as much as
    /// `limit_weights` say. Zero or more.
    #[serde(default = "wait_limit")]
    pub wait_limit: f64,
    /// The least weight of what goes beyond `wait_limit` of the wait after each operation, of a person only: one for each
    /// operation, or empty: 0. The first feedback on a wait writes down here what waits weighed before.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub limit_weights: Vec<f64>,
    /// `zeta_{a,i}` of the energy near the agent: one for each operation, or empty: all 1.
    pub approach_weights: Vec<f64>,
}

/// How long a wait may become by what people say where nobody declares it (s).
pub const WAIT_LIMIT: f64 = 60.0;

fn wait_limit() -> f64 {
    WAIT_LIMIT
}

/// How long the ways are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Distances {
    /// The straight line between depot and place.
    Straight,
    /// `l_{a,m}^d` (m) by `[robot][agent]`, the length of the path from the depot to the place.
    Table(Vec<Vec<f64>>),
}

/// Weights of the cost (5.5). All zero or more.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Weights {
    /// `beta`, of the waits of working robots.
    pub worker_wait: f64,
    /// `gamma`, of the energy.
    pub energy: f64,
    /// `kappa`, of the makespan.
    pub makespan: f64,
}

/// When a robot passes from one phase of a service to the next (s), ascending. (5.10) holds by construction: each phase
/// begins where the one before ends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ServiceTimes {
    /// It leaves its depot.
    pub going: f64,
    /// It is at the waiting place.
    pub waiting: f64,
    /// It leaves the waiting place.
    pub proximity: f64,
    /// It is with the agent and serves.
    pub serving: f64,
    /// It leaves the agent.
    pub depositing: f64,
    /// It has done what is done at the depot.
    pub end: f64,
}

impl ServiceTimes {
    /// The six instants, in order.
    pub fn instants(&self) -> [f64; 6] {
        [self.going, self.waiting, self.proximity, self.serving, self.depositing, self.end]
    }

    /// All instants later by `delay` (s).
    pub fn later(&self, delay: f64) -> ServiceTimes {
        ServiceTimes {
            going: self.going + delay,
            waiting: self.waiting + delay,
            proximity: self.proximity + delay,
            serving: self.serving + delay,
            depositing: self.depositing + delay,
            end: self.end + delay,
        }
    }
}

/// An operation that has begun when the plan is made. It stays as it is, and so does its service if that has begun.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Begun {
    /// Index of the agent.
    pub agent: usize,
    /// Number of the operation, from 0.
    pub operation: usize,
    /// When it began (s).
    pub start: f64,
    /// When it ended, or is expected to end (s).
    pub end: f64,
    /// The service, if its robot has left the depot: which robot, and its times as they were and are planned.
    pub service: Option<(usize, ServiceTimes)>,
}

/// A robot that takes no new service: it is out of order, or on its way home from a service that was broken off. What it
/// has begun, it goes on with.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Absence {
    /// Index of the robot.
    pub robot: usize,
    /// When it is at its depot and ready (s); none: never.
    pub until: Option<f64>,
}

/// What makes the terms of the cost comparable: the denominators of `Delta`, of `w` and of (5.4).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scales {
    /// Of the makespan (s).
    pub makespan: f64,
    /// Of a wait (s).
    pub wait: f64,
    /// Of the energy of going, proximity and depositing (J); 0 where no robot has a way to go in that phase.
    pub energy: [f64; 3],
}

/// Everything a schedule is planned from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Problem {
    /// The service robots.
    pub robots: Vec<Robot>,
    /// The agents that they serve.
    pub agents: Vec<Agent>,
    /// What people read in place of names.
    #[serde(default, skip_serializing_if = "Labels::is_empty")]
    pub labels: Labels,
    /// How long the ways are.
    pub distances: Distances,
    /// `pr_min`: an operation ends within its planned duration with this probability. Between 0 and 1, both excluded.
    pub confidence: f64,
    /// Weights of the cost.
    pub weights: Weights,
    /// `t_0` (s): when the plan is made. Nothing that has not begun begins before.
    pub start: f64,
    /// What has begun, each operation at most once, the first ones of an agent.
    pub begun: Vec<Begun>,
    /// Robots that take no new service, each at most once.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub absent: Vec<Absence>,
    /// Scales of the cost of a larger mission of which this is a part; none: those of this problem.
    pub scales: Option<Scales>,
}

/// Lengths of the three ways of a service (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lengths {
    /// `l^g`, depot to waiting place.
    pub going: f64,
    /// `l^p`, waiting place to agent.
    pub proximity: f64,
    /// `l^d`, agent to depot.
    pub depositing: f64,
}

impl Problem {
    /// From when on this robot takes new services (s): `start`, or later if it is absent; none if it never does.
    pub fn ready(&self, robot: usize) -> Option<f64> {
        match self.absent.iter().find(|absence| absence.robot == robot) {
            Some(absence) => absence.until.map(|until| until.max(self.start)),
            None => Some(self.start),
        }
    }

    /// What people read for a robot; none if there is none of this index.
    pub fn robot_label(&self, robot: usize) -> Option<&str> {
        self.robots.get(robot).map(|machine| self.labels.member(&machine.name))
    }

    /// What people read for an agent; none if there is none of this index.
    pub fn agent_label(&self, agent: usize) -> Option<&str> {
        self.agents.get(agent).map(|who| self.labels.member(&who.name))
    }

    /// Number of operations of all agents `|O|`.
    pub fn operations(&self) -> usize {
        self.agents.iter().map(|agent| agent.operations).sum()
    }

    /// What holds when this robot approaches this agent: speeds (m/s), clamped into the cruising speeds of the robot
    /// (the thesis asks for that and prints defaults that break it), and waiting distance (m).
    pub fn approach(&self, agent: &Agent, robot: usize) -> (Range, f64) {
        let own = agent.approaches.iter().find(|approach| approach.robot == robot);
        let Some(machine) = self.robots.get(robot) else { return (Range::point(0.0), agent.wait_distance) };
        let asked = own.and_then(|approach| approach.speed).or(machine.proximity).unwrap_or_else(|| {
            let low = self.robots.iter().map(|m| m.speed.low).fold(f64::INFINITY, f64::min);
            let high = self.robots.iter().map(|m| m.speed.high).fold(0.0, f64::max);
            Range::new(0.8 * low, 0.75 * high)
        });
        let clamp = |v: f64| v.max(machine.speed.low).min(machine.speed.high);
        let distance = own.and_then(|approach| approach.wait_distance).unwrap_or(agent.wait_distance);
        (Range::new(clamp(asked.low), clamp(asked.high)), distance)
    }

    /// The ways of this robot to this agent (m). The waiting place lies on the path between depot and agent; beyond the
    /// depot if that is nearer than the waiting distance.
    pub fn lengths(&self, agent: usize, robot: usize) -> Lengths {
        let (Some(who), Some(machine)) = (self.agents.get(agent), self.robots.get(robot)) else {
            return Lengths { going: 0.0, proximity: 0.0, depositing: 0.0 };
        };
        let depositing = match &self.distances {
            Distances::Straight => f64::hypot(machine.depot[0] - who.place[0], machine.depot[1] - who.place[1]),
            Distances::Table(table) => table.get(robot).and_then(|row| row.get(agent)).copied().unwrap_or(0.0),
        };
        let (_, proximity) = self.approach(who, robot);
        Lengths { going: (depositing - proximity).abs(), proximity, depositing }
    }

    /// Where this robot waits for this agent `x_{a,m}^w` (m); none where lengths come from a table.
    pub fn waiting_place(&self, agent: usize, robot: usize) -> Option<[f64; 2]> {
        let (who, machine) = (self.agents.get(agent)?, self.robots.get(robot)?);
        if self.distances != Distances::Straight {
            return None;
        }
        let (dx, dy) = (machine.depot[0] - who.place[0], machine.depot[1] - who.place[1]);
        let length = f64::hypot(dx, dy);
        let (_, wait) = self.approach(who, robot);
        let (ux, uy) = if length > 0.0 { (dx / length, dy / length) } else { (1.0, 0.0) };
        Some([who.place[0] + wait * ux, who.place[1] + wait * uy])
    }

    /// The weight of the wait after an operation: `alpha_{a,i}` of a person, `beta` of a working robot.
    pub fn wait_weight(&self, agent: usize, operation: usize) -> f64 {
        match self.agents.get(agent) {
            Some(who) if who.kind == AgentKind::Human => who.wait_weights.get(operation).copied().unwrap_or(1.0),
            _ => self.weights.worker_wait,
        }
    }

    /// By how much more a second of the wait after an operation weighs beyond the agent's `wait_limit`. Zero or more.
    pub fn limit_weight(&self, agent: usize, operation: usize) -> f64 {
        let Some(who) = self.agents.get(agent).filter(|who| who.kind == AgentKind::Human) else { return 0.0 };
        let least = who.limit_weights.get(operation).copied().unwrap_or(0.0);
        (least - self.wait_weight(agent, operation)).max(0.0)
    }

    /// `zeta_{a,i}`, the weight of the energy near the agent.
    pub fn approach_weight(&self, agent: usize, operation: usize) -> f64 {
        self.agents.get(agent).and_then(|who| who.approach_weights.get(operation)).copied().unwrap_or(1.0)
    }
}
