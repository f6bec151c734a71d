//! Planning the missions of a spec: the plan, what it costs term by term, each service, and the verdict of the validator,
//! which knows nothing of the planner. A plan that it refuses is never given out.

use mission::kinds::layers;
use mission::kinds::layers::steps::{Step, from_plan as steps_of};
use mission::kinds::schedule::assistance::{Assistance, from_plan};
use mission::kinds::schedule::choose::{Choice, Options, Refusal, choose, plan};
use mission::kinds::schedule::cost::{Cost, cost, wait};
use mission::kinds::schedule::problem::Problem;
use mission::kinds::schedule::validate::validate;
use mission::plan::Plan;
use runtime::program::MissionProgram;

/// A plan of a schedule that was found to keep to everything that its mission says.
#[derive(Clone, Debug, PartialEq)]
pub struct Planned {
    /// How it was found, and why so.
    pub choice: Choice,
    /// The plan.
    pub plan: Plan,
    /// What it costs, term by term.
    pub cost: Cost,
    /// Its services, by robot and time.
    pub services: Vec<Service>,
}

/// A service of an agent by a robot; times in s, speeds in m/s.
#[derive(Clone, Debug, PartialEq)]
pub struct Service {
    /// The robot.
    pub robot: String,
    /// The agent.
    pub agent: String,
    /// Which of the agent's operations, from 1.
    pub operation: usize,
    /// How many it has.
    pub operations: usize,
    /// When the robot leaves its depot.
    pub leaves: f64,
    /// When it is at the waiting place.
    pub waits: f64,
    /// When it leaves the waiting place.
    pub approaches: f64,
    /// When it is with the agent.
    pub serves: f64,
    /// When it leaves the agent.
    pub returns: f64,
    /// When it has done what is done at the depot.
    pub ends: f64,
    /// Speed to the waiting place; none where there is no way.
    pub going_speed: Option<f64>,
    /// Speed from there to the agent.
    pub approach_speed: Option<f64>,
    /// Speed of the way back.
    pub return_speed: Option<f64>,
    /// When the operation ends.
    pub operation_ends: f64,
    /// How long the agent waits behind it.
    pub agent_waits: f64,
}

/// A plan of layers that was found to keep to everything that its mission says.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedLayers {
    /// How it was found, and why so.
    pub choice: layers::choose::Choice,
    /// The plan.
    pub plan: Plan,
    /// What it costs, term by term.
    pub cost: layers::cost::Cost,
    /// What is done, in the order of time.
    pub steps: Vec<Step>,
}

/// Why there is no plan.
#[derive(Clone, Debug, PartialEq)]
pub enum Unplanned {
    /// The planner of a schedule refused.
    Refused(Refusal),
    /// The planner of layers refused.
    Layers(layers::choose::Refusal),
    /// The planner gave what is no plan of the mission, for these reasons: a mistake in the planner.
    Invalid(Vec<String>),
}

/// Plans layers, and has the plan checked.
///
/// # Errors
/// See [`Unplanned`].
pub fn layers(
    problem: &layers::problem::Problem,
    options: &layers::choose::Options,
) -> Result<PlannedLayers, Unplanned> {
    let choice = layers::choose::choose(problem, options).map_err(Unplanned::Layers)?;
    let plan = layers::choose::plan(problem, options).map_err(Unplanned::Layers)?;
    let violations = layers::validate::validate(problem, &plan);
    let mut steps = steps_of(problem, &plan);
    if !violations.is_empty() || steps.len() != problem.tasks.len() {
        return Err(Unplanned::Invalid(violations.iter().map(ToString::to_string).collect()));
    }
    let cost = layers::cost::cost(problem, &steps);
    steps.sort_by(|a, b| a.start.total_cmp(&b.start).then(a.task.cmp(&b.task)));
    Ok(PlannedLayers { choice, plan, cost, steps })
}

/// Plans a schedule, and has the plan checked.
///
/// # Errors
/// See [`Unplanned`].
pub fn schedule(problem: &Problem, options: &Options) -> Result<Planned, Unplanned> {
    let choice = choose(problem, options).map_err(Unplanned::Refused)?;
    let plan = plan(problem, options).map_err(Unplanned::Refused)?;
    checked(problem, choice, plan)
}

