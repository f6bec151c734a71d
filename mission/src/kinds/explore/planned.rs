//! The plan of an exploration behind the interface of all kinds: what is printed, drawn and written of it.

use serde::Serialize;

use crate::plan::{Statistics, Status};
use crate::plan_data::{Cost, Named, Part};
use crate::planned::{Choice, Listing, PlanOptions, Planned, Refusal};

use super::chart::{chart, label};
use super::execution::{ExploreExecution, Settings};
use super::foresight::Foresight;
use super::map::{Way, doubts, map};
use super::mission::Explore;
use super::objective::Costs;
use super::plan::{Activity, Plan, activities};
use super::polygon::norm;
use super::problem::{EngineChoice, Problem};
use super::program::Present;
use super::solve::{Best, NoPlan, Solver};
use super::validate::validate;

/// Name of the formulation.
pub const PREDICTIVE: &str = "predictive";

impl Explore {
    /// Plans the exploration as it begins, and validates the plan.
    ///
    /// # Errors
    /// See [`Refusal`].
    pub fn planned(&self, options: &PlanOptions<'_>) -> Result<Planned, Refusal> {
        options.formulation_among(&[()], |()| PREDICTIVE)?;
        if options.batch.is_some() {
            return Err(Refusal::Mission(vec!["an exploration is planned as a whole, and not in batches".into()]));
        }
        let mut problem = self.problem.clone();
        if options.engine == crate::engine::Engine::Highs {
            problem.planner.engine = EngineChoice::Highs;
        }
        let refuse = |why: String| Refusal::Mission(vec![why]);
        let mut solver = Solver::find(problem.planner.engine)?;
        let (present, foresight) = ExploreExecution::start(&problem, &Settings::default()).map_err(refuse)?;
        let time = match options.time {
            Some(time) => {
                problem.planner.nodes = u64::MAX;
                time
            }
            None => super::execution::first_time(&problem),
        };
        let best = solver.plan(&problem, &present, &foresight, time).map_err(|why| match why {
            NoPlan::Engine(error) => Refusal::Engine(error),
            other => Refusal::Mission(vec![other.to_string()]),
        })?;
        let broken = validate(&problem, &present, &foresight, &best.trajectories);
        if !broken.is_empty() {
            return Err(Refusal::Invalid(broken.iter().map(ToString::to_string).collect()));
        }
        Ok(planned(&problem, &present, &foresight, &best, solver.name()))
    }
}

/// Describes a plan.
fn planned(problem: &Problem, present: &Present, foresight: &Foresight, best: &Best, engine: &str) -> Planned {
    let activities = activities(problem, present, &best.trajectories, foresight, 0.0);
    let status = match best.stopped {
        None => Status::Proven { bound: best.bound },
        Some(stopped) => Status::Gap { bound: best.bound, gap: best.gap(), stopped },
    };
    let members = problem.robots.iter().map(|robot| &robot.name).chain([&problem.person.name]).cloned().collect();
    let statistics = Statistics { solves: 1, nodes: best.nodes, cuts: 0 };
    let plan = Plan {
        members,
        activities,
        cost: best.cost,
        status: status.at_cost(best.cost),
        engine: engine.into(),
        statistics,
    };
    let mut taken = vec![None; problem.targets.len()];
    for visit in &best.trajectories.visits {
        taken[visit.target] = Some(visit.robot);
    }
    for (target, _) in &foresight.visits {
        taken[*target] = Some(problem.robots.len());
    }
    let ways: Vec<Way> = plan
        .activities
        .iter()
        .map(|activity| Way { member: activity.member, points: activity.way.clone(), expected: false })
        .collect();
    let places: Vec<_> =
        present.states.iter().map(|state| state.at).chain(foresight.positions.first().copied()).collect();
    let data = Data {
        agents: (0..=problem.robots.len()).map(|member| agent(problem, member, places[member])).collect(),
        targets: problem
            .targets
            .iter()
            .enumerate()
            .map(|(index, target)| TargetData {
                named: Named::new(&target.name, problem.target_label(index)),
                r#type: problem.types[target.of].clone(),
                worth: target.worth,
                by: taken[index].map(|member| name(problem, member)),
            })
            .collect(),
        arrives: foresight.arrives,
        activities: plan.activities.iter().map(|activity| activity_data(problem, activity)).collect(),
    };
    let method = Choice {
        formulation: PREDICTIVE,
        why: format!("robots plan around the expected way of {}", problem.person_label()),
    };
    let drawn = (chart(problem, &plan.activities), map(problem, &ways, doubts(foresight, 0), &taken, Some(&places)));
    let robots = best.trajectories.visits.len();
    let cost = cost(problem, present, foresight, best);
    Planned {
        summary: format!(
            "{robots} targets of {} by robots, {} by the person",
            problem.targets.len(),
            foresight.visits.len()
        ),
        cost_text: format!("rewards {:.2}, effort {:.2}", 0.0 - cost.parts[0].cost, cost.parts[2].cost),
        cost,
        table: table(problem, &plan),
        ..Planned::new(&plan, method, drawn.0, drawn.1, Box::new(data))
    }
}

