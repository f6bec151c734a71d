//! The steps that happen by themselves, and the motion between them.

use super::super::motion::State;
use super::super::polygon::{distance, minus};
use super::{ExploreExecution, LogEntry, TICKS};

/// Times (s) that are the same but for rounding.
const SAME: f64 = 1e-9;
use crate::execution::DiscreteEvents;

/// A step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Step {
    /// The person ends an action.
    Person,
    /// A period begins.
    Period,
    /// Contacts and connections are looked at, and the fallback acts.
    Tick,
}

impl DiscreteEvents for ExploreExecution {
    type Step = Step;

    fn now(&self) -> f64 {
        self.time
    }

    fn set_time(&mut self, time: f64) {
        self.time = time;
    }

    fn due(&self, ticks: bool) -> Vec<(f64, Step)> {
        if self.done.is_some() {
            return Vec::new();
        }
        let period = self.problem.period;
        let mut due = vec![(self.period as f64 * period, Step::Period)];
        due.extend(self.person.ends().map(|time| (time, Step::Person)));
        if ticks {
            due.push((self.tick as f64 * period / TICKS as f64, Step::Tick));
        }
        due
    }

    fn perform(&mut self, step: Step) {
        self.move_robots();
        match step {
            Step::Person => self.end_action(),
            Step::Period => {
                self.begin_period();
                self.period += 1;
            }
            Step::Tick => {
                self.look();
                self.tick += 1;
                if self.without_plan {
                    self.look_at_bases();
                    self.fall_back(self.problem.period / TICKS as f64);
                    self.lay_motions();
                }
            }
        }
    }
}

impl ExploreExecution {
    /// The state of a robot at a time (s), not before the last step: it holds its input.
    pub(super) fn state_at(&self, robot: usize, time: f64) -> Option<State> {
        let mover = self.robots.get(robot)?;
        if let Some(base) = &mover.base {
            return Some(base.state);
        }
        // Nobody moves after the end.
        let time = self.done.map_or(time, |done| time.min(done));
        let dynamics = self.problem.robots[robot].dynamics;
        Some(if mover.active { dynamics.after(mover.state, mover.input, time - self.moved_to) } else { mover.state })
    }

    /// Moves the robots up to the present. It happens at steps and events alone, so that however time is cut the same numbers
    /// come out.
    pub(super) fn move_robots(&mut self) {
        let passed = self.time - self.moved_to;
        if passed <= 0.0 {
            return;
        }
        for (robot, who) in self.robots.iter_mut().zip(&self.problem.robots).filter(|(robot, _)| robot.active) {
            let next = who.dynamics.after(robot.state, robot.input, passed);
            if robot.base.is_none() {
                robot.travelled += distance(next.at, robot.state.at);
            }
            robot.state = next;
        }
        self.moved_to = self.time;
    }

    /// Ends an action of the person, and begins the next one.
    fn end_action(&mut self) {
        let open: Vec<bool> = self.takers.iter().map(Option::is_none).collect();
        let ended = self.person.end_action(&self.problem, &self.grid, &open, self.time);
        let person = self.robots.len();
        if let Some(target) = ended.takes {
            match self.takers[target] {
                None => {
                    self.takers[target] = Some((person, self.time));
                    self.record(LogEntry::Taken { member: person, target });
                }
                Some(_) => {
                    self.counts.redundant += 1;
                    self.record(LogEntry::Redundant { member: person, target });
                }
            }
        }
        if ended.arrives && self.done.is_none() {
            self.look();
            // Whatever the robots take at the same moment counts.
            if (self.period as f64 * self.problem.period - self.time).abs() < SAME {
                self.take();
            }
            self.done = Some(self.time);
            let at = self.person.at(self.time);
            let ends: Vec<_> = (0..self.robots.len()).filter_map(|robot| self.place(robot)).chain([at]).collect();
            self.walked.iter_mut().zip(ends).for_each(|(way, end)| way.push(end));
            self.record(LogEntry::Done);
        }
    }

    /// Looks for contacts and lost connections.
    pub(super) fn look(&mut self) {
        let count = self.robots.len();
        let person = self.person.at(self.time);
        let mut bodies: Vec<_> = (self.problem.robots.iter().enumerate())
            .filter_map(|(robot, of)| Some(of.body.moved(self.place(robot)?)))
            .collect();
        bodies.push(self.problem.person.body.moved(person));
        for one in 0..=count {
            for other in one + 1..=count {
                let gap = bodies[one].gap(&bodies[other]);
                if other == count && self.robots[one].active {
                    self.counts.near(gap);
                }
                let (touch, before) = (gap < -1e-6, one * (count + 1) + other);
                // A lost robot that somebody walks into is an obstacle, and no contact of the team.
                let counts = self.robots[one].active || self.robots.get(other).is_some_and(|robot| robot.active);
                if touch && !self.touching[before] && counts {
                    self.counts.collisions += 1;
                    self.record(LogEntry::Touch { one, other });
                }
                self.touching[before] = touch;
            }
        }
        self.look_at_links();
        let apart = !self.is_connected();
        if apart && !self.apart {
            self.counts.disconnections += 1;
            self.record(LogEntry::Disconnected);
        } else if self.apart && !apart {
            self.record(LogEntry::Connected);
        }
        self.apart = apart;
    }

    /// True if the graph of the robots that take part and of the person is connected now.
    pub fn is_connected(&self) -> bool {
        let active = (0..self.robots.len()).filter(|robot| self.robots[*robot].active);
        let active = active.filter_map(|robot| Some(self.state_at(robot, self.time)?.at));
        let places: Vec<_> = active.chain([self.person.at(self.time)]).collect();
        if places.len() == 1 {
            return true;
        }
        let mut reached = vec![false; places.len()];
        reached[0] = true;
        let mut open = vec![0];
        while let Some(at) = open.pop() {
            for (other, place) in places.iter().enumerate() {
                if !reached[other] && self.problem.connection.contains(minus(*place, places[at]), 1e-6) {
                    reached[other] = true;
                    open.push(other);
                }
            }
        }
        reached.into_iter().all(|reached| reached)
    }
}
