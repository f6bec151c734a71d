//! Periods at whose ends a robot can be in a target: by its limits, the way around the obstacles, the connection of the team, and the
//! person.

use super::super::foresight::Foresight;
use super::super::motion::Dynamics;
use super::super::polygon::{Convex, Point};
use super::super::problem::{Problem, Robot};
use super::super::program::{Present, Reach, reach};
use super::ways::{SLACK, Ways};

/// Slack (m) of the length of a way, for the tolerances at its corners.
const WAY_SLACK: f64 = 10.0 * SLACK;

/// Limits of the robots in the periods of a plan.
pub(super) struct Windows<'p> {
    problem: &'p Problem,
    ways: &'p Ways,
    /// Robots that take part.
    pub active: Vec<usize>,
    pub periods: usize,
    /// By robot, boxes that hold it now and at the end of each period.
    pub boxes: Vec<Vec<Reach>>,
    /// By period, positions from which a robot sees the person at its end, wherever the person walks meanwhile.
    pub seen: Vec<Convex>,
    /// By robot and period, the positions at its end at which the robot is connected.
    connected: Vec<Vec<Vec<Convex>>>,
    /// By robot and period, the positions at its end at which the robot could touch the person.
    near: Vec<Vec<Convex>>,
}

impl<'p> Windows<'p> {
    /// The limits in a situation; none: nobody can see the person for a whole period, so that there is no plan, or there is no period.
    pub fn new(problem: &'p Problem, ways: &'p Ways, present: &Present, foresight: &Foresight) -> Option<Windows<'p>> {
        let periods = foresight.periods().min(problem.periods);
        let active: Vec<usize> = (0..problem.robots.len()).filter(|robot| present.active[*robot]).collect();
        let bounds = |who: &Robot| problem.area.difference(&who.body).map_or(problem.area.bounds(), |of| of.bounds());
        let boxes = problem.robots.iter().zip(&present.states);
        let boxes: Vec<Vec<Reach>> = boxes
            .map(|(who, now)| stopping(who, problem.period, reach(who, *now, problem.period, periods, bounds(who))))
            .collect();
        let strides = problem.strides(problem.period);
        let slack = Convex::rectangle([2.0 * SLACK, 2.0 * SLACK])?;
        let sees = problem.connection.difference(&Convex::hull(&strides)?)?.sum(&slack);
        let seen: Vec<Convex> = (0..periods).map(|step| sees.moved(foresight.positions[step])).collect();
        let mut windows =
            Windows { problem, ways, active, periods, boxes, seen, connected: Vec::new(), near: Vec::new() };
        for (robot, who) in problem.robots.iter().enumerate() {
            windows.connected.push((0..periods).map(|step| windows.connected_at(robot, step)).collect());
            let set = problem.person.body.sum(&who.body.reflected()).sum_with_points(&strides);
            windows.near.push((0..periods).map(|step| set.moved(foresight.positions[step])).collect());
        }
        Some(windows)
    }

    /// Positions at the end of a period at which a robot sees the person, or another one that may.
    fn connected_at(&self, robot: usize, step: usize) -> Vec<Convex> {
        let seen = &self.seen[step];
        let range = &self.problem.connection;
        let others = self.active.iter().filter(|other| **other != robot);
        let linked = match others.clone().count() {
            0 => Vec::new(),
            // The one between them is where it can be by then.
            1 => others.filter_map(|other| Some(within(seen, &self.boxes[*other][step + 1])?.sum(range))).collect(),
            many => vec![(0..many).fold(seen.clone(), |sum, _| sum.sum(range))],
        };
        [seen.clone()].into_iter().chain(linked).collect()
    }

    /// The box in which a robot is at the end of a period, whatever it does, by the connection.
    pub fn connected_box(&self, robot: usize, step: usize) -> [Point; 2] {
        let all: Vec<[Point; 2]> = self.connected[robot][step].iter().map(Convex::bounds).collect();
        let pick = |corner: usize, axis: usize, by: fn(f64, f64) -> f64, from: f64| {
            all.iter().map(|of| of[corner][axis]).fold(from, by)
        };
        [
            [0, 1].map(|axis| pick(0, axis, f64::min, f64::INFINITY)),
            [0, 1].map(|axis| pick(1, axis, f64::max, f64::NEG_INFINITY)),
        ]
    }

    /// By target and period, true if a robot can be in the target at the end of the period.
    pub fn of(&self, robot: usize, targets: &[usize]) -> Vec<Vec<bool>> {
        let who = &self.problem.robots[robot];
        let ways = self.ways.of(robot).to_targets(self.boxes[robot][0].low);
        let far = farthest(who, &self.boxes[robot][0], self.problem.period, self.periods);
        let can = |target: usize, step: usize| {
            let shape = &self.problem.targets[target].shape;
            let [low, high] = shape.bounds();
            let there = &self.boxes[robot][step + 1];
            let in_box = (0..2).all(|i| there.low[i] <= high[i] + SLACK && there.high[i] >= low[i] - SLACK);
            let is_near = || shape.corners().iter().all(|at| self.near[robot][step].outside(*at) < -SLACK);
            in_box
                && ways[target] <= far[step] + WAY_SLACK
                && self.connected[robot][step].iter().any(|area| area.gap(shape) <= SLACK)
                && !is_near()
        };
        targets.iter().map(|target| (0..self.periods).map(|step| can(*target, step)).collect()).collect()
    }

    /// The least number of periods between the visits of two targets by a robot; none: there is no way.
    pub fn between(&self, robot: usize, a: usize, b: usize) -> Option<usize> {
        let way = self.ways.of(robot).between(a, b) - WAY_SLACK;
        let stride = top_speed(&self.problem.robots[robot], &self.boxes[robot][0]) * self.problem.period;
        way.is_finite().then(|| (way / stride).ceil().max(0.0) as usize)
    }

    /// The parts of the free ground within the box in which a robot is at the end of the first period.
    pub fn first(&self, robot: usize) -> Vec<Convex> {
        let parts = self.ways.of(robot).parts.iter();
        parts.filter_map(|part| within(part, self.boxes[robot].get(1)?)).collect()
    }
}

