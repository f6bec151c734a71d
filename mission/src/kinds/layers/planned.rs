//! The plan of layers behind the interface of all kinds: what is printed, drawn and written of it.

use serde::Serialize;

use crate::engine::Budget;
use crate::plan_data::{Cost as CostData, Named, Part};
use crate::planned::{Listing, Method, PlanOptions, Planned, Refusal};

use super::chart::chart;
use super::choose::{self, Formulation, Options, choose};
use super::cost::{Cost, cost};
use super::map::map;
use super::mission::Layers;
use super::plan::{Activity, Plan};
use super::problem::{Problem, Weights};
use super::steps::{Step, from_plan};
use super::validate::validate;

impl From<choose::Refusal> for Refusal {
    fn from(refusal: choose::Refusal) -> Refusal {
        match refusal {
            choose::Refusal::Problem(mistakes) => {
                Refusal::Mission(mistakes.iter().map(|mistake| mistake.reason.to_string()).collect())
            }
            choose::Refusal::Engine(error) => Refusal::Engine(error),
        }
    }
}

impl Layers {
    /// Plans the layers, and validates the plan.
    ///
    /// # Errors
    /// See [`Refusal`].
    pub fn planned(&self, options: &PlanOptions<'_>) -> Result<Planned, Refusal> {
        let usual = Options::default();
        let limited = |time| Budget { time, nodes: u64::MAX, ..usual.budget };
        let options = Options {
            formulation: options.formulation_among(&Formulation::ALL, Formulation::name)?,
            engine: options.engine,
            batch: options.batch.or(self.batch),
            budget: options.time.map_or(usual.budget, limited),
        };
        let choice = choose(&self.problem, &options)?;
        let plan = choose::plan(&self.problem, &options)?;
        planned(&self.problem, &plan, choice.named(Formulation::name))
    }
}

/// Describes a plan, if the validator accepts it.
///
/// # Errors
/// The constraints that it breaks.
pub fn planned(problem: &Problem, plan: &Plan, method: Method) -> Result<Planned, Refusal> {
    let violations = validate(problem, plan);
    let mut steps = from_plan(plan);
    if !violations.is_empty() || steps.len() != problem.tasks.len() {
        return Err(Refusal::Invalid(violations.iter().map(ToString::to_string).collect()));
    }
    let cost = cost(problem, &steps);
    steps.sort_by(|a, b| a.start.total_cmp(&b.start).then(a.task.cmp(&b.task)));
    Ok(Planned {
        summary: format!("{} tasks", steps.len()),
        cost_text: cost_text(&cost),
        cost: cost_data(&cost, &problem.weights),
        table: table(problem, &steps),
        ..Planned::new(plan, method, chart(problem, plan), map(problem, plan), Box::new(data(problem, plan)))
    })
}

/// Keys of the plan that only layers have.
#[derive(Debug, Serialize)]
struct Data {
    agents: Vec<AgentData>,
    objects: Vec<ObjectData>,
    layers: Vec<Named>,
    tasks: Vec<TaskData>,
    activities: Vec<ActivityData>,
}

#[derive(Debug, Serialize)]
struct AgentData {
    #[serde(flatten)]
    named: Named,
    kind: &'static str,
    place: [f64; 3],
}

#[derive(Debug, Serialize)]
struct ObjectData {
    #[serde(flatten)]
    named: Named,
    place: [f64; 3],
    mass: f64,
    features: Vec<String>,
}

#[derive(Debug, Serialize)]
struct TaskData {
    #[serde(flatten)]
    named: Named,
    layer: String,
    action: String,
}

#[derive(Debug, Serialize)]
struct ActivityData {
    agent: String,
    phase: &'static str,
    task: String,
    layer: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    object: Option<String>,
    start: f64,
    end: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    speed: Option<f64>,
    place: [f64; 3],
    begun: bool,
}

fn data(problem: &Problem, plan: &Plan) -> Data {
    let labels = &problem.labels;
    let agents = problem.agents.iter().map(|who| AgentData {
        named: Named::new(&who.name, labels.member(&who.name)),
        kind: if who.is_human() { "human" } else { "robot" },
        place: who.place,
    });
    let objects = problem.objects.iter().map(|thing| ObjectData {
        named: Named::new(&thing.name, labels.member(&thing.name)),
        place: thing.place,
        mass: thing.mass,
        features: thing.features.iter().cloned().collect(),
    });
    let tasks = problem.tasks.iter().map(|task| TaskData {
        named: Named::new(&task.name, labels.task(&task.name)),
        layer: layer(problem, task.layer),
        action: task.action.clone(),
    });
    Data {
        agents: agents.collect(),
        objects: objects.collect(),
        layers: problem.layers.iter().map(|name| Named::new(name, labels.layer(name))).collect(),
        tasks: tasks.collect(),
        activities: plan.activities.iter().map(|activity| activity_data(problem, activity)).collect(),
    }
}

fn layer(problem: &Problem, layer: usize) -> String {
    problem.layers.get(layer).cloned().unwrap_or_default()
}

fn activity_data(problem: &Problem, activity: &Activity) -> ActivityData {
    let Activity { agent, task, object, start, end, speed, place, begun } = *activity;
    let task = problem.tasks.get(task);
    ActivityData {
        agent: problem.agents.get(agent).map(|who| who.name.clone()).unwrap_or_default(),
        phase: "task",
        task: task.map(|task| task.name.clone()).unwrap_or_default(),
        layer: task.map(|task| layer(problem, task.layer)).unwrap_or_default(),
        object: object.and_then(|object| problem.objects.get(object)).map(|thing| thing.name.clone()),
        start,
        end,
        speed,
        place,
        begun,
    }
}

fn cost_data(cost: &Cost, weights: &Weights) -> CostData {
    let parts = vec![
        Part::weighted("makespan", cost.makespan, weights.makespan),
        Part::weighted("workload", cost.workload, weights.workload),
        Part::weighted("energy", cost.energy, weights.energy),
    ];
    CostData { total: cost.total(), parts }
}

fn cost_text(cost: &Cost) -> String {
    format!(
        "cost {:.4}, from workload {:.4}, energy {:.4} and makespan {:.4}, each before its weight",
        cost.total(),
        cost.workload,
        cost.energy,
        cost.makespan
    )
}

/// The steps, in the order of time.
fn table(problem: &Problem, steps: &[Step]) -> Listing {
    let mut rows = Vec::new();
    let mut last = "";
    for step in steps {
        let Some(task) = problem.tasks.get(step.task) else { continue };
        let layer = problem.layer_label(task.layer).unwrap_or_default();
        let shown = if std::mem::replace(&mut last, layer) == layer { "" } else { layer };
        let moves = problem.distance(step.agent, step.task, step.object) > 0.0;
        rows.push(vec![
            shown.to_string(),
            problem.labels.task(&task.name).to_string(),
            problem.agent_label(step.agent).unwrap_or_default().to_string(),
            task.action.clone(),
            step.object.and_then(|object| problem.object_label(object)).unwrap_or("-").to_string(),
            format!("{:.1}", step.start),
            format!("{:.1}", step.end),
            if moves { format!("{:.3}", step.speed) } else { "-".to_string() },
        ]);
    }
    Listing {
        columns: vec!["layer", "task", "who", "does", "with", "begins", "ends", "speed"],
        names: 5,
        rows,
        note: "(times in s, speeds in m/s)",
    }
}
