//! Events of an execution, and the reasons for which one is rejected.

use serde::{Deserialize, Serialize};

use crate::kinds::schedule::adapt::{Feedback, NoFeedback};
use crate::kinds::schedule::plan::Actor;

/// Something that happens at the present time. Agents and robots are named by index.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Event {
    /// An agent begins its next operation now, though the plan lets it begin later.
    Begun {
        /// The agent, which has been served and has not begun.
        agent: usize,
    },
    /// An agent's operation ends now.
    Done {
        /// The agent, which is at work.
        agent: usize,
    },
    /// The operation under way, or the service, takes longer than was expected.
    Late {
        /// The agent, which is at work or being served.
        agent: usize,
        /// By how much (s); less than 0: it takes shorter.
        by: f64,
    },
    /// A service ends now, earlier than its time.
    Served {
        /// The agent, which is being served.
        agent: usize,
    },
    /// A service failed, and is done again from its beginning.
    Failed {
        /// The agent, which is being served.
        agent: usize,
    },
    /// An agent is at another place from now on. Not while a robot approaches or serves it (thesis 5.4.1).
    Moved {
        /// The agent.
        agent: usize,
        /// The new place (m).
        place: [f64; 2],
    },
    /// A person says what the last service was like, in the five steps of thesis Fig. 5.5, each -2 to 2.
    Said {
        /// The person, who has been served.
        agent: usize,
        /// The wait was too short (-2), short, right (0), long, too long (2).
        wait: i8,
        /// The robot came very fast (-2), fast, right (0), slowly, very slowly (2).
        approach: i8,
        /// The robot waited very far away (-2), far, right (0), close, very close (2).
        distance: i8,
    },
    /// A person says in numbers what a service was like.
    Feedback(Feedback),
    /// A robot breaks down, or an agent leaves. The service under way is broken off; the robot of an agent that left goes
    /// home.
    Lost {
        /// Who.
        who: Actor,
    },
    /// The part that has not begun is planned anew, for any index of (5.19).
    Replan,
    /// A lost member is back: a robot at its depot, an agent at its place, where it begins again the operation that was
    /// not served.
    Back {
        /// Who.
        who: Actor,
    },
}

/// Reason for which an event is rejected. A rejected event changes nothing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "the message says what each field is")]
pub enum EventError {
    #[error("there is no agent with number {agent}")]
    NoAgent { agent: usize },
    #[error("there is no robot with number {robot}")]
    NoRobot { robot: usize },
    #[error("{name} is lost")]
    IsLost { name: String },
    #[error("{name} is not lost")]
    NotLost { name: String },
    #[error("{name} is not at work")]
    NotWorking { name: String },
    #[error("{name} is neither at work nor being served")]
    NotBusy { name: String },
    #[error("{name} is not between two operations")]
    NotReady { name: String },
    #[error("{name} is not being served")]
    NotServing { name: String },
    #[error("{name} has not been served yet")]
    NotServed { name: String },
    #[error("a robot is near {name}, who stays where it is until it has been served")]
    RobotNear { name: String },
    #[error("lengths come from a table, so no agent can move")]
    NoPlaces,
    #[error("a step of feedback lies between -2 and 2, and is {step}")]
    Step { step: i8 },
    #[error(transparent)]
    Feedback(#[from] NoFeedback),
    #[error("a time must be a number of at most a million seconds, and is {value}")]
    Time { value: f64 },
    #[error("the mission could not be planned after it: {why}")]
    Impossible { why: String },
}
