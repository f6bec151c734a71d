//! Contents of the pages as data: created by the engine from the execution, sent as JSON.

pub mod diary;
pub mod messages;

use std::sync::Arc;
use std::time::Duration;

use mission::chart::Chart;
use mission::kinds::schedule::execution::{AgentView, Coming, Doing, Execution, RobotView, Stage};
use mission::kinds::schedule::plan::{Activity, Actor, Phase};
use mission::kinds::schedule::problem::Problem;
use serde::Serialize;

use self::diary::Diary;
use super::words::{self, written};
use mission::map::Map;

/// State of the mission for pages, at one instant.
#[derive(Clone, Debug)]
pub struct Published {
    /// Name of the mission.
    pub mission: Arc<str>,
    /// The clock.
    pub clock: ClockView,
    /// Delay of the mission behind its clock, if it lags.
    pub behind: Option<Duration>,
    /// Reason why the journal cannot be written, if so.
    pub unwritten: Option<String>,
    /// Pages of the agents, by index.
    pub people: Vec<PersonView>,
    /// The page of the supervisor.
    pub supervisor: SupervisorView,
    /// The chart of the plan.
    pub plan: Arc<Chart>,
    /// The map; `None` if there is none.
    pub map: Option<Arc<Map>>,
}

/// The clock of a mission.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ClockView {
    /// Mission time (s).
    pub time: f64,
    /// Mission seconds per real second.
    pub speed: f64,
    /// True if it runs.
    pub running: bool,
}

/// The page of one person.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PersonView {
    /// Name of the person.
    pub name: String,
    /// Current activity, as a sentence.
    pub doing: String,
    /// Start of the current activity (s).
    pub since: Option<f64>,
    /// Planned end of the current activity (s).
    pub until: Option<f64>,
    /// Next activity, as a sentence.
    pub next: String,
    /// Expected arrival of a robot (s), for a countdown.
    pub comes: Option<f64>,
    /// Current activity of that robot.
    pub robot: Option<String>,
    /// Number of the operation to which buttons refer, from 0; in a mission of layers the index of the task.
    pub at: usize,
    /// Heading of the operation's buttons.
    pub operation: String,
    /// Heading of the service's buttons; `None` if the agent is not served.
    pub service: Option<String>,
    /// Reports that are possible now.
    pub may: May,
    /// Measurements of the person.
    pub measured: Vec<Measured>,
    /// The service that the page asks about.
    pub ask: Option<Ask>,
    /// The steps of the plan.
    pub steps: Vec<Step>,
    /// Messages, the latest first.
    pub messages: Vec<Message>,
    /// Notice above all other content.
    pub note: Option<String>,
}

/// Enabled buttons.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct May {
    /// Start of an operation.
    pub begin: bool,
    /// Finish of an operation.
    pub done: bool,
    /// Start of a service.
    pub serve: bool,
    /// Finish of a service.
    pub served: bool,
    /// Failure of a service or a task.
    pub failed: bool,
    /// Delay of the current activity.
    pub longer: bool,
}

/// A measured duration.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measured {
    /// Name of the measured activity.
    pub name: String,
    /// Duration (s); `None` while it runs.
    pub seconds: Option<f64>,
}

/// The question after a service.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Ask {
    /// Number of the operation that was served, from 0.
    pub operation: usize,
    /// Text of the question.
    pub text: String,
}

/// A step of a person's plan.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Step {
    /// Start (s).
    pub at: f64,
    /// Description.
    pub text: String,
    /// `done`, `now` or `next`.
    pub state: &'static str,
}

/// A message about an event.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Message {
    /// Time (s).
    pub at: f64,
    /// Text.
    pub text: String,
}

/// The page of the supervisor.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SupervisorView {
    /// Status of the plan in words.
    pub status: String,
    /// Results so far.
    pub numbers: String,
    /// Reason why the mission is over, if it is.
    pub over: Option<String>,
    /// Notice above all other content of a running mission.
    pub note: Option<String>,
    /// True if agents can be reported at another position.
    pub moves: bool,
    /// The agents.
    pub agents: Vec<AgentRow>,
    /// The robots.
    pub robots: Vec<RobotRow>,
    /// Events, the latest first.
    pub events: Vec<Message>,
    /// Changes whenever the charts do.
    pub drawing: usize,
}

