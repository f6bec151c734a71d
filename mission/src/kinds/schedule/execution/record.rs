//! Log entries of an execution.

use serde::{Deserialize, Serialize};

use crate::execution::{self, PlanChange};

use super::event::Event;

/// An entry of the log.
pub type Record = execution::Record<LogEntry>;

/// Content of a log entry. Agents and robots are named by index, operations count from 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "agent, operation and robot are indices; other fields are described")]
pub enum LogEntry {
    /// An agent began an operation.
    OperationBegan { agent: usize, operation: usize },
    /// An operation has not ended when it was expected to.
    OperationLate {
        agent: usize,
        operation: usize,
        /// New expected end (s).
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
        /// New expected arrival (s).
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
    /// An event was handled.
    Handled { event: Event },
    /// The plan changed.
    Plan(PlanChange),
    /// Everything is served that can be, and every robot is back.
    Done,
}
