//! Executing a layered plan: a world in which a team does its tasks, and the plan follows what happens.
//!
//! A [`LayersExecution`] is a discrete-event simulation. It begins with a plan, lets time pass with
//! [`LayersExecution::advance`], and takes what people and robots report with [`LayersExecution::handle_event`]. An agent begins
//! its next task when it is free and every task of the layers before is done, so that what is late moves only what comes
//! after it. What differs from the plan repairs it: who does what with which object stays, times move, and robots take the
//! speeds that are then best. When the repaired plan has become too costly, or nobody is left for a task, what has not begun
//! is planned anew. No plan is used that [`validate`](super::validate) refuses, and what has begun stays as it is.
//!
//! The same problem, settings and events at the same times give the same records, however time is cut into steps, unless a
//! planner was ended by its wall time.

mod clock;
mod durations;
mod event;
mod handle_event;
mod outcome;
mod record;
mod repair;
mod settings;
mod state;
mod steps;
mod update;
mod view;
mod way;

use crate::execution::Simulation;
use crate::kinds::layers::plan::Plan;

use super::choose::plan;
use super::problem::Problem;
use super::scales::Scales;
use super::steps::{Step, from_plan};
use super::validate::validate;

pub use self::event::{Event, EventError};
pub use self::outcome::{AgentOutcome, Outcome};
pub use self::record::{LogEntry, Record};
pub use self::settings::{Refusal, Settings};
pub use self::view::{AgentView, Doing, NextTask, UnderWay};

use self::state::AgentState;

/// A mission of layers under way. While nobody is left for a task its plan lacks that task; what was given to somebody who
/// is still there goes on, as far as the order of the layers allows.
pub type LayersExecution = Simulation<LayersWorld>;

/// The state of the team and of its tasks.
#[derive(Clone, Debug)]
pub struct LayersWorld {
    /// Planned steps that have not begun, by start.
    ahead: Vec<Step>,
    /// Finished steps with their true times, by end.
    ended: Vec<Step>,
    /// The same for the whole mission.
    scales: Scales,
    /// Cost of the plan at the last planning.
    optimal: f64,
    agents: Vec<AgentState>,
    /// Number of starts of each task.
    tries: Vec<usize>,
    /// The first layer in which anything is to be done; none: everything is done.
    open: Option<usize>,
    dropped: usize,
}

impl LayersExecution {
    /// Plans the mission and stands at its start.
    ///
    /// # Errors
    ///
    /// The settings or the problem are wrong, or something has begun already.
    pub fn new(problem: Problem, settings: Settings) -> Result<LayersExecution, Refusal> {
        let plan = plan(&problem, &settings.planning)?;
        LayersExecution::with_plan(problem, plan, settings)
    }

    /// Stands at the start of a plan that was made before.
    ///
    /// # Errors
    ///
    /// The settings or the problem are wrong, something has begun already, or the plan is none of this problem.
    pub fn with_plan(problem: Problem, plan: Plan, settings: Settings) -> Result<LayersExecution, Refusal> {
        let mistakes = problem.check();
        if !mistakes.is_empty() {
            return Err(Refusal::Plan(super::choose::Refusal::Problem(mistakes)));
        }
        if !problem.begun.is_empty() {
            return Err(Refusal::Begun);
        }
        settings.check(&problem)?;
        let violations = validate(&problem, &plan);
        if !violations.is_empty() {
            return Err(Refusal::Violations(violations));
        }
        let mut ahead = from_plan(&plan);
        repair::sort(&mut ahead);
        let begin = problem.start;
        let world = LayersWorld {
            ahead,
            ended: Vec::new(),
            optimal: plan.cost,
            scales: Scales::of(&problem),
            agents: problem.agents.iter().map(|who| AgentState::new(who, begin)).collect(),
            tries: vec![0; problem.tasks.len()],
            open: first_layer(&problem, &[]),
            dropped: 0,
        };
        Ok(Simulation::at_start(problem, plan, settings, begin, world))
    }

    /// Steps under way, with their start and expected end.
    fn running(&self) -> impl Iterator<Item = Step> {
        self.world.agents.iter().filter_map(|agent| agent.task.as_ref()).map(|task| task.expected_step())
    }

    /// The next task of an agent that does nothing, if its layer has begun.
    fn ready(&self, agent: usize) -> Option<&Step> {
        let next = self.world.ahead.iter().find(|step| step.agent == agent)?;
        (self.world.open == Some(self.problem.tasks[next.task].layer)).then_some(next)
    }
}

/// The first layer in which anything is to be done, after these.
fn first_layer(problem: &Problem, ended: &[Step]) -> Option<usize> {
    let open = |task: &usize| ended.iter().all(|step| step.task != *task);
    (0..problem.tasks.len()).filter(open).map(|task| problem.tasks[task].layer).min()
}
