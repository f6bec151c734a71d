//! A schedule for the engine: people report the begin and end of operations, and feedback on services.

use std::sync::Arc;

use mission::execution::PlanChange;
use mission::kinds::schedule::chart::chart;
use mission::kinds::schedule::execution::{Doing, Event, EventError, Execution, Happening, Stage};
use mission::kinds::schedule::map::map;
use mission::kinds::schedule::plan::Actor;

use super::engine::Answer;
use super::engine::world::{Note, Shown, World};
use super::journal::Entry;
use super::overview::supervisor;
use super::told::{PersonTells, SupervisorTells, longer, still};
use super::view::diary::Diary;
use super::view::person;
use super::words::written;

/// A running schedule, with the history for its pages.
pub struct Schedule {
    execution: Execution,
    diary: Diary,
    /// Number of records that the diary contains.
    noted: usize,
}

impl Schedule {
    /// Creates the schedule at the start of an execution.
    pub fn new(execution: Execution) -> Schedule {
        let diary = Diary::new(execution.problem());
        Schedule { execution, diary, noted: 0 }
    }
}

impl World for Schedule {
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
        let time = self.execution.time();
        match entry {
            Entry::Event(event) => {
                self.could(event)?;
                let _ = self.execution.tell(*event);
            }
            Entry::Serve { agent, operation } => {
                let who = self.execution.problem().agents.get(*agent).ok_or_else(|| nobody(*agent))?;
                if *operation >= who.operations {
                    return Err(format!(
                        "{} has no operation {operation}",
                        self.execution.problem().labels.member(&who.name)
                    ));
                }
                self.diary.page_mut(*agent).ok_or_else(|| nobody(*agent))?.begin(*operation, time);
            }
            Entry::Served { agent } => {
                self.diary.page_mut(*agent).ok_or_else(|| nobody(*agent))?.end(time);
            }
            Entry::Layered(_) => return Err("it is of a mission of layers".into()),
            Entry::Records(_) => {}
        }
        self.remember();
        Ok(())
    }

    fn shown(&self, running: bool) -> Shown {
        let execution = &self.execution;
        let people = 0..execution.problem().agents.len();
        Shown {
            people: people.map(|index| person(execution, &self.diary, index, running)).collect(),
            supervisor: supervisor(execution, &self.diary),
            plan: Arc::new(chart(execution.problem(), execution.plan())),
            map: Some(Arc::new(map(execution.problem(), execution.plan()))),
        }
    }

    fn person(&mut self, agent: usize, tells: PersonTells, note: &mut Note<'_>) -> Answer {
        match tells {
            PersonTells::Feedback { operation, wait, approach, distance } => {
                self.feedback(agent, operation, [wait, approach, distance], note)
            }
            tells => self.works(agent, tells, note),
        }
    }

    fn supervisor(&mut self, tells: SupervisorTells, note: &mut Note<'_>) -> Answer {
        let event = match tells {
            SupervisorTells::Replan {} => Event::Replan,
            SupervisorTells::Lost { robot, agent } => Event::Lost { who: who(robot, agent)? },
            SupervisorTells::Back { robot, agent } => Event::Back { who: who(robot, agent)? },
            SupervisorTells::Moved { agent, place } => Event::Moved { agent, place },
            SupervisorTells::Failed { robot, agent, until } => {
                let (agent, expected) = self.under_way(who(robot, agent)?)?;
                if !still(expected, until) {
                    return Ok(TOLD_BEFORE.into());
                }
                Event::Failed { agent }
            }
            SupervisorTells::Longer { robot, agent, until } => {
                let (agent, expected) = self.under_way(who(robot, agent)?)?;
                match longer(expected, until) {
                    Some(by) => Event::Late { agent, by },
                    None => return Ok(TOLD_BEFORE.into()),
                }
            }
            SupervisorTells::Run {} | SupervisorTells::Stop {} | SupervisorTells::Invite { .. } => {
                return Err("That is not told to a mission.".into());
            }
        };
        self.happen(event, note).map(said)
    }
}

/// Reply to a report that is duplicated or late.
pub(super) const TOLD_BEFORE: &str = "That was noted before: look at when it is expected to end.";