/// A plan with what it costs, if it is one of this problem.
fn checked(problem: &Problem, choice: Choice, plan: Plan) -> Result<Planned, Unplanned> {
    let violations = validate(problem, &plan);
    let schedule = from_plan(&plan).unwrap_or_default();
    if !violations.is_empty() || schedule.len() != problem.operations() {
        return Err(Unplanned::Invalid(violations.iter().map(ToString::to_string).collect()));
    }
    let cost = cost(problem, &schedule);
    let mut services: Vec<(usize, Service)> =
        schedule.iter().map(|a| (a.robot, service(problem, &schedule, a))).collect();
    services.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.leaves.total_cmp(&b.1.leaves)));
    Ok(Planned { choice, plan, cost, services: services.into_iter().map(|s| s.1).collect() })
}

fn service(problem: &Problem, schedule: &[Assistance], of: &Assistance) -> Service {
    let (lengths, times) = (problem.lengths(of.agent, of.robot), of.times);
    let robot = problem.robots.get(of.robot);
    let agent = problem.agents.get(of.agent);
    let speed = |length: f64, time: f64| (length > 0.0 && time > 0.0).then(|| length / time);
    let deposit = robot.map_or(0.0, |m| m.deposit);
    Service {
        robot: robot.map(|m| m.name.clone()).unwrap_or_default(),
        agent: agent.map(|a| a.name.clone()).unwrap_or_default(),
        operation: of.operation + 1,
        operations: agent.map_or(0, |a| a.operations),
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
        agent_waits: wait(schedule, of),
    }
}

/// The mission of this name; of a spec that declares one alone, that one where no name is given.
///
/// # Errors
/// There is none, or several and no name; the message says which there are.
pub fn find<'p>(missions: &'p [MissionProgram], name: Option<&str>) -> Result<&'p MissionProgram, String> {
    let names = || missions.iter().map(|m| m.name.as_str());
    let Some(name) = name else {
        return match missions {
            [one] => Ok(one),
            [] => Err("it declares no mission: write one, `mission NAME : schedule { .. }`".to_string()),
            _ => Err(format!("it declares several missions: name one of {}", compiler::names::list(names(), 12))),
        };
    };
    missions.iter().find(|m| m.name == name).ok_or_else(|| {
        let help = match compiler::names::suggest(name, names()) {
            Some(near) => format!("did you mean `{near}`?"),
            None if missions.is_empty() => "it declares none".to_string(),
            None => format!("it has {}", compiler::names::list(names(), 12)),
        };
        format!("there is no mission `{name}`: {help}")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use mission::kinds::schedule::problem::{Agent, AgentKind, Distances, Duration, Robot, Weights};
    use mission::numbers::{Energy, Range};

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
        let agent = Agent {
            name: "a".to_string(),
            kind: AgentKind::Human,
            place: [4.0, 3.0],
            operations: 2,
            duration: Duration { mean: 60.0, sigma: 0.0 },
            severity: 0.0,
            wait_distance: 1.0,
            approaches: Vec::new(),
            wait_weights: Vec::new(),
            wait_limit: 60.0,
            limit_weights: Vec::new(),
            approach_weights: Vec::new(),
        };
        Problem {
            robots: vec![robot],
            agents: vec![agent],
            labels: Default::default(),
            distances: Distances::Straight,
            confidence: 0.9,
            weights: Weights { worker_wait: 1.0, energy: 1.0, makespan: 1.0 },
            start: 0.0,
            begun: Vec::new(),
            absent: Vec::new(),
            scales: None,
        }
    }

    #[test]
    fn a_plan_comes_with_its_services_and_cost() {
        let planned = schedule(&problem(), &Options::default()).expect("a plan");
        assert_eq!(planned.services.len(), 2);
        assert!((planned.cost.total() - planned.plan.cost).abs() < 1e-9);
        for s in &planned.services {
            let times = [s.leaves, s.waits, s.approaches, s.serves, s.returns, s.ends];
            assert!(times.windows(2).all(|w| w[0] <= w[1]), "{s:?}");
            assert!((s.returns - s.serves - 5.0).abs() < 1e-6);
            let going = s.going_speed.expect("a way");
            assert!((going * (s.waits - s.leaves) - 4.0).abs() < 1e-6, "{going}");
        }
    }

    /// What the validator refuses is never given out as a plan.
    #[test]
    fn a_plan_that_is_none_is_refused() {
        let problem = problem();
        let good = schedule(&problem, &Options::default()).expect("a plan");
        let mut late = good.plan.clone();
        late.activities.iter_mut().for_each(|a| a.end += 1.0);
        let mut missing = good.plan.clone();
        missing.activities.clear();
        for bad in [late, missing] {
            assert!(matches!(checked(&problem, good.choice.clone(), bad), Err(Unplanned::Invalid(_))));
        }
    }
}
