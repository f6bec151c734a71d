//! What has happened in an execution of layers, one line each.

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

/// What can happen. Agents, tasks, objects and layers are named by index.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "agent, task, object and layer are indices; other fields are described")]
pub enum Happening {
    /// An agent began a task.
    Began {
        agent: usize,
        task: usize,
        /// None: it needs none.
        object: Option<usize>,
    },
    /// A task has not ended when it was expected to.
    TaskLate {
        agent: usize,
        task: usize,
        /// When it is now expected to end (s).
        expected: f64,
    },
    /// A task is done.
    Ended { agent: usize, task: usize },
    /// A task failed, or was dropped by an agent that is lost: it is to be done again.
    Dropped { agent: usize, task: usize },
    /// All tasks of a layer are done, and of those before.
    LayerDone { layer: usize },
    /// An event was told.
    Told { event: Event },
    /// Times or speeds of the plan changed; who does what stayed.
    Rescheduled {
        /// By how much the cost has changed since it was planned last, relative to what it was.
        index: f64,
    },
    /// What has not begun was planned anew.
    Reallocated {
        /// The index before; none where planning was not a choice.
        index: Option<f64>,
        /// What the plan costs.
        cost: f64,
        /// What solved it.
        engine: String,
    },
    /// Planning anew gave no plan that could be used: the repaired one stays.
    Refused { why: String },
    /// There is no plan for everything any more.
    Stranded { why: NoPlan },
    /// Every task is done.
    Done,
}

/// Why there is no plan for everything any more.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum NoPlan {
    /// Nobody is left.
    #[error("everybody is lost")]
    Nobody,
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
