//! The plan of a search behind the interface of all kinds: what is printed, drawn and written of it.

use serde::Serialize;

use crate::engine::Budget;
use crate::plan_data::{Cost, Named, Part};
use crate::planned::{Listing, Method, PlanOptions, Planned, Refusal};

use super::chart::chart;
use super::choose::{Formulation, Options, plan};
use super::map::map_of_plan;
use super::mission::Search;
use super::plan::{Phase, Plan};
use super::problem::{Problem, SourceKind};
use super::reward::{Rewards, evaluate};
use super::validate::validate;

impl Search {
    /// Plans the search, and validates the plan.
    ///
    /// # Errors
    /// See [`Refusal`].
    pub fn planned(&self, options: &PlanOptions<'_>) -> Result<Planned, Refusal> {
        let usual = Options::of(&self.problem);
        let formulation = options.formulation_among(&Formulation::ALL, Formulation::name)?;
        if options.batch.is_some() {
            return Err(Refusal::Mission(vec!["a search is planned as a whole, and not in batches".into()]));
        }
        let formulation = formulation.unwrap_or(Formulation::TreeSearch);
        let budget = match options.time {
            Some(time) => Budget { time, nodes: u64::MAX, ..usual.budget },
            None => usual.budget,
        };
        let found = plan(&self.problem, &Options { formulation, budget, ..usual });
        let found = found.map_err(|mistakes| Refusal::Mission(mistakes.into_iter().map(|m| m.text).collect()))?;
        let why = match found.exhausted && formulation == Formulation::TreeSearch {
            true => format!("{}; every sequence of its actions was tried", formulation.why()),
            false => formulation.why().into(),
        };
        planned(&self.problem, &found.plan, Method { formulation: formulation.name(), why })
    }
}

/// Describes a plan, if the validator accepts it.
///
/// # Errors
/// The constraints that it breaks.
pub fn planned(problem: &Problem, plan: &Plan, method: Method) -> Result<Planned, Refusal> {
    let violations = validate(problem, plan);
    if !violations.is_empty() {
        return Err(Refusal::Invalid(violations.iter().map(ToString::to_string).collect()));
    }
    let rewards = evaluate(problem, &plan.activities);
    let drawn = (chart(problem, &plan.activities), map_of_plan(problem, &plan.activities));
    Ok(Planned {
        summary: format!("{} activities", plan.activities.len()),
        cost: cost(problem, &rewards),
        cost_text: cost_text(problem, &rewards),
        table: table(problem, plan),
        ..Planned::new(plan, method, drawn.0, drawn.1, Box::new(data(problem, plan, &rewards)))
    })
}

/// Reward by the sets of srs (7).
fn by_kind(problem: &Problem, rewards: &Rewards) -> [f64; 4] {
    let mut sums = [0.0; 4];
    for (source, reward) in problem.sources.iter().zip(&rewards.sources) {
        sums[source.kind as usize] += reward;
    }
    sums
}

/// The parts of srs (15), with the opposite sign.
fn cost(problem: &Problem, rewards: &Rewards) -> Cost {
    let sums = by_kind(problem, rewards);
    let parts = SourceKind::ALL.into_iter().zip(sums).map(|(kind, sum)| Part::plain(kind.name(), 0.0 - sum));
    let hidden = (!problem.objects.is_empty()).then(|| Part::plain("hidden", 0.0 - rewards.objects));
    let parts: Vec<Part> = parts.chain(hidden).collect();
    Cost { total: parts.iter().map(|part| part.cost).sum(), parts }
}

fn cost_text(problem: &Problem, rewards: &Rewards) -> String {
    let sums = by_kind(problem, rewards);
    // A part that rounds to zero is not a part.
    let parts = SourceKind::ALL.into_iter().zip(sums).filter(|(_, sum)| sum.abs() >= 0.005);
    let hidden = (rewards.objects >= 0.005).then(|| format!("hidden objects {:.2}", rewards.objects));
    let parts: Vec<String> = parts.map(|(kind, sum)| format!("{} {sum:.2}", kind.name())).chain(hidden).collect();
    match parts.is_empty() {
        true => "reward 0".into(),
        false => format!("reward {:.2}: {}", rewards.total, parts.join(", ")),
    }
}

