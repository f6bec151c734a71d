//! The plan of a schedule behind the interface of all kinds: what is printed, drawn and written of it.

use serde::Serialize;

use crate::engine::Budget;
use crate::plan_data::{Cost as CostData, Named, Part};
use crate::planned::{Listing, PlanOptions, Planned, Refusal};

use super::assistance::{Assistance, from_plan};
use super::chart::chart;
use super::choose::{self, Choice, Formulation, Options, choose};
use super::cost::{Cost, cost, wait};
use super::map::map;
use super::mission::Schedule;
use super::plan::{Activity, Actor, Plan};
use super::problem::{AgentKind, Problem};
use super::validate::validate;

impl From<choose::Refusal> for Refusal {
    fn from(refusal: choose::Refusal) -> Refusal {
        match refusal {
            choose::Refusal::Problem(mistakes) => {
                Refusal::Mission(mistakes.iter().map(|mistake| mistake.reason.to_string()).collect())
            }
            choose::Refusal::Engine(error) => Refusal::Engine(error),
            choose::Refusal::Speeds { .. } | choose::Refusal::NotSubsets | choose::Refusal::NotOrders => {
                Refusal::Formulation { why: refusal.to_string(), instead: Formulation::Position.name() }
            }
        }
    }
}

impl Schedule {
    /// Plans the schedule, and validates the plan.
    ///
    /// # Errors
    /// See [`Refusal`].
    pub fn planned(&self, options: &PlanOptions<'_>) -> Result<Planned, Refusal> {
        let budget = Budget::default();
        let options = Options {
            formulation: options.formulation_among(&Formulation::ALL, Formulation::name)?,
            engine: options.engine,
            batch: options.batch.unwrap_or(self.batch),
            budget: options.time.map_or(budget, |time| Budget { time, nodes: u64::MAX, ..budget }),
        };
        let choice = choose(&self.problem, &options)?;
        let plan = choose::plan(&self.problem, &options)?;
        planned(&self.problem, choice, &plan)
    }
}

/// Describes a plan, if the validator accepts it.
fn planned(problem: &Problem, choice: Choice, plan: &Plan) -> Result<Planned, Refusal> {
    let violations = validate(problem, plan);
    let schedule = from_plan(plan).unwrap_or_default();
    if !violations.is_empty() || schedule.len() != problem.operations() {
        return Err(Refusal::Invalid(violations.iter().map(ToString::to_string).collect()));
    }
    let services = services(problem, &schedule);
    let cost = cost(problem, &schedule);
    let method = choice.named(Formulation::name);
    let data = Data {
        agents: agents(problem),
        activities: plan.activities.iter().map(|activity| ActivityData::new(problem, activity)).collect(),
        services: services.clone(),
    };
    Ok(Planned {
        summary: format!("{} services", services.len()),
        cost_text: cost_text(&cost),
        cost: CostData { total: cost.total(), parts: parts(&cost) },
        table: table(problem, &services),
        ..Planned::new(plan, method, chart(problem, plan), map(problem, plan), Box::new(data))
    })
}

/// Keys of the plan that only schedules have.
#[derive(Debug, Serialize)]
struct Data {
    agents: Vec<AgentData>,
    activities: Vec<ActivityData>,
    services: Vec<Service>,
}

#[derive(Debug, Serialize)]
struct AgentData {
    #[serde(flatten)]
    named: Named,
    kind: &'static str,
    place: [f64; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    operations: Option<usize>,
}

/// An operation of a served agent.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
struct OperationData {
    /// Name of the agent.
    of: String,
    /// Number of the operation, from 1.
    number: usize,
}

#[derive(Debug, Serialize)]
struct ActivityData {
    agent: String,
    phase: &'static str,
    operation: OperationData,
    start: f64,
    end: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    speed: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    place: Option<[f64; 3]>,
    begun: bool,
}

/// A service of an agent by a robot; times in s, speeds in m/s.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct Service {
    /// Name of the serving agent, a robot.
    agent: String,
    operation: OperationData,
    leaves: f64,
    waits: f64,
    approaches: f64,
    serves: f64,
    returns: f64,
    ends: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    going_speed: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    approach_speed: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    return_speed: Option<f64>,
    operation_ends: f64,
    wait: f64,
}

