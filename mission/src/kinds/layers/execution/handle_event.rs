//! Events from outside: what they change in the world.

use crate::numbers::MAX_NUMBER;

use crate::execution::ReplanPolicy;

use super::LayersExecution;
use super::event::{Event, EventError};
use super::record::{LogEntry, Record};
use super::view::Doing;

impl LayersExecution {
    /// Something happens at the present time. Gives what followed from it at once.
    ///
    /// # Errors
    ///
    /// The event is of nobody, or cannot happen now. Nothing has changed then.
    pub fn handle_event(&mut self, event: Event) -> Result<&[Record], EventError> {
        let from = self.log.records.len();
        match event {
            Event::Begun { agent } => {
                self.may_begin(agent)?;
                self.record_event(event);
                self.begins(agent);
            }
            Event::Done { agent } => {
                self.is_working(agent)?;
                self.record_event(event);
                self.ends(agent);
            }
            Event::Late { agent, by } => {
                self.is_working(agent)?;
                if !by.is_finite() || by.abs() > MAX_NUMBER {
                    return Err(EventError::Time { value: by });
                }
                self.record_event(event);
                self.late(agent, by);
            }
            Event::Failed { agent } => {
                self.is_working(agent)?;
                self.record_event(event);
                self.drops(agent);
                let state = &mut self.world.agents[agent];
                state.begin(Doing::Idle, self.time);
                state.place = self.problem.agents[agent].place;
                self.update();
            }
            Event::Lost { agent } => {
                self.is_here(agent)?;
                self.record_event(event);
                let place = self.position(agent).unwrap_or_default();
                self.drops(agent);
                let state = &mut self.world.agents[agent];
                state.begin(Doing::Lost, self.time);
                state.place = place;
                self.problem.agents[agent].lost = true;
                self.update();
            }
            Event::Back { agent } => {
                match self.world.agents.get(agent) {
                    None => return Err(EventError::NoAgent { agent }),
                    Some(state) if state.doing != Doing::Lost => {
                        return Err(EventError::NotLost { name: self.name(agent) });
                    }
                    Some(_) => {}
                }
                self.record_event(event);
                let state = &mut self.world.agents[agent];
                state.begin(Doing::Idle, self.time);
                state.place = self.problem.agents[agent].place;
                self.problem.agents[agent].lost = false;
                self.update_or_plan(ReplanPolicy::Asked);
            }
            Event::Replan => {
                self.record_event(event);
                self.update_or_plan(ReplanPolicy::Asked);
            }
        }
        Ok(&self.log.records[from..])
    }

    fn record_event(&mut self, event: Event) {
        self.record(LogEntry::Handled { event });
    }

    fn name(&self, agent: usize) -> String {
        self.problem.agent_label(agent).unwrap_or_default().to_string()
    }

    /// Somebody exists and takes part.
    fn is_here(&self, agent: usize) -> Result<(), EventError> {
        match self.world.agents.get(agent) {
            None => Err(EventError::NoAgent { agent }),
            Some(state) if state.doing == Doing::Lost => Err(EventError::IsLost { name: self.name(agent) }),
            Some(_) => Ok(()),
        }
    }

    fn is_working(&self, agent: usize) -> Result<(), EventError> {
        self.is_here(agent)?;
        match self.world.agents[agent].doing {
            Doing::Working => Ok(()),
            _ => Err(EventError::NotWorking { name: self.name(agent) }),
        }
    }

    fn may_begin(&self, agent: usize) -> Result<(), EventError> {
        self.is_here(agent)?;
        let name = || self.name(agent);
        if self.world.agents[agent].doing == Doing::Working {
            return Err(EventError::Working { name: name() });
        }
        if self.ready(agent).is_some() {
            return Ok(());
        }
        match self.world.ahead.iter().any(|step| step.agent == agent) {
            true => Err(EventError::NotOpen { name: name() }),
            false => Err(EventError::NoTask { name: name() }),
        }
    }

    fn late(&mut self, agent: usize, by: f64) {
        let time = self.time;
        if let Some(running) = &mut self.world.agents[agent].task {
            running.rebase(time);
            running.ends = (running.ends + by).max(time);
            running.expected = (running.expected + by).max(time);
        }
        self.update();
    }
}
