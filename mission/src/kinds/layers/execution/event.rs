//! Events of an execution of layers, and the reasons for which one is rejected.

use serde::{Deserialize, Serialize};

/// Something that happens at the present time. Agents are named by index.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Event {
    /// An agent that is waited for begins its next task.
    Begun {
        /// The agent, which does nothing; the layer of its next task has begun.
        agent: usize,
    },
    /// An agent's task is done.
    Done {
        /// The agent, which is at work.
        agent: usize,
    },
    /// The task under way takes longer than was expected.
    Late {
        /// The agent, which is at work.
        agent: usize,
        /// By how much (s); less than 0: it takes shorter.
        by: f64,
    },
    /// The task under way failed, and is done again from its beginning; its object is where it was.
    Failed {
        /// The agent, which is at work.
        agent: usize,
    },
    /// An agent takes no part any more. What it does is dropped, the object where it was.
    Lost {
        /// The agent.
        agent: usize,
    },
    /// A lost agent is back at its base.
    Back {
        /// The agent.
        agent: usize,
    },
    /// The part that has not begun is planned anew for any change of cost, if the settings allow it.
    Replan,
}

impl Event {
    /// The agent that it is of, if it is of one.
    pub fn agent(self) -> Option<usize> {
        match self {
            Event::Begun { agent }
            | Event::Done { agent }
            | Event::Late { agent, .. }
            | Event::Failed { agent }
            | Event::Lost { agent }
            | Event::Back { agent } => Some(agent),
            Event::Replan => None,
        }
    }
}

/// Reason for which an event is rejected. A rejected event changes nothing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "the message says what each field is")]
pub enum EventError {
    #[error("there is no agent with number {agent}")]
    NoAgent { agent: usize },
    #[error("{name} is lost")]
    IsLost { name: String },
    #[error("{name} is not lost")]
    NotLost { name: String },
    #[error("{name} is not at work")]
    NotWorking { name: String },
    #[error("{name} is at work already")]
    Working { name: String },
    #[error("{name} has no task to begin")]
    NoTask { name: String },
    #[error("the layer before the next task of {name} is not done")]
    NotOpen { name: String },
    #[error("a time must be a number of at most a million seconds, and is {value}")]
    Time { value: f64 },
}
