//! State of the agents and robots in the world.

use crate::kinds::schedule::problem::{Problem, WorkingAgent};

use super::motion::Leg;
use super::view::{Doing, Stage};

/// An agent.
#[derive(Clone, Debug)]
pub(super) struct AgentState {
    pub doing: Doing,
    /// Since when (s).
    pub since: f64,
    /// The operation under way, or the next one. Those before have been served.
    pub operation: usize,
    /// Start of the operation under way (s).
    pub start: f64,
    /// True end (s); infinite: an event reports it.
    pub ends: f64,
    /// Expected end (s).
    pub expected: f64,
    /// Number of expected ends that have passed.
    pub late: usize,
    /// Waits after the operations that have been served (s), as far as they are known.
    pub waits: Vec<f64>,
    /// Wait (s) without a service, before it left or began again; part of its next wait.
    pub carried: f64,
    /// Approach speeds of the robots that served its operations (m/s).
    pub speeds: Vec<f64>,
    /// Robot of the last service.
    pub last: Option<usize>,
}

impl AgentState {
    pub fn new(who: &WorkingAgent, time: f64) -> AgentState {
        AgentState {
            doing: if who.operations == 0 { Doing::Finished } else { Doing::Ready },
            since: time,
            operation: 0,
            start: time,
            ends: time,
            expected: time,
            late: 0,
            waits: Vec::new(),
            carried: 0.0,
            speeds: Vec::new(),
            last: None,
        }
    }

    /// The wait after this operation, or before it, is over at this time (s).
    pub fn waited(&mut self, time: f64) {
        self.waits.push(std::mem::take(&mut self.carried) + time - self.ends);
    }

    /// For how long it has waited (s), of the wait that is not over at this time (s).
    pub fn waiting(&self, time: f64) -> f64 {
        let waits = match self.doing {
            Doing::Waiting => true,
            // The wait for the last service is over when it begins.
            Doing::Served => self.waits.len() <= self.operation,
            Doing::Ready => self.operation > 0,
            Doing::Working | Doing::Finished | Doing::Lost => false,
        };
        self.carried + if waits { time - self.ends } else { 0.0 }
    }

    /// The operation has begun and has not been served.
    pub fn started(&self) -> bool {
        matches!(self.doing, Doing::Working | Doing::Waiting | Doing::Served)
    }
}

/// A service robot.
#[derive(Clone, Debug)]
pub(super) struct RobotState {
    pub stage: Stage,
    /// Since when (s).
    pub since: f64,
    /// Agent and operation of the service under way.
    pub target: Option<(usize, usize)>,
    /// Present leg; a point while it stands.
    pub leg: Leg,
    /// It is where it goes no earlier than this (s), because it is late, or goes another way than that from its depot.
    pub not_before: f64,
    /// The least that was left of the present leg (m) when it was late, and since when (s).
    pub nearest: Option<(f64, f64)>,
    /// The robot out of order that holds it up.
    pub held_up: Option<usize>,
    /// Position at the last step of the bases (m).
    pub position: [f64; 2],
    /// Its velocity since then (m/s).
    pub velocity: [f64; 2],
    /// Heading (rad).
    pub heading: f64,
    /// Distance of the present path covered before the present leg (m).
    pub gone: f64,
    /// Speed of the approach under way (m/s).
    pub approach: f64,
    /// Energy that it has taken (J).
    pub energy: f64,
    /// Way that it has gone (m).
    pub travelled: f64,
    /// Operations that it has served.
    pub served: usize,
}

impl RobotState {
    pub fn new(problem: &Problem, robot: usize) -> RobotState {
        let place = problem.robots[robot].depot;
        let gone = problem.absent.iter().any(|absence| absence.robot == robot && absence.until.is_none());
        RobotState {
            stage: if gone { Stage::Lost } else { Stage::Home },
            since: problem.start,
            target: None,
            leg: Leg::rest(place, problem.start),
            not_before: f64::NEG_INFINITY,
            nearest: None,
            held_up: None,
            position: place,
            velocity: [0.0; 2],
            heading: 0.0,
            gone: 0.0,
            approach: 0.0,
            energy: 0.0,
            travelled: 0.0,
            served: 0,
        }
    }

    /// Passes to another stage.
    pub fn begin(&mut self, stage: Stage, time: f64) {
        self.stage = stage;
        self.since = time;
        self.not_before = f64::NEG_INFINITY;
        (self.nearest, self.held_up) = (None, None);
    }

    /// Number of the six instants of its service that have passed.
    pub fn passed(&self) -> usize {
        match self.stage {
            Stage::Home | Stage::Recalled | Stage::Lost => 0,
            Stage::Going => 1,
            Stage::Waiting => 2,
            Stage::Approaching => 3,
            Stage::Serving => 4,
            Stage::Returning | Stage::Unloading => 5,
        }
    }
}
