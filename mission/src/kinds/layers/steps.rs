//! A layered plan as a list of tasks, each with its agent, object, speed and times. Planners use this form internally;
//! a [`Plan`] is the form of the result. Each converts into the other.

use crate::plan::{Activity, Actor, Layered, LayeredTask, Phase, Plan, Statistics, Status, Target, Work};

use super::cost;
use super::problem::{Begun, Problem};

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

/// Returns the actor of an agent in a plan: robots and people are numbered separately, each in the problem's order.
pub fn actor(problem: &Problem, agent: usize) -> Actor {
    let human = |index: usize| problem.agents.get(index).is_some_and(|who| who.is_human());
    let same = (0..agent).filter(|other| human(*other) == human(agent)).count();
    if human(agent) { Actor::Agent(same) } else { Actor::Robot(same) }
}

/// Returns the agent of an actor of a plan; `None` if there is no such agent.
pub fn agent_of(problem: &Problem, of: Actor) -> Option<usize> {
    (0..problem.agents.len()).find(|agent| actor(problem, *agent) == of)
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
    let status = match status {
        Status::Proven { bound } => Status::Proven { bound: bound.min(cost) },
        Status::Gap { bound, gap, stopped } => Status::Gap { bound: bound.min(cost), gap, stopped },
        Status::Unbounded { stopped } => Status::Unbounded { stopped },
    };
    let names = |human: bool| {
        let those = problem.agents.iter().filter(|who| who.is_human() == human);
        those.map(|who| who.name.clone()).collect()
    };
    let tasks = problem.tasks.iter().map(|task| LayeredTask {
        name: task.name.clone(),
        action: task.action.clone(),
        layer: task.layer,
    });
    let mut plan = Plan {
        robots: names(false),
        agents: names(true),
        labels: problem.labels.clone(),
        activities: steps.iter().map(|step| activity(problem, step)).collect(),
        cost,
        status,
        engine,
        statistics,
        layered: Some(Layered {
            layers: problem.layers.clone(),
            tasks: tasks.collect(),
            objects: problem.objects.iter().map(|thing| thing.name.clone()).collect(),
        }),
    };
    plan.sort();
    plan
}

fn activity(problem: &Problem, step: &Step) -> Activity {
    let Step { task, agent, object, speed, start, end, begun } = *step;
    let what = problem.tasks.get(task);
    let thing = object.and_then(|object| problem.objects.get(object)).map(|thing| thing.place);
    let base = problem.agents.get(agent).map(|who| who.place);
    let last = what.and_then(|what| what.path.last().copied()).or(thing).or(base);
    let moves = problem.distance(agent, task, object) > 0.0;
    Activity {
        actor: actor(problem, agent),
        phase: Phase::Task,
        target: Target { agent: what.map_or(0, |what| what.layer), operation: task },
        start,
        end,
        speed: moves.then_some(speed),
        place: last,
        begun,
        work: Some(Work { task, object }),
    }
}

/// Converts a layered plan into steps, by task. Activities of other plans and of unknown actors are omitted. A motion
/// without a speed gets 1 m/s.
pub fn from_plan(problem: &Problem, plan: &Plan) -> Vec<Step> {
    let step = |activity: &Activity| {
        let work = activity.work?;
        Some(Step {
            task: work.task,
            agent: agent_of(problem, activity.actor)?,
            object: work.object,
            speed: activity.speed.unwrap_or(1.0),
            start: activity.start,
            end: activity.end,
            begun: activity.begun,
        })
    };
    let mut steps: Vec<Step> = plan.activities.iter().filter_map(step).collect();
    steps.sort_by_key(|step| step.task);
    steps
}
