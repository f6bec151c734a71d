//! Log entries of an execution of a search.

use crate::execution::{self, PlanChange};
use crate::kinds::search::plan::Phase;

use super::event::Event;
use super::messages::Role;

/// An entry of the log.
pub type Record = execution::Record<LogEntry>;

/// Content of a log entry.
#[derive(Clone, Debug, PartialEq)]
pub enum LogEntry {
    /// An agent began an activity.
    Begun {
        /// Index of the agent.
        agent: usize,
        /// The kind of activity.
        phase: Phase,
        /// Index of the source that it is for.
        source: Option<usize>,
    },
    /// The pool of a source is empty.
    Consumed {
        /// Index of the source.
        source: usize,
    },
    /// A hidden object is found.
    Found {
        /// Index of its group.
        object: usize,
        /// Index of the agent that has detected it.
        agent: usize,
    },
    /// An event was handled.
    Handled {
        /// The event.
        event: Event,
    },
    /// A person is reminded to send their pose.
    Reminded {
        /// Index of the agent.
        agent: usize,
    },
    /// An agent has reached the goal that was told.
    GoalReached {
        /// Index of the agent.
        agent: usize,
    },
    /// Others decide the goals now.
    Role {
        /// The new role.
        role: Role,
    },
    /// The plan changed.
    Plan(PlanChange),
    /// Every activity is done.
    Done,
}
