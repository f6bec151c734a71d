//! Events from outside: what they change in the world.

use crate::execution::ReplanPolicy;
use crate::kinds::search::geometry::Pose;
use crate::kinds::search::ground::{Body, Ground};
use crate::numbers::MAX_NUMBER;

use super::SearchExecution;
use super::event::{Event, EventError};
use super::record::{LogEntry, Record};

impl SearchExecution {
    /// Something happens at the present time. Gives what followed from it at once.
    ///
    /// # Errors
    /// The event is of nobody, or cannot happen now. Nothing has changed then.
    pub fn handle_event(&mut self, event: Event) -> Result<&[Record], EventError> {
        self.check_event(event)?;
        let from = self.log.records.len();
        self.settle();
        self.record(LogEntry::Handled { event });
        match event {
            Event::Late { agent, by } => {
                self.late(agent, by);
                self.update(ReplanPolicy::IfCostly);
            }
            Event::Done { agent } => {
                self.end(agent, true);
                self.start(agent);
                // A stay that ends early leaves something in its source.
                self.update(ReplanPolicy::IfCostly);
            }
            Event::Moved { agent, to } => {
                self.end(agent, false);
                let heading = self.world.members[agent].pose.heading;
                self.stand(agent, Pose { at: to, heading });
                self.world.members[agent].displace(true);
                self.reopen();
                self.update(ReplanPolicy::IfInfeasible);
            }
            Event::Lost { agent } => {
                self.end(agent, false);
                self.world.members[agent].displace(false);
                self.problem.agents[agent].lost = true;
                self.update(ReplanPolicy::IfCostly);
            }
            Event::Back { agent } => {
                self.world.members[agent].displaced = true;
                self.problem.agents[agent].lost = false;
                self.reopen();
                self.update(ReplanPolicy::IfInfeasible);
            }
            Event::Replan => {
                self.reopen();
                self.update(ReplanPolicy::Asked);
            }
        }
        self.wake();
        Ok(&self.log.records[from..])
    }

    fn late(&mut self, agent: usize, by: f64) {
        let now = self.time;
        if let Some(current) = &mut self.world.members[agent].current {
            current.from = [current.share(now), now];
            current.ends = current.ends.map(|ends| (ends + by).max(now));
        }
    }

    /// A new plan may leave something to do where everything was done.
    fn reopen(&mut self) {
        self.log.done = None;
    }

    /// Checks if an event can happen now.
    ///
    /// # Errors
    /// The reason why it cannot.
    pub fn check_event(&self, event: Event) -> Result<(), EventError> {
        let name = |agent: usize| self.problem.agent_label(agent).to_string();
        match event {
            Event::Late { agent, by } => {
                self.is_active(agent)?;
                if !by.is_finite() || by.abs() > MAX_NUMBER {
                    return Err(EventError::Time { value: by });
                }
            }
            Event::Done { agent } => self.is_active(agent)?,
            Event::Lost { agent } => self.is_here(agent)?,
            Event::Moved { agent, to } => {
                self.is_here(agent)?;
                if !Ground::new(&self.problem, &Body::of(&self.problem.agents[agent])).fits(to) {
                    return Err(EventError::NotFree { name: name(agent), at: to });
                }
            }
            Event::Back { agent } => match self.problem.agents.get(agent) {
                None => return Err(EventError::NoAgent { agent }),
                Some(who) if !who.lost => return Err(EventError::NotLost { name: name(agent) }),
                Some(_) => {}
            },
            Event::Replan => {}
        }
        Ok(())
    }

    /// Somebody exists and takes part.
    fn is_here(&self, agent: usize) -> Result<(), EventError> {
        match self.problem.agents.get(agent) {
            None => Err(EventError::NoAgent { agent }),
            Some(who) if who.lost => Err(EventError::IsLost { name: self.problem.agent_label(agent).to_string() }),
            Some(_) => Ok(()),
        }
    }

    /// Somebody has an activity that can end.
    fn is_active(&self, agent: usize) -> Result<(), EventError> {
        self.is_here(agent)?;
        let current = self.world.members[agent].current.as_ref();
        match current.is_some_and(|current| current.ends.is_some()) {
            true => Ok(()),
            false => Err(EventError::NoActivity { name: self.problem.agent_label(agent).to_string() }),
        }
    }
}
