//! A mission of layers for the engine: people report the begin, end and failure of tasks.
//!
//! Pages number robots and people separately, as plans do; the execution numbers them together.

mod view;

use std::sync::Arc;

use mission::execution::PlanChange;
use mission::kinds::layers::chart::chart;
use mission::kinds::layers::execution::{AgentView, Doing, Event, EventError, Happening, LayeredExecution};
use mission::kinds::layers::map::map;
use mission::kinds::layers::problem::Problem;
use mission::kinds::layers::words::of_happening as of_layered_happening;

use self::view::{for_one, person, supervisor};
use super::engine::Answer;
use super::engine::world::{Note, Shown, World};
use super::journal::Entry;
use super::schedule::{Followed, TOLD_BEFORE, said};
use super::told::{PersonTells, SupervisorTells, longer, still};
use super::view::Message;
use super::view::messages::Messages;
use super::words::written;

/// Maximum number of messages of one person's page.
const MESSAGES: usize = 12;
/// Maximum number of events of the supervisor's page.
const EVENTS: usize = 80;

/// A running mission of layers, with the history for its pages.
pub struct Layered {
    execution: LayeredExecution,
    /// Messages by person, the latest first.
    messages: Vec<Messages<Happening>>,
    /// Events of all, the latest first.
    events: Messages<Happening>,
    /// Number of records that the history contains.
    noted: usize,
}

/// Returns the people of a mission, as indices of the execution.
pub fn people(problem: &Problem) -> Vec<usize> {
    (0..problem.agents.len()).filter(|agent| problem.agents[*agent].is_human()).collect()
}

/// Returns the robots of a mission, as indices of the execution.
pub fn robots(problem: &Problem) -> Vec<usize> {
    (0..problem.agents.len()).filter(|agent| !problem.agents[*agent].is_human()).collect()
}

impl Layered {
    /// Creates the mission at the start of an execution.
    pub fn new(execution: LayeredExecution) -> Layered {
        let messages = people(execution.problem()).iter().map(|_| Messages::new(MESSAGES)).collect();
        Layered { execution, messages, events: Messages::new(EVENTS), noted: 0 }
    }

    fn remember(&mut self) {
        let problem = self.execution.problem();
        for record in self.execution.records().iter().skip(self.noted) {
            let message = |text: String| Message { at: record.time, text };
            self.events.add(&record.what, false, message(of_layered_happening(&record.what, problem)));
            let outdates =
                matches!(record.what, Happening::Plan(PlanChange::Reallocated { .. }) | Happening::TaskLate { .. });
            for (agent, messages) in people(problem).into_iter().zip(&mut self.messages) {
                if let Some(text) = for_one(problem, agent, record) {
                    messages.add(&record.what, outdates, message(text));
                }
            }
        }
        self.noted = self.execution.records().len();
    }

    /// Records an event and applies it. Returns the change of the plan.
    fn happen(&mut self, event: Event, note: &mut Note<'_>) -> Result<Followed, String> {
        note(Entry::Layered(event))?;
        let followed = self.execution.tell(event).map(|records| Followed {
            anew: records.iter().any(|record| matches!(record.what, Happening::Plan(PlanChange::Reallocated { .. }))),
            moved: records.iter().any(|record| matches!(record.what, Happening::Plan(PlanChange::Rescheduled { .. }))),
        });
        self.remember();
        followed.map_err(|refused| format!("That cannot be now: {refused}."))
    }

    fn task(&self, task: usize) -> String {
        self.execution.problem().task_label(task).unwrap_or_default().to_string()
    }

    /// Returns the expected end of an agent's task (s).
    fn expected(&self, agent: usize) -> Option<f64> {
        self.execution.agent(agent)?.work.map(|work| work.expected)
    }

    /// Returns true if the agent has done a task.
    fn did(&self, agent: usize, task: usize) -> bool {
        let done = Happening::Ended { agent, task };
        self.execution.records().iter().any(|record| record.what == done)
    }
}

impl World for Layered {
    fn time(&self) -> f64 {
        self.execution.time()
    }

    fn records(&self) -> usize {
        self.execution.records().len()
    }

    fn advance(&mut self, to: f64) {
        self.execution.advance(to);
        self.remember();
    }

    fn replay(&mut self, entry: &Entry) -> Result<(), String> {
        match entry {
            Entry::Layered(event) => {
                if let Some(agent) = event.agent().filter(|agent| self.execution.agent(*agent).is_none()) {
                    return Err(EventError::NoAgent { agent }.to_string());
                }
                let _ = self.execution.tell(*event);
                self.remember();
                Ok(())
            }
            Entry::Records(_) => Ok(()),
            Entry::Event(_) | Entry::Serve { .. } | Entry::Served { .. } => Err("it is of a schedule".into()),
        }
    }