/// An agent in the supervisor's table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AgentRow {
    /// Name of the agent.
    pub name: String,
    /// Current activity.
    pub doing: String,
    /// State of its page, in words.
    pub page: String,
    /// True if it has a page.
    pub paged: bool,
    /// True if it has left.
    pub lost: bool,
    /// Possible reports about its activity.
    #[serde(flatten)]
    pub trouble: Trouble,
}

/// Possible reports about a member's current operation, service or task.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Trouble {
    /// Expected end (s), which a report may delay. `None` without a current activity.
    pub until: Option<f64>,
    /// True if it may fail.
    pub fails: bool,
}

/// A robot in the supervisor's table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RobotRow {
    /// Name of the robot.
    pub name: String,
    /// Current activity.
    pub doing: String,
    /// Position (m); `None` without coordinates.
    pub at: Option<[f64; 2]>,
    /// True if it has broken down.
    pub lost: bool,
    /// Possible reports about its activity.
    #[serde(flatten)]
    pub trouble: Trouble,
}

/// Returns the page of an agent; a page with only a name if the index is out of range.
pub fn person(execution: &Execution, diary: &Diary, index: usize, running: bool) -> PersonView {
    let problem = execution.problem();
    let name = words::agent(problem, index).to_string();
    let Some(agent) = execution.agent(index) else { return nothing(name) };
    let total = problem.agents.get(index).map_or(0, |who| who.operations);
    let number = agent.operation.map_or(total, |operation| operation + 1);
    let page = diary.page(index);
    let over = execution.done() || execution.stranded().is_some();
    let (next, comes, robot) = next(execution, &agent, index);
    let serving = agent.doing == Doing::Served;
    let may = May {
        begin: agent.doing == Doing::Ready && agent.operation.is_some() && !over,
        done: agent.doing == Doing::Working,
        serve: serving && !page.measures(),
        served: serving || page.measures(),
        failed: serving,
        longer: serving || agent.doing == Doing::Working,
    };
    let may = if running { may } else { May::default() };
    PersonView {
        doing: doing(problem, &agent, index, number, total, execution),
        since: matches!(agent.doing, Doing::Working | Doing::Waiting | Doing::Served).then_some(agent.since),
        until: agent.until.filter(|_| matches!(agent.doing, Doing::Working | Doing::Served)),
        next,
        comes,
        robot,
        at: agent.operation.unwrap_or(total),
        operation: match agent.doing {
            Doing::Lost => "Operation".into(),
            _ => format!("Operation {} of {total}", number.min(total)),
        },
        service: Some(format!(
            "Service of operation {}",
            page.measured_operation().unwrap_or(number.min(total).max(1) - 1) + 1
        )),
        may,
        measured: page.measured(),
        ask: page.ask(problem),
        steps: steps(execution, &agent, index),
        messages: page.messages(),
        note: note(execution, &agent, running),
        name,
    }
}

fn nothing(name: String) -> PersonView {
    PersonView {
        name,
        doing: "You have no part in this mission.".into(),
        since: None,
        until: None,
        next: "Nothing comes.".into(),
        comes: None,
        robot: None,
        at: 0,
        operation: "Operation".into(),
        service: Some("Service".into()),
        may: May::default(),
        measured: Vec::new(),
        ask: None,
        steps: Vec::new(),
        messages: Vec::new(),
        note: None,
    }
}

fn note(execution: &Execution, agent: &AgentView, running: bool) -> Option<String> {
    match () {
        () if execution.done() => Some("The mission is done. Thank you.".into()),
        () if execution.stranded().is_some() => {
            execution.stranded().map(|why| format!("There is no plan any more: {why}. Ask the supervisor."))
        }
        () if agent.doing == Doing::Lost => {
            Some("The supervisor has noted that you left. If you are back, tell the supervisor.".into())
        }
        () if !running => Some("The clock of the mission stands. The supervisor lets it run.".into()),
        () => None,
    }
}

