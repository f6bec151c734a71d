//! Result of all planners: a plan as data, with its status.
//!
//! A plan is a list of activities of actors with a start and an end, in a stable order. It can be printed, drawn,
//! compared, and checked by a validator that is independent of the planner.

use serde::{Deserialize, Serialize};

use crate::labels::Labels;

/// Actor of an activity: an index into the names of the plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Actor {
    /// The robot of this index in [`Plan::robots`].
    Robot(usize),
    /// The agent (a person or a working robot) of this index in [`Plan::agents`].
    Agent(usize),
}

/// Kind of an activity. The order is that of the phases of a service.
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
    /// A task of a layered plan, from its agent's base to the end of the task.
    Task,
}

impl Phase {
    /// All phases of a schedule, in order.
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
            Phase::Task => "task",
        }
    }
}

/// Target of an activity: operation `operation` (the first is 0) of agent `agent`. In a layered plan `agent` is the
/// index of a layer and `operation` that of a task in [`Layered::tasks`], so that it identifies the task there too.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Target {
    /// Index into [`Plan::agents`].
    pub agent: usize,
    /// Number of the agent's operation, from 0.
    pub operation: usize,
}

/// Task and object of an activity in a layered plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Work {
    /// Index into [`Layered::tasks`].
    pub task: usize,
    /// Index into [`Layered::objects`]; `None`: the task needs no object.
    pub object: Option<usize>,
}

/// A task of a layered plan for output.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LayeredTask {
    /// Name of the task.
    pub name: String,
    /// The primitive action.
    pub action: String,
    /// Index into [`Layered::layers`].
    pub layer: usize,
}

/// Names of layers, tasks and objects of a layered plan, in the problem's order.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Layered {
    /// The layers.
    pub layers: Vec<String>,
    /// The tasks.
    pub tasks: Vec<LayeredTask>,
    /// The objects.
    pub objects: Vec<String>,
}

/// An activity of one actor from `start` to `end`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Activity {
    /// The actor.
    pub actor: Actor,
    /// Kind of the activity.
    pub phase: Phase,
    /// The operation or task to which it belongs.
    pub target: Target,
    /// Start (s).
    pub start: f64,
    /// End (s), not before `start`.
    pub end: f64,
    /// Mean speed of a motion (m/s); `None` without motion.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed: Option<f64>,
    /// Position of the actor at the end (m); `None` if the problem has no coordinates. A schedule is on the ground, `z
    /// = 0`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<[f64; 3]>,
    /// True if it had begun when the plan was made; it stays unchanged.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub begun: bool,
    /// Task and object, of a layered plan only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub work: Option<Work>,
}

/// Limit that ended a search before its proof.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Limit {
    /// The time limit of the budget: another run may get further.
    Time,
    /// The nodes or conflicts of the budget: every run stops here.
    Work,
    /// The rounds of the outer loop, or the numerical accuracy of the engine: every run stops here.
    Accuracy,
}

/// Status of a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// No plan costs less than `bound`, and the cost of this one exceeds it by at most the requested gap.
    Proven {
        /// Lower bound on the cost of every plan.
        bound: f64,
    },
    /// The best plan found before a limit ended the search.
    Gap {
        /// Lower bound on the cost of every plan.
        bound: f64,
        /// `(cost - bound) / cost`, from 0 to 1.
        gap: f64,
        /// Limit that ended the search.
        stopped: Limit,
    },
    /// A valid plan without a bound: repaired from another one, or given.
    Unbounded {
        /// Limit that ended a search before its proof, if any.
        stopped: Option<Limit>,
    },
}

impl Status {
    /// Returns the limit that ended the search before its proof, if any.
    pub fn stopped(&self) -> Option<Limit> {
        match self {
            Status::Proven { .. } => None,
            Status::Gap { stopped, .. } => Some(*stopped),
            Status::Unbounded { stopped } => *stopped,
        }
    }

    /// Returns the lower bound on the cost of every plan, if there is one.
    pub fn bound(&self) -> Option<f64> {
        match self {
            Status::Proven { bound } | Status::Gap { bound, .. } => Some(*bound),
            Status::Unbounded { .. } => None,
        }
    }
}

/// Statistics of a search: counts that are the same in every run, unless the time limit ends it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Statistics {
    /// Number of mixed-integer, constraint and cone programs solved.
    pub solves: u64,
    /// Number of nodes or conflicts of their searches, as far as the engine reports them.
    pub nodes: u64,
    /// Number of tangent cuts added.
    pub cuts: u64,
}

impl Statistics {
    /// Returns the sum of both statistics.
    pub fn plus(self, other: Statistics) -> Statistics {
        Statistics { solves: self.solves + other.solves, nodes: self.nodes + other.nodes, cuts: self.cuts + other.cuts }
    }
}

/// A plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Names of the robots, in the problem's order.
    pub robots: Vec<String>,
    /// Names of the agents, in the problem's order.
    pub agents: Vec<String>,
    /// Labels that are displayed instead of names.
    #[serde(default, skip_serializing_if = "Labels::is_empty")]
    pub labels: Labels,
    /// All activities, sorted by actor, start, end, target and phase.
    pub activities: Vec<Activity>,
    /// The cost that the planner minimised, dimensionless.
    pub cost: f64,
    /// Status of the plan.
    pub status: Status,
    /// Name of the planner: formulation and engine.
    pub engine: String,
    /// Statistics of the search.
    pub statistics: Statistics,
    /// Names of layers, tasks and objects, of a layered plan only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layered: Option<Layered>,
}

impl Plan {
    /// Returns the name of an actor; empty if the plan has no such actor.
    pub fn name(&self, actor: Actor) -> &str {
        let name = match actor {
            Actor::Robot(index) => self.robots.get(index),
            Actor::Agent(index) => self.agents.get(index),
        };
        name.map_or("", String::as_str)
    }

    /// Returns the label of an actor; empty if the plan has no such actor.
    pub fn label(&self, actor: Actor) -> &str {
        self.labels.member(self.name(actor))
    }

    /// Returns the activities of one actor, in order.
    pub fn of(&self, actor: Actor) -> impl Iterator<Item = &Activity> {
        self.activities.iter().filter(move |activity| activity.actor == actor)
    }

    /// Returns the end of the last activity (s); `None` for an empty plan.
    pub fn end(&self) -> Option<f64> {
        self.activities.iter().map(|activity| activity.end).reduce(f64::max)
    }

    /// Sorts the activities into the stable order.
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
