//! Executing a search: a world in which agents perform their activities and consume sources, and the plan follows what
//! happens.
//!
//! A [`SearchExecution`] is a discrete-event simulation. An activity begins when the one before ends, and a wait ends with the
//! activity that it is for, so that what is late moves what waits for it. Rewards are settled at each end and each event, as
//! in the states of the planner. What differs from the plan repairs it: activities stay, times move. When the reward that the
//! team can expect has changed, everything is planned anew from where everybody is; no plan is used that
//! [`validate`](super::validate) refuses.
//!
//! The same problem, settings and events at the same times give the same records, however time is cut into steps, unless a
//! planner was ended by its wall time.

mod driven;
mod event;
mod finds;
mod handle_event;
mod messages;
mod own_goals;
mod people;
mod record;
mod reminders;
mod rewards;
mod settings;
mod state;
mod steps;
mod update;
mod view;

use crate::execution::Simulation;

use super::check::check;
use super::choose::plan_checked;
use super::geometry::Pose;
use super::plan::{Activity, Plan};
use super::problem::{Agent, Problem};
use super::reward::Rewards;
use super::validate::validate;

pub use self::event::{Event, EventError};
pub use self::finds::Secret;
pub use self::messages::{MessageCounts, Role};
pub use self::record::{LogEntry, Record};
pub use self::settings::{Refusal, Settings};
pub use self::view::AgentView;

use self::driven::DrivenBase;
use self::finds::Hunt;
use self::people::Person;
use self::reminders::Poses;
use self::state::Member;

/// Rewards that differ by less are equal.
const EQUAL: f64 = 1e-9;

/// A search under way.
pub type SearchExecution = Simulation<SearchWorld>;

/// The state of the team and of the sources.
#[derive(Clone, Debug)]
pub struct SearchWorld {
    /// Time up to which rewards are settled (s).
    settled: f64,
    rewards: Rewards,
    members: Vec<Member>,
    /// Looking for what is hidden; none: nothing is.
    hunt: Option<Hunt>,
    /// Simulated people.
    people: Vec<Person>,
    /// Poses that were sent, and reminders, by agent.
    poses: Vec<Poses>,
    /// Positions at the start.
    starts: Vec<[f64; 2]>,
    /// Messages that people have sent.
    sent: MessageCounts,
    /// Reward that the first plan promised.
    promised: f64,
    /// Reward of the whole mission that the team could expect at the last planning.
    expected: f64,
}

impl SearchExecution {
    /// Plans the mission and stands at its start.
    ///
    /// # Errors
    /// The problem has mistakes, or the settings are wrong.
    pub fn new(problem: Problem, settings: Settings) -> Result<SearchExecution, Refusal> {
        let mistakes = check(&problem);
        if !mistakes.is_empty() {
            return Err(Refusal::Problem(mistakes));
        }
        settings.check(&problem)?;
        let plan = plan_checked(&problem, &settings.options(&problem)).plan;
        SearchExecution::with_plan(problem, plan, settings)
    }

    /// Stands at the start of a plan that was made before, for a problem without mistakes.
    ///
    /// # Errors
    /// The plan is none of this problem, or the settings are wrong.
    pub fn with_plan(problem: Problem, plan: Plan, settings: Settings) -> Result<SearchExecution, Refusal> {
        settings.check(&problem)?;
        let violations = validate(&problem, &plan);
        if !violations.is_empty() {
            return Err(Refusal::Violations(violations));
        }
        let member = |(agent, who): (usize, &Agent)| {
            let pose = Pose { at: who.start, heading: who.heading };
            let rates = rewards::rates(&problem, agent, who.start);
            let mut member = Member::new(pose, rates, rewards::seat(&problem, agent, who.start), own(&plan, agent));
            let driven = settings.driven.iter().find(|driven| driven.member == agent);
            member.driven = driven.map(|driven| DrivenBase::new(&problem, agent, pose, driven.tolerance));
            member
        };
        let world = SearchWorld {
            settled: problem.start,
            rewards: Rewards::none(&problem),
            hunt: Hunt::new(&problem, &settings),
            members: problem.agents.iter().enumerate().map(member).collect(),
            people: Person::all(&problem, &settings),
            poses: vec![Poses::none(&problem); problem.agents.len()],
            starts: problem.agents.iter().map(|who| who.start).collect(),
            sent: MessageCounts::default(),
            promised: -plan.cost,
            expected: -plan.cost,
        };
        let begin = problem.start;
        let mut execution = Simulation::at_start(problem, plan, settings, begin, world);
        (0..execution.world.members.len()).for_each(|agent| execution.start(agent));
        execution.wake();
        Ok(execution)
    }
}

/// The activities of an agent.
fn own(plan: &Plan, agent: usize) -> Vec<Activity> {
    plan.activities.iter().filter(|activity| activity.agent == agent).cloned().collect()
}
