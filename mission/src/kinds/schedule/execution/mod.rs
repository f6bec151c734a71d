//! Executing a schedule: a world in which agents work and robots serve them, and the plan follows what happens.
//!
//! An [`ScheduleExecution`] is a discrete-event simulation. It begins with a plan, lets time pass with [`ScheduleExecution::advance`], and
//! takes what people and robots report with [`ScheduleExecution::handle_event`]. What differs from the plan repairs it
//! ([`reschedule`](crate::kinds::schedule::reschedule)); when the repaired plan has become too costly, what has not begun is
//! planned anew ([`reallocate`](crate::kinds::schedule::reallocate)). No plan is used that
//! [`validate`](crate::kinds::schedule::validate) refuses, and what has begun stays as it is.
//!
//! The same problem, settings and events at the same times give the same records, however time is cut into steps, unless a
//! planner was ended by its wall time.

mod bases;
mod clock;
mod durations;
mod early;
mod event;
mod handle_event;
mod indices;
mod motion;
mod outcome;
mod progress;
mod record;
mod satisfaction;
mod settings;
mod state;
mod steps;
mod surroundings;
mod update;
mod view;

use crate::execution::Simulation;
use crate::kinds::schedule::adapt::Satisfaction;
use crate::kinds::schedule::assistance::{Assistance, from_plan};
use crate::kinds::schedule::choose::plan;
use crate::kinds::schedule::plan::Plan;
use crate::kinds::schedule::problem::{Distances, Problem, Scales, WorkingAgent};
use crate::kinds::schedule::validate::validate;

pub use self::event::{Event, EventError};
pub use self::outcome::{AgentOutcome, Outcome, RobotOutcome};
pub use self::record::{LogEntry, Record};
pub use self::settings::{Obstacle, Potentials, Refusal, Settings, Travel};
pub use self::view::{AgentView, Coming, Doing, RobotView, Stage};

use self::indices::Indices;
use self::state::{AgentState, RobotState};

/// A schedule under way. It is done if everything is served that can be, and every robot is back. If there is no plan any
/// more, its plan is the last one: what is under way by agents goes on, and robots are at their depots.
pub type ScheduleExecution = Simulation<ScheduleWorld>;

/// The state of agents and robots.
#[derive(Clone, Debug)]
pub struct ScheduleWorld {
    schedule: Vec<Assistance>,
    /// The problem and schedule of the last planning, against which (5.19) compares.
    optimal: (Problem, Vec<Assistance>),
    agents: Vec<AgentState>,
    robots: Vec<RobotState>,
    /// Lost agents, as they were before.
    lost: Vec<Option<WorkingAgent>>,
    satisfied: Vec<Option<Satisfaction>>,
    indices: Vec<Indices>,
    /// Steps of the bases since the start, while one moves.
    tick: Option<u64>,
}

impl ScheduleExecution {
    /// Plans the mission and stands at its start.
    ///
    /// # Errors
    ///
    /// The settings or the problem are wrong, or there is no plan.
    pub fn new(problem: Problem, settings: Settings) -> Result<ScheduleExecution, Refusal> {
        let problem = with_scales(problem);
        let plan = plan(&problem, &settings.planning)?;
        ScheduleExecution::with_plan(problem, plan, settings)
    }

    /// Stands at the start of a plan that was made before.
    ///
    /// # Errors
    ///
    /// The settings or the problem are wrong, something has begun already, or the plan is none of this problem.
    pub fn with_plan(problem: Problem, plan: Plan, settings: Settings) -> Result<ScheduleExecution, Refusal> {
        let problem = with_scales(problem);
        let mistakes = problem.check();
        if !mistakes.is_empty() {
            return Err(Refusal::Plan(crate::kinds::schedule::choose::Refusal::Problem(mistakes)));
        }
        if !problem.begun.is_empty() {
            return Err(Refusal::Begun);
        }
        settings.check(&problem)?;
        let violations = validate(&problem, &plan);
        if !violations.is_empty() {
            return Err(Refusal::Violations(violations));
        }
        let schedule = from_plan(&plan).map_err(|wrong| Refusal::NoSchedule(wrong.to_string()))?;
        let agents = problem.agents.iter().map(|who| AgentState::new(who, problem.start)).collect();
        let robots = (0..problem.robots.len()).map(|m| RobotState::new(&problem, m)).collect();
        let (begin, people) = (problem.start, problem.agents.len());
        let world = ScheduleWorld {
            optimal: (problem.clone(), schedule.clone()),
            schedule,
            agents,
            robots,
            lost: vec![None; people],
            satisfied: vec![None; people],
            indices: vec![Indices::NONE; people],
            tick: None,
        };
        Ok(Simulation::at_start(problem, plan, settings, begin, world))
    }

    /// The service of an operation in the plan.
    fn service(&self, agent: usize, operation: usize) -> Option<&Assistance> {
        self.world.schedule.iter().find(|at| at.agent == agent && at.operation == operation)
    }

    fn has_places(&self) -> bool {
        self.problem.distances == Distances::Straight
    }
}

/// The scales of the beginning hold for the whole mission, so that costs before and after a change compare.
fn with_scales(problem: Problem) -> Problem {
    let wanted = problem.scales.is_none() && problem.check().is_empty();
    let scales = if wanted { Some(Scales::of(&problem)) } else { problem.scales };
    Problem { scales, ..problem }
}
