//! Robots as kinematic bases that follow the plan and avoid each other, thesis 5.7.1.
//!
//! A base is a unicycle. The point `y = p + b (cos theta, sin theta)` ahead of its axle obeys `y' = u` for
//! `v = cos theta u_x + sin theta u_y`, `omega = (cos theta u_y - sin theta u_x) / b` (input/output linearisation), so that
//! where a robot is means where this point is. Every step
//!
//! ```text
//! u = y_d' + k (y_d - y) + sum over others nearer than d_th of s v_max (1/d - 1/d_th) / d^2 n + 1.5 of it n_left
//! ```
//!
//! with `n` away from the other. The last part is of the nearest one that lies ahead alone. It turns around it to the left of
//! `n`, which for a base that meets another one means to its own right: two of them head-on pass. All fades within a metre of
//! the target, where something may stand. A base that stands somewhere gives way and comes back; one that serves stands fast.
//! Of two that go to the same place the later one gives way like one that stands.
//!
//! Then `u` is cut so that `n u >= -phi (d - d_min) / 2` for each other base: what is left is never more than half of
//! the margin for each, so that no pair comes nearer than `d_min`, at any step up to `1 / phi`. What does not move, a base
//! that has broken down among it, leaves the whole margin. Who and what is near a base stands in [`surroundings`](super::surroundings).

use super::ScheduleExecution;
use super::motion::distance;
use super::settings::{Potentials, Travel};
use super::state::RobotState;
use super::surroundings::Other;
use super::view::Stage;

/// Ratio of the rotational to the repulsive potential.
const TURN: f64 = 1.5;
/// Within this distance of the target repulsion fades (m).
const FADE: f64 = 1.0;
/// Share of its greatest speed at which a base comes back to where it stands.
const BACK: f64 = 0.25;
/// A base slower than this stands (m/s).
const STILL: f64 = 1e-4;
/// Rounds in which commands are cut against all others.
const ROUNDS: usize = 3;

impl ScheduleExecution {
    /// Commands are given from now on, if a base is to go somewhere.
    pub(super) fn wake_bases(&mut self) {
        let Travel::Bases(potentials) = &self.settings.travel else { return };
        if self.world.tick.is_none() && self.world.robots.iter().any(|robot| goes(robot, self.time)) {
            self.world.tick = Some(((self.time - self.begin) / potentials.step).floor().max(0.0) as u64);
        }
    }

    /// One step: bases move by their commands, and get the next ones.
    pub(super) fn move_bases(&mut self) {
        let (Travel::Bases(potentials), Some(tick)) = (&self.settings.travel, self.world.tick) else { return };
        for state in &mut self.world.robots {
            let [x, y] = state.velocity;
            state.position[0] += potentials.step * x;
            state.position[1] += potentials.step * y;
            state.gone += potentials.step * f64::hypot(x, y);
            state.heading = turned(state.heading, state.velocity, potentials);
        }
        for robot in 0..self.world.robots.len() {
            self.world.robots[robot].velocity = self.command(robot, potentials);
        }
        let moves =
            |state: &RobotState| goes(state, self.time) || f64::hypot(state.velocity[0], state.velocity[1]) > STILL;
        if self.world.robots.iter().any(moves) {
            self.world.tick = Some(tick + 1);
        } else {
            self.world.robots.iter_mut().for_each(|state| state.velocity = [0.0; 2]);
            self.world.tick = None;
        }
    }
}

/// It is on a way.
fn goes(state: &RobotState, time: f64) -> bool {
    state.stage != Stage::Lost && state.leg.until > time
}

/// Heading of a base after a step. The angle between heading and motion obeys `phi' = -|u| / b sin phi`.
fn turned(heading: f64, velocity: [f64; 2], potentials: &Potentials) -> f64 {
    let speed = f64::hypot(velocity[0], velocity[1]);
    if speed == 0.0 {
        return heading;
    }
    let course = velocity[1].atan2(velocity[0]);
    let off = (heading - course).sin().atan2((heading - course).cos());
    course + 2.0 * ((off / 2.0).tan() * (-speed / potentials.ahead * potentials.step).exp()).atan()
}

