//! The plan of layers as data.

use mission::kinds::layers::cost::Cost;
use mission::kinds::layers::problem::{Agent, Problem, Weights};
use mission::plan::{Activity, Plan};

use super::{ActivityData, AgentData, CostData, Named, ObjectData, Part, PlanData, TaskData, VERSION};

/// What found a plan of layers, and why so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Found<'a> {
    /// The formulation; `given` where nothing was planned.
    pub formulation: &'a str,
    /// Why so.
    pub why: &'a str,
}

impl PlanData {
    /// The plan of this mission of this spec, which costs so much.
    pub fn of_layers(
        (spec, mission): (&str, &str),
        problem: &Problem,
        (plan, cost): (&Plan, &Cost),
        found: Found<'_>,
    ) -> PlanData {
        let labels = &problem.labels;
        PlanData {
            version: VERSION,
            ok: true,
            spec: spec.to_string(),
            mission: mission.to_string(),
            kind: "layers",
            formulation: found.formulation.to_string(),
            why: found.why.to_string(),
            engine: plan.engine.clone(),
            valid: true,
            status: plan.status.clone(),
            statistics: plan.statistics,
            cost: cost_of(cost, &problem.weights),
            agents: problem.agents.iter().map(|who| agent(problem, who)).collect(),
            objects: problem
                .objects
                .iter()
                .map(|thing| ObjectData {
                    named: Named::new(&thing.name, labels.member(&thing.name)),
                    place: thing.place,
                    mass: thing.mass,
                    features: thing.features.iter().cloned().collect(),
                })
                .collect(),
            layers: problem.layers.iter().map(|name| Named::new(name, labels.layer(name))).collect(),
            tasks: problem
                .tasks
                .iter()
                .map(|task| TaskData {
                    named: Named::new(&task.name, labels.task(&task.name)),
                    layer: layer(problem, task.layer),
                    action: task.action.clone(),
                })
                .collect(),
            activities: plan.activities.iter().map(|activity| of(problem, plan, activity)).collect(),
            services: Vec::new(),
        }
    }
}

fn cost_of(cost: &Cost, weights: &Weights) -> CostData {
    let part = |(name, value, weight): (&'static str, f64, f64)| Part {
        name,
        cost: weight * value,
        value: Some(value),
        weight: Some(weight),
    };
    let parts = [
        ("workload", cost.workload, weights.workload),
        ("energy", cost.energy, weights.energy),
        ("makespan", cost.makespan, weights.makespan),
    ];
    CostData { total: cost.total(), parts: parts.map(part).to_vec() }
}

fn agent(problem: &Problem, who: &Agent) -> AgentData {
    AgentData {
        named: Named::new(&who.name, problem.labels.member(&who.name)),
        kind: if who.is_human() { "human" } else { "robot" },
        place: who.place,
        operations: None,
    }
}

fn layer(problem: &Problem, layer: usize) -> String {
    problem.layers.get(layer).cloned().unwrap_or_default()
}

fn of(problem: &Problem, plan: &Plan, activity: &Activity) -> ActivityData {
    let task = activity.work.and_then(|work| problem.tasks.get(work.task));
    let object = activity.work.and_then(|work| problem.objects.get(work.object?));
    ActivityData {
        agent: plan.name(activity.actor).to_string(),
        phase: activity.phase.name(),
        operation: None,
        task: task.map(|task| task.name.clone()),
        layer: task.map(|task| layer(problem, task.layer)),
        object: object.map(|thing| thing.name.clone()),
        start: activity.start,
        end: activity.end,
        speed: activity.speed,
        place: activity.place,
        begun: activity.begun,
    }
}
