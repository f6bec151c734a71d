//! Input data of a schedule: service robots, working agents (here called agents), lengths, weights,
//! and the operations that have begun.
//!
//! Notation of thesis Table 5.1. Robots and agents are identified by index; operations of an agent count from 0.
//! Lengths are in metres, times in seconds, speeds in metres per second. [`Problem::check`](super::check) reports
//! mistakes.

use serde::{Deserialize, Serialize};

pub use super::blocks::Weights;
use crate::labels::Labels;
use crate::numbers::{Energy, Range};

/// A service robot `m`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Robot {
    /// Name of the robot.
    pub name: String,
    /// Base position `x_m^d` (m): start of the robot and end of every service.
    pub depot: [f64; 2],
    /// Cruising speeds `v_min^c .. v_max^c` (m/s).
    pub speed: Range,
    /// Speeds `v_min^p .. v_max^p` (m/s) near an agent without its own; `None`: 0.8 of the minimum and 0.75 of the
    /// maximum cruising speed of the team. Both ends are clamped into `speed`.
    pub proximity: Option<Range>,
    /// Time to serve an agent `delta_m^s` (s). Zero or more.
    pub serve: f64,
    /// Time at the depot after a service `delta_m^d` (s). Zero or more.
    pub deposit: f64,
    /// Physical factor `mu_m`: larger is more massive. More than 0.
    pub factor: f64,
    /// Coefficients of the robot's power.
    pub energy: Energy,
}

/// Kind of an agent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AgentKind {
    /// A person: waits are weighted by `alpha`, which feedback changes.
    Human,
    /// A working robot: waits are weighted by `beta`.
    Worker,
}

/// Duration of an operation: normally distributed with this mean and standard deviation (s).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Duration {
    /// `phi_a` (s). More than 0.
    pub mean: f64,
    /// `sigma_a` (s). Zero or more.
    pub sigma: f64,
}

/// Requirements of an agent on the approach of one robot, instead of the defaults.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Approach {
    /// Index of the robot.
    pub robot: usize,
    /// Speeds from the waiting place to the agent (m/s); `None`: those of the robot.
    pub speed: Option<Range>,
    /// Waiting distance `l_{a,m}^p` (m); `None`: that of the agent.
    pub wait_distance: Option<f64>,
}

/// A working agent `a`: a person or a working robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WorkingAgent {
    /// Name of the agent.
    pub name: String,
    /// A person or a robot.
    pub kind: AgentKind,
    /// Position of the service `x_a^s` (m).
    pub place: [f64; 2],
    /// Number of operations `q_a`. If zero, the agent is part of the team but needs no service.
    pub operations: usize,
    /// Duration of an operation.
    pub duration: Duration,
    /// Severity of the working conditions `rho_a^s`, 0 to 1.
    pub severity: f64,
    /// Waiting distance `l_{a,m}^p` of a robot from the agent's position (m). Zero or more.
    pub wait_distance: f64,
    /// Exceptions for single robots, each robot at most once.
    pub approaches: Vec<Approach>,
    /// `alpha_{a,i}`: weights of the waits after each operation, used for a person only; one for each operation, or
    /// empty: all 1.
    pub wait_weights: Vec<f64>,
    /// Limit of waits (s), for a person whose feedback reduces the weight of waits: the time beyond it has at least the
    /// weight `limit_weights`. Zero or more.
    #[serde(default = "wait_limit")]
    pub wait_limit: f64,
    /// Minimum weight of the time beyond `wait_limit` of the wait after each operation, used for a person only; one for
    /// each operation, or empty: 0. The first feedback on a wait stores the previous weights of waits here.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub limit_weights: Vec<f64>,
    /// `zeta_{a,i}`: weights of the energy near the agent; one for each operation, or empty: all 1.
    pub approach_weights: Vec<f64>,
}

impl WorkingAgent {
    /// Creates an agent in usual conditions: a robot waits 1 m away, and every weight is 1.
    pub fn new(
        name: impl Into<String>,
        kind: AgentKind,
        place: [f64; 2],
        operations: usize,
        duration: Duration,
    ) -> WorkingAgent {
        WorkingAgent {
            name: name.into(),
            kind,
            place,
            operations,
            duration,
            severity: 0.0,
            wait_distance: 1.0,
            approaches: Vec::new(),
            wait_weights: Vec::new(),
            wait_limit: WAIT_LIMIT,
            limit_weights: Vec::new(),
            approach_weights: Vec::new(),
        }
    }
}

/// Default of [`Agent::wait_limit`] (s).
pub const WAIT_LIMIT: f64 = 60.0;

fn wait_limit() -> f64 {
    WAIT_LIMIT
}

/// Lengths of the paths.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Distances {
    /// The straight line between depot and place.
    Straight,
    /// `l_{a,m}^d` (m) by `[robot][agent]`, the length of the path from the depot to the place.
    Table(Vec<Vec<f64>>),
}

/// Instants of the transitions between the phases of a service (s), ascending. (5.10) holds by construction: each phase
/// begins at the end of the previous one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ServiceTimes {
    /// The robot leaves its depot.
    pub going: f64,
    /// The robot arrives at the waiting place.
    pub waiting: f64,
    /// The robot leaves the waiting place.
    pub proximity: f64,
    /// The robot arrives at the agent and serves.
    pub serving: f64,
    /// The robot leaves the agent.
    pub depositing: f64,
    /// The robot has finished at the depot.
    pub end: f64,
}

impl ServiceTimes {
    /// Returns the six instants, in order.
    pub fn instants(&self) -> [f64; 6] {
        [self.going, self.waiting, self.proximity, self.serving, self.depositing, self.end]
    }

