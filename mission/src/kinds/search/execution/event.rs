//! Events of an execution of a search, and the reasons for which one is rejected.

use crate::kinds::search::geometry::Point;

/// Something that happens at the present time. Agents are named by index.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// The activity under way takes longer than was expected.
    Late {
        /// The agent.
        agent: usize,
        /// By how much (s); less than 0: it takes shorter.
        by: f64,
    },
    /// The activity under way is done.
    Done {
        /// The agent.
        agent: usize,
    },
    /// An agent is at this place.
    Moved {
        /// The agent.
        agent: usize,
        /// The place (m).
        to: Point,
    },
    /// An agent takes no part any more.
    Lost {
        /// The agent.
        agent: usize,
    },
    /// A lost agent takes part again, from where it is.
    Back {
        /// The agent.
        agent: usize,
    },
    /// *My pose*: a person says where they are.
    MyPose {
        /// The person.
        agent: usize,
        /// The place (m).
        to: Point,
    },
    /// *My goal*: a person says where they go next.
    MyGoal {
        /// The person.
        agent: usize,
        /// The place (m).
        to: Point,
    },
    /// *Robot goal*: a person says where a robot goes next.
    RobotGoal {
        /// The robot.
        agent: usize,
        /// The place (m).
        to: Point,
    },
    /// *Robot pose*: a person says where a robot is.
    RobotPose {
        /// The robot.
        agent: usize,
        /// The place (m).
        to: Point,
    },
    /// A goal that was told is withdrawn.
    Free {
        /// The agent.
        agent: usize,
    },
    /// A person leaves the plan for a place, and tells nobody.
    Strays {
        /// The person.
        agent: usize,
        /// The place (m).
        to: Point,
    },
    /// The others see a person: they know where the person is.
    Seen {
        /// The person.
        agent: usize,
    },
    /// Somebody says that a hidden object is found.
    Found {
        /// The group of objects.
        object: usize,
    },
    /// *Replan*: everything is planned anew, if the settings allow it.
    Replan,
}

/// Reason for which an event is rejected. A rejected event changes nothing.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message says what each field is")]
pub enum EventError {
    #[error("there is no agent with number {agent}")]
    NoAgent { agent: usize },
    #[error("{name} is lost")]
    IsLost { name: String },
    #[error("{name} is not lost")]
    NotLost { name: String },
    #[error("{name} has no activity that can end")]
    NoActivity { name: String },
    #[error("({:.1}, {:.1}) m is in a wall, nearer to one than the radius of {name}, or outside the area", .at[0], .at[1])]
    NotFree { name: String, at: Point },
    #[error("there is no way for {name} to ({:.1}, {:.1}) m", .at[0], .at[1])]
    NoWay { name: String, at: Point },
    #[error("this goal of {name} is noted already")]
    SameGoal { name: String },
    #[error("nobody has told a goal for {name}")]
    NoGoal { name: String },
    #[error("there are no hidden objects with number {object}")]
    NoObject { object: usize },
    #[error("every {name} is found already")]
    AllFound { name: String },
    #[error("its controller drives {name}, and only that moves it")]
    Driven { name: String },
    #[error("{name} is no person")]
    NoPerson { name: String },
    #[error("{name} is no robot")]
    NoRobot { name: String },
    #[error("a time must be a number of at most a million seconds, and is {value}")]
    Time { value: f64 },
}