fn on_ground([x, y]: [f64; 2]) -> [f64; 3] {
    [x, y, 0.0]
}

fn robot_name(problem: &Problem, robot: usize) -> String {
    problem.robots.get(robot).map(|robot| robot.name.clone()).unwrap_or_default()
}

fn agent_name(problem: &Problem, agent: usize) -> String {
    problem.agents.get(agent).map(|agent| agent.name.clone()).unwrap_or_default()
}

fn agents(problem: &Problem) -> Vec<AgentData> {
    let named = |name: &str| Named::new(name, problem.labels.member(name));
    let robots = problem.robots.iter().map(|robot| AgentData {
        named: named(&robot.name),
        kind: "robot",
        place: on_ground(robot.depot),
        operations: None,
    });
    let served = problem.agents.iter().map(|who| AgentData {
        named: named(&who.name),
        kind: match who.kind {
            AgentKind::Human => "human",
            AgentKind::Worker => "worker",
        },
        place: on_ground(who.place),
        operations: Some(who.operations),
    });
    robots.chain(served).collect()
}

impl ActivityData {
    fn new(problem: &Problem, activity: &Activity) -> ActivityData {
        let Activity { actor, phase, target, start, end, speed, place, begun } = *activity;
        ActivityData {
            agent: match actor {
                Actor::Robot(robot) => robot_name(problem, robot),
                Actor::Agent(agent) => agent_name(problem, agent),
            },
            phase: phase.name(),
            operation: OperationData { of: agent_name(problem, target.agent), number: target.operation + 1 },
            start,
            end,
            speed,
            place: place.map(on_ground),
            begun,
        }
    }
}

/// The services, by robot and time.
fn services(problem: &Problem, schedule: &[Assistance]) -> Vec<Service> {
    let mut sorted: Vec<&Assistance> = schedule.iter().collect();
    sorted.sort_by(|a, b| a.robot.cmp(&b.robot).then(a.times.going.total_cmp(&b.times.going)));
    sorted.into_iter().map(|of| service(problem, schedule, of)).collect()
}

fn service(problem: &Problem, schedule: &[Assistance], of: &Assistance) -> Service {
    let (lengths, times) = (problem.lengths(of.agent, of.robot), of.times);
    let speed = |length: f64, time: f64| (length > 0.0 && time > 0.0).then(|| length / time);
    let deposit = problem.robots.get(of.robot).map_or(0.0, |robot| robot.deposit);
    Service {
        agent: robot_name(problem, of.robot),
        operation: OperationData { of: agent_name(problem, of.agent), number: of.operation + 1 },
        leaves: times.going,
        waits: times.waiting,
        approaches: times.proximity,
        serves: times.serving,
        returns: times.depositing,
        ends: times.end,
        going_speed: speed(lengths.going, times.waiting - times.going),
        approach_speed: speed(lengths.proximity, times.serving - times.proximity),
        return_speed: speed(lengths.depositing, times.end - times.depositing - deposit),
        operation_ends: of.end,
        wait: wait(schedule, of),
    }
}

fn parts(cost: &Cost) -> Vec<Part> {
    vec![
        Part::plain("human_wait", cost.human_wait),
        Part::plain("worker_wait", cost.worker_wait),
        Part::plain("energy_going", cost.going),
        Part::plain("energy_proximity", cost.proximity),
        Part::plain("energy_depositing", cost.depositing),
        Part::plain("makespan", cost.makespan),
    ]
}

