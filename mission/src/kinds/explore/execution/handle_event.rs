//! Events from outside.

use super::super::event::Event;
use super::{ExploreExecution, LogEntry};

impl ExploreExecution {
    /// An event happens at the present time; `text` are its words.
    ///
    /// # Errors
    /// The reason why it cannot happen now, in a sentence. Nothing has changed then.
    pub(super) fn happen(&mut self, event: &Event, text: String) -> Result<(), String> {
        if self.done.is_some() {
            return Err("the exploration is over".into());
        }
        let time = self.time;
        self.move_robots();
        let who = |robot: usize| self.problem.robot_label(robot).to_string();
        match *event {
            Event::RobotLost { robot } => {
                if !self.robots[robot].active {
                    return Err(format!("{} is lost already", who(robot)));
                }
                let mover = &mut self.robots[robot];
                (mover.active, mover.input, mover.state.velocity) = (false, [0.0; 2], [0.0; 2]);
                if let Some(base) = &mut mover.base {
                    base.state.velocity = [0.0; 2];
                    mover.state = base.state;
                }
                self.solver.forget();
            }
            Event::RobotBack { robot } => {
                if self.robots[robot].active {
                    return Err(format!("{} is there", who(robot)));
                }
                self.robots[robot].active = true;
                self.solver.forget();
            }
            Event::PersonLost => self.person.set_unseen(true)?,
            Event::PersonBack => self.person.set_unseen(false)?,
            Event::Late { by } => self.person.wait(by, time)?,
            Event::Strays { to } => self.person.stray(&self.grid, to)?,
            Event::MyPose { at } => self.person.tell(&self.grid, at, time)?,
            Event::Done => {
                if !self.settings.played {
                    return Err("the person reaches the exit by walking there".into());
                }
                self.done = Some(time);
                self.record(LogEntry::Handled { text });
                self.record(LogEntry::Done);
                return Ok(());
            }
        }
        self.record(LogEntry::Handled { text });
        Ok(())
    }
}
