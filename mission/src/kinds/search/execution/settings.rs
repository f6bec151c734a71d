//! Settings of an execution of a search, and the reasons for which it cannot begin.

use crate::engine::Budget;
use crate::execution::{Durations, Replan};
use crate::kind::course::Driven;
use crate::kinds::search::check::Mistake;
use crate::kinds::search::choose::{Formulation, Options};
use crate::kinds::search::problem::Problem;
use crate::kinds::search::validate::Violation;

/// Settings of an execution of a search.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Source of the true times of ways: the plan, or a distribution with the
    /// [`spread`](crate::kinds::search::problem::Agent::spread) of the agent.
    pub durations: Durations,
    /// Reaction to a deviation from the plan. [`Replan::None`] and [`Replan::Reschedule`]: times move, since agents have one
    /// speed. [`Replan::Both`]: everything is also replanned if the reward that the team can expect has changed. An agent
    /// that was moved, or is back, has no way from where it is, and is planned for in every case.
    pub replan: Replan,
    /// Limits of each planning.
    pub budget: Budget,
    /// The planner.
    pub formulation: Formulation,
    /// Agents (by index) whose activities end only by an event.
    pub reporting: Vec<usize>,
    /// Agents whose bases controllers drive: a way ends only by an event.
    pub driven: Vec<Driven>,
}

/// Reason for which an execution cannot begin.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// The problem has mistakes.
    #[error("{}", .0.first().map_or("", |mistake| mistake.text.as_str()))]
    Problem(Vec<Mistake>),
    /// The plan breaks constraints of the problem.
    #[error("the plan does not belong to this problem: {} constraints are violated", .0.len())]
    Violations(Vec<Violation>),
    /// An agent that is waited for does not exist.
    #[error("there is no agent with number {0}, whose activities are to end by events")]
    Reporting(usize),
}

impl Settings {
    /// Checks the settings for this problem.
    ///
    /// # Errors
    /// An agent that does not exist.
    pub fn check(&self, problem: &Problem) -> Result<(), Refusal> {
        let driven = self.driven.iter().map(|driven| &driven.member);
        match self.reporting.iter().chain(driven).find(|agent| **agent >= problem.agents.len()) {
            Some(nobody) => Err(Refusal::Reporting(*nobody)),
            None => Ok(()),
        }
    }

    /// The options of the planner.
    pub(super) fn options(&self, problem: &Problem) -> Options {
        Options { budget: self.budget, formulation: self.formulation, ..Options::of(problem) }
    }
}
