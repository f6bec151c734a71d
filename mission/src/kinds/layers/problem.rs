//! Input data of a layered task plan: agents, objects, tasks in ordered layers, weights, and the tasks that have begun.
//!
//! Notation of thesis Table 6.1. Agents, objects, layers and tasks are identified by index; actions and features are
//! words. Lengths are in metres, times in seconds, speeds in metres per second, masses in kilograms.
//! [`Problem::check`](super::check) reports mistakes.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

pub use super::blocks::Weights;
use crate::numbers::{Energy, Range};

use crate::labels::Labels;

/// A primitive action that an agent can perform, an element of `S_a`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Skill {
    /// The action.
    pub action: String,
    /// `delta_{a,s}`: duration of the action without motion (s). Zero or more.
    pub duration: f64,
    /// `kappa_s` of (6.15): fraction of a person's maximum speed that the action permits, more than 0, at most 1.
    /// Ignored for a robot.
    pub pace: f64,
}

/// Kind of an agent, with its speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Body {
    /// A robot: its speed is a decision, and its energy is part of the cost.
    Robot {
        /// `v_{r,min} .. v_{r,max}` (m/s).
        speed: Range,
        /// Coefficients `varrho` of its power (6.3).
        energy: Energy,
    },
    /// A person: the speed follows from the action and the object (6.15), and the workload is part of the cost.
    Human {
        /// `v_{h,max}` (m/s).
        speed: f64,
        /// `alpha` of (6.15): reduction of the speed by a heavier object (1/kg). Zero or more.
        slowing: f64,
    },
}

/// An agent `a`, which performs tasks, one at a time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Agent {
    /// Name of the agent.
    pub name: String,
    /// Base `p_a` (m): starting point of every action.
    pub place: [f64; 3],
    /// A robot or a person.
    pub body: Body,
    /// Skills `S_a`, each action at most once.
    pub skills: Vec<Skill>,
    /// Maximum distance from the base (m); `None`: unlimited.
    pub reach: Option<f64>,
    /// Maximum mass of an object that it can handle (kg); `None`: unlimited.
    pub payload: Option<f64>,
    /// Features of objects that it cannot handle.
    pub cannot: BTreeSet<String>,
    /// Standard deviation of the duration of its tasks, relative to the planned duration. Zero or more. Plans do not
    /// consider it.
    #[serde(default)]
    pub spread: f64,
    /// True if the agent has failed: tasks that it has begun remain, and no further task is assigned to it.
    pub lost: bool,
}

/// An object `o`: used by at most one task (6.10).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Object {
    /// Name of the object.
    pub name: String,
    /// Position `p_o` (m).
    pub place: [f64; 3],
    /// `m_o` (kg). Zero or more.
    pub mass: f64,
    /// `F_o`.
    pub features: BTreeSet<String>,
}

/// A task `tau`: performed once, by one agent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Task {
    /// Name of the task.
    pub name: String,
    /// Index of its layer `l(tau)`; a layer begins after the previous one has been completed.
    pub layer: usize,
    /// Primitive action `s_tau`.
    pub action: String,
    /// Features that its object must have `F_tau`. Empty: no object, unless one is named.
    pub features: BTreeSet<String>,
    /// Via positions `M_tau` (m), in order; the last is the end of the motion. Empty: the task ends at the object.
    pub path: Vec<[f64; 3]>,
    /// The object that must be used; `None`: any with the features.
    pub object: Option<usize>,
    /// The agent that must perform it; `None`: any with the abilities.
    pub agent: Option<usize>,
}

/// A task that has begun, or is completed, when the plan is made. It stays unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Begun {
    /// Index of the task.
    pub task: usize,
    /// Index of the agent.
    pub agent: usize,
    /// Index of the object; `None`: the task needs none.
    pub object: Option<usize>,
    /// Speed at which it is performed (m/s), more than 0.
    pub speed: f64,
    /// Start (s).
    pub start: f64,
    /// Observed or expected end (s).
    pub end: f64,
}

/// Problem of a layered task plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Problem {
    /// The team.
    pub agents: Vec<Agent>,
    /// The objects that tasks may use.
    pub objects: Vec<Object>,
    /// Named positions (m), for display and for authors of layers; the planner ignores them.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub places: BTreeMap<String, [f64; 3]>,
    /// Names of the layers `L_1, L_2, ...`, in their order.
    pub layers: Vec<String>,
    /// The tasks, in any order.
    pub tasks: Vec<Task>,
    /// Labels that are displayed instead of names.
    #[serde(default, skip_serializing_if = "Labels::is_empty")]
    pub labels: Labels,
    /// Weights of the cost.
    pub weights: Weights,
    /// True if the return to the base is part of a task. The thesis leaves this open; every action begins at the base,
    /// so that without the return agents would be moved back there in no time.
    pub returns: bool,
    /// Instant at which the plan is made (s). Everything that has not begun begins then or later.
    pub start: f64,
    /// Tasks that have begun, each at most once.
    pub begun: Vec<Begun>,
}

