//! Positions of robots: legs of their paths, and travel along them as planned.

use crate::kinds::schedule::problem::Problem;

use super::ScheduleExecution;
use super::settings::Travel;
use super::view::Stage;

/// A straight way at one speed, or standing at its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Leg {
    pub from: [f64; 2],
    pub to: [f64; 2],
    /// Start (s).
    pub start: f64,
    /// End (s).
    pub until: f64,
}

impl Leg {
    /// Standing here.
    pub fn rest(place: [f64; 2], time: f64) -> Leg {
        Leg { from: place, to: place, start: time, until: time }
    }

    /// Position at this time (m).
    pub fn at(&self, time: f64) -> [f64; 2] {
        let whole = self.until - self.start;
        let share = if whole > 0.0 { ((time - self.start) / whole).clamp(0.0, 1.0) } else { 1.0 };
        if share >= 1.0 {
            return self.to;
        }
        [0, 1].map(|axis| self.from[axis] + share * (self.to[axis] - self.from[axis]))
    }

    /// Velocity at this time (m/s).
    pub fn velocity(&self, time: f64) -> [f64; 2] {
        let whole = self.until - self.start;
        if whole > 0.0 && (self.start..self.until).contains(&time) {
            [0, 1].map(|axis| (self.to[axis] - self.from[axis]) / whole)
        } else {
            [0.0; 2]
        }
    }

    /// Its length (m).
    pub fn length(&self) -> f64 {
        distance(self.from, self.to)
    }
}

/// Between two places (m).
pub(super) fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    f64::hypot(a[0] - b[0], a[1] - b[1])
}

/// Waiting place of a robot at an agent (m). If distances come from a table, it divides the straight line in the ratio
/// of the waiting distance to the distance of the table.
pub(super) fn waiting_place(problem: &Problem, agent: usize, robot: usize) -> [f64; 2] {
    if let Some(place) = problem.waiting_place(agent, robot) {
        return place;
    }
    let (Some(who), Some(machine)) = (problem.agents.get(agent), problem.robots.get(robot)) else { return [0.0; 2] };
    let lengths = problem.lengths(agent, robot);
    let share = if lengths.depositing > 0.0 { (lengths.proximity / lengths.depositing).min(1.0) } else { 0.0 };
    [0, 1].map(|axis| who.place[axis] + share * (machine.depot[axis] - who.place[axis]))
}

impl ScheduleExecution {
    /// Position of a robot (m) at a time not before the last step.
    pub(super) fn position(&self, robot: usize, time: f64) -> [f64; 2] {
        let state = &self.world.robots[robot];
        match (&self.settings.travel, self.world.tick) {
            (Travel::Planned, _) => state.leg.at(time),
            (Travel::Bases(_), None) => state.position,
            (Travel::Bases(potentials), Some(tick)) => {
                let since = (time - self.begin - tick as f64 * potentials.step).clamp(0.0, potentials.step);
                [0, 1].map(|axis| state.position[axis] + since * state.velocity[axis])
            }
        }
    }

    /// Velocity of a robot (m/s).
    pub(super) fn velocity(&self, robot: usize, time: f64) -> [f64; 2] {
        match self.settings.travel {
            Travel::Planned => self.world.robots[robot].leg.velocity(time),
            Travel::Bases(_) => self.world.robots[robot].velocity,
        }
    }

    /// Earliest arrival of a robot at a place (s), at its greatest speed from its present position.
    pub(super) fn reach(&self, robot: usize, place: [f64; 2]) -> f64 {
        self.time + distance(self.position(robot, self.time), place) / self.problem.robots[robot].speed.high
    }

    /// Sends a robot from where it is to a place, to be there at a time.
    pub(super) fn send(&mut self, robot: usize, to: [f64; 2], until: f64) {
        let from = self.position(robot, self.time);
        let time = self.time;
        let state = &mut self.world.robots[robot];
        if self.settings.travel == Travel::Planned {
            state.gone += distance(state.leg.from, from);
        }
        state.leg = Leg { from, to, start: time, until: until.max(time) };
    }

    /// A way is given up where the robot is: what it took is counted.
    pub(super) fn count_partial_way(&mut self, robot: usize) {
        let here = self.position(robot, self.time);
        let time = self.time - self.world.robots[robot].since;
        let still = matches!(self.world.robots[robot].stage, Stage::Waiting | Stage::Serving);
        let leg = &mut self.world.robots[robot].leg;
        *leg = Leg { to: here, ..*leg };
        if !still {
            let gone = self.world.robots[robot].leg.length();
            self.count_way(robot, gone, time);
        }
        self.world.robots[robot].leg = Leg::rest(here, self.time);
    }

    /// A way has been gone in this time (s): what it took is counted.
    pub(super) fn count_way(&mut self, robot: usize, planned: f64, time: f64) {
        let table = !self.has_places();
        let state = &mut self.world.robots[robot];
        if self.settings.travel == Travel::Planned {
            state.gone += state.leg.length();
        }
        let length = if table { planned } else { state.gone };
        state.gone = 0.0;
        if length > 0.0 && time > 0.0 {
            state.travelled += length;
            state.energy += self.problem.robots[robot].energy.of_way(length, time);
        }
    }
}
