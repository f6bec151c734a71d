//! Events from outside: what they change in the world.

use crate::execution::ReplanPolicy;
use crate::kinds::search::geometry::distance;
use crate::numbers::MAX_NUMBER;

use super::SearchExecution;
use super::event::{Event, EventError};
use super::messages::FOUND;
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
                self.end_stray(agent);
                self.place(agent, to);
                self.update(ReplanPolicy::IfInfeasible);
            }
            Event::MyPose { agent, to } => {
                self.world.sent.poses += 1;
                self.count_pose(agent);
                if distance(self.true_pose(agent, self.time).at, to) <= FOUND {
                    self.end_stray(agent);
                }
                self.believe(agent, to);
            }
            Event::RobotPose { agent, to } => {
                self.world.sent.robot_poses += 1;
                self.believe(agent, to);
            }
            Event::MyGoal { agent, to } => {
                self.world.sent.goals += 1;
                self.tell_goal(agent, Some(to));
            }
            Event::RobotGoal { agent, to } => {
                self.world.sent.robot_goals += 1;
                self.tell_goal(agent, Some(to));
            }
            Event::Free { agent } => self.tell_goal(agent, None),
            Event::Strays { agent, to } => self.let_stray(agent, to),
            Event::Seen { agent } => {
                let at = self.true_pose(agent, self.time).at;
                self.end_stray(agent);
                self.believe(agent, at);
            }
            Event::Lost { agent } => {
                let before = self.role();
                self.end_stray(agent);
                self.end(agent, false);
                self.world.members[agent].displace(false);
                self.problem.agents[agent].lost = true;
                self.problem.agents[agent].told = None;
                self.record_role(before);
                self.update(ReplanPolicy::IfCostly);
            }
            Event::Back { agent } => {
                self.world.members[agent].displaced = true;
                self.problem.agents[agent].lost = false;
                self.reopen();
                self.update(ReplanPolicy::IfInfeasible);
            }
            Event::Found { object } => self.report_find(object),
            Event::Replan => {
                self.world.sent.replans += 1;
                self.reopen();
                self.update(ReplanPolicy::Asked);
            }
        }
        self.follow();
        self.wake();
        Ok(&self.log.records[from..])
    }

    pub(super) fn late(&mut self, agent: usize, by: f64) {
        let now = self.time;
        if let Some(current) = &mut self.world.members[agent].current {
            current.from = [current.share(now), now];
            current.ends = current.ends.map(|ends| (ends + by).max(now));
        }
    }

    /// A new plan may leave something to do where everything was done.
    pub(super) fn reopen(&mut self) {
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
                self.is_not_driven(agent)?;
                self.check_place(agent, to, None)?;
            }
            Event::MyPose { agent, to } => {
                self.is_person(agent)?;
                self.check_place(agent, to, None)?;
            }
            Event::RobotPose { agent, to } => {
                self.is_robot(agent)?;
                self.is_not_driven(agent)?;
                self.check_place(agent, to, None)?;
            }
            Event::MyGoal { agent, to } => {
                self.is_person(agent)?;
                self.check_goal(agent, to)?;
            }
            Event::RobotGoal { agent, to } => {
                self.is_robot(agent)?;
                self.check_goal(agent, to)?;
            }
            Event::Free { agent } => {
                self.is_here(agent)?;
                if self.told_goal(agent).is_none() {
                    return Err(EventError::NoGoal { name: name(agent) });
                }
            }
            Event::Strays { agent, to } => {
                self.is_person(agent)?;
                self.check_place(agent, to, Some(self.true_pose(agent, self.time).at))?;
            }
            Event::Seen { agent } => self.is_person(agent)?,
            Event::Back { agent } => match self.problem.agents.get(agent) {
                None => return Err(EventError::NoAgent { agent }),
                Some(who) if !who.lost => return Err(EventError::NotLost { name: name(agent) }),
                Some(_) => {}
            },
            Event::Found { object } => match self.problem.objects.get(object) {
                None => return Err(EventError::NoObject { object }),
                Some(of) if of.left() == 0 => {
                    return Err(EventError::AllFound { name: self.problem.object_label(object).to_string() });
                }
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

    /// Somebody is where the plan has them, and not where a controller brings them.
    fn is_not_driven(&self, agent: usize) -> Result<(), EventError> {
        match self.world.members[agent].driven {
            Some(_) => Err(EventError::Driven { name: self.problem.agent_label(agent).to_string() }),
            None => Ok(()),
        }
    }

    /// Somebody is a person, and takes part.
    fn is_person(&self, agent: usize) -> Result<(), EventError> {
        self.is_here(agent)?;
        match self.problem.agents[agent].human {
            true => Ok(()),
            false => Err(EventError::NoPerson { name: self.problem.agent_label(agent).to_string() }),
        }
    }

    /// Somebody is a robot, and takes part.
    fn is_robot(&self, agent: usize) -> Result<(), EventError> {
        self.is_here(agent)?;
        match self.problem.agents[agent].human {
            true => Err(EventError::NoRobot { name: self.problem.agent_label(agent).to_string() }),
            false => Ok(()),
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