/// Returns the straight-line distance (m).
pub(crate) fn between(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt()
}

impl Agent {
    /// Returns the skill for an action.
    pub fn skill(&self, action: &str) -> Option<&Skill> {
        self.skills.iter().find(|skill| skill.action == action)
    }

    /// Returns true if the agent is a person.
    pub fn is_human(&self) -> bool {
        matches!(self.body, Body::Human { .. })
    }

    /// Returns true if this position (m) is within reach.
    pub fn reaches(&self, place: &[f64; 3]) -> bool {
        self.reach.is_none_or(|reach| between(&self.place, place) <= reach)
    }
}

impl Task {
    /// Returns true if the task uses an object.
    pub fn needs_object(&self) -> bool {
        self.object.is_some() || !self.features.is_empty()
    }
}

impl Problem {
    /// Returns true if this task may use this object: the object has the features and is the named one, if any (6.9).
    pub fn suits(&self, task: usize, object: usize) -> bool {
        let (Some(task), Some(thing)) = (self.tasks.get(task), self.objects.get(object)) else { return false };
        task.needs_object()
            && task.object.is_none_or(|named| named == object)
            && task.features.is_subset(&thing.features)
    }

    /// Returns true if this agent can perform this task `c_a(s, M, F)`, with this object if the task needs one. The
    /// `c_a` of the thesis considers the required features; here the position, mass and all features of the object
    /// count.
    pub fn able(&self, agent: usize, task: usize, object: Option<usize>) -> bool {
        let Some(what) = self.tasks.get(task) else { return false };
        let known = agent < self.agents.len() && object.is_none_or(|object| object < self.objects.len());
        known && what.needs_object() == object.is_some() && self.obstacle(agent, task, object).is_none()
    }

    /// Computes `d_{a,tau,o}`: from the base to the object, along the path, and back to the base if `returns` is set
    /// (m).
    pub fn distance(&self, agent: usize, task: usize, object: Option<usize>) -> f64 {
        let (Some(who), Some(what)) = (self.agents.get(agent), self.tasks.get(task)) else { return 0.0 };
        let object = object.and_then(|object| self.objects.get(object)).map(|thing| &thing.place);
        let mut at = &who.place;
        let mut length = 0.0;
        for place in object.into_iter().chain(&what.path) {
            length += between(at, place);
            at = place;
        }
        if self.returns { length + between(at, &who.place) } else { length }
    }

    /// Returns `m_min`, the minimum mass of the objects (kg); 0 if there are none.
    pub fn least_mass(&self) -> f64 {
        self.objects.iter().map(|thing| thing.mass).reduce(f64::min).unwrap_or(0.0)
    }

    /// Computes `v_h(s, o)` of (6.15) for a person's skill and an object of this mass (m/s): `kappa_s v_max / (1 +
    /// alpha (m_o - m_min))`. Without an object the mass is the minimum. `None` for a robot.
    pub fn pace(&self, agent: &Agent, skill: &Skill, mass: Option<f64>) -> Option<f64> {
        let Body::Human { speed, slowing } = agent.body else { return None };
        let least = self.least_mass();
        Some(skill.pace * speed / (1.0 + slowing * (mass.unwrap_or(least) - least)))
    }

    /// Returns the mass of an object (kg); `None` without one.
    pub fn mass(&self, object: Option<usize>) -> Option<f64> {
        object.and_then(|object| self.objects.get(object)).map(|thing| thing.mass)
    }

    /// Returns the label of an agent; `None` if the index is out of range.
    pub fn agent_label(&self, agent: usize) -> Option<&str> {
        self.agents.get(agent).map(|who| self.labels.member(&who.name))
    }

    /// Returns the label of an object; `None` if the index is out of range.
    pub fn object_label(&self, object: usize) -> Option<&str> {
        self.objects.get(object).map(|thing| self.labels.member(&thing.name))
    }

    /// Returns the label of a task; `None` if the index is out of range.
    pub fn task_label(&self, task: usize) -> Option<&str> {
        self.tasks.get(task).map(|what| self.labels.task(&what.name))
    }

    /// Returns the label of a layer; `None` if the index is out of range.
    pub fn layer_label(&self, layer: usize) -> Option<&str> {
        self.layers.get(layer).map(|name| self.labels.layer(name))
    }

    /// Returns a position (m) for display: the label of the place there (the first in alphabetical order), or its
    /// coordinates.
    pub fn called(&self, position: &[f64; 3]) -> String {
        match self.places.iter().find(|(_, at)| *at == position) {
            Some((name, _)) => self.labels.member(name).to_string(),
            None => format!("({:.2}, {:.2}, {:.2}) m", position[0], position[1], position[2]),
        }
    }

    /// Returns the entry of this task in `begun`, if it has begun.
    pub fn begun_of(&self, task: usize) -> Option<&Begun> {
        self.begun.iter().find(|begun| begun.task == task)
    }
}
