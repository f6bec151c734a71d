//! The problem of a layered task plan as data: agents, objects, tasks in ordered layers, weights, and what has begun.
//!
//! Notation of thesis Table 6.1. Agents, objects, layers and tasks are named by index; actions and features are words.
//! Lengths are in metres, times in seconds, speeds in metres a second, masses in kilograms.
//! [`Problem::check`](super::check) says what cannot be planned.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use crate::numbers::{Energy, Range};

use crate::labels::Labels;

/// A primitive action that an agent is able to perform, an element of `S_a`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Skill {
    /// The action.
    pub action: String,
    /// `delta_{a,s}`: what performing it takes besides moving (s). Zero or more.
    pub duration: f64,
    /// `kappa_s` of (6.15): the part of a person's greatest speed that the action allows, more than 0, at most 1. Of a
    /// robot it has no meaning.
    pub pace: f64,
}

/// What kind of agent it is, and how it moves.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Body {
    /// A robot: its speed is decided, its energy counts.
    Robot {
        /// `v_{r,min} .. v_{r,max}` (m/s).
        speed: Range,
        /// Coefficients `varrho` of its power (6.3).
        energy: Energy,
    },
    /// A person: the speed follows from the action and the object (6.15), the workload counts.
    Human {
        /// `v_{h,max}` (m/s).
        speed: f64,
        /// `alpha` of (6.15): how much a heavier object slows (1/kg). Zero or more.
        slowing: f64,
    },
}

/// An agent `a`: who performs tasks, one at a time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Agent {
    /// Its name.
    pub name: String,
    /// Base `p_a` (m): where every action begins.
    pub place: [f64; 3],
    /// A robot or a person.
    pub body: Body,
    /// What it is able to perform `S_a`, each action at most once.
    pub skills: Vec<Skill>,
    /// How far from its base it gets (m); none: everywhere.
    pub reach: Option<f64>,
    /// The heaviest object that it handles (kg); none: any.
    pub payload: Option<f64>,
    /// Features of objects that it cannot handle.
    pub cannot: BTreeSet<String>,
    /// How much its tasks take longer or shorter than planned: the standard deviation of their time, relative to it. Zero or
    /// more. Plans do not count with it.
    #[serde(default)]
    pub spread: f64,
    /// It takes no part any more: what it has begun stays, and nothing is given to it.
    pub lost: bool,
}

/// An object `o`: used by at most one task (6.10).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Object {
    /// Its name.
    pub name: String,
    /// Where it is `p_o` (m).
    pub place: [f64; 3],
    /// `m_o` (kg). Zero or more.
    pub mass: f64,
    /// `F_o`.
    pub features: BTreeSet<String>,
}

/// A task `tau`: performed once, by one agent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Task {
    /// Its name.
    pub name: String,
    /// Index of its layer `l(tau)`; a layer begins when the one before has been completed.
    pub layer: usize,
    /// Primitive action `s_tau`.
    pub action: String,
    /// Features that its object must have `F_tau`. Empty: no object, unless one is named.
    pub features: BTreeSet<String>,
    /// Positions to pass `M_tau` (m), in order; the last is where it ends. Empty: it stays where the object is.
    pub path: Vec<[f64; 3]>,
    /// The object that must be used; none: any with the features.
    pub object: Option<usize>,
    /// The agent that must perform it; none: any that is able to.
    pub agent: Option<usize>,
}

/// Weights of the cost (6.7). All zero or more.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Weights {
    /// `beta`, of people's workload.
    pub workload: f64,
    /// `gamma`, of the energy.
    pub energy: f64,
    /// `eta`, of the makespan.
    pub makespan: f64,
}

/// A task that has begun, or is done, when the plan is made. It stays as it is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Begun {
    /// Index of the task.
    pub task: usize,
    /// Index of the agent.
    pub agent: usize,
    /// Index of the object; none: the task needs none.
    pub object: Option<usize>,
    /// The speed at which it is performed (m/s), more than 0.
    pub speed: f64,
    /// When it began (s).
    pub start: f64,
    /// When it ended, or is expected to end (s).
    pub end: f64,
}

/// Everything a layered plan is made from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Problem {
    /// The team.
    pub agents: Vec<Agent>,
    /// What there is to be used.
    pub objects: Vec<Object>,
    /// Positions with names (m), for people and for those who write layers; nothing is planned from them.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub places: BTreeMap<String, [f64; 3]>,
    /// Names of the layers `L_1, L_2, ...`, in their order.
    pub layers: Vec<String>,
    /// The tasks, in any order.
    pub tasks: Vec<Task>,
    /// What people read in place of names.
    #[serde(default, skip_serializing_if = "Labels::is_empty")]
    pub labels: Labels,
    /// Weights of the cost.
    pub weights: Weights,
    /// Whether the way back to the base is part of a task. The thesis does not say; every action begins at the base, so
    /// that without it agents would be put back there in no time.
    pub returns: bool,
    /// When the plan is made (s). Nothing that has not begun begins before.
    pub start: f64,
    /// What has begun, each task at most once.
    pub begun: Vec<Begun>,
}

