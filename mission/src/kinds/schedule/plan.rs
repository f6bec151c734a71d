//! The plan of a schedule: phases of services and operations.

use serde::{Deserialize, Serialize};

use crate::plan;

/// The plan of a schedule.
pub type Plan = plan::Plan<Activity>;

/// Actor of an activity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Actor {
    /// The robot of this index in the problem.
    Robot(usize),
    /// The agent (a person or a working robot) of this index in the problem.
    Agent(usize),
}

/// Phase of a service, or the operation before it. The order is that of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// An agent's own work.
    Operation,
    /// A robot moves from its depot to the waiting place.
    Going,
    /// A robot waits at the waiting place.
    Waiting,
    /// A robot moves from the waiting place to the agent.
    Proximity,
    /// A robot serves the agent.
    Serving,
    /// A robot returns to its depot and finishes the service there.
    Depositing,
}

impl Phase {
    /// All phases, in order.
    pub const ALL: [Phase; 6] =
        [Phase::Operation, Phase::Going, Phase::Waiting, Phase::Proximity, Phase::Serving, Phase::Depositing];

    /// The phases of a robot's service, in order.
    pub const SERVICE: [Phase; 5] = [Phase::Going, Phase::Waiting, Phase::Proximity, Phase::Serving, Phase::Depositing];

    /// Returns the name of the phase for output.
    pub fn name(self) -> &'static str {
        match self {
            Phase::Operation => "operation",
            Phase::Going => "going",
            Phase::Waiting => "waiting",
            Phase::Proximity => "proximity",
            Phase::Serving => "serving",
            Phase::Depositing => "depositing",
        }
    }
}

/// Target of an activity: operation `operation` of agent `agent`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Target {
    /// Index of the agent.
    pub agent: usize,
    /// Number of the agent's operation, from 0.
    pub operation: usize,
}

/// An activity of one actor from `start` to `end`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Activity {
    /// The actor.
    pub actor: Actor,
    /// Phase of the service.
    pub phase: Phase,
    /// The operation to which it belongs.
    pub target: Target,
    /// Start (s).
    pub start: f64,
    /// End (s), not before `start`.
    pub end: f64,
    /// Mean speed of a motion (m/s); `None` without motion.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed: Option<f64>,
    /// Position of the actor at the end (m), on the ground; `None` if the problem has no coordinates.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<[f64; 2]>,
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

impl Plan {
    /// Returns the activities of one actor, in order.
    pub fn of(&self, actor: Actor) -> impl Iterator<Item = &Activity> {
        self.activities.iter().filter(move |activity| activity.actor == actor)
    }

    /// Sorts the activities into the stable order: by actor, start, end, target and phase.
    pub fn sort(&mut self) {
        self.activities.sort_by(|a, b| {
            a.actor
                .cmp(&b.actor)
                .then(a.start.total_cmp(&b.start))
                .then(a.end.total_cmp(&b.end))
                .then(a.target.cmp(&b.target))
                .then(a.phase.cmp(&b.phase))
        });
    }
}
