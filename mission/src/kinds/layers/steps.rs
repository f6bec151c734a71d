//! A layered plan as a list of tasks, each with its agent, object, speed and times. Planners use this form internally;
//! a [`Plan`] is the form of the result. Each converts into the other.

use super::plan::{Activity, Plan};
use crate::plan::{Statistics, Status};

use super::cost;
use super::problem::{Agent, Begun, Problem};

/// A planned task.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Index of the task.
    pub task: usize,
    /// Index of the agent.
    pub agent: usize,
    /// Index of the object; `None`: the task needs none.
    pub object: Option<usize>,
    /// Speed (m/s), more than 0.
    pub speed: f64,
    /// Start (s).
    pub start: f64,
    /// End (s).
    pub end: f64,
    /// True if the task had begun when the plan was made.
    pub begun: bool,
}

impl Begun {
    /// Converts a task that has begun into a step of a plan.
    pub fn step(&self) -> Step {
        let Begun { task, agent, object, speed, start, end } = *self;
        Step { task, agent, object, speed, start, end, begun: true }
    }
}

/// Converts steps into a plan, and computes its cost. A bound that exceeds the cost by rounding is lowered to it.
pub fn to_plan(problem: &Problem, steps: &[Step], status: Status, engine: String, statistics: Statistics) -> Plan {
    let cost = cost::cost(problem, steps).total();
    with_cost(problem, (steps, cost), status, engine, statistics)
}

/// As [`to_plan`] with a given cost.
pub(super) fn with_cost(
    problem: &Problem,
    (steps, cost): (&[Step], f64),
    status: Status,
    engine: String,
    statistics: Statistics,
) -> Plan {
    let mut plan = Plan {
        members: problem.agents.iter().map(|who| who.name.clone()).collect(),
        activities: steps.iter().map(|step| activity(problem, step)).collect(),
        cost,
        status: status.at_cost(cost),
        engine,
        statistics,
    };
    // Robots first, then people; each by time.
    let human = |agent: usize| problem.agents.get(agent).is_some_and(Agent::is_human);
    let layer = |task: usize| problem.tasks.get(task).map_or(0, |task| task.layer);
    plan.activities.sort_by(|a, b| {
        (human(a.agent), a.agent)
            .cmp(&(human(b.agent), b.agent))
            .then(a.start.total_cmp(&b.start))
            .then(a.end.total_cmp(&b.end))
            .then((layer(a.task), a.task).cmp(&(layer(b.task), b.task)))
    });
    plan
}

fn activity(problem: &Problem, step: &Step) -> Activity {
    let Step { task, agent, object, speed, start, end, begun } = *step;
    let path = problem.tasks.get(task).and_then(|what| what.path.last().copied());
    let thing = object.and_then(|object| problem.objects.get(object)).map(|thing| thing.place);
    let base = problem.agents.get(agent).map(|who| who.place);
    let moves = problem.distance(agent, task, object) > 0.0;
    let place = path.or(thing).or(base).unwrap_or_default();
    Activity { agent, task, object, start, end, speed: moves.then_some(speed), place, begun }
}

/// Converts a plan into steps, by task. A motion without a speed gets 1 m/s.
pub fn from_plan(plan: &Plan) -> Vec<Step> {
    let step = |activity: &Activity| {
        let Activity { agent, task, object, start, end, begun, .. } = *activity;
        Step { task, agent, object, speed: activity.speed.unwrap_or(1.0), start, end, begun }
    };
    let mut steps: Vec<Step> = plan.activities.iter().map(step).collect();
    steps.sort_by_key(|step| step.task);
    steps
}
