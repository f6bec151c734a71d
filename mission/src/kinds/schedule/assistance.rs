//! A schedule as a list of operations, each with its service. Planners use this form internally; a [`Plan`] is the form
//! of the result. Each converts into the other.

use std::collections::BTreeMap;

use crate::plan::{Statistics, Status};

use super::cost;
use super::plan::{Activity, Actor, Phase, Plan, Target};
use super::problem::{Begun, Problem, ServiceTimes};

/// An operation of an agent and the service at its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Assistance {
    /// Index of the agent.
    pub agent: usize,
    /// Number of the operation, from 0.
    pub operation: usize,
    /// Start of the operation (s).
    pub start: f64,
    /// End of the operation (s).
    pub end: f64,
    /// Index of the robot that serves.
    pub robot: usize,
    /// Times of the service.
    pub times: ServiceTimes,
}

/// Reason why the activities of a plan are not a schedule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("operation {} of agent {} lacks or repeats its {}", .target.operation, .target.agent, .phase.name())]
pub struct NoSchedule {
    /// The operation.
    pub target: Target,
    /// The phase that is missing or repeated.
    pub phase: Phase,
}

impl Assistance {
    /// Returns the operation and its agent.
    pub fn target(&self) -> Target {
        Target { agent: self.agent, operation: self.operation }
    }
}

/// Returns the record of this operation in [`Problem::begun`], if it has begun.
pub fn begun_of(problem: &Problem, agent: usize, operation: usize) -> Option<&Begun> {
    problem.begun.iter().find(|begun| begun.agent == agent && begun.operation == operation)
}

/// Converts assistances into a plan, and computes its cost. A bound that exceeds the cost by rounding is lowered to it.
pub fn to_plan(
    problem: &Problem,
    schedule: &[Assistance],
    status: Status,
    engine: String,
    statistics: Statistics,
) -> Plan {
    let cost = cost::cost(problem, schedule).total();
    let robots = problem.robots.iter().map(|robot| &robot.name);
    let mut plan = Plan {
        members: robots.chain(problem.agents.iter().map(|agent| &agent.name)).cloned().collect(),
        activities: schedule.iter().flat_map(|assistance| activities(problem, assistance)).collect(),
        cost,
        status: status.at_cost(cost),
        engine,
        statistics,
    };
    plan.sort();
    plan
}

fn activities(problem: &Problem, assistance: &Assistance) -> [Activity; 6] {
    let Assistance { agent, operation, start, end, robot, times } = *assistance;
    let begun = begun_of(problem, agent, operation);
    let served = begun.is_some_and(|begun| begun.service.is_some());
    let lengths = problem.lengths(agent, robot);
    let deposit = problem.robots.get(robot).map_or(0.0, |machine| machine.deposit);
    let speed = |length: f64, time: f64| (length > 0.0 && time > 0.0).then(|| length / time);
    let place = problem.agents.get(agent).map(|who| who.place);
    let wait = problem.waiting_place(agent, robot);
    let depot = problem.robots.get(robot).map(|machine| machine.depot);
    let service = |phase, start, end, speed, place| Activity {
        actor: Actor::Robot(robot),
        phase,
        target: assistance.target(),
        start,
        end,
        speed,
        place,
        begun: served,
    };
    [
        Activity {
            actor: Actor::Agent(agent),
            phase: Phase::Operation,
            target: assistance.target(),
            start,
            end,
            speed: None,
            place,
            begun: begun.is_some(),
        },
        service(Phase::Going, times.going, times.waiting, speed(lengths.going, times.waiting - times.going), wait),
        service(Phase::Waiting, times.waiting, times.proximity, None, wait),
        service(
            Phase::Proximity,
            times.proximity,
            times.serving,
            speed(lengths.proximity, times.serving - times.proximity),
            place,
        ),
        service(Phase::Serving, times.serving, times.depositing, None, place),
        service(
            Phase::Depositing,
            times.depositing,
            times.end,
            speed(lengths.depositing, times.end - times.depositing - deposit),
            depot,
        ),
    ]
}

/// Converts a plan into assistances, by agent and operation.
///
/// # Errors
///
/// Reports the first operation that lacks one of its six activities or has one twice.
pub fn from_plan(plan: &Plan) -> Result<Vec<Assistance>, NoSchedule> {
    let mut parts: BTreeMap<Target, Vec<&Activity>> = BTreeMap::new();
    for activity in &plan.activities {
        parts.entry(activity.target).or_default().push(activity);
    }
    parts.iter().map(|(target, parts)| assistance(*target, parts)).collect()
}

fn assistance(target: Target, parts: &[&Activity]) -> Result<Assistance, NoSchedule> {
    let only = |phase: Phase| {
        let mut of = parts.iter().filter(|a| a.phase == phase);
        match (of.next(), of.next()) {
            (Some(activity), None) => Ok(activity),
            _ => Err(NoSchedule { target, phase }),
        }
    };
    let operation = only(Phase::Operation)?;
    let depositing = only(Phase::Depositing)?;
    let Actor::Robot(robot) = depositing.actor else {
        return Err(NoSchedule { target, phase: Phase::Depositing });
    };
    Ok(Assistance {
        agent: target.agent,
        operation: target.operation,
        start: operation.start,
        end: operation.end,
        robot,
        times: ServiceTimes {
            going: only(Phase::Going)?.start,
            waiting: only(Phase::Waiting)?.start,
            proximity: only(Phase::Proximity)?.start,
            serving: only(Phase::Serving)?.start,
            depositing: depositing.start,
            end: depositing.end,
        },
    })
}
