//! The plan of layers: an activity for each task.

use serde::{Deserialize, Serialize};

use crate::plan;

/// The plan of layers.
pub type Plan = plan::Plan<Activity>;

/// A task of one agent, from its base to the end of the task. Agents, tasks and objects are indices into the problem.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Activity {
    /// The agent.
    pub agent: usize,
    /// The task.
    pub task: usize,
    /// The object; `None`: the task needs none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub object: Option<usize>,
    /// Start (s).
    pub start: f64,
    /// End (s), not before `start`.
    pub end: f64,
    /// Mean speed (m/s); `None` without motion.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed: Option<f64>,
    /// Position of the agent's hand at the end (m).
    pub place: [f64; 3],
    /// True if it had begun when the plan was made; it stays unchanged.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub begun: bool,
}

impl plan::Activity for Activity {
    fn start(&self) -> f64 {
        self.start
    }

    fn end(&self) -> f64 {
        self.end
    }
}
