//! Reasons for rejecting a declaration of a layered problem, and obstacles between an agent and a task.

use serde::{Deserialize, Serialize};

use crate::check::NumberReason;
use crate::numbers::MAX_NUMBER;

use super::problem::{Problem, between};

/// Reason why a declaration is rejected. Agents, tasks and objects are identified by index.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "the message says what each field is")]
pub enum Reason {
    #[error("must be a finite number of at most {MAX_NUMBER:e}, and is {value}")]
    TooLarge { value: f64 },
    #[error("must be at least {least}, and is {value}")]
    TooSmall { value: f64, least: f64 },
    #[error("begins at {low} and ends below, at {high}")]
    Reversed { low: f64, high: f64 },
    #[error("there are {count}, more than {most}")]
    TooMany { count: usize, most: usize },
    #[error("names number {index}, which does not exist")]
    Unknown { index: usize },
    #[error("there is no agent")]
    NoAgent,
    #[error("there is nothing to do: there is no task")]
    NoTask,
    #[error("has no task")]
    EmptyLayer,
    #[error("the skill `{action}` is given twice")]
    TwiceSkill { action: String },
    #[error("the pace of `{action}` must be more than 0 and at most 1, and is {value}")]
    Pace { action: String, value: f64 },
    #[error("no task takes any time, so that the makespan has no scale")]
    NoTime,
    #[error("no agent has the skill `{action}`")]
    NobodyHasSkill { action: String },
    #[error("no agent is able to perform it")]
    Nobody { obstacles: Vec<Obstacle> },
    #[error("no object has the features {}", features.join(", "))]
    NoObject { features: Vec<String>, nearest: Option<usize> },
    #[error("the object that is named lacks the feature {feature}")]
    LacksFeature { object: usize, feature: String },
    #[error("{} tasks need an object of their own, and only {} objects are there for them", tasks.len(), objects.len())]
    TooFewObjects { tasks: Vec<usize>, objects: Vec<usize> },
    #[error("is given twice")]
    Twice,
    #[error("uses an object that another task uses")]
    SameObject,
    #[error("the agent does two tasks at a time")]
    Overlap,
    #[error("has an object and needs none, or needs one and has none")]
    ObjectOfBegun,
    #[error("agent {agent} lacks the skill `{action}`")]
    NoSkill { agent: usize, action: String },
    #[error("ends before it begins")]
    NotAscending,
    #[error("it begins at {begins} s, after the plan is made")]
    Later { begins: f64 },
    #[error("it begins before task {task} of a layer before is done")]
    LayerBefore { task: usize },
}

impl NumberReason for Reason {
    fn too_large(value: f64) -> Reason {
        Reason::TooLarge { value }
    }

    fn too_small(value: f64, least: f64) -> Reason {
        Reason::TooSmall { value, least }
    }
}

/// Obstacle that prevents an agent from performing a task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Obstacle {
    /// Index of the agent.
    pub agent: usize,
    /// The object with the smallest obstacle for the agent; `None` if the obstacle is independent of the object.
    pub object: Option<usize>,
    /// Kind of the obstacle.
    pub kind: ObstacleKind,
}

/// Kind of an obstacle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "the message says what each field is")]
pub enum ObstacleKind {
    #[error("it is lost")]
    Lost,
    #[error("another agent is named")]
    Another,
    #[error("it lacks the skill `{action}`")]
    Skill { action: String },
    #[error("the path leads {distance:.3} m from its base, beyond its reach of {reach} m")]
    Path { distance: f64, reach: f64 },
    #[error("the object lies {distance:.3} m from its base, beyond its reach of {reach} m")]
    Place { distance: f64, reach: f64 },
    #[error("the object's {mass} kg are more than its payload of {payload} kg")]
    Payload { mass: f64, payload: f64 },
    #[error("it cannot handle what is {feature}")]
    Feature { feature: String },
}

impl Problem {
    /// Returns the first obstacle between this agent and this task, or between the agent and this object; `None` if the
    /// agent can perform it.
    pub fn obstacle(&self, agent: usize, task: usize, object: Option<usize>) -> Option<ObstacleKind> {
        let (who, what) = (self.agents.get(agent)?, self.tasks.get(task)?);
        if who.lost {
            return Some(ObstacleKind::Lost);
        }
        if what.agent.is_some_and(|named| named != agent) {
            return Some(ObstacleKind::Another);
        }
        self.task_obstacle(agent, task).or_else(|| self.grip_obstacle(agent, object?))
    }

    /// Returns the obstacle between the agent and this task with any object, even if the agent is lost or another one
    /// is named.
    pub(super) fn task_obstacle(&self, agent: usize, task: usize) -> Option<ObstacleKind> {
        let (who, what) = (self.agents.get(agent)?, self.tasks.get(task)?);
        if who.skill(&what.action).is_none() {
            return Some(ObstacleKind::Skill { action: what.action.clone() });
        }
        let far = what.path.iter().find(|place| !who.reaches(place))?;
        Some(ObstacleKind::Path { distance: between(&who.place, far), reach: who.reach? })
    }

    /// Returns the obstacle between the agent and this object in any task.
    pub(super) fn grip_obstacle(&self, agent: usize, object: usize) -> Option<ObstacleKind> {
        let (who, thing) = (self.agents.get(agent)?, self.objects.get(object)?);
        if !who.reaches(&thing.place) {
            return Some(ObstacleKind::Place { distance: between(&who.place, &thing.place), reach: who.reach? });
        }
        if let Some(payload) = who.payload.filter(|most| thing.mass > *most) {
            return Some(ObstacleKind::Payload { mass: thing.mass, payload });
        }
        let feature = who.cannot.intersection(&thing.features).next()?;
        Some(ObstacleKind::Feature { feature: feature.clone() })
    }
}
