//! The validator of plans: it knows the problem and what a plan begins with, and nothing of the program that made the plan.
//!
//! Motions are integrated in small steps from the differential equations, and looked at in between: limits, distances, and
//! whether the graph of the team is connected, by a search over it.

use std::fmt;

use super::foresight::Foresight;
use super::motion::{Dynamics, State};
use super::polygon::{Convex, Point, minus};
use super::problem::Problem;
use super::program::{Present, Trajectories};

/// Looks in each period.
const LOOKS: usize = 10;
/// Steps of the integration between two looks.
const STEPS: usize = 20;
/// Tolerance of lengths (m), speeds (m/s) and accelerations (m/s^2).
const TOLERANCE: f64 = 1e-5;

/// A constraint that a plan breaks.
#[derive(Clone, Debug, PartialEq)]
pub struct Violation {
    /// Time from the begin of the plan (s).
    pub time: f64,
    /// The constraint, in a sentence.
    pub what: String,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "at {:.2} s {}", self.time, self.what)
    }
}

/// Returns the constraints that a plan breaks, each once with the first time.
pub fn validate(problem: &Problem, present: &Present, foresight: &Foresight, of: &Trajectories) -> Vec<Violation> {
    let mut judge = Judge { problem, present, found: Vec::new() };
    let periods = foresight.periods().min(problem.periods);
    if of.inputs.len() != problem.robots.len() || of.inputs.iter().any(|inputs| inputs.len() != periods) {
        judge.note(0.0, "there is an input for each robot and period".into());
        return judge.found;
    }
    let mut states = present.states.clone();
    for step in 0..periods {
        judge.inputs(step, of, &states);
        let from = foresight.positions[step];
        for look in 1..=LOOKS {
            let share = look as f64 / LOOKS as f64;
            let time = (step as f64 + share) * problem.period;
            for (robot, state) in states.iter_mut().enumerate().filter(|(robot, _)| present.active[*robot]) {
                let h = problem.period / (LOOKS * STEPS) as f64;
                *state = (0..STEPS).fold(*state, |state, _| {
                    integrate(problem.robots[robot].dynamics, state, of.inputs[robot][step], h)
                });
            }
            // The person may be anywhere within a stride of the position at the begin of the period.
            judge.look(time, &states, from, share * problem.period);
        }
        judge.visits(step + 1, of, &states);
    }
    judge.taken_once(of, foresight);
    judge.found
}

/// One step by the fourth-order Runge-Kutta rule, which is exact for polynomials.
fn integrate(dynamics: Dynamics, state: State, input: Point, h: f64) -> State {
    let mut next = state;
    for (i, input) in input.into_iter().enumerate() {
        let rate = |v: f64| match dynamics {
            Dynamics::Velocity => [input, 0.0],
            Dynamics::Acceleration => [v, input],
            Dynamics::Lag(constant) => [v, (input - v) / constant],
        };
        let v = state.velocity[i];
        let a = rate(v);
        let b = rate(v + 0.5 * h * a[1]);
        let c = rate(v + 0.5 * h * b[1]);
        let d = rate(v + h * c[1]);
        next.at[i] += h / 6.0 * (a[0] + 2.0 * b[0] + 2.0 * c[0] + d[0]);
        next.velocity[i] += h / 6.0 * (a[1] + 2.0 * b[1] + 2.0 * c[1] + d[1]);
        if dynamics == Dynamics::Velocity {
            next.velocity[i] = input;
        }
    }
    next
}

struct Judge<'p> {
    problem: &'p Problem,
    present: &'p Present,
    found: Vec<Violation>,
}

