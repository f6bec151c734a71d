//! Settings of an execution of layers: source of durations, rule of replanning, members that report by events.

use serde::{Deserialize, Serialize};

use crate::execution::{Durations, Replan};
use crate::kinds::layers::choose::{self, Options};
use crate::kinds::layers::problem::Problem;
use crate::kinds::layers::validate::Violation;

/// Settings of an execution of layers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Source of the true durations of tasks: the plan, or a distribution with the
    /// [`spread`](crate::kinds::layers::problem::Agent::spread) of the agent.
    pub durations: Durations,
    /// Reaction to a deviation from the plan. [`Replan::None`]: times move. [`Replan::Reschedule`]: robots also take
    /// the speeds that are then optimal. [`Replan::Both`]: activities that have not begun are also replanned if the
    /// cost has changed by more than `reallocate_above`. A loss that leaves a task without an agent is replanned in
    /// every case.
    pub replan: Replan,
    /// The relative change of the cost since it was planned last, above which is planned anew. Zero or more.
    pub reallocate_above: f64,
    /// Options of the planner.
    pub planning: Options,
    /// Agents (by index) whose tasks begin and end only by an event.
    pub reporting: Vec<usize>,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            durations: Durations::default(),
            replan: Replan::default(),
            reallocate_above: 0.1,
            planning: Options::default(),
            reporting: Vec::new(),
        }
    }
}

/// Reason for which an execution cannot begin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum Refusal {
    /// There is no plan.
    #[error("{}", of_plan(.0))]
    Plan(choose::Refusal),
    /// The plan breaks constraints of the problem.
    #[error("the plan does not belong to this problem: {} constraints are violated", .0.len())]
    Violations(Vec<Violation>),
    /// Something has begun.
    #[error("an execution must begin at the start of its mission, and an activity has begun already")]
    Begun,
    /// The threshold is no number of zero or more.
    #[error("`reallocate_above` must be zero or more, and is {0}")]
    Threshold(f64),
    /// An agent that is waited for does not exist.
    #[error("there is no agent with number {0}, whose tasks are to begin and end by events")]
    Reporting(usize),
}

impl From<choose::Refusal> for Refusal {
    fn from(why: choose::Refusal) -> Refusal {
        Refusal::Plan(why)
    }
}

/// Reason of a planner's refusal; the first of several mistakes.
pub(super) fn of_plan(why: &choose::Refusal) -> String {
    match why {
        choose::Refusal::Problem(mistakes) => match mistakes.first() {
            Some(first) => first.reason.to_string(),
            None => why.to_string(),
        },
        choose::Refusal::Engine(_) => why.to_string(),
    }
}

impl Settings {
    /// Checks the settings for this problem.
    ///
    /// # Errors
    ///
    /// A threshold below zero, or an agent that does not exist.
    pub fn check(&self, problem: &Problem) -> Result<(), Refusal> {
        if let Some(nobody) = self.reporting.iter().find(|agent| **agent >= problem.agents.len()) {
            return Err(Refusal::Reporting(*nobody));
        }
        if self.reallocate_above.is_nan() || self.reallocate_above < 0.0 {
            return Err(Refusal::Threshold(self.reallocate_above));
        }
        Ok(())
    }
}
