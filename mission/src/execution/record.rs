//! What has happened, one line each.

use serde::{Deserialize, Serialize};

use super::event::Event;

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// When (s).
    pub time: f64,
    /// What.
    pub what: Happening,
}

/// What can happen. Agents and robots are named by index, operations count from 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "agent, operation and robot are indices; other fields are described")]
pub enum Happening {
    /// An agent began an operation.
    OperationBegan { agent: usize, operation: usize },
    /// An operation has not ended when it was expected to.
    OperationLate {
        agent: usize,
        operation: usize,
        /// When it is now expected to end (s).
        expected: f64,
    },
    /// An operation ended.
    OperationEnded { agent: usize, operation: usize },
    /// A robot left its depot for an operation.
    Left { robot: usize, agent: usize, operation: usize },
    /// A robot is at the waiting place.
    Waits { robot: usize, agent: usize, operation: usize },
    /// A robot left the waiting place for the agent.
    Approaches { robot: usize, agent: usize, operation: usize },
    /// A robot serves.
    Serves { robot: usize, agent: usize, operation: usize },
    /// A service ended: the operation is served, and the robot goes home.
    Served { robot: usize, agent: usize, operation: usize },
    /// A robot has done what is done at the depot.
    Home { robot: usize },
    /// A robot is not where it should be.
    RobotLate {
        robot: usize,
        agent: usize,
        operation: usize,
        /// When it is now expected there (s).
        expected: f64,
    },
    /// A robot stands, since one that is out of order stands in its way, and it is not known until when.
    HeldUp {
        robot: usize,
        /// To whom it was going; none: home.
        agent: Option<usize>,
        /// The robot that is out of order.
        by: usize,
    },
    /// A service was broken off; the robot, unless it is lost, goes home.
    BrokenOff { robot: usize, agent: usize, operation: usize },
    /// An event was told.
    Told { event: Event },
    /// Times of the plan moved; who serves whom stayed.
    Rescheduled {
        /// By how much the cost of what has not begun has changed since it was planned last, (5.19).
        index: f64,
    },
    /// What has not begun was planned anew.
    Reallocated {
        /// The index before, (5.19); none where planning was not a choice.
        index: Option<f64>,
        /// What the plan costs.
        cost: f64,
        /// What solved it.
        engine: String,
    },
    /// Planning anew gave no plan that could be used: the repaired one stays.
    Refused { why: String },
    /// There is no plan any more.
    Stranded { why: NoPlan },
    /// Everything is served that can be, and every robot is back.
    Done,
}

/// Why there is no plan any more.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum NoPlan {
    /// Nobody is left to serve.
    #[error("every robot is lost")]
    NoRobot,
    /// The planner has none.
    #[error("no plan was found: {why}")]
    NotFound {
        /// What the planner said.
        why: String,
    },
    /// The plan breaks a constraint.
    #[error("the plan breaks a constraint: {why}")]
    Broken {
        /// Which.
        why: String,
    },
}
