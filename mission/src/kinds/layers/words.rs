//! Texts of events and log entries of a mission of layers.

use super::execution::{Doing, Event, LogEntry};
use super::problem::Problem;

use quantities::number;

fn name(problem: &Problem, agent: usize) -> &str {
    problem.agent_label(agent).unwrap_or("somebody")
}

/// The word for what an agent does.
pub fn doing(doing: Doing) -> &'static str {
    match doing {
        Doing::Idle => "idle",
        Doing::Working => "working",
        Doing::Lost => "lost",
    }
}

/// An event in words.
pub fn of_event(event: &Event, problem: &Problem) -> String {
    let name = |agent: usize| name(problem, agent);
    match *event {
        Event::Begun { agent } => format!("{} begins", name(agent)),
        Event::Done { agent } => format!("{} is done", name(agent)),
        Event::Late { agent, by } => format!("{} is late by {} s", name(agent), number(by)),
        Event::Failed { agent } => format!("the task of {} fails", name(agent)),
        Event::Lost { agent } => format!("{} is lost", name(agent)),
        Event::Back { agent } => format!("{} is back", name(agent)),
        Event::Replan => "a new plan is requested".to_string(),
    }
}

/// Something that happened, in words.
pub fn of_log_entry(what: &LogEntry, problem: &Problem) -> String {
    let by = |agent: usize| name(problem, agent);
    let task = |task: usize| problem.task_label(task).unwrap_or("a task");
    match what {
        LogEntry::Begun { agent, task: of, object } => match object.and_then(|object| problem.object_label(object)) {
            Some(thing) => format!("{} begins {} with {}", by(*agent), task(*of), thing),
            None => format!("{} begins {}", by(*agent), task(*of)),
        },
        LogEntry::TaskLate { agent, task: of, expected } => {
            format!("{} is late with {}, expected at {} s", by(*agent), task(*of), number(*expected))
        }
        LogEntry::Ended { agent, task: of } => format!("{} has done {}", by(*agent), task(*of)),
        LogEntry::Dropped { agent, task: of } => {
            format!("{} drops {}, which is to be done again", by(*agent), task(*of))
        }
        LogEntry::LayerDone { layer } => {
            format!("layer {} is done", problem.layer_label(*layer).unwrap_or_default())
        }
        LogEntry::Handled { event } => of_event(event, problem),
        LogEntry::Plan(change) => change.describe("there is no plan for everything any more"),
        LogEntry::Done => "everything is done".to_string(),
    }
}