impl Schedule {
    /// Returns the agent of an actor (itself, or the one that a robot serves), and the expected end of its current
    /// activity (s).
    fn under_way(&self, actor: Actor) -> Result<(usize, Option<f64>), String> {
        let agent = match actor {
            Actor::Agent(agent) => agent,
            Actor::Robot(robot) => {
                let view = self.execution.robot(robot).ok_or_else(|| EventError::NoRobot { robot }.to_string())?;
                let target = view.target.filter(|_| view.stage == Stage::Serving);
                target.ok_or("That robot serves nobody now.")?.agent
            }
        };
        let view = self.execution.agent(agent).ok_or_else(|| nobody(agent))?;
        let busy = matches!(view.doing, Doing::Working | Doing::Served);
        Ok((agent, view.until.filter(|_| busy)))
    }

    fn remember(&mut self) {
        for record in self.execution.records().iter().skip(self.noted) {
            self.diary.note(self.execution.problem(), record);
        }
        self.noted = self.execution.records().len();
    }

    /// Rejects events that are never valid in this mission, in any state.
    fn could(&self, event: &Event) -> Result<(), String> {
        let problem = self.execution.problem();
        let actor = match event {
            Event::Begun { agent }
            | Event::Done { agent }
            | Event::Late { agent, .. }
            | Event::Served { agent }
            | Event::Failed { agent }
            | Event::Moved { agent, .. } => Actor::Agent(*agent),
            Event::Said { agent, wait, approach, distance } => {
                if let Some(step) = [wait, approach, distance].into_iter().find(|step| !(-2..=2).contains(*step)) {
                    return Err(EventError::Step { step: *step }.to_string());
                }
                Actor::Agent(*agent)
            }
            Event::Feedback(feedback) => Actor::Agent(feedback.agent),
            Event::Lost { who } | Event::Back { who } => *who,
            Event::Replan => return Ok(()),
        };
        match actor {
            Actor::Agent(agent) if agent >= problem.agents.len() => Err(nobody(agent)),
            Actor::Robot(robot) if robot >= problem.robots.len() => Err(EventError::NoRobot { robot }.to_string()),
            _ => Ok(()),
        }
    }

    /// Records an event and applies it. Returns the change of the plan.
    fn happen(&mut self, event: Event, note: &mut Note<'_>) -> Result<Followed, String> {
        self.could(&event).map_err(|why| format!("That cannot be: {why}."))?;
        note(Entry::Event(event))?;
        let followed = self.execution.tell(event).map(|records| Followed {
            anew: records.iter().any(|record| matches!(record.what, Happening::Plan(PlanChange::Reallocated { .. }))),
            moved: records.iter().any(|record| matches!(record.what, Happening::Plan(PlanChange::Rescheduled { .. }))),
        });
        self.remember();
        followed.map_err(|refused| format!("That cannot be now: {refused}."))
    }

    fn works(&mut self, agent: usize, tells: PersonTells, note: &mut Note<'_>) -> Answer {
        let view = self.execution.agent(agent).ok_or("There is no such person.")?;
        let (doing, now) = (view.doing, written(self.execution.time()));
        let is = |operation: usize| view.operation == Some(operation);
        let past = |operation: usize| view.operation.is_none_or(|current| operation < current);
        match tells {
            PersonTells::Begin { operation } if is(operation) && doing == Doing::Ready => {
                self.happen(Event::Begun { agent }, note)?;
                Ok(format!("Noted: operation {} began at {now}.", operation + 1))
            }
            PersonTells::Begin { operation } if is(operation) || past(operation) => {
                Ok(format!("Operation {} has begun already.", operation + 1))
            }
            PersonTells::Done { operation } if is(operation) && doing == Doing::Working => {
                self.happen(Event::Done { agent }, note)?;
                Ok(format!("Noted: operation {} ended at {now}.", operation + 1))
            }
            PersonTells::Done { operation } if past(operation) || (is(operation) && doing != Doing::Ready) => {
                Ok(format!("Operation {} is finished already.", operation + 1))
            }
            PersonTells::Serve { operation } if is(operation) && doing == Doing::Served => {
                if !self.diary.page(agent).measures() {
                    note(Entry::Serve { agent, operation })?;
                    let time = self.execution.time();
                    if let Some(page) = self.diary.page_mut(agent) {
                        page.begin(operation, time);
                    }
                }
                Ok(format!("Noted: the service began at {now}."))
            }
            PersonTells::Served { operation } => {
                self.served(agent, operation, (is(operation) && doing == Doing::Served, past(operation)), note)
            }
            PersonTells::Serve { .. } => Err("No robot serves you now.".into()),
            PersonTells::Failed { operation, until } if is(operation) && doing == Doing::Served => {
                if !still(view.until, until) {
                    return Ok(TOLD_BEFORE.into());
                }
                self.happen(Event::Failed { agent }, note)?;
                Ok(format!("Noted: the service failed, and is done again{}.", self.until(agent)))
            }
            PersonTells::Longer { operation, until }
                if is(operation) && matches!(doing, Doing::Working | Doing::Served) =>
            {
                let Some(by) = longer(view.until, until) else { return Ok(TOLD_BEFORE.into()) };
                self.happen(Event::Late { agent, by }, note)?;
                let what = if doing == Doing::Served { "the service" } else { "the operation" };
                Ok(format!("Noted: {what} takes {by:.0} s longer{}.", self.until(agent)))
            }
            PersonTells::Failed { .. } => Err("No robot serves you now.".into()),
            PersonTells::Longer { .. } => Err("Nothing goes on that could take longer.".into()),
            PersonTells::Begin { operation }
            | PersonTells::Done { operation }
            | PersonTells::Feedback { operation, .. } => Err(format!("Operation {} is not under way.", operation + 1)),
        }
    }

