//! The least cost of a robot for taking a set of targets: the best of all orders, each target at the earliest end of a period that the order
//! leaves, and the effort of the visit that needs most.

use super::super::motion::State;
use super::super::objective::gain;
use super::super::polygon::Point;
use super::super::problem::Problem;
use super::effort::{Interval, braking, least_effort};
use super::windows::Windows;

/// Tours of one robot.
pub(super) struct Tours<'w> {
    problem: &'w Problem,
    windows: &'w Windows<'w>,
    robot: usize,
    now: State,
    /// Least sum of the absolute inputs along each axis, whatever it does.
    least: Point,
}

/// Least costs by the set of targets that are taken, as bits.
pub(super) struct Table {
    /// With any effort.
    pub any: Vec<f64>,
    /// With at least a given cost of the effort.
    pub with_effort: Vec<f64>,
}

/// Visits of one target.
struct Visits {
    target: usize,
    /// By period, true if the robot can be there at its end.
    can: Vec<bool>,
    /// By period, the least cost of the effort and the gain, of all visits at its end or later.
    later: Vec<f64>,
}

/// A part of a tour.
#[derive(Clone, Copy)]
struct Part {
    set: usize,
    last: Option<usize>,
    /// The period at whose end the last target is taken.
    step: usize,
    gains: f64,
    /// The largest sum by which effort and a later visit of one target cost more than its earliest visit gains.
    extra: f64,
}

impl<'w> Tours<'w> {
    pub fn new(problem: &'w Problem, windows: &'w Windows<'w>, robot: usize, now: State) -> Tours<'w> {
        let mut tours = Tours { problem, windows, robot, now, least: [0.0; 2] };
        let boxes: Vec<[Point; 2]> = (0..windows.periods).map(|step| windows.connected_box(robot, step)).collect();
        tours.least = [0, 1].map(|axis| {
            let staying = boxes.iter().enumerate().map(|(step, of)| tours.along(axis, step, *of));
            staying.fold(braking(problem.period, &problem.robots[robot], now, axis), f64::max)
        });
        tours
    }

    /// The least sum of the absolute inputs along an axis of a robot that is in a box at the end of a period.
    fn along(&self, axis: usize, step: usize, [low, high]: [Point; 2]) -> f64 {
        let there = Interval { low: low[axis], high: high[axis], step: step + 1 };
        least_effort(self.problem.period, &self.problem.robots[self.robot], self.now, axis, there).max(self.least[axis])
    }

    /// The least cost of the effort of being in a box at the end of a period.
    pub fn effort(&self, step: usize, there: [Point; 2]) -> f64 {
        self.problem.effort * (self.along(0, step, there) + self.along(1, step, there))
    }

    /// The least cost of the effort, whatever the robot does.
    pub fn idle(&self) -> f64 {
        self.problem.effort * (self.least[0] + self.least[1])
    }

    /// Least costs of all sets of these targets.
    pub fn table(&self, targets: &[usize], effort: f64) -> Table {
        let windows = self.windows.of(self.robot, targets);
        let visits = targets.iter().zip(windows).map(|(target, can)| {
            let shape = &self.problem.targets[*target].shape;
            let mut later = vec![f64::INFINITY; can.len() + 1];
            for step in (0..can.len()).rev() {
                let here = match can[step] {
                    true => self.effort(step, shape.bounds()) - self.gain(*target, step),
                    false => f64::INFINITY,
                };
                later[step] = later[step + 1].min(here);
            }
            Visits { target: *target, can, later }
        });
        let visits: Vec<Visits> = visits.collect();
        let sets = 1_usize << targets.len();
        let mut table = Table { any: vec![f64::INFINITY; sets], with_effort: vec![f64::INFINITY; sets] };
        let nothing = Part { set: 0, last: None, step: 0, gains: 0.0, extra: f64::NEG_INFINITY };
        self.go_on(&visits, effort, nothing, &mut table);
        table
    }

    /// Gain of a target that is taken at the end of this period.
    fn gain(&self, target: usize, step: usize) -> f64 {
        gain(&self.problem.targets[target], step + 1)
    }

    /// Notes the cost of a part of a tour, and of all that begin with it.
    fn go_on(&self, visits: &[Visits], effort: f64, part: Part, table: &mut Table) {
        let cost = |least: f64| part.extra.max(least) - part.gains;
        table.any[part.set] = table.any[part.set].min(cost(self.idle()));
        table.with_effort[part.set] = table.with_effort[part.set].min(cost(effort.max(self.idle())));
        for (bit, next) in visits.iter().enumerate().filter(|(bit, _)| part.set >> bit & 1 == 0) {
            let between = match part.last {
                None => Some(0),
                Some(last) => self.windows.between(self.robot, visits[last].target, next.target),
            };
            let Some(first) = between.map(|steps| part.step + steps) else { continue };
            let Some(step) = (first..next.can.len()).find(|step| next.can[*step]) else { continue };
            let gain = self.gain(next.target, step);
            let extra = part.extra.max(next.later[step] + gain);
            let set = part.set | 1 << bit;
            self.go_on(visits, effort, Part { set, last: Some(bit), step, gains: part.gains + gain, extra }, table);
        }
    }
}
