//! Texts of events and log entries of a schedule. Operations count from 1.

use super::execution::{Doing, Event, LogEntry, Stage};
use super::plan::Actor;
use super::problem::Problem;

use quantities::number;

fn agent_name(problem: &Problem, index: usize) -> &str {
    problem.agent_label(index).unwrap_or("somebody")
}

fn robot(problem: &Problem, index: usize) -> &str {
    problem.robot_label(index).unwrap_or("a robot")
}

fn who(problem: &Problem, actor: Actor) -> &str {
    match actor {
        Actor::Agent(index) => agent_name(problem, index),
        Actor::Robot(index) => robot(problem, index),
    }
}

/// A step of feedback as the word for it, the least of the five first; none for what is right.
fn step(value: i8, words: [&'static str; 5]) -> Option<&'static str> {
    usize::try_from(value + 2).ok().filter(|_| value != 0).and_then(|i| words.get(i)).copied()
}

/// An event in words.
pub fn of_event(event: &Event, problem: &Problem) -> String {
    let name = |index: usize| agent_name(problem, index);
    match event {
        Event::Begun { agent } => format!("{} begins", name(*agent)),
        Event::Done { agent } => format!("{} is done", name(*agent)),
        Event::Late { agent, by } => format!("{} is late by {} s", name(*agent), number(*by)),
        Event::Served { agent } => format!("the service of {} ends", name(*agent)),
        Event::Failed { agent } => format!("the service of {} fails", name(*agent)),
        Event::Moved { agent, place } => {
            format!("{} moves to ({}, {}) m", name(*agent), number(place[0]), number(place[1]))
        }
        Event::Said { agent, wait, approach, distance } => {
            let wait = step(*wait, ["too short", "short", "", "long", "too long"]).map(|w| format!("the wait was {w}"));
            let speed = step(*approach, ["very fast", "fast", "", "slow", "very slow"]);
            let far = step(*distance, ["very far away", "far away", "", "close", "very close"]);
            let parts = [wait, speed.map(|w| format!("the robot came {w}")), far.map(|w| format!("it waited {w}"))];
            let said: Vec<String> = parts.into_iter().flatten().collect();
            let said = if said.is_empty() { "all was right".to_string() } else { said.join(", ") };
            format!("{} says: {said}", name(*agent))
        }
        Event::Feedback(feedback) => format!("{} says what the service was like", name(feedback.agent)),
        Event::Lost { who: lost } => format!("{} is lost", who(problem, *lost)),
        Event::Back { who: back } => format!("{} is back", who(problem, *back)),
        Event::Replan => "a new plan is requested".to_string(),
    }
}

/// Something that happened, in words.
pub fn of_log_entry(what: &LogEntry, problem: &Problem) -> String {
    let of = |index: usize, operation: usize| format!("operation {} of {}", operation + 1, agent_name(problem, index));
    let by = |index: usize| robot(problem, index);
    match what {
        LogEntry::OperationBegan { agent, operation } => format!("{} begins", of(*agent, *operation)),
        LogEntry::OperationLate { agent, operation, expected } => {
            format!("{} is late, expected at {} s", of(*agent, *operation), number(*expected))
        }
        LogEntry::OperationEnded { agent, operation } => format!("{} ends", of(*agent, *operation)),
        LogEntry::Left { robot, agent, operation } => format!("{} leaves for {}", by(*robot), of(*agent, *operation)),
        LogEntry::Waits { robot, agent, .. } => {
            format!("{} is at the waiting place of {}", by(*robot), agent_name(problem, *agent))
        }
        LogEntry::Approaches { robot, agent, .. } => {
            format!("{} approaches {}", by(*robot), agent_name(problem, *agent))
        }
        LogEntry::Serves { robot, agent, .. } => format!("{} serves {}", by(*robot), agent_name(problem, *agent)),
        LogEntry::Served { robot, agent, operation } => {
            format!("{} has served {}", by(*robot), of(*agent, *operation))
        }
        LogEntry::Home { robot } => format!("{} is at its depot, and ready", by(*robot)),
        LogEntry::RobotLate { robot, agent, expected, .. } => {
            format!("{} is late, expected with {} at {} s", by(*robot), agent_name(problem, *agent), number(*expected))
        }
        LogEntry::HeldUp { robot, agent, by: lost } => {
            let to = agent.map_or_else(|| "home".to_string(), |agent| format!("to {}", agent_name(problem, agent)));
            format!("{} has stopped on its way {to}: {}, which is out of order, blocks it", by(*robot), by(*lost))
        }
        LogEntry::BrokenOff { robot, agent, operation } => {
            format!("{} breaks off the service of {}", by(*robot), of(*agent, *operation))
        }
        LogEntry::Handled { event } => of_event(event, problem),
        LogEntry::Plan(change) => change.describe("there is no plan any more"),
        LogEntry::Done => "everything is done".to_string(),
    }
}

/// The word for what a robot does.
pub fn stage(stage: Stage) -> &'static str {
    match stage {
        Stage::Home => "home",
        Stage::Going => "going",
        Stage::Waiting => "waiting",
        Stage::Approaching => "approaching",
        Stage::Serving => "serving",
        Stage::Returning => "returning",
        Stage::Unloading => "unloading",
        Stage::Recalled => "recalled",
        Stage::Lost => "lost",
    }
}

/// The word for what an agent does.
pub fn doing(doing: Doing) -> &'static str {
    match doing {
        Doing::Ready => "ready",
        Doing::Working => "working",
        Doing::Waiting => "waiting",
        Doing::Served => "served",
        Doing::Finished => "finished",
        Doing::Lost => "lost",
    }
}
