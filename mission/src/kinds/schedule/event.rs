//! Events of a schedule by the words of the language, as events of its execution.

use super::plan::Actor;
use crate::kind::{Detail, Event as Named};
use crate::numbers::MAX_NUMBER;

use super::execution::{Event, ScheduleExecution, Stage};
use super::problem::Problem;
use super::words::of_event;

/// An event with the member that it is of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Typed {
    /// An event of the execution.
    Event(Event),
    /// The service that this robot gives fails, whomever it serves then.
    ServiceFails(usize),
    /// The service that this robot gives takes longer, whomever it serves then, by a time (s).
    ServiceLate(usize, f64),
}

/// The actor of a member.
pub(super) fn actor(problem: &Problem, member: usize) -> Option<Actor> {
    match member.checked_sub(problem.robots.len()) {
        None => Some(Actor::Robot(member)),
        Some(agent) => (agent < problem.agents.len()).then_some(Actor::Agent(agent)),
    }
}

/// The agent that a member is.
pub(super) fn agent(problem: &Problem, member: usize) -> Option<usize> {
    match actor(problem, member)? {
        Actor::Agent(agent) => Some(agent),
        Actor::Robot(_) => None,
    }
}

/// The member of an actor.
pub fn member(problem: &Problem, actor: Actor) -> usize {
    match actor {
        Actor::Robot(robot) => robot,
        Actor::Agent(agent) => problem.robots.len() + agent,
    }
}

/// The event of the execution.
pub(super) fn typed(problem: &Problem, of: &Named) -> Result<Typed, String> {
    let name = of.event.as_str();
    if name == "replan" {
        return Ok(Typed::Event(Event::Replan));
    }
    let who = of.member.and_then(|member| actor(problem, member));
    let who = who.ok_or_else(|| format!("`{name}` names a member that does not exist"))?;
    let by = || of.number("by").filter(|by| by.abs() <= MAX_NUMBER).ok_or_else(|| format!("`{name}` needs `by`"));
    let agent = match (name, who) {
        ("lost", who) => return Ok(Typed::Event(Event::Lost { who })),
        ("back", who) => return Ok(Typed::Event(Event::Back { who })),
        ("failed", Actor::Robot(robot)) => return Ok(Typed::ServiceFails(robot)),
        ("late", Actor::Robot(robot)) => return Ok(Typed::ServiceLate(robot, by()?)),
        (_, Actor::Agent(agent)) => agent,
        (_, Actor::Robot(_)) => return Err(format!("`{name}` makes no sense for a robot that serves")),
    };
    let step = |key: &str| -> Result<i8, String> {
        let step = of.number(key).unwrap_or(0.0);
        let known = (-2..=2).find(|known| f64::from(*known) == step);
        known.ok_or_else(|| format!("a step of feedback lies between -2 and 2, and is {step}"))
    };
    Ok(Typed::Event(match name {
        "begun" => Event::Begun { agent },
        "done" => Event::Done { agent },
        "served" => Event::Served { agent },
        "failed" => Event::Failed { agent },
        "late" => Event::Late { agent, by: by()? },
        "moved" => {
            let place = of.point("to").filter(|to| to.iter().all(|x| x.abs() <= MAX_NUMBER));
            Event::Moved { agent, place: place.ok_or("`moved` needs `to`")? }
        }
        "feedback" => {
            Event::Said { agent, wait: step("wait")?, approach: step("approach")?, distance: step("distance")? }
        }
        other => return Err(format!("a schedule has no event `{other}`")),
    }))
}

/// The words for an event.
pub(super) fn describe(problem: &Problem, of: &Named) -> String {
    let robot = |robot: usize| problem.robots.get(robot).map_or("?", |m| m.name.as_str());
    match typed(problem, of) {
        Ok(Typed::Event(event)) => of_event(&event, problem),
        Ok(Typed::ServiceFails(of)) => format!("the service that {} gives fails", robot(of)),
        Ok(Typed::ServiceLate(of, by)) => {
            format!("the service that {} gives takes {} s longer", robot(of), quantities::number(by))
        }
        Err(_) => of.event.clone(),
    }
}

/// Lets an event happen at the present time.
pub(super) fn handle(execution: &mut ScheduleExecution, of: &Named) -> Result<(), String> {
    let (robot, event): (usize, fn(usize, f64) -> Event) = match typed(execution.problem(), of)? {
        Typed::Event(event) => return execution.handle_event(event).map(|_| ()).map_err(|why| why.to_string()),
        Typed::ServiceFails(robot) => (robot, |agent, _| Event::Failed { agent }),
        Typed::ServiceLate(robot, _) => (robot, |agent, by| Event::Late { agent, by }),
    };
    let by = of.number("by").unwrap_or(0.0);
    let view = execution.robot(robot).filter(|view| view.stage == Stage::Serving);
    let Some(target) = view.and_then(|view| view.target) else {
        let name = execution.problem().robot_label(robot).unwrap_or_default();
        return Err(format!("{name} serves nobody"));
    };
    execution.handle_event(event(target.agent, by)).map(|_| ()).map_err(|why| why.to_string())
}

/// Feedback of a person in the five steps of thesis Fig. 5.5, each -2 to 2.
pub fn feedback(member: usize, [wait, approach, distance]: [i8; 3]) -> Named {
    let step = |step: i8| Detail::Number(f64::from(step));
    let of = Named::of("feedback", member);
    of.and("wait", step(wait)).and("approach", step(approach)).and("distance", step(distance))
}
