//! What pages remember of the records: the latest of them in words, measurements, services nobody has spoken of yet.

use mission::execution::PlanChange;
use mission::kinds::schedule::execution::{Event, Happening, Record};
use mission::kinds::schedule::problem::{AgentKind, Problem};
use mission::plan::Actor;
use runtime::missions::of_happening;

use super::messages::Messages;
use super::view::{Ask, Measured, Message};
use super::words;

/// Messages of one person's page.
const MESSAGES: usize = 12;
/// Events of the supervisor's page.
const EVENTS: usize = 80;

/// What one person's page remembers.
#[derive(Clone, Debug)]
pub struct Page {
    messages: Messages<Happening>,
    /// Since when the operation under way runs (s), and how long the last one took.
    filling: Option<(usize, f64, Option<f64>)>,
    /// The same of a service, as the person measures it.
    serving: Option<(usize, f64, Option<f64>)>,
    /// The last service: its operation and robot, and whether the person has spoken of it.
    served: Option<(usize, usize, bool)>,
    human: bool,
}

impl Page {
    /// Of somebody of whom nothing has been told.
    fn new(human: bool) -> Page {
        Page { messages: Messages::new(MESSAGES), filling: None, serving: None, served: None, human }
    }

    /// A measurement of a service runs.
    pub fn measures(&self) -> bool {
        self.serving.is_some_and(|(_, _, took)| took.is_none())
    }

    /// The operation whose service is being measured.
    pub fn measured_operation(&self) -> Option<usize> {
        self.serving.filter(|(_, _, took)| took.is_none()).map(|(operation, _, _)| operation)
    }

    /// Begins to measure the service of an operation.
    pub fn begin(&mut self, operation: usize, time: f64) {
        self.serving = Some((operation, time, None));
    }

    /// Ends the measurement; how long it took (s), if one ran.
    pub fn end(&mut self, time: f64) -> Option<f64> {
        let (_, since, took) = self.serving.as_mut().filter(|(_, _, took)| took.is_none())?;
        *took = Some(time - *since);
        *took
    }

    /// What was measured last.
    pub fn measured(&self) -> Vec<Measured> {
        let of = |word: &str, at: Option<(usize, f64, Option<f64>)>| {
            at.map(|(operation, _, seconds)| Measured { name: format!("{word} {}", operation + 1), seconds })
        };
        of("Operation", self.filling).into_iter().chain(of("Service", self.serving)).collect()
    }

    /// The service that the person has not spoken of.
    pub fn ask(&self, problem: &Problem) -> Option<Ask> {
        let (operation, robot, spoken) = self.served.filter(|_| self.human)?;
        let text = format!(
            "{} served operation {}. Three short answers shape the next time:",
            words::robot(problem, robot),
            operation + 1
        );
        (!spoken).then_some(Ask { operation, text })
    }

    /// The last operation that was served, and whether the person has spoken of it.
    pub fn spoken(&self) -> Option<(usize, bool)> {
        self.served.map(|(operation, _, spoken)| (operation, spoken))
    }

    /// What happened, the latest first.
    pub fn messages(&self) -> Vec<Message> {
        self.messages.shown()
    }
}

/// All that pages remember.
#[derive(Clone, Debug)]
pub struct Diary {
    pages: Vec<Page>,
    events: Messages<Happening>,
    nobody: Page,
}

impl Diary {
    /// Of a mission in which nothing has happened.
    pub fn new(problem: &Problem) -> Diary {
        let page = |agent: &mission::kinds::schedule::problem::Agent| Page::new(agent.kind == AgentKind::Human);
        let pages = problem.agents.iter().map(page).collect();
        Diary { pages, events: Messages::new(EVENTS), nobody: Page::new(false) }
    }

    /// What the page of this agent remembers.
    pub fn page(&self, agent: usize) -> &Page {
        self.pages.get(agent).unwrap_or(&self.nobody)
    }

    /// The same, to be changed; none if there is no such agent.
    pub fn page_mut(&mut self, agent: usize) -> Option<&mut Page> {
        self.pages.get_mut(agent)
    }

    /// What happened, the latest first.
    pub fn events(&self) -> Vec<Message> {
        self.events.shown()
    }

    /// Takes note of a record.
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
                // What was under way is done once more by who comes back.
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