/// The terms of the objective.
fn cost(problem: &Problem, present: &Present, foresight: &Foresight, best: &Best) -> Cost {
    let costs = Costs::of(problem, present, foresight, &best.trajectories);
    let parts = vec![
        Part::plain("rewards", costs.rewards),
        Part::plain("delay", costs.delay),
        Part::weighted("effort", costs.inputs, costs.weight),
        Part::plain("reserve", if costs.reserve < 1e-9 { 0.0 } else { costs.reserve }),
    ];
    Cost { total: parts.iter().map(|part| part.cost).sum(), parts }
}

fn name(problem: &Problem, member: usize) -> String {
    problem.robots.get(member).map_or(&problem.person.name, |robot| &robot.name).clone()
}

fn table(problem: &Problem, plan: &Plan) -> Listing {
    let row = |activity: &Activity| {
        let end = activity.way.last().copied().unwrap_or_default();
        let fastest =
            activity.way.windows(2).map(|two| norm(super::polygon::minus(two[1], two[0]))).fold(0.0, f64::max);
        vec![
            label(problem, activity.member).to_string(),
            activity.phase.name().to_string(),
            activity.target.map_or("-", |target| problem.target_label(target)).to_string(),
            format!("{:.1}", activity.start),
            format!("{:.1}", activity.end),
            format!("{:.2}", end[0]),
            format!("{:.2}", end[1]),
            format!("{:.2}", fastest / problem.period),
        ]
    };
    Listing {
        columns: vec!["who", "does", "target", "begins", "ends", "x", "y", "fastest"],
        names: 3,
        rows: plan.activities.iter().map(row).collect(),
        note: "(times in s, positions in m; `fastest` is the greatest mean speed of a period in m/s)",
    }
}

/// Keys of the plan that only an exploration has.
#[derive(Debug, Serialize)]
struct Data {
    agents: Vec<AgentData>,
    targets: Vec<TargetData>,
    arrives: bool,
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
struct TargetData {
    #[serde(flatten)]
    named: Named,
    r#type: String,
    worth: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    by: Option<String>,
}

#[derive(Debug, Serialize)]
struct ActivityData {
    agent: String,
    phase: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    target: Option<String>,
    start: f64,
    end: f64,
    place: [f64; 3],
    way: Vec<[f64; 2]>,
    begun: bool,
}

fn agent(problem: &Problem, member: usize, at: [f64; 2]) -> AgentData {
    let person = member == problem.robots.len();
    AgentData {
        named: Named::new(&name(problem, member), label(problem, member)),
        kind: if person { "human" } else { "robot" },
        place: [at[0], at[1], 0.0],
    }
}

fn activity_data(problem: &Problem, of: &Activity) -> ActivityData {
    let end = of.way.last().copied().unwrap_or_default();
    ActivityData {
        agent: name(problem, of.member),
        phase: of.phase.name(),
        target: of.target.map(|target| problem.targets[target].name.clone()),
        start: of.start,
        end: of.end,
        place: [end[0], end[1], 0.0],
        way: of.way.clone(),
        begun: of.begun,
    }
}