    fn shown(&self, running: bool) -> Shown {
        let execution = &self.execution;
        let pages = people(execution.problem()).into_iter().zip(&self.messages);
        Shown {
            people: pages.map(|(agent, messages)| person(execution, agent, messages.shown(), running)).collect(),
            supervisor: supervisor(execution, self.events.shown()),
            plan: Arc::new(chart(execution.problem(), execution.plan())),
            map: Some(Arc::new(map(self.execution.problem(), self.execution.plan()))),
        }
    }

    fn person(&mut self, person: usize, tells: PersonTells, note: &mut Note<'_>) -> Answer {
        let agent = people(self.execution.problem()).get(person).copied().ok_or("There is no such person.")?;
        let view: AgentView = self.execution.agent(agent).ok_or("There is no such person.")?;
        let now = written(self.execution.time());
        let at = |task: usize| view.work.is_some_and(|work| work.task == task);
        let next = |task: usize| view.doing == Doing::Idle && view.next.is_some_and(|next| next.task == task);
        match tells {
            PersonTells::Begin { operation: task } if next(task) => {
                self.happen(Event::Began { agent }, note)?;
                Ok(format!("Noted: {} began at {now}.", self.task(task)))
            }
            PersonTells::Begin { operation: task } if at(task) => Ok(format!("{} has begun already.", self.task(task))),
            PersonTells::Done { operation: task } if at(task) => {
                self.happen(Event::Done { agent }, note)?;
                Ok(format!("Noted: {} was done at {now}.", self.task(task)))
            }
            PersonTells::Longer { operation: task, until } if at(task) => {
                let Some(by) = longer(view.work.map(|work| work.expected), until) else {
                    return Ok(TOLD_BEFORE.into());
                };
                self.happen(Event::Late { agent, by }, note)?;
                Ok(format!("Noted: {} takes {by:.0} s longer, until {}.", self.task(task), written(until)))
            }
            PersonTells::Failed { operation: task, until } if at(task) => {
                if !still(view.work.map(|work| work.expected), until) {
                    return Ok(TOLD_BEFORE.into());
                }
                let followed = self.happen(Event::Failed { agent }, note)?;
                let then = if followed.anew { "The plan was made anew." } else { "It is to be done again." };
                Ok(format!("Noted: {} failed. {then}", self.task(task)))
            }
            PersonTells::Begin { operation: task } | PersonTells::Done { operation: task } if self.did(agent, task) => {
                Ok(format!("{} is done already.", self.task(task)))
            }
            PersonTells::Begin { .. }
            | PersonTells::Done { .. }
            | PersonTells::Failed { .. }
            | PersonTells::Longer { .. } => Err("That task is not yours now: look at the page.".into()),
            PersonTells::Serve { .. } | PersonTells::Served { .. } | PersonTells::Feedback { .. } => {
                Err("In this mission nobody is served.".into())
            }
        }
    }

    fn supervisor(&mut self, tells: SupervisorTells, note: &mut Note<'_>) -> Answer {
        let problem = self.execution.problem();
        let who = |robot: Option<usize>, person: Option<usize>| {
            let agent = match (robot, person) {
                (Some(robot), None) => robots(problem).get(robot).copied(),
                (None, Some(person)) => people(problem).get(person).copied(),
                _ => return Err("Name a robot or an agent, not both."),
            };
            agent.ok_or("There is nobody of that number.")
        };
        let event = match tells {
            SupervisorTells::Replan {} => Event::Replan,
            SupervisorTells::Lost { robot, agent } => Event::Lost { agent: who(robot, agent)? },
            SupervisorTells::Back { robot, agent } => Event::Back { agent: who(robot, agent)? },
            SupervisorTells::Failed { robot, agent, until } => {
                let agent = who(robot, agent)?;
                if !still(self.expected(agent), until) {
                    return Ok(TOLD_BEFORE.into());
                }
                Event::Failed { agent }
            }
            SupervisorTells::Longer { robot, agent, until } => {
                let agent = who(robot, agent)?;
                match longer(self.expected(agent), until) {
                    Some(by) => Event::Late { agent, by },
                    None => return Ok(TOLD_BEFORE.into()),
                }
            }
            SupervisorTells::Moved { .. } => {
                return Err("Tasks begin and end at the bases of their agents, which stay where they are.".into());
            }
            SupervisorTells::Run {} | SupervisorTells::Stop {} | SupervisorTells::Invite { .. } => {
                return Err("That is not told to a mission.".into());
            }
        };
        self.happen(event, note).map(said)
    }
}