    /// Returns all instants shifted later by `delay` (s).
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

/// An operation that has begun when the plan is made. It stays unchanged, and so does its service if that has begun.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Begun {
    /// Index of the agent.
    pub agent: usize,
    /// Number of the operation, from 0.
    pub operation: usize,
    /// Start of the operation (s).
    pub start: f64,
    /// Observed or expected end of the operation (s).
    pub end: f64,
    /// The service, if its robot has left the depot: the robot, and the past and planned instants.
    pub service: Option<(usize, ServiceTimes)>,
}

/// A robot that takes no new service: it is out of order, or returning from an aborted service. It continues services
/// that it has begun.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Absence {
    /// Index of the robot.
    pub robot: usize,
    /// Instant at which the robot is at its depot and ready (s); `None`: never.
    pub until: Option<f64>,
}

/// Scales of the terms of the cost: the denominators of `Delta`, of `w` and of (5.4).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scales {
    /// Scale of the makespan (s).
    pub makespan: f64,
    /// Scale of a wait (s).
    pub wait: f64,
    /// Scales of the energy of going, proximity and depositing (J); 0 if no robot has a leg of positive length in that
    /// phase.
    pub energy: [f64; 3],
}

/// Problem of a schedule.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Problem {
    /// The service robots.
    pub robots: Vec<Robot>,
    /// The agents to serve.
    pub agents: Vec<WorkingAgent>,
    /// Labels that are displayed instead of names.
    #[serde(default, skip_serializing_if = "Labels::is_empty")]
    pub labels: Labels,
    /// Lengths of the paths.
    pub distances: Distances,
    /// `pr_min`: an operation ends within its planned duration with this probability. Between 0 and 1, both excluded.
    pub confidence: f64,
    /// Weights of the cost.
    pub weights: Weights,
    /// `t_0` (s): instant at which the plan is made. Everything that has not begun begins then or later.
    pub start: f64,
    /// Operations that have begun, each at most once, the first ones of each agent.
    pub begun: Vec<Begun>,
    /// Robots that take no new service, each at most once.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub absent: Vec<Absence>,
    /// Scales of the cost of a larger mission of which this is a part; `None`: those of this problem.
    pub scales: Option<Scales>,
}

/// Lengths of the three legs of a service (m).
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
    /// Creates a problem on straight paths with confidence 0.9, in which every weight is 1 and nothing has begun.
    pub fn new(robots: Vec<Robot>, agents: Vec<WorkingAgent>) -> Problem {
        Problem {
            robots,
            agents,
            labels: Labels::default(),
            distances: Distances::Straight,
            confidence: 0.9,
            weights: Weights { worker_wait: 1.0, energy: 1.0, makespan: 1.0 },
            start: 0.0,
            begun: Vec::new(),
            absent: Vec::new(),
            scales: None,
        }
    }

    /// Returns the instant from which this robot takes new services (s): `start`, or later if it is absent; `None` if
    /// it never does.
    pub fn ready(&self, robot: usize) -> Option<f64> {
        match self.absent.iter().find(|absence| absence.robot == robot) {
            Some(absence) => absence.until.map(|until| until.max(self.start)),
            None => Some(self.start),
        }
    }

    /// Returns the label of a robot; `None` if the index is out of range.
    pub fn robot_label(&self, robot: usize) -> Option<&str> {
        self.robots.get(robot).map(|machine| self.labels.member(&machine.name))
    }

    /// Returns the label of an agent; `None` if the index is out of range.
    pub fn agent_label(&self, agent: usize) -> Option<&str> {
        self.agents.get(agent).map(|who| self.labels.member(&who.name))
    }

    /// Returns the number of operations of all agents `|O|`.
    pub fn operations(&self) -> usize {
        self.agents.iter().map(|agent| agent.operations).sum()
    }

    /// Returns the speeds (m/s) and the waiting distance (m) of this robot's approach to this agent. The speeds are
    /// clamped into the cruising speeds of the robot (the thesis requires that and prints defaults that violate it).
    pub fn approach(&self, agent: &WorkingAgent, robot: usize) -> (Range, f64) {
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

    /// Computes the lengths of the legs of this robot to this agent (m). The waiting place lies on the path between
    /// depot and agent, or beyond the depot if that is closer than the waiting distance.
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

    /// Computes the waiting place of this robot for this agent `x_{a,m}^w` (m); `None` if lengths are given by a table.
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

    /// Returns the weight of the wait after an operation: `alpha_{a,i}` of a person, `beta` of a working robot.
    pub fn wait_weight(&self, agent: usize, operation: usize) -> f64 {
        match self.agents.get(agent) {
            Some(who) if who.kind == AgentKind::Human => who.wait_weights.get(operation).copied().unwrap_or(1.0),
            _ => self.weights.worker_wait,
        }
    }

    /// Returns the additional weight of the wait after an operation beyond the agent's `wait_limit`. Zero or more.
    pub fn limit_weight(&self, agent: usize, operation: usize) -> f64 {
        let Some(who) = self.agents.get(agent).filter(|who| who.kind == AgentKind::Human) else { return 0.0 };
        let least = who.limit_weights.get(operation).copied().unwrap_or(0.0);
        (least - self.wait_weight(agent, operation)).max(0.0)
    }

    /// Returns `zeta_{a,i}`, the weight of the energy near the agent.
    pub fn approach_weight(&self, agent: usize, operation: usize) -> f64 {
        self.agents.get(agent).and_then(|who| who.approach_weights.get(operation)).copied().unwrap_or(1.0)
    }
}