/// It is on a way, or at its end.
fn is_moving(state: &RobotState) -> bool {
    matches!(state.stage, Stage::Going | Stage::Approaching | Stage::Returning | Stage::Recalled)
}

/// Another one goes to the same place and comes first: of the earlier operation, or of that the one that is listed first.
fn stands_back(robots: &[RobotState], robot: usize, potentials: &Potentials) -> bool {
    let rank = |index: usize| (robots[index].target.map_or(usize::MAX, |(_, operation)| operation), index);
    robots.iter().enumerate().any(|(index, other)| {
        let same = distance(other.leg.to, robots[robot].leg.to) < potentials.clearance;
        is_moving(other) && same && rank(index) < rank(robot)
    })
}

impl ScheduleExecution {
    fn command(&self, robot: usize, potentials: &Potentials) -> [f64; 2] {
        let (problem, robots, time) = (&self.problem, &self.world.robots, self.time);
        let state = &robots[robot];
        if matches!(state.stage, Stage::Lost | Stage::Serving) {
            return [0.0; 2];
        }
        let near = state.target.map(|(agent, _)| problem.approach(&problem.agents[agent], robot).0.high);
        let fastest = match (state.stage, near) {
            (Stage::Approaching, Some(near)) => near.max(state.approach),
            _ => problem.robots[robot].speed.high,
        };
        let stands = !is_moving(state) || stands_back(robots, robot, potentials);
        let (now, then) = (state.leg.at(time), state.leg.at(time + potentials.step));
        let mut u = [0, 1].map(|axis| {
            (then[axis] - now[axis]) / potentials.step + potentials.gain * (now[axis] - state.position[axis])
        });
        if stands {
            u = limited(u, BACK * fastest);
        }
        let wanted = u;
        let fade = if stands { 1.0 } else { (distance(state.position, state.leg.to) / FADE).min(1.0) };
        let others = self.others(robot, potentials);
        let mut nearest: Option<(&Other, f64)> = None;
        for other in others.iter().filter(|other| other.distance < potentials.threshold) {
            let d = other.distance.max(potentials.clearance / 2.0);
            let push = fade * potentials.strength * fastest * (1.0 / d - 1.0 / potentials.threshold).max(0.0) / (d * d);
            u = [u[0] + push * other.away[0], u[1] + push * other.away[1]];
            let ahead = !stands && dot(wanted, other.away) < 0.0;
            if ahead && nearest.is_none_or(|(least, _)| other.distance < least.distance) {
                nearest = Some((other, push));
            }
        }
        if let Some((Other { away: [x, y], .. }, push)) = nearest {
            u = [u[0] - TURN * push * y, u[1] + TURN * push * x];
        }
        guarded(limited(u, fastest), fastest, &others)
    }
}

/// The command nearest to `u`, or a shorter one, that uses up no margin too fast.
fn guarded(mut u: [f64; 2], fastest: f64, others: &[Other]) -> [f64; 2] {
    for _ in 0..ROUNDS {
        for other in others {
            let excess = -other.margin - dot(u, other.away);
            if excess > 0.0 {
                u = [u[0] + excess * other.away[0], u[1] + excess * other.away[1]];
            }
        }
    }
    let u = limited(u, fastest);
    // Standing still uses up nothing: shortened enough, every command keeps every margin.
    let shares = others.iter().map(|other| {
        let towards = -dot(u, other.away);
        if towards > other.margin { other.margin / towards } else { 1.0 }
    });
    let share = shares.fold(1.0, f64::min);
    [u[0] * share, u[1] * share]
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn limited(u: [f64; 2], most: f64) -> [f64; 2] {
    let size = f64::hypot(u[0], u[1]);
    if size > most { [u[0] * most / size, u[1] * most / size] } else { u }
}