    /// Returns the expected end of an agent's current activity: `, until 3:07`.
    fn until(&self, agent: usize) -> String {
        let until = self.execution.agent(agent).and_then(|view| view.until);
        until.map_or_else(String::new, |until| format!(", until {}", written(until)))
    }

    /// Ends a service, or its measurement, or both.
    fn served(&mut self, agent: usize, operation: usize, (serves, past): (bool, bool), note: &mut Note<'_>) -> Answer {
        let measures = self.diary.page(agent).measures();
        let mut took = None;
        if measures {
            note(Entry::Served { agent })?;
            let time = self.execution.time();
            took = self.diary.page_mut(agent).and_then(|page| page.end(time));
        }
        let measured = took.map(|took| format!(" You measured {took:.0} s.")).unwrap_or_default();
        match (serves, measures || past) {
            (true, _) => {
                self.happen(Event::Served { agent }, note)?;
                Ok(format!("Noted: the service of operation {} is finished.{measured}", operation + 1))
            }
            (false, true) => Ok(format!("The service is finished.{measured}")),
            (false, false) => Err("No robot serves you now.".into()),
        }
    }

    fn feedback(
        &mut self,
        agent: usize,
        operation: usize,
        [wait, approach, distance]: [i8; 3],
        note: &mut Note<'_>,
    ) -> Answer {
        match self.diary.page(agent).spoken() {
            Some((last, false)) if last == operation => {
                let followed = self.happen(Event::Said { agent, wait, approach, distance }, note)?;
                let then = match followed {
                    Followed { anew: true, .. } => "The plan was made anew.",
                    Followed { moved: true, .. } => "The plan has been adapted.",
                    _ => "It counts from now on.",
                };
                Ok(format!("Thank you. {then}"))
            }
            Some((last, _)) if operation <= last => {
                Ok("Thank you; that was noted before, or is about an earlier service.".into())
            }
            _ => Err("That service has not been.".into()),
        }
    }
}

fn nobody(agent: usize) -> String {
    EventError::NoAgent { agent }.to_string()
}

/// Change of the plan by an event.
pub(super) struct Followed {
    /// True if the plan was replaced.
    pub anew: bool,
    /// True if times of the plan moved.
    pub moved: bool,
}

/// Returns the reply to the supervisor.
pub(super) fn said(followed: Followed) -> String {
    match followed {
        Followed { anew: true, .. } => "Noted; planned anew.".into(),
        Followed { moved: true, .. } => "Noted; the plan has moved.".into(),
        _ => "Noted; the plan stays.".into(),
    }
}

fn who(robot: Option<usize>, agent: Option<usize>) -> Result<Actor, String> {
    match (robot, agent) {
        (Some(robot), None) => Ok(Actor::Robot(robot)),
        (None, Some(agent)) => Ok(Actor::Agent(agent)),
        _ => Err("Name a robot or an agent, not both.".into()),
    }
}