fn table(problem: &Problem, plan: &Plan) -> Listing {
    let lookout = |activity: &super::plan::Activity| {
        let is = activity.source.is_none() && activity.phase != Phase::Waiting && problem.is_searching();
        is.then_some("lookout")
    };
    let row = |activity: &super::plan::Activity| {
        let end = activity.way.last().copied().unwrap_or_default();
        let source = activity.source.map(|source| problem.source_label(source));
        let whom = activity.awaits.map(|of| problem.agent_label(of.agent));
        vec![
            problem.agent_label(activity.agent).to_string(),
            activity.phase.name().to_string(),
            source.or(whom).or_else(|| lookout(activity)).unwrap_or("-").to_string(),
            format!("{:.1}", activity.start),
            format!("{:.1}", activity.end),
            format!("{:.2}", end[0]),
            format!("{:.2}", end[1]),
        ]
    };
    Listing {
        columns: vec!["who", "does", "source", "begins", "ends", "x", "y"],
        names: 3,
        rows: plan.activities.iter().map(row).collect(),
        note: "(times in s, positions in m; for an agent that waits, `source` is the agent for which it waits)",
    }
}

/// Keys of the plan that only a search has.
#[derive(Debug, Serialize)]
struct Data {
    agents: Vec<AgentData>,
    sources: Vec<SourceData>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    hidden: Vec<ObjectData>,
    activities: Vec<ActivityData>,
}

#[derive(Debug, Serialize)]
struct AgentData {
    #[serde(flatten)]
    named: Named,
    kind: &'static str,
    place: [f64; 3],
    reward: f64,
}

#[derive(Debug, Serialize)]
struct SourceData {
    #[serde(flatten)]
    named: Named,
    set: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pool: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    left: Option<f64>,
    reward: f64,
}

#[derive(Debug, Serialize)]
struct ObjectData {
    #[serde(flatten)]
    named: Named,
    count: usize,
    found: usize,
    worth: f64,
}

#[derive(Debug, Serialize)]
struct ActivityData {
    agent: String,
    phase: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    source: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    awaits: Option<String>,
    start: f64,
    end: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    speed: Option<f64>,
    place: [f64; 3],
    way: Vec<[f64; 2]>,
    begun: bool,
}

fn data(problem: &Problem, plan: &Plan, rewards: &Rewards) -> Data {
    let flat = |[x, y]: [f64; 2]| [x, y, 0.0];
    let agents = problem.agents.iter().zip(&rewards.agents).map(|(agent, reward)| AgentData {
        named: Named::new(&agent.name, problem.labels.member(&agent.name)),
        kind: if agent.human { "human" } else { "robot" },
        place: flat(agent.start),
        reward: *reward,
    });
    let sources = problem.sources.iter().enumerate().map(|(index, source)| SourceData {
        named: Named::new(&source.name, problem.labels.member(&source.name)),
        set: source.kind.name(),
        pool: source.pool,
        left: source.pool.map(|_| rewards.pools[index]),
        reward: rewards.sources[index],
    });
    let objects = problem.objects.iter().map(|object| ObjectData {
        named: Named::new(&object.name, problem.labels.member(&object.name)),
        count: object.count,
        found: object.found,
        worth: object.worth,
    });
    let name = |agent: usize| problem.agents.get(agent).map(|agent| agent.name.clone());
    let activities = plan.activities.iter().map(|activity| ActivityData {
        agent: name(activity.agent).unwrap_or_default(),
        phase: activity.phase.name(),
        source: activity.source.and_then(|source| problem.sources.get(source)).map(|source| source.name.clone()),
        awaits: activity.awaits.and_then(|of| name(of.agent)),
        start: activity.start,
        end: activity.end,
        speed: (activity.phase == Phase::Going).then(|| problem.agents[activity.agent].speed),
        place: flat(activity.way.last().copied().unwrap_or_default()),
        way: if activity.phase == Phase::Going { activity.way.clone() } else { Vec::new() },
        begun: activity.begun,
    });
    Data {
        agents: agents.collect(),
        sources: sources.collect(),
        hidden: objects.collect(),
        activities: activities.collect(),
    }
}
