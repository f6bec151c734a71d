//! History for pages: recent records as messages, measurements, and services without feedback.

use mission::execution::PlanChange;
use mission::kinds::schedule::execution::{Event, Happening, Record};
use mission::kinds::schedule::plan::Actor;
use mission::kinds::schedule::problem::{AgentKind, Problem};
use mission::kinds::schedule::words::of_happening;

use crate::view::messages::Messages;
use crate::view::{Ask, Measured, Message};
use crate::words;

/// Maximum number of messages of one person's page.
const MESSAGES: usize = 12;
/// Maximum number of events of the supervisor's page.
const EVENTS: usize = 80;

/// History for one person's page.
#[derive(Clone, Debug)]
pub struct Page {
    messages: Messages<Happening>,
    /// Current or last operation: number, start (s), and duration (s) if it has ended.
    filling: Option<(usize, f64, Option<f64>)>,
    /// Current or last measurement of a service by the person: operation, start (s), and duration (s) if it has ended.
    serving: Option<(usize, f64, Option<f64>)>,
    /// Last service: operation, robot, and true if the person has given feedback.
    served: Option<(usize, usize, bool)>,
    human: bool,
}

impl Page {
    /// Creates an empty history.
    fn new(human: bool) -> Page {
        Page { messages: Messages::new(MESSAGES), filling: None, serving: None, served: None, human }
    }

    /// Returns true while a measurement of a service runs.
    pub fn measures(&self) -> bool {
        self.serving.is_some_and(|(_, _, took)| took.is_none())
    }

    /// Returns the operation whose service is being measured.
    pub fn measured_operation(&self) -> Option<usize> {
        self.serving.filter(|(_, _, took)| took.is_none()).map(|(operation, _, _)| operation)
    }

    /// Starts the measurement of an operation's service.
    pub fn begin(&mut self, operation: usize, time: f64) {
        self.serving = Some((operation, time, None));
    }

    /// Ends the measurement; returns its duration (s), or `None` if none was running.
    pub fn end(&mut self, time: f64) -> Option<f64> {
        let (_, since, took) = self.serving.as_mut().filter(|(_, _, took)| took.is_none())?;
        *took = Some(time - *since);
        *took
    }

    /// Returns the last measurements.
    pub fn measured(&self) -> Vec<Measured> {
        let of = |word: &str, at: Option<(usize, f64, Option<f64>)>| {
            at.map(|(operation, _, seconds)| Measured { name: format!("{word} {}", operation + 1), seconds })
        };
        of("Operation", self.filling).into_iter().chain(of("Service", self.serving)).collect()
    }

    /// Returns the question about the last service, if the person has not given feedback.
    pub fn ask(&self, problem: &Problem) -> Option<Ask> {
        let (operation, robot, spoken) = self.served.filter(|_| self.human)?;
        let text = format!(
            "{} served operation {}. Three short answers shape the next time:",
            words::robot(problem, robot),
            operation + 1
        );
        (!spoken).then_some(Ask { operation, text })
    }

    /// Returns the last operation that was served, and whether the person has given feedback.
    pub fn spoken(&self) -> Option<(usize, bool)> {
        self.served.map(|(operation, _, spoken)| (operation, spoken))
    }

    /// Returns the messages, the latest first.
    pub fn messages(&self) -> Vec<Message> {
        self.messages.shown()
    }
}

/// History for all pages.
#[derive(Clone, Debug)]
pub struct Diary {
    pages: Vec<Page>,
    events: Messages<Happening>,
    nobody: Page,
}

impl Diary {
    /// Creates the history of a mission before its start.
    pub fn new(problem: &Problem) -> Diary {
        let page = |agent: &mission::kinds::schedule::problem::Agent| Page::new(agent.kind == AgentKind::Human);
        let pages = problem.agents.iter().map(page).collect();
        Diary { pages, events: Messages::new(EVENTS), nobody: Page::new(false) }
    }

    /// Returns the history for the page of this agent.
    pub fn page(&self, agent: usize) -> &Page {
        self.pages.get(agent).unwrap_or(&self.nobody)
    }

    /// Mutable version of [`Diary::page`]; `None` if there is no such agent.
    pub fn page_mut(&mut self, agent: usize) -> Option<&mut Page> {
        self.pages.get_mut(agent)
    }

    /// Returns the events, the latest first.
    pub fn events(&self) -> Vec<Message> {
        self.events.shown()
    }

    /// Adds a record.
    pub fn note(&mut self, problem: &Problem, record: &Record) {
        let message = |text: String| Message { at: record.time, text };
        self.events.add(&record.what, false, message(of_happening(&record.what, problem)));
        let outdates = matches!(
            record.what,
            Happening::Plan(PlanChange::Reallocated { .. })
                | Happening::OperationLate { .. }
                | Happening::RobotLate { .. }
                | Happening::HeldUp { .. }
        );
        for (who, page) in self.pages.iter_mut().enumerate() {
            if let Some(text) = words::for_one(problem, who, record) {
                page.messages.add(&record.what, outdates, message(text));
            }
        }
        match &record.what {
            Happening::OperationBegan { agent, operation } => {
                self.change(*agent, |page| page.filling = Some((*operation, record.time, None)));
            }
            Happening::OperationEnded { agent, .. } => {
                let ended = |page: &mut Page| {
                    if let Some((_, since, took)) = &mut page.filling {
                        *took = Some(record.time - *since);
                    }
                };
                self.change(*agent, ended);
            }
            Happening::Served { robot, agent, operation } => {
                self.change(*agent, |page| page.served = Some((*operation, *robot, false)));
            }
            Happening::Told { event: Event::Lost { who: Actor::Agent(agent) } } => {
                // After it comes back, an agent repeats its current operation.
                let over = |at: &(usize, f64, Option<f64>)| at.2.is_some();
                self.change(*agent, |page| {
                    (page.filling, page.serving) = (page.filling.filter(over), page.serving.filter(over));
                });
            }
            Happening::Told { event: Event::Said { agent, .. } } => self.spoken(*agent),
            Happening::Told { event: Event::Feedback(said) } => self.spoken(said.agent),
            _ => {}
        }
    }

    fn spoken(&mut self, agent: usize) {
        self.change(agent, |page| {
            if let Some((_, _, spoken)) = &mut page.served {
                *spoken = true;
            }
        });
    }

    fn change(&mut self, agent: usize, change: impl FnOnce(&mut Page)) {
        if let Some(page) = self.pages.get_mut(agent) {
            change(page);
        }
    }
}
