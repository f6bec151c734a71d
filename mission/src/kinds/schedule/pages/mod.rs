//! Web pages of a schedule: people report the begin and end of operations, and give feedback on services.

mod history;
mod messages;
mod person;
mod request;

use serde_json::Value;

use crate::executed::Executed;
use crate::kind::pages::words::{clock_time, plan_status};
use crate::kind::pages::{
    ALREADY_NOTED, Activity, JournalSink, Pages, PersonContent, PersonMessage, PlanUpdate, Progress, Refusal,
    additional_time, is_current, parse,
};
use crate::kind::{Event, Execution};

use super::event::{self, member};
use super::execution::{AgentView, Doing, RobotView, ScheduleWorld, Stage};
use super::plan::Actor;
use super::problem::{Distances, Problem};

use self::history::History;
use self::request::{PersonRequest, feedback};

/// A schedule under way with its pages.
pub(super) struct SchedulePages {
    run: Executed<ScheduleWorld>,
    /// By agent.
    histories: Vec<History>,
}

impl SchedulePages {
    pub fn new(run: Executed<ScheduleWorld>) -> SchedulePages {
        let histories = run.execution.problem().agents.iter().map(|agent| History::new(agent.kind)).collect();
        SchedulePages { run, histories }
    }

    fn problem(&self) -> &Problem {
        self.run.execution.problem()
    }

    /// Returns the expected end of an agent's current activity: `, until 3:07`.
    fn until(&self, agent: usize) -> String {
        let until = self.run.execution.agent(agent).and_then(|view| view.until);
        until.map_or_else(String::new, |until| format!(", until {}", clock_time(until)))
    }

    fn work(&mut self, agent: usize, request: PersonRequest, journal: &mut JournalSink<'_>) -> Result<String, Refusal> {
        let view = self.run.execution.agent(agent).ok_or_else(|| Refusal::Invalid("there is no such agent".into()))?;
        let (doing, time) = (view.doing, self.run.execution.time());
        let (now, of) = (clock_time(time), member(self.problem(), Actor::Agent(agent)));
        let is = |operation: usize| view.operation == Some(operation);
        let past = |operation: usize| view.operation.is_none_or(|current| operation < current);
        match request {
            PersonRequest::Begin { operation } if is(operation) && doing == Doing::Ready => {
                self.happen(&Event::of("begun", of), journal)?;
                Ok(format!("Noted: operation {} began at {now}.", operation + 1))
            }
            PersonRequest::Begin { operation } if is(operation) || past(operation) => {
                Ok(format!("Operation {} has begun already.", operation + 1))
            }
            PersonRequest::Done { operation } if is(operation) && doing == Doing::Working => {
                self.happen(&Event::of("done", of), journal)?;
                Ok(format!("Noted: operation {} ended at {now}.", operation + 1))
            }
            PersonRequest::Done { operation } if past(operation) || (is(operation) && doing != Doing::Ready) => {
                Ok(format!("Operation {} is finished already.", operation + 1))
            }
            PersonRequest::Serve { operation } if is(operation) && doing == Doing::Served => {
                if !self.histories[agent].measures() {
                    journal.record()?;
                    self.histories[agent].begin_measurement(operation, time);
                }
                Ok(format!("Noted: the service began at {now}."))
            }
            PersonRequest::Served { operation } => {
                let took = if self.histories[agent].measures() {
                    journal.record()?;
                    self.histories[agent].end_measurement(time)
                } else {
                    None
                };
                let measured = took.map(|took| format!(" You measured {took:.0} s.")).unwrap_or_default();
                if is(operation) && doing == Doing::Served {
                    self.happen(&Event::of("served", of), journal)?;
                    Ok(format!("Noted: the service of operation {} is finished.{measured}", operation + 1))
                } else if took.is_some() || past(operation) {
                    Ok(format!("The service is finished.{measured}"))
                } else {
                    Err(not_served())
                }
            }
            PersonRequest::Failed { operation, until } if is(operation) && doing == Doing::Served => {
                if !is_current(view.until, until) {
                    return Ok(ALREADY_NOTED.into());
                }
                self.happen(&Event::of("failed", of), journal)?;
                Ok(format!("Noted: the service failed and is repeated{}.", self.until(agent)))
            }
            PersonRequest::Longer { operation, until }
                if is(operation) && matches!(doing, Doing::Working | Doing::Served) =>
            {
                let Some(by) = additional_time(view.until, until) else { return Ok(ALREADY_NOTED.into()) };
                self.happen(&request::late(of, by), journal)?;
                let what = if doing == Doing::Served { "the service" } else { "the operation" };
                Ok(format!("Noted: {what} takes {by:.0} s longer{}.", self.until(agent)))
            }
            PersonRequest::Serve { .. } | PersonRequest::Failed { .. } => Err(not_served()),
            PersonRequest::Longer { .. } => Err(Refusal::NotNow("There is no current activity.".into())),
            PersonRequest::Feedback { operation, wait, approach, distance } => {
                match self.histories[agent].feedback_on() {
                    Some((last, false)) if last == operation => {
                        let then = match self.happen(&feedback(of, [wait, approach, distance]), journal)? {
                            PlanUpdate::Replanned => "There is a new plan.",
                            PlanUpdate::Rescheduled => "The plan has been adapted.",
                            PlanUpdate::Unchanged => "It counts from now on.",
                        };
                        Ok(format!("Thank you. {then}"))
                    }
                    Some((last, _)) if operation <= last => {
                        Ok("Thank you. This was noted before, or is about an earlier service.".into())
                    }
                    _ => Err(Refusal::NotNow("This service has not taken place.".into())),
                }
            }
            PersonRequest::Begin { operation } | PersonRequest::Done { operation } => {
                Err(Refusal::NotNow(format!("Operation {} is not under way.", operation + 1)))
            }
        }
    }
}

