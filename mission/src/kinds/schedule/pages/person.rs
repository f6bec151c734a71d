//! The page of a person of a schedule.

use serde_json::json;

use crate::kind::pages::words::clock_time;
use crate::kind::pages::{Button, ButtonGroup, PersonContent, Step};
use crate::kinds::schedule::execution::{AgentView, Coming, Doing, RobotView, ScheduleExecution, Stage};
use crate::kinds::schedule::plan::{Activity, Actor, Phase};

use super::history::History;

/// Returns the page of an agent; `None` if the index is out of range.
pub(super) fn page(execution: &ScheduleExecution, history: &History, index: usize) -> Option<PersonContent> {
    let (problem, agent) = (execution.problem(), execution.agent(index)?);
    let total = problem.agents.get(index)?.operations;
    let (next, countdown, detail) = next(execution, &agent, index);
    Some(PersonContent {
        doing: doing(execution, &agent, index, total),
        since: matches!(agent.doing, Doing::Working | Doing::Waiting | Doing::Served).then_some(agent.since),
        until: agent.until.filter(|_| matches!(agent.doing, Doing::Working | Doing::Served)),
        next,
        countdown,
        detail,
        groups: groups(execution, history, &agent, total),
        measured: history.measured(),
        form: history.form(problem),
        steps: steps(execution, &agent, index),
        map: None,
        reminder: None,
    })
}

/// The number of an agent's current operation, from 1; that after the last one if it has none.
fn number(agent: &AgentView, total: usize) -> usize {
    agent.operation.map_or(total, |operation| operation + 1)
}

fn groups(execution: &ScheduleExecution, history: &History, agent: &AgentView, total: usize) -> Vec<ButtonGroup> {
    let number = number(agent, total).min(total);
    let over = execution.done() || execution.stranded().is_some();
    let (works, serving) = (agent.doing == Doing::Working, agent.doing == Doing::Served);
    let ready = agent.doing == Doing::Ready && agent.operation.is_some() && !over;
    let operation = agent.operation.unwrap_or(total.saturating_sub(1));
    let request = |what: &str| json!({ "what": what, "operation": operation });
    let longer = |by: f64| {
        let until = agent.until.map_or(serde_json::Value::Null, |until| (until + by).into());
        json!({ "what": "longer", "operation": operation, "until": until })
    };
    let goes_on = serving || works;
    vec![
        ButtonGroup {
            heading: match agent.doing {
                Doing::Lost => "Operation".into(),
                _ => format!("Operation {number} of {total}"),
            },
            buttons: vec![
                Button::main("begin", "Start", ready, request("begin")),
                Button::main("done", "Finish", works, request("done")),
            ],
        },
        ButtonGroup {
            heading: format!(
                "Service of operation {}",
                history.measured_operation().unwrap_or(number.saturating_sub(1)) + 1
            ),
            buttons: vec![
                Button::main("serve", "Start", serving && !history.measures(), request("serve")),
                Button::main("served", "Finish", serving || history.measures(), request("served")),
            ],
        },
        ButtonGroup {
            heading: "Problems".into(),
            buttons: vec![
                Button::new("longer", "30 s longer", goes_on, longer(30.0)),
                Button::new("much", "2 min longer", goes_on, longer(120.0)),
                Button::new(
                    "failed",
                    "The service failed",
                    serving,
                    json!({ "what": "failed", "operation": operation, "until": agent.until }),
                ),
            ],
        },
    ]
}

fn doing(on: &ScheduleExecution, agent: &AgentView, index: usize, total: usize) -> String {
    let (problem, number) = (on.problem(), number(agent, total));
    let serves = || {
        let at = (0..problem.robots.len()).find(|m| {
            let view = on.robot(*m);
            view.is_some_and(|r| r.stage == Stage::Serving && r.target.is_some_and(|t| t.agent == index))
        });
        at.and_then(|m| problem.robot_label(m)).unwrap_or("A robot")
    };
    match agent.doing {
        Doing::Ready => match agent.until {
            Some(start) => format!("Operation {number} of {total} begins at {}.", clock_time(start)),
            None => format!("Operation {number} of {total} is next."),
        },
        Doing::Working => format!("You work on operation {number} of {total}."),
        Doing::Waiting => format!("Operation {number} is finished. You wait for a robot."),
        Doing::Served => format!("{} serves you.", serves()),
        Doing::Finished => "All your operations are served.".into(),
        Doing::Lost => "You have left the mission.".into(),
    }
}

/// Returns the next activity, the arrival of the robot (s), and the robot's current activity.
fn next(execution: &ScheduleExecution, agent: &AgentView, index: usize) -> (String, Option<f64>, Option<String>) {
    let problem = execution.problem();
    match (&agent.coming, agent.doing) {
        (Some(coming), _) if execution.stranded().is_none() => {
            let name = problem.robot_label(coming.robot).unwrap_or("?");
            let text = format!("{name} comes to you at {}.", clock_time(coming.serves));
            (text, Some(coming.serves), execution.robot(coming.robot).map(|robot| way(name, coming, &robot, index)))
        }
        (_, Doing::Served) => ("Your next operation begins afterwards.".to_string(), agent.until, None),
        (_, Doing::Finished) => ("Nothing more is planned for you.".into(), None, None),
        _ => ("No robot is planned to come.".into(), None, None),
    }
}

fn way(name: &str, coming: &Coming, robot: &RobotView, index: usize) -> String {
    let mine = robot.target.is_some_and(|target| target.agent == index && target.operation == coming.operation);
    match robot.stage {
        Stage::Going if mine => {
            let until = robot.until.map(|until| format!(" and arrives near you at {}", clock_time(until)));
            format!("{name} is on its way{}.", until.unwrap_or_default())
        }
        Stage::Waiting if mine => {
            format!("{name} waits near you and approaches you at {}.", clock_time(coming.approaches))
        }
        Stage::Approaching if mine => format!("{name} approaches you now."),
        Stage::Home => robot.until.map_or_else(
            || format!("{name} is at its depot."),
            |leaves| format!("{name} is at its depot and leaves at {}.", clock_time(leaves)),
        ),
        Stage::Lost => format!("{name} has broken down."),
        _ => format!("{name} has another job first."),
    }
}

/// Returns the operations of an agent, each with the serving robot.
fn steps(execution: &ScheduleExecution, agent: &AgentView, index: usize) -> Vec<Step> {
    let (plan, problem) = (execution.plan(), execution.problem());
    let current = agent.operation.unwrap_or(usize::MAX);
    let step = |operation: &Activity| {
        let serving = plan.activities.iter().find(|a| a.phase == Phase::Serving && a.target == operation.target);
        let by = serving.and_then(|a| match a.actor {
            Actor::Robot(robot) => Some((problem.robot_label(robot).unwrap_or("?"), a.start)),
            Actor::Agent(_) => None,
        });
        let state = match operation.target.operation.cmp(&current) {
            std::cmp::Ordering::Less => "done",
            std::cmp::Ordering::Equal if agent.doing != Doing::Ready => "now",
            _ => "next",
        };
        let number = operation.target.operation + 1;
        let text = match by {
            Some((robot, at)) if state == "done" => {
                format!("Operation {number}, served by {robot} at {}", clock_time(at))
            }
            Some((robot, at)) if execution.stranded().is_none() => {
                format!("Operation {number}; {robot} serves at {}", clock_time(at))
            }
            _ => format!("Operation {number}"),
        };
        Step { at: operation.start, text, state }
    };
    let own = plan.activities.iter().filter(|of| of.actor == Actor::Agent(index) && of.phase == Phase::Operation);
    own.map(step).collect()
}
