//! Events and log entries of a search in the words of the language and of people.

use crate::kind::{Detail, Event as Named};
use crate::numbers::MAX_NUMBER;

use super::execution::{Event, LogEntry};
use super::plan::Phase;
use super::problem::Problem;

/// The event of the execution.
pub(super) fn typed(problem: &Problem, of: &Named) -> Result<Event, String> {
    let name = of.event.as_str();
    if name == "replan" {
        return Ok(Event::Replan);
    }
    if name == "found" {
        let first = problem.agents.len() + problem.sources.len();
        let object = of.member.and_then(|member| member.checked_sub(first));
        let object = object.filter(|object| *object < problem.objects.len());
        return object.map(|object| Event::Found { object }).ok_or_else(|| "`found` needs a hidden object".into());
    }
    let agent = of.member.filter(|member| *member < problem.agents.len());
    let agent = agent.ok_or_else(|| format!("`{name}` names a member that does not exist"))?;
    let place = || {
        let to = of.point("to").filter(|to| to.iter().all(|x| x.abs() <= MAX_NUMBER));
        to.ok_or_else(|| format!("`{name}` needs `to`"))
    };
    Ok(match name {
        "late" => {
            let by = of.number("by").filter(|by| by.abs() <= MAX_NUMBER);
            Event::Late { agent, by: by.ok_or("`late` needs `by`")? }
        }
        "done" => Event::Done { agent },
        "moved" => Event::Moved { agent, to: place()? },
        "my_pose" => Event::MyPose { agent, to: place()? },
        "my_goal" => Event::MyGoal { agent, to: place()? },
        "robot_goal" => Event::RobotGoal { agent, to: place()? },
        "robot_pose" => Event::RobotPose { agent, to: place()? },
        "strays" => Event::Strays { agent, to: place()? },
        "seen" => Event::Seen { agent },
        "free" => Event::Free { agent },
        "lost" => Event::Lost { agent },
        "back" => Event::Back { agent },
        other => return Err(format!("a search has no event `{other}`")),
    })
}

/// An event of the execution by the words of the language.
pub(super) fn named(agent: usize, name: &str, detail: Option<(&str, Detail)>) -> Named {
    let event = Named::of(name, agent);
    match detail {
        Some((key, detail)) => event.and(key, detail),
        None => event,
    }
}

/// The words for an event.
pub(super) fn words(problem: &Problem, event: &Event) -> String {
    let label = |agent: &usize| problem.agent_label(*agent);
    match event {
        Event::Late { agent, by } if *by < 0.0 => format!("{} is earlier by {:.1} s", label(agent), -by),
        Event::Late { agent, by } => format!("{} is late by {by:.1} s", label(agent)),
        Event::Done { agent } => format!("{} is done", label(agent)),
        Event::Moved { agent, to } => format!("{} is at ({:.1}, {:.1}) m", label(agent), to[0], to[1]),
        Event::Lost { agent } => format!("{} is lost", label(agent)),
        Event::Back { agent } => format!("{} is back", label(agent)),
        Event::MyPose { agent, to } => format!("{} says to be at ({:.1}, {:.1}) m", label(agent), to[0], to[1]),
        Event::MyGoal { agent, to } => format!("{} says to go to ({:.1}, {:.1}) m", label(agent), to[0], to[1]),
        Event::RobotGoal { agent, to } => format!("{} is sent to ({:.1}, {:.1}) m", label(agent), to[0], to[1]),
        Event::RobotPose { agent, to } => format!("{} is said to be at ({:.1}, {:.1}) m", label(agent), to[0], to[1]),
        Event::Free { agent } => format!("the goal of {} is withdrawn", label(agent)),
        Event::Strays { agent, to } => format!("{} strays to ({:.1}, {:.1}) m", label(agent), to[0], to[1]),
        Event::Seen { agent } => format!("{} is seen", label(agent)),
        Event::Found { object } => format!("{} is reported as found", problem.object_label(*object)),
        Event::Replan => "a new plan is requested".into(),
    }
}

/// The words for an activity.
pub(super) fn activity(problem: &Problem, phase: Phase, source: Option<usize>) -> String {
    if phase == Phase::Staying && source.is_none() {
        return "looks around".into();
    }
    let source = source.map_or("a place", |source| problem.source_label(source));
    match phase {
        Phase::Going => format!("goes to {source}"),
        Phase::Staying => format!("stays at {source}"),
        Phase::Waiting => "waits".into(),
    }
}

/// The words for an entry of the log.
pub(super) fn of_log_entry(problem: &Problem, what: &LogEntry) -> String {
    match what {
        LogEntry::Begun { agent, phase, source } => {
            format!("{} {}", problem.agent_label(*agent), activity(problem, *phase, *source))
        }
        LogEntry::Consumed { source } => format!("{} is consumed", problem.source_label(*source)),
        LogEntry::Found { object, agent } => {
            format!("{} has found {}", problem.agent_label(*agent), problem.object_label(*object))
        }
        LogEntry::Reminded { agent } => format!("{} is reminded to send the pose", problem.agent_label(*agent)),
        LogEntry::GoalReached { agent } => {
            format!("{} has reached the goal that was told", problem.agent_label(*agent))
        }
        LogEntry::Role { role } => format!("the roles are now {}", role.name()),
        LogEntry::Handled { event } => words(problem, event),
        LogEntry::Plan(change) => change.describe("the search has stopped"),
        LogEntry::Done => "everything is done".into(),
    }
}

/// The words for an event by its name.
pub(super) fn describe(problem: &Problem, of: &Named) -> String {
    typed(problem, of).map_or_else(|_| of.event.clone(), |event| words(problem, &event))
}