/// Straight-line distance (m).
pub(crate) fn between(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt()
}

impl Agent {
    /// Its skill for an action.
    pub fn skill(&self, action: &str) -> Option<&Skill> {
        self.skills.iter().find(|skill| skill.action == action)
    }

    /// It is a person.
    pub fn is_human(&self) -> bool {
        matches!(self.body, Body::Human { .. })
    }

    /// Whether this place (m) is not beyond its reach.
    pub fn reaches(&self, place: &[f64; 3]) -> bool {
        self.reach.is_none_or(|reach| between(&self.place, place) <= reach)
    }
}

impl Task {
    /// Whether an object is used.
    pub fn needs_object(&self) -> bool {
        self.object.is_some() || !self.features.is_empty()
    }
}

impl Problem {
    /// Whether this object may be used by this task: it has the features and is the one named, if one is (6.9).
    pub fn suits(&self, task: usize, object: usize) -> bool {
        let (Some(task), Some(thing)) = (self.tasks.get(task), self.objects.get(object)) else { return false };
        task.needs_object()
            && task.object.is_none_or(|named| named == object)
            && task.features.is_subset(&thing.features)
    }

    /// Whether this agent is able to perform this task `c_a(s, M, F)`, with this object where it needs one. The thesis'
    /// `c_a` sees the features that are asked for; here the object that is used counts, its place, mass and all its
    /// features.
    pub fn able(&self, agent: usize, task: usize, object: Option<usize>) -> bool {
        let Some(what) = self.tasks.get(task) else { return false };
        let known = agent < self.agents.len() && object.is_none_or(|object| object < self.objects.len());
        known && what.needs_object() == object.is_some() && self.obstacle(agent, task, object).is_none()
    }

    /// `d_{a,tau,o}`: from the base to the object, along the path, and back to the base if that is part of a task (m).
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

    /// `m_min`, the least mass of the objects (kg); 0 if there are none.
    pub fn least_mass(&self) -> f64 {
        self.objects.iter().map(|thing| thing.mass).reduce(f64::min).unwrap_or(0.0)
    }

    /// `v_h(s, o)` of (6.15) for a person's skill and an object of this mass (m/s):
    /// `kappa_s v_max / (1 + alpha (m_o - m_min))`. Without an object the mass is the least. None for a robot.
    pub fn pace(&self, agent: &Agent, skill: &Skill, mass: Option<f64>) -> Option<f64> {
        let Body::Human { speed, slowing } = agent.body else { return None };
        let least = self.least_mass();
        Some(skill.pace * speed / (1.0 + slowing * (mass.unwrap_or(least) - least)))
    }

    /// The mass of an object (kg); none without one.
    pub fn mass(&self, object: Option<usize>) -> Option<f64> {
        object.and_then(|object| self.objects.get(object)).map(|thing| thing.mass)
    }

    /// What people read for an agent; none if there is none of this index.
    pub fn agent_label(&self, agent: usize) -> Option<&str> {
        self.agents.get(agent).map(|who| self.labels.member(&who.name))
    }

    /// What people read for an object; none if there is none of this index.
    pub fn object_label(&self, object: usize) -> Option<&str> {
        self.objects.get(object).map(|thing| self.labels.member(&thing.name))
    }

    /// What people read for a task; none if there is none of this index.
    pub fn task_label(&self, task: usize) -> Option<&str> {
        self.tasks.get(task).map(|what| self.labels.task(&what.name))
    }

    /// What people read for a layer; none if there is none of this index.
    pub fn layer_label(&self, layer: usize) -> Option<&str> {
        self.layers.get(layer).map(|name| self.labels.layer(name))
    }

    /// A position (m) as people call it: by the label of the place there, the first in the alphabet, or by its numbers.
    pub fn called(&self, position: &[f64; 3]) -> String {
        match self.places.iter().find(|(_, at)| *at == position) {
            Some((name, _)) => self.labels.member(name).to_string(),
            None => format!("({:.2}, {:.2}, {:.2}) m", position[0], position[1], position[2]),
        }
    }

    /// What of this task has begun, if it has.
    pub fn begun_of(&self, task: usize) -> Option<&Begun> {
        self.begun.iter().find(|begun| begun.task == task)
    }
}
