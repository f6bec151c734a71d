//! What all planners give: a plan as data, and how sure its planner is of it.
//!
//! A plan is activities of actors with a start and an end, in a stable order. It can be printed, drawn, checked by a
//! validator that knows nothing of the planner, and compared.

use serde::{Deserialize, Serialize};

use crate::labels::Labels;

/// Who does an activity: an index into the names of the plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Actor {
    /// The robot of this index in [`Plan::robots`].
    Robot(usize),
    /// The agent (a person or a working robot) of this index in [`Plan::agents`].
    Agent(usize),
}

/// What an activity is. The order is the one in which a service passes through them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// An agent's own work.
    Operation,
    /// A robot goes from its depot to the waiting place.
    Going,
    /// A robot stands at the waiting place.
    Waiting,
    /// A robot goes from the waiting place to the agent.
    Proximity,
    /// A robot serves the agent.
    Serving,
    /// A robot goes back to its depot and does there what ends the service.
    Depositing,
    /// A task of a layered plan, from its agent's base and as far as the task leads.
    Task,
}

impl Phase {
    /// All of a schedule, in order.
    pub const ALL: [Phase; 6] =
        [Phase::Operation, Phase::Going, Phase::Waiting, Phase::Proximity, Phase::Serving, Phase::Depositing];

    /// The phases of a robot's service, in order.
    pub const SERVICE: [Phase; 5] = [Phase::Going, Phase::Waiting, Phase::Proximity, Phase::Serving, Phase::Depositing];

    /// The name by which it is printed.
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

/// What an activity is for: operation `operation` (the first is 0) of agent `agent`. In a layered plan `agent` is the index
/// of a layer and `operation` that of a task in [`Layered::tasks`], so that it names the task there too.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Target {
    /// Index into [`Plan::agents`].
    pub agent: usize,
    /// Number of the agent's operation, from 0.
    pub operation: usize,
}

/// What an activity of a layered plan is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Work {
    /// Index into [`Layered::tasks`].
    pub task: usize,
    /// Index into [`Layered::objects`]; none: the task needs no object.
    pub object: Option<usize>,
}

/// A task of a layered plan as it is printed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LayeredTask {
    /// Its name.
    pub name: String,
    /// The primitive action.
    pub action: String,
    /// Index into [`Layered::layers`].
    pub layer: usize,
}

/// Names of what a layered plan is about, in the problem's order.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Layered {
    /// The layers.
    pub layers: Vec<String>,
    /// The tasks.
    pub tasks: Vec<LayeredTask>,
    /// The objects.
    pub objects: Vec<String>,
}

/// One thing that one actor does from `start` to `end`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Activity {
    /// Who does it.
    pub actor: Actor,
    /// What it is.
    pub phase: Phase,
    /// What it is for.
    pub target: Target,
    /// When it begins (s).
    pub start: f64,
    /// When it ends (s), not before `start`.
    pub end: f64,
    /// Mean speed of a motion (m/s); none where nothing moves.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed: Option<f64>,
    /// Where the actor is when it ends (m); none where the problem gives no coordinates. A schedule is on the ground, `z = 0`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<[f64; 3]>,
    /// It had begun when the plan was made, and stays as it is.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub begun: bool,
    /// Task and object, of a layered plan only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub work: Option<Work>,
}

/// What ended a search before its proof.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Limit {
    /// The wall time of the budget: another run may come further.
    Time,
    /// The nodes or conflicts of the budget: every run stops here.
    Work,
    /// The rounds of the outer loop, or numbers too close for the engine: every run stops here.
    Accuracy,
}

/// How sure a planner is of a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// No plan costs less than `bound`, and this one costs no more than the accuracy asked for above it.
    Proven {
        /// Lower bound on the cost of every plan.
        bound: f64,
    },
    /// The best plan found when a limit ended the search.
    Gap {
        /// Lower bound on the cost of every plan.
        bound: f64,
        /// `(cost - bound) / cost`, from 0 to 1.
        gap: f64,
        /// What ended the search.
        stopped: Limit,
    },
    /// A valid plan without a bound: repaired from another, or given.
    Unbounded {
        /// What ended a search before its proof; none: nothing did.
        stopped: Option<Limit>,
    },
}

impl Status {
    /// What ended the search before its proof, if something did.
    pub fn stopped(&self) -> Option<Limit> {
        match self {
            Status::Proven { .. } => None,
            Status::Gap { stopped, .. } => Some(*stopped),
            Status::Unbounded { stopped } => *stopped,
        }
    }

    /// The lower bound on the cost of every plan, where there is one.
    pub fn bound(&self) -> Option<f64> {
        match self {
            Status::Proven { bound } | Status::Gap { bound, .. } => Some(*bound),
            Status::Unbounded { .. } => None,
        }
    }
}

/// How much a planner worked, in counts that are the same in every run that no wall time ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Statistics {
    /// Mixed-integer, constraint and cone programs solved.
    pub solves: u64,
    /// Nodes or conflicts of their searches, as far as the engine tells them.
    pub nodes: u64,
    /// Tangent cuts added.
    pub cuts: u64,
}

impl Statistics {
    /// Both together.
    pub fn plus(self, other: Statistics) -> Statistics {
        Statistics { solves: self.solves + other.solves, nodes: self.nodes + other.nodes, cuts: self.cuts + other.cuts }
    }
}

/// What a planner gives.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Names of the robots, in the problem's order.
    pub robots: Vec<String>,
    /// Names of the agents, in the problem's order.
    pub agents: Vec<String>,
    /// What people read in place of names.
    #[serde(default, skip_serializing_if = "Labels::is_empty")]
    pub labels: Labels,
    /// Everything that is done, sorted by actor, start, end, target and phase.
    pub activities: Vec<Activity>,
    /// The cost that the planner minimised, without unit.
    pub cost: f64,
    /// How sure the planner is.
    pub status: Status,
    /// What solved it: formulation and engine.
    pub engine: String,
    /// How much work it was.
    pub statistics: Statistics,
    /// Names of layers, tasks and objects, of a layered plan only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layered: Option<Layered>,
}

impl Plan {
    /// The name of an actor; empty if the plan has no such actor.
    pub fn name(&self, actor: Actor) -> &str {
        let name = match actor {
            Actor::Robot(index) => self.robots.get(index),
            Actor::Agent(index) => self.agents.get(index),
        };
        name.map_or("", String::as_str)
    }

    /// What people read for an actor; empty if the plan has no such actor.
    pub fn label(&self, actor: Actor) -> &str {
        self.labels.member(self.name(actor))
    }

    /// The activities of one actor, in order.
    pub fn of(&self, actor: Actor) -> impl Iterator<Item = &Activity> {
        self.activities.iter().filter(move |activity| activity.actor == actor)
    }

    /// When the last activity ends (s); none for a plan of nothing.
    pub fn end(&self) -> Option<f64> {
        self.activities.iter().map(|activity| activity.end).reduce(f64::max)
    }

    /// Brings the activities into the stable order.
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