impl Judge<'_> {
    fn note(&mut self, time: f64, what: String) {
        if self.found.iter().all(|known| known.what != what) {
            self.found.push(Violation { time, what });
        }
    }

    fn name(&self, robot: usize) -> &str {
        &self.problem.robots[robot].name
    }

    /// (10f), (10g).
    fn inputs(&mut self, step: usize, of: &Trajectories, states: &[State]) {
        let time = step as f64 * self.problem.period;
        for (robot, who) in self.problem.robots.iter().enumerate().filter(|(robot, _)| self.present.active[*robot]) {
            let input = of.inputs[robot][step];
            for (input, v) in input.into_iter().zip(states[robot].velocity) {
                let acceleration = match who.dynamics {
                    Dynamics::Velocity => (input - v) / self.problem.period,
                    Dynamics::Acceleration => input,
                    Dynamics::Lag(constant) => (input - v) / constant,
                };
                if acceleration.abs() > who.acceleration * (1.0 + TOLERANCE) + TOLERANCE || !input.is_finite() {
                    self.note(time, format!("`{}` accelerates more than it can", self.name(robot)));
                }
            }
        }
    }

    fn look(&mut self, time: f64, states: &[State], person: Point, ahead: f64) {
        let problem = self.problem;
        let bodies: Vec<Convex> =
            problem.robots.iter().zip(states).map(|(robot, state)| robot.body.moved(state.at)).collect();
        let strides = problem.strides(ahead);
        let around = problem.person.body.sum_with_points(&strides).moved(person);
        for (robot, body) in bodies.iter().enumerate() {
            if self.present.active[robot] {
                self.alone(time, robot, body, &states[robot], &around);
            }
            for (other, its) in bodies.iter().enumerate().take(robot) {
                let moves = self.present.active[robot] || self.present.active[other];
                if moves && body.gap(its) < -TOLERANCE {
                    self.note(time, format!("`{}` and `{}` touch", self.name(other), self.name(robot)));
                }
            }
        }
        if !self.connected(states, person, &strides) {
            self.note(time, "the team is not connected".into());
        }
    }

    fn alone(&mut self, time: f64, robot: usize, body: &Convex, state: &State, around: &Convex) {
        let (problem, who) = (self.problem, &self.problem.robots[robot]);
        if body.corners().iter().any(|corner| !problem.area.contains(*corner, TOLERANCE)) {
            self.note(time, format!("`{}` leaves the area", self.name(robot)));
        }
        if state.velocity.iter().any(|v| v.abs() > who.speed + TOLERANCE) {
            self.note(time, format!("`{}` is faster than it can", self.name(robot)));
        }
        for obstacle in &problem.obstacles {
            if body.gap(&obstacle.shape) < -TOLERANCE {
                self.note(time, format!("`{}` is in the obstacle `{}`", self.name(robot), obstacle.name));
            }
        }
        if body.gap(around) < -TOLERANCE {
            self.note(time, format!("`{}` is where `{}` may walk", self.name(robot), problem.person.name));
        }
    }

    /// True if the graph of the robots that take part and the person is connected, wherever the person has walked.
    fn connected(&self, states: &[State], person: Point, strides: &[Point]) -> bool {
        let problem = self.problem;
        let active: Vec<usize> = (0..states.len()).filter(|robot| self.present.active[*robot]).collect();
        let Some(first) = active.first() else { return true };
        let within = |apart: Point| problem.connection.contains(apart, TOLERANCE);
        let mut reached = vec![*first];
        let mut next = 0;
        while next < reached.len() {
            let at = states[reached[next]].at;
            for robot in &active {
                if !reached.contains(robot) && within(minus(states[*robot].at, at)) {
                    reached.push(*robot);
                }
            }
            next += 1;
        }
        let sees = |robot: &usize| {
            strides.iter().all(|stride| {
                let at = [person[0] + stride[0], person[1] + stride[1]];
                within(minus(states[*robot].at, at))
            })
        };
        reached.len() == active.len() && reached.iter().any(sees)
    }

    /// (10i).
    fn visits(&mut self, step: usize, of: &Trajectories, states: &[State]) {
        let time = step as f64 * self.problem.period;
        for visit in of.visits.iter().filter(|visit| visit.step == step) {
            let target = &self.problem.targets[visit.target];
            if !target.shape.contains(states[visit.robot].at, TOLERANCE) || !self.present.active[visit.robot] {
                self.note(time, format!("`{}` is not in `{}`, which it takes", self.name(visit.robot), target.name));
            }
        }
    }

    /// (10j).
    fn taken_once(&mut self, of: &Trajectories, foresight: &Foresight) {
        for (index, target) in self.problem.targets.iter().enumerate() {
            let robots = of.visits.iter().filter(|visit| visit.target == index).count();
            let person = foresight.visits.iter().filter(|(target, _)| *target == index).count();
            if robots + person > 1 || (robots > 0 && !self.present.open[index]) {
                self.note(0.0, format!("`{}` is taken more than once", target.name));
            }
        }
    }
}