fn cost_text(cost: &Cost) -> String {
    format!(
        "cost {:.4}: waits of people {:.4}, of workers {:.4}, makespan {:.4},\n  energy of going {:.4}, of approaching \
         {:.4}, of coming back {:.4}",
        cost.total(),
        cost.human_wait,
        cost.worker_wait,
        cost.makespan,
        cost.going,
        cost.proximity,
        cost.depositing
    )
}

fn table(problem: &Problem, services: &[Service]) -> Listing {
    let time = |s: f64| format!("{s:.1}");
    let speed = |v: Option<f64>| v.map_or_else(|| "-".to_string(), |v| format!("{v:.3}"));
    let label = |name: &str| problem.labels.member(name).to_string();
    let mut last = "";
    let row = |s: &'_ Service, first: bool| {
        vec![
            if first { label(&s.agent) } else { String::new() },
            format!("{}.{}", problem.labels.member(&s.operation.of), s.operation.number),
            time(s.leaves),
            time(s.waits),
            time(s.approaches),
            time(s.serves),
            time(s.returns),
            time(s.ends),
            speed(s.going_speed),
            speed(s.approach_speed),
            speed(s.return_speed),
            time(s.wait),
        ]
    };
    let rows = services.iter().map(|s| row(s, std::mem::replace(&mut last, s.agent.as_str()) != s.agent));
    Listing {
        columns: vec![
            "robot", "serves", "leaves", "waits", "comes", "serves", "goes", "done", "speed", "near", "back", "waited",
        ],
        names: 2,
        rows: rows.collect(),
        note: "(when the robot leaves its depot, waits, comes near, serves, goes back and is done, in s; how fast it is on its \
               way,\n near the agent and back, in m/s; how long the agent waited, in s)\n",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::schedule::problem::{AgentKind, Duration, Robot, WorkingAgent};
    use crate::numbers::{Energy, Range};

    fn problem() -> Problem {
        let robot = Robot {
            name: "m".to_string(),
            depot: [0.0, 0.0],
            speed: Range::new(0.1, 0.4),
            proximity: None,
            serve: 5.0,
            deposit: 2.0,
            factor: 1.0,
            energy: Energy::of_factor(1.0),
        };
        let duration = Duration { mean: 60.0, sigma: 0.0 };
        Problem::new(vec![robot], vec![WorkingAgent::new("a", AgentKind::Human, [4.0, 3.0], 2, duration)])
    }

    #[test]
    fn a_plan_comes_with_its_services_and_cost() {
        let problem = problem();
        let plan = choose::plan(&problem, &Options::default()).expect("a plan");
        let schedule = from_plan(&plan).expect("a schedule");
        let services = services(&problem, &schedule);
        assert_eq!(services.len(), 2);
        assert!((cost(&problem, &schedule).total() - plan.cost).abs() < 1e-9);
        for s in &services {
            let times = [s.leaves, s.waits, s.approaches, s.serves, s.returns, s.ends];
            assert!(times.windows(2).all(|w| w[0] <= w[1]), "{s:?}");
            assert!((s.returns - s.serves - 5.0).abs() < 1e-6);
            let going = s.going_speed.expect("a way");
            assert!((going * (s.waits - s.leaves) - 4.0).abs() < 1e-6, "{going}");
        }
    }

    /// A plan that the validator rejects is never returned.
    #[test]
    fn an_invalid_plan_is_refused() {
        let problem = problem();
        let (choice, good) = (choose(&problem, &Options::default()), choose::plan(&problem, &Options::default()));
        let (choice, good) = (choice.expect("a choice"), good.expect("a plan"));
        assert!(planned(&problem, choice.clone(), &good).is_ok());
        let mut late = good.clone();
        late.activities.iter_mut().for_each(|a| a.end += 1.0);
        let mut missing = good.clone();
        missing.activities.clear();
        for bad in [late, missing] {
            assert!(matches!(planned(&problem, choice.clone(), &bad), Err(Refusal::Invalid(_))));
        }
    }
}
