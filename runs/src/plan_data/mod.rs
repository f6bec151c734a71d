//! A plan as data: the JSON of `hierarq plan --json`, in one form for all kinds of mission.
//!
//! An *agent* is everybody who takes part: robots, people, working robots. Everything refers to others by name, and labels
//! stand beside names. The form has a [`VERSION`] and a JSON Schema, [`SCHEMA`], which says what each key means; the book
//! has both in words.

mod layers;
mod schedule;

pub use layers::Found;

use mission::plan::{Statistics, Status};
use serde::Serialize;

/// The version of the form. A change that a reader of this version would not understand raises it.
pub const VERSION: u32 = 2;

/// The JSON Schema of the form.
pub static SCHEMA: &str = include_str!("schema.json");

/// A plan with everything that it refers to. Times in s, lengths in m, speeds in m/s, masses in kg.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlanData {
    /// [`VERSION`].
    pub version: u32,
    /// True: there is a plan.
    pub ok: bool,
    /// The file of the spec.
    pub spec: String,
    /// Name of the mission.
    pub mission: String,
    /// The kind of mission: `schedule` or `layers`.
    pub kind: &'static str,
    /// How the plan was found.
    pub formulation: String,
    /// Why so.
    pub why: String,
    /// What solved it.
    pub engine: String,
    /// True: the validator, which knows nothing of the planner, found nothing against it.
    pub valid: bool,
    /// How sure the planner is.
    pub status: Status,
    /// How much work it was.
    pub statistics: Statistics,
    /// The cost.
    pub cost: CostData,
    /// Everybody who takes part.
    pub agents: Vec<AgentData>,
    /// What tasks may use; empty in a schedule.
    pub objects: Vec<ObjectData>,
    /// The layers, in their order; empty in a schedule.
    pub layers: Vec<Named>,
    /// The tasks; empty in a schedule.
    pub tasks: Vec<TaskData>,
    /// Everything that is done, by agent and time.
    pub activities: Vec<ActivityData>,
    /// The services of a schedule, by robot and time; empty in a mission of layers.
    pub services: Vec<ServiceData>,
}

/// The cost of a plan.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CostData {
    /// What the planner minimised, without unit: the sum of the parts.
    pub total: f64,
    /// What it consists of.
    pub parts: Vec<Part>,
}

/// A part of the cost.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Part {
    /// What it is of.
    pub name: &'static str,
    /// What it adds to the total.
    pub cost: f64,
    /// The normalised value before its weight; none where operations have weights of their own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// The weight, where there is one for the whole.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weight: Option<f64>,
}

/// A name with what people read in its place.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Named {
    /// The name.
    pub name: String,
    /// What people read; none: the name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
}

/// Somebody who takes part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AgentData {
    /// Name and label.
    #[serde(flatten)]
    pub named: Named,
    /// `robot`, `human` or `worker`.
    pub kind: &'static str,
    /// Where it is at home: depot, place of work, base.
    pub place: [f64; 3],
    /// How many operations it has, each of which is served; none of whoever is not served.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub operations: Option<usize>,
}

/// Something that a task may use.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ObjectData {
    /// Name and label.
    #[serde(flatten)]
    pub named: Named,
    /// Where it lies.
    pub place: [f64; 3],
    /// How heavy it is.
    pub mass: f64,
    /// Words for what it is.
    pub features: Vec<String>,
}

/// A task of a layer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TaskData {
    /// Name and label.
    #[serde(flatten)]
    pub named: Named,
    /// Name of its layer.
    pub layer: String,
    /// The skill that it asks for.
    pub action: String,
}

/// An operation of an agent that is served.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct OperationData {
    /// Name of the agent whose operation it is.
    pub of: String,
    /// Which one, from 1.
    pub number: usize,
}

/// One thing that one agent does.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ActivityData {
    /// Name of the agent that does it.
    pub agent: String,
    /// What it is: a phase of a service, an operation, or a task.
    pub phase: &'static str,
    /// The operation that is worked on or served, in a schedule.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub operation: Option<OperationData>,
    /// Name of the task, in a mission of layers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub task: Option<String>,
    /// Name of its layer.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub layer: Option<String>,
    /// Name of the object that is used, if one is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub object: Option<String>,
    /// When it begins.
    pub start: f64,
    /// When it ends.
    pub end: f64,
    /// Mean speed of a motion; none where nothing moves.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed: Option<f64>,
    /// Where it ends; none where lengths come from a table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub place: Option<[f64; 3]>,
    /// It had begun when the plan was made.
    pub begun: bool,
}

/// A service of a schedule.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ServiceData {
    /// Name of the agent that serves, a robot.
    pub agent: String,
    /// The operation at whose end it serves.
    pub operation: OperationData,
    /// When the robot leaves its depot.
    pub leaves: f64,
    /// When it is at the waiting place.
    pub waits: f64,
    /// When it leaves the waiting place.
    pub approaches: f64,
    /// When it is there and begins to serve.
    pub serves: f64,
    /// When it goes back.
    pub returns: f64,
    /// When it has done what is done at the depot.
    pub ends: f64,
    /// Speed to the waiting place; none where there is no way.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub going_speed: Option<f64>,
    /// Speed from there on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub approach_speed: Option<f64>,
    /// Speed of the way back.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub return_speed: Option<f64>,
    /// When the operation ends.
    pub operation_ends: f64,
    /// How long whoever is served waits behind it.
    pub wait: f64,
}

impl Named {
    fn new(name: &str, shown: &str) -> Named {
        Named { name: name.to_string(), label: (shown != name).then(|| shown.to_string()) }
    }
}
