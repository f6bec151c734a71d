//! What the pages show, as data: made by the engine from the execution, sent as JSON.

use std::sync::Arc;
use std::time::Duration;

use mission::kinds::schedule::execution::{AgentView, Coming, Doing, Execution, RobotView, Stage};
use mission::kinds::schedule::problem::Problem;
use mission::plan::{Actor, Phase, Plan};
use serde::Serialize;

use super::diary::Diary;
use super::words::{self, written};
use super::world::Ground;

/// Everything that pages need, at one instant.
#[derive(Clone, Debug)]
pub struct Published {
    /// Name of the mission.
    pub mission: Arc<str>,
    /// Time of the mission (s), how fast it runs, and whether it does.
    pub clock: ClockView,
    /// How long the mission is behind its clock, where it lags.
    pub behind: Option<Duration>,
    /// Why what is told cannot be written down, where that is so.
    pub unwritten: Option<String>,
    /// For each agent the page of it.
    pub people: Vec<PersonView>,
    /// The page of the supervisor.
    pub supervisor: SupervisorView,
    /// What the pictures show.
    pub plan: Arc<Plan>,
    /// What the map shows; none where there is none.
    pub ground: Option<Ground>,
}

/// The clock of a mission.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ClockView {
    /// What it shows (s).
    pub time: f64,
    /// Seconds of the mission in a second.
    pub speed: f64,
    /// True unless it stands.
    pub running: bool,
}

/// The page of one person.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PersonView {
    /// Its name.
    pub name: String,
    /// What it does now, in a sentence.
    pub doing: String,
    /// Since when (s), and until when it is planned.
    pub since: Option<f64>,
    /// See `since`.
    pub until: Option<f64>,
    /// What comes next, in a sentence.
    pub next: String,
    /// When a robot is expected (s), to count down to.
    pub comes: Option<f64>,
    /// What that robot does now.
    pub robot: Option<String>,
    /// The operation that buttons are about, from 0; of layers the index of the task.
    pub at: usize,
    /// Words over the buttons.
    pub operation: String,
    /// See `operation`; none where nobody is served.
    pub service: Option<String>,
    /// What may be told now.
    pub may: May,
    /// What the person measured.
    pub measured: Vec<Measured>,
    /// The service to ask about.
    pub ask: Option<Ask>,
    /// The plan in words.
    pub steps: Vec<Step>,
    /// What happened, the latest first.
    pub messages: Vec<Message>,
    /// What stands above all else.
    pub note: Option<String>,
}

/// Which buttons may be pressed.
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
    /// A service or a task failed.
    pub failed: bool,
    /// What goes on takes longer.
    pub longer: bool,
}

/// A time that was measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measured {
    /// Of what.
    pub name: String,
    /// How long it took (s); none while it runs.
    pub seconds: Option<f64>,
}

/// The question after a service.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Ask {
    /// Which operation was served, from 0.
    pub operation: usize,
    /// What is asked about.
    pub text: String,
}

/// A part of a person's plan.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Step {
    /// When it begins (s).
    pub at: f64,
    /// What it is.
    pub text: String,
    /// `done`, `now` or `next`.
    pub state: &'static str,
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Message {
    /// When (s).
    pub at: f64,
    /// What.
    pub text: String,
}

/// The page of the supervisor.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SupervisorView {
    /// How good the plan is.
    pub status: String,
    /// What has come of it so far.
    pub numbers: String,
    /// Why it is over, if it is.
    pub over: Option<String>,
    /// What stands above all else of one that goes on.
    pub note: Option<String>,
    /// Agents may be told to have moved to another place.
    pub moves: bool,
    /// The agents.
    pub agents: Vec<AgentRow>,
    /// The robots.
    pub robots: Vec<RobotRow>,
    /// What happened, the latest first.
    pub events: Vec<Message>,
    /// Changes when the pictures do.
    pub drawing: usize,
}

/// An agent in the table of the supervisor.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AgentRow {
    /// Its name.
    pub name: String,
    /// What it does.
    pub doing: String,
    /// Whether its page is open, in words.
    pub page: String,
    /// It has a page.
    pub paged: bool,
    /// It has left.
    pub lost: bool,
    /// What may be told of what it does.
    #[serde(flatten)]
    pub trouble: Trouble,
}

/// What may be told of somebody's operation, service or task that goes on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Trouble {
    /// When it is expected to end (s): it may take longer. None where nothing goes on.
    pub until: Option<f64>,
    /// It may fail.
    pub fails: bool,
}

/// A robot in the table of the supervisor.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RobotRow {
    /// Its name.
    pub name: String,
    /// What it does.
    pub doing: String,
    /// Where it is (m); none where there are no coordinates.
    pub at: Option<[f64; 2]>,
    /// It has broken down.
    pub lost: bool,
    /// What may be told of what it does.
    #[serde(flatten)]
    pub trouble: Trouble,
}

/// The page of an agent; that of a name alone if there is none of this index.
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

/// What comes next, when the robot is there, and what that robot does now.
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

/// The operations of an agent, each with who serves at its end.
fn steps(execution: &Execution, agent: &AgentView, index: usize) -> Vec<Step> {
    let (plan, problem) = (execution.plan(), execution.problem());
    let current = agent.operation.unwrap_or(usize::MAX);
    let step = |operation: &mission::plan::Activity| {
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