fn doing(problem: &Problem, agent: &AgentView, index: usize, number: usize, total: usize, on: &Execution) -> String {
    let serves = || {
        let at = (0..problem.robots.len()).find(|m| {
            let view = on.robot(*m);
            view.is_some_and(|r| r.stage == Stage::Serving && r.target.is_some_and(|t| t.agent == index))
        });
        at.map_or("A robot", |m| words::robot(problem, m))
    };
    match agent.doing {
        Doing::Ready => match agent.until {
            Some(start) => format!("Operation {number} of {total} begins at {}.", written(start)),
            None => format!("Operation {number} of {total} comes next."),
        },
        Doing::Working => format!("You work on operation {number} of {total}."),
        Doing::Waiting => format!("Operation {number} is finished. You wait for a robot."),
        Doing::Served => format!("{} serves you.", serves()),
        Doing::Finished => "All your operations are served.".into(),
        Doing::Lost => "You have left the mission.".into(),
    }
}

/// Returns the next activity, the arrival of the robot, and the robot's current activity.
fn next(execution: &Execution, agent: &AgentView, index: usize) -> (String, Option<f64>, Option<String>) {
    let problem = execution.problem();
    match (&agent.coming, agent.doing) {
        (Some(coming), _) if execution.stranded().is_none() => {
            let name = words::robot(problem, coming.robot);
            let text = format!("{name} comes to you at {}.", written(coming.serves));
            (text, Some(coming.serves), execution.robot(coming.robot).map(|robot| way(problem, coming, &robot, index)))
        }
        (_, Doing::Served) => ("Then your next operation begins.".to_string(), agent.until, None),
        (_, Doing::Finished) => ("Nothing more is planned for you.".into(), None, None),
        _ => ("No robot is planned to come.".into(), None, None),
    }
}

fn way(problem: &Problem, coming: &Coming, robot: &RobotView, index: usize) -> String {
    let name = words::robot(problem, coming.robot);
    let mine = robot.target.is_some_and(|target| target.agent == index && target.operation == coming.operation);
    match robot.stage {
        Stage::Going if mine => {
            let until = robot.until.map(|until| format!(", and is near you at {}", written(until))).unwrap_or_default();
            format!("{name} is on its way{until}.")
        }
        Stage::Waiting if mine => format!("{name} waits near you and comes up at {}.", written(coming.approaches)),
        Stage::Approaching if mine => format!("{name} comes up to you now."),
        Stage::Home => robot.until.map_or_else(
            || format!("{name} is at its depot."),
            |leaves| format!("{name} is at its depot, and leaves at {}.", written(leaves)),
        ),
        Stage::Lost => format!("{name} has broken down."),
        _ => format!("{name} has something else to do before."),
    }
}

/// Returns the operations of an agent, each with the serving robot.
fn steps(execution: &Execution, agent: &AgentView, index: usize) -> Vec<Step> {
    let (plan, problem) = (execution.plan(), execution.problem());
    let current = agent.operation.unwrap_or(usize::MAX);
    let step = |operation: &Activity| {
        let serving = plan.activities.iter().find(|a| a.phase == Phase::Serving && a.target == operation.target);
        let by = serving.and_then(|a| match a.actor {
            Actor::Robot(robot) => Some((words::robot(problem, robot), a.start)),
            Actor::Agent(_) => None,
        });
        let state = match operation.target.operation.cmp(&current) {
            std::cmp::Ordering::Less => "done",
            std::cmp::Ordering::Equal if agent.doing != Doing::Ready => "now",
            _ => "next",
        };
        let number = operation.target.operation + 1;
        let text = match by {
            Some((robot, at)) if state == "done" => format!("Operation {number}, served by {robot} at {}", written(at)),
            Some((robot, at)) if execution.stranded().is_none() => {
                format!("Operation {number}; {robot} serves at {}", written(at))
            }
            _ => format!("Operation {number}"),
        };
        Step { at: operation.start, text, state }
    };
    plan.of(Actor::Agent(index)).filter(|activity| activity.phase == Phase::Operation).map(step).collect()
}
