//! The visible state of an execution: present and next activity of each agent and robot.

use serde::{Deserialize, Serialize};

use crate::kinds::schedule::plan::Target;

use super::ScheduleExecution;

/// Activity of an agent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Doing {
    /// It has not begun its next operation.
    Ready,
    /// It is at work.
    Working,
    /// Its operation has ended, and no robot serves yet.
    Waiting,
    /// It is being served.
    Served,
    /// All its operations have been served.
    Finished,
    /// It has left.
    Lost,
}

/// Stage of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// It stands at its depot.
    Home,
    /// It goes to the waiting place.
    Going,
    /// It waits there.
    Waiting,
    /// It goes from there to the agent, or stands there until the operation has ended.
    Approaching,
    /// It serves.
    Serving,
    /// It goes back to its depot.
    Returning,
    /// It does what is done at the depot.
    Unloading,
    /// Its service was broken off: it goes back to its depot.
    Recalled,
    /// It has broken down.
    Lost,
}

/// A robot that comes to an agent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Coming {
    /// Index of the robot.
    pub robot: usize,
    /// The operation that it comes for.
    pub operation: usize,
    /// Expected departure from the waiting place (s).
    pub approaches: f64,
    /// Expected start of the service (s).
    pub serves: f64,
}

/// An agent now.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AgentView {
    /// Present activity.
    pub doing: Doing,
    /// Since when (s).
    pub since: f64,
    /// The operation under way, or the next one; none if there is none any more.
    pub operation: Option<usize>,
    /// Expected end of its activity (s); none if nothing is planned.
    pub until: Option<f64>,
    /// The next robot that comes.
    pub coming: Option<Coming>,
    /// Place of service (m).
    pub place: [f64; 2],
    /// Waits after its operations so far (s).
    pub waits: Vec<f64>,
}

/// A robot now.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotView {
    /// Present activity.
    pub stage: Stage,
    /// Since when (s).
    pub since: f64,
    /// Expected end (s); none if nothing is planned.
    pub until: Option<f64>,
    /// Operation that it serves.
    pub target: Option<Target>,
    /// Position (m).
    pub position: [f64; 2],
    /// Its velocity (m/s).
    pub velocity: [f64; 2],
    /// Heading (rad); 0 for a robot that is no base.
    pub heading: f64,
}

impl ScheduleExecution {
    /// State of this agent; none if there is no such agent.
    pub fn agent(&self, agent: usize) -> Option<AgentView> {
        let (state, who) = (self.world.agents.get(agent)?, self.problem.agents.get(agent)?);
        let over = matches!(state.doing, Doing::Finished | Doing::Lost);
        let service = self.service(agent, state.operation).filter(|_| !over);
        let until = match state.doing {
            Doing::Ready => service.map(|at| at.start),
            Doing::Working => Some(state.expected),
            Doing::Waiting => service.map(|at| at.times.serving),
            Doing::Served => service.map(|at| at.times.depositing),
            Doing::Finished | Doing::Lost => None,
        };
        let coming = service.filter(|_| state.doing != Doing::Served).map(|at| Coming {
            robot: at.robot,
            operation: at.operation,
            approaches: at.times.proximity,
            serves: at.times.serving,
        });
        Some(AgentView {
            doing: state.doing,
            since: state.since,
            operation: (!over).then_some(state.operation),
            until,
            coming,
            place: who.place,
            waits: state.waits.clone(),
        })
    }

    /// State of this robot; none if there is no such robot.
    pub fn robot(&self, robot: usize) -> Option<RobotView> {
        let state = self.world.robots.get(robot)?;
        let service = state.target.and_then(|(agent, operation)| self.service(agent, operation)).map(|at| at.times);
        let until = match state.stage {
            Stage::Home => self.next_service(robot).map(|at| at.times.going),
            Stage::Going => service.map(|times| times.waiting),
            Stage::Waiting => service.map(|times| times.proximity),
            Stage::Approaching => service.map(|times| times.serving),
            Stage::Serving => service.map(|times| times.depositing),
            Stage::Returning | Stage::Recalled => Some(state.leg.until),
            Stage::Unloading => service.map(|times| times.end),
            Stage::Lost => None,
        };
        Some(RobotView {
            stage: state.stage,
            since: state.since,
            until,
            target: state.target.map(|(agent, operation)| Target { agent, operation }),
            position: self.position(robot, self.time),
            velocity: self.velocity(robot, self.time),
            heading: state.heading,
        })
    }
}