fn not_served() -> Refusal {
    Refusal::NotNow("No robot serves you now.".into())
}

impl Pages for SchedulePages {
    fn execution(&self) -> &dyn Execution {
        &self.run
    }

    fn execution_mut(&mut self) -> &mut dyn Execution {
        &mut self.run
    }

    fn plan_status(&self) -> String {
        plan_status(self.run.execution.plan())
    }

    fn progress(&self) -> Progress {
        let stranded = self.run.execution.stranded().map(|why| format!("There is no plan any more: {why}."));
        let over = match self.run.execution.done() {
            true => Some("The mission is done: all possible services are finished.".into()),
            // Robots are at their depots, and none leaves.
            false => stranded.clone(),
        };
        Progress { done: None, over, stranded }
    }

    fn activity(&self, member: usize) -> Activity {
        let execution = &self.run.execution;
        match event::actor(self.problem(), member) {
            Some(Actor::Robot(robot)) => execution.robot(robot).map(|view| {
                let serves = view.stage == Stage::Serving;
                Activity {
                    doing: robot_activity(self.problem(), &view),
                    at: (self.problem().distances == Distances::Straight).then_some(view.position),
                    lost: view.stage == Stage::Lost,
                    until: view.until.filter(|_| serves),
                    fails: serves,
                }
            }),
            // The service of an agent is reported at the robot.
            Some(Actor::Agent(agent)) => execution.agent(agent).map(|view| Activity {
                doing: agent_activity(&view),
                at: None,
                lost: view.doing == Doing::Lost,
                until: view.until.filter(|_| view.doing == Doing::Working),
                fails: false,
            }),
            None => None,
        }
        .unwrap_or_default()
    }

    fn person(&self, member: usize) -> PersonContent {
        let agent = event::agent(self.problem(), member);
        let page = agent.and_then(|agent| person::page(&self.run.execution, self.histories.get(agent)?, agent));
        page.unwrap_or_default()
    }

    fn message(&self, entry: usize, member: usize) -> Option<PersonMessage> {
        messages::for_one(
            self.problem(),
            event::agent(self.problem(), member)?,
            &self.run.execution.records().get(entry)?.what,
        )
    }

    fn observe(&mut self, entry: usize) {
        if let Some(record) = self.run.execution.records().get(entry) {
            history::observe(&mut self.histories, record);
        }
    }

    fn request(&mut self, member: usize, body: &Value, journal: &mut JournalSink<'_>) -> Result<String, Refusal> {
        let request: PersonRequest = parse(body)?;
        let agent =
            event::agent(self.problem(), member).ok_or_else(|| Refusal::Invalid("this member is not served".into()))?;
        request.check(self.problem().agents[agent].operations)?;
        self.work(agent, request, journal)
    }

    fn accepts_stopped(&self, body: &Value) -> bool {
        matches!(parse(body), Ok(PersonRequest::Feedback { .. }))
    }
}

fn robot_activity(problem: &Problem, robot: &RobotView) -> String {
    let whom = robot.target.and_then(|target| problem.agent_label(target.agent)).unwrap_or("?");
    match robot.stage {
        Stage::Home => {
            robot.until.map_or("at its depot".into(), |until| format!("at its depot until {}", clock_time(until)))
        }
        Stage::Going => format!("goes to {whom}"),
        Stage::Waiting => format!("waits near {whom}"),
        Stage::Approaching => format!("approaches {whom}"),
        Stage::Serving => format!("serves {whom}"),
        Stage::Returning => "returns to its depot".into(),
        Stage::Unloading => "at its depot, unloading".into(),
        Stage::Recalled => "returns to its depot, its service was aborted".into(),
        Stage::Lost => "broken down".into(),
    }
}

fn agent_activity(agent: &AgentView) -> String {
    let number = agent.operation.map_or(0, |operation| operation + 1);
    match agent.doing {
        Doing::Ready => format!("before operation {number}"),
        Doing::Working => agent.until.map_or_else(
            || format!("operation {number}"),
            |until| format!("operation {number}, until {}", clock_time(until)),
        ),
        Doing::Waiting => format!("waits after operation {number}"),
        Doing::Served => "is served".into(),
        Doing::Finished => "finished".into(),
        Doing::Lost => "left".into(),
    }
}