/// The greatest speed along an axis that a robot has in a plan (m/s).
fn top_speed(who: &Robot, now: &Reach) -> f64 {
    who.speed.max(now.slow[0].abs()).max(now.slow[1].abs())
}

/// The greatest lengths of ways by the maximum norm up to the end of each period (m). The speed along an axis is at most what the acceleration
/// allows; between samples it is at most linear.
fn farthest(who: &Robot, now: &Reach, period: f64, periods: usize) -> Vec<f64> {
    let most = top_speed(who, now);
    let mut speed = now.slow[0].abs().max(now.slow[1].abs());
    let mut way = 0.0;
    let strides = (0..periods).map(|step| {
        let next = (speed + who.acceleration * period).min(most).min(stopped_from(who, period, periods - 1 - step));
        way += period
            * match who.dynamics {
                Dynamics::Acceleration => 0.5 * (speed + next),
                Dynamics::Velocity | Dynamics::Lag(_) => next,
            };
        speed = next;
        way
    });
    strides.collect()
}

/// The greatest speed (m/s) from which a robot stands after a number of periods.
fn stopped_from(who: &Robot, period: f64, periods: usize) -> f64 {
    match who.dynamics {
        Dynamics::Acceleration | Dynamics::Velocity => who.acceleration * period * periods as f64 + SLACK,
        Dynamics::Lag(_) => f64::INFINITY,
    }
}

/// The boxes of a robot that stands at the end of the last period. Between samples the velocity is linear, or that of the end.
fn stopping(who: &Robot, period: f64, mut boxes: Vec<Reach>) -> Vec<Reach> {
    let share = match who.dynamics {
        Dynamics::Acceleration => 0.5,
        Dynamics::Velocity => 0.0,
        Dynamics::Lag(_) => return boxes,
    };
    for step in 1..boxes.len() {
        let most = stopped_from(who, period, boxes.len() - 1 - step);
        let before = boxes[step - 1];
        let of = &mut boxes[step];
        for i in 0..2 {
            (of.slow[i], of.fast[i]) = (of.slow[i].max(-most), of.fast[i].min(most));
            let ahead = |first: f64, last: f64| period * (share * first + (1.0 - share) * last);
            of.low[i] = of.low[i].max(before.low[i] + ahead(before.slow[i], of.slow[i]));
            of.high[i] = of.high[i].min(before.high[i] + ahead(before.fast[i], of.fast[i]));
        }
    }
    boxes
}

/// The part of a polygon within a box; none: it has no inside.
fn within(of: &Convex, there: &Reach) -> Option<Convex> {
    let size = [0, 1].map(|i| there.high[i] - there.low[i] + 2.0 * SLACK);
    let middle = [0, 1].map(|i| 0.5 * (there.high[i] + there.low[i]));
    let whole = Convex::rectangle(size)?.moved(middle);
    whole.faces().iter().try_fold(of.clone(), |rest, face| rest.cut(face))
}
