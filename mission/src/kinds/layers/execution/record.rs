//! Log entries of an execution of layers.

use serde::{Deserialize, Serialize};

use crate::execution::{self, PlanChange};

use super::event::Event;

/// An entry of the log.
pub type Record = execution::Record<LogEntry>;

/// Content of a log entry. Agents, tasks, objects and layers are named by index.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "agent, task, object and layer are indices; other fields are described")]
pub enum LogEntry {
    /// An agent began a task.
    Begun {
        agent: usize,
        task: usize,
        /// None: it needs none.
        object: Option<usize>,
    },
    /// A task has not ended when it was expected to.
    TaskLate {
        agent: usize,
        task: usize,
        /// New expected end (s).
        expected: f64,
    },
    /// A task is done.
    Ended { agent: usize, task: usize },
    /// A task failed, or was dropped by an agent that is lost: it is to be done again.
    Dropped { agent: usize, task: usize },
    /// All tasks of a layer are done, and of those before.
    LayerDone { layer: usize },
    /// An event was handled.
    Handled { event: Event },
    /// The plan changed.
    Plan(PlanChange),
    /// Every task is done.
    Done,
}
