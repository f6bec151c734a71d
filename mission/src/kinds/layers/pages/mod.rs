//! Web pages of a mission of layers: people report the begin, end and failure of tasks.

mod messages;
mod person;

use serde::Deserialize;
use serde_json::Value;

use crate::executed::Executed;
use crate::kind::pages::words::{clock_time, plan_status};
use crate::kind::pages::{
    ALREADY_NOTED, Activity, JournalSink, Pages, PersonContent, PersonMessage, PlanUpdate, Progress, Refusal,
    additional_time, is_current, parse,
};
use crate::kind::{Detail, Event, Execution};

use super::execution::{Doing, LayersWorld, LogEntry};
use super::problem::Problem;

/// A request of a person. Each names its task by index, so that duplicated or late requests are recognised.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(tag = "what", rename_all = "snake_case", deny_unknown_fields)]
enum PersonRequest {
    /// The task begins.
    Begin { task: usize },
    /// The task is done.
    Done { task: usize },
    /// The task failed, and is to be repeated.
    Failed {
        task: usize,
        /// Expected end (s) that the page showed: a duplicated request counts once.
        until: Option<f64>,
    },
    /// The task takes longer.
    Longer {
        task: usize,
        /// New expected end (s). A duplicated request has no further effect.
        until: f64,
    },
}

/// Layers under way with their pages.
pub(super) struct LayersPages {
    run: Executed<LayersWorld>,
}

impl LayersPages {
    pub fn new(run: Executed<LayersWorld>) -> LayersPages {
        LayersPages { run }
    }

    fn problem(&self) -> &Problem {
        self.run.execution.problem()
    }

    /// Returns true if the agent has done a task.
    fn did(&self, agent: usize, task: usize) -> bool {
        let done = LogEntry::Ended { agent, task };
        self.run.execution.records().iter().any(|record| record.what == done)
    }
}

impl Pages for LayersPages {
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
        let execution = &self.run.execution;
        let stranded = execution.stranded();
        Progress {
            done: Some(format!("{} of {} tasks done", execution.statistics().tasks, self.problem().tasks.len())),
            over: execution.done().then(|| "The mission is done: every task is done.".into()),
            stranded: stranded.map(|why| format!("There is no plan for everything any more: {why}.")),
        }
    }

    fn activity(&self, member: usize) -> Activity {
        let Some(view) = self.run.execution.agent(member) else { return Activity::default() };
        let human = self.problem().agents.get(member).is_some_and(|agent| agent.is_human());
        let task = |task: usize, object: Option<usize>| person::task(self.problem(), task, object);
        Activity {
            doing: match (view.doing, view.work, view.next) {
                (Doing::Lost, _, _) => "has left".into(),
                (_, Some(work), _) => format!("{}, until {}", task(work.task, work.object), clock_time(work.expected)),
                (_, None, Some(next)) if next.open => format!("is to begin {}", task(next.task, next.object)),
                (_, None, Some(_)) => "waits for the previous layer".into(),
                (_, None, None) => "has nothing to do".into(),
            },
            at: (!human).then_some([view.position[0], view.position[1]]),
            lost: view.doing == Doing::Lost,
            until: view.work.map(|work| work.expected),
            fails: view.work.is_some(),
        }
    }

    fn person(&self, member: usize) -> PersonContent {
        person::page(&self.run.execution, member).unwrap_or_default()
    }

    fn message(&self, entry: usize, member: usize) -> Option<PersonMessage> {
        messages::for_one(self.problem(), member, &self.run.execution.records().get(entry)?.what)
    }

    fn request(&mut self, member: usize, body: &Value, journal: &mut JournalSink<'_>) -> Result<String, Refusal> {
        let request: PersonRequest = parse(body)?;
        let (PersonRequest::Begin { task }
        | PersonRequest::Done { task }
        | PersonRequest::Failed { task, .. }
        | PersonRequest::Longer { task, .. }) = request;
        let known = self.problem().task_label(task).map(str::to_string);
        let name = known.ok_or_else(|| Refusal::Invalid(format!("there is no task with number {task}")))?;
        let view = self.run.execution.agent(member);
        let view = view.ok_or_else(|| Refusal::Invalid("there is no such member".into()))?;
        let now = clock_time(self.run.execution.time());
        let expected = view.work.map(|work| work.expected);
        let at = view.work.is_some_and(|work| work.task == task);
        let next = view.doing == Doing::Idle && view.next.is_some_and(|next| next.task == task);
        match request {
            PersonRequest::Begin { .. } if next => {
                self.happen(&Event::of("begun", member), journal)?;
                Ok(format!("Noted: {name} began at {now}."))
            }
            PersonRequest::Begin { .. } if at => Ok(format!("{name} has begun already.")),
            PersonRequest::Done { .. } if at => {
                self.happen(&Event::of("done", member), journal)?;
                Ok(format!("Noted: {name} was done at {now}."))
            }
            PersonRequest::Longer { until, .. } if at => {
                let Some(by) = additional_time(expected, until) else { return Ok(ALREADY_NOTED.into()) };
                self.happen(&Event::of("late", member).and("by", Detail::Number(by)), journal)?;
                Ok(format!("Noted: {name} takes {by:.0} s longer, until {}.", clock_time(until)))
            }
            PersonRequest::Failed { until, .. } if at => {
                if !is_current(expected, until) {
                    return Ok(ALREADY_NOTED.into());
                }
                let then = match self.happen(&Event::of("failed", member), journal)? {
                    PlanUpdate::Replanned => "There is a new plan.",
                    _ => "It is to be repeated.",
                };
                Ok(format!("Noted: {name} failed. {then}"))
            }
            PersonRequest::Begin { .. } | PersonRequest::Done { .. } if self.did(member, task) => {
                Ok(format!("{name} is done already."))
            }
            _ => Err(Refusal::NotNow("This task is not yours now: look at the page.".into())),
        }
    }
}
