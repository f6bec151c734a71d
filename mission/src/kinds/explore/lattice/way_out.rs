//! Ways out of a situation without a plan: motions on the lattice that give way to the person first, and meet the other
//! constraints in as many periods as they can.
//!
//! A robot that is driven by the distance alone flees ahead of the person, into a dead end if there is one. These
//! motions look ahead, on a lattice that is finer in space and time than that of plans, as there may be no plan because a robot cannot turn a corner
//! in time. They keep out of everywhere the person can walk; if no motion does, out of everywhere the person can walk at first and of the predicted
//! way then, and at last out of the predicted way.

use super::super::foresight::Foresight;
use super::super::polygon::Point;
use super::super::problem::Problem;
use super::super::program::Present;
use super::{Lattice, Motion, ROUNDS};

/// Periods of a way out in each period of a plan.
const FINER: usize = 2;
/// Periods that a way out looks ahead.
const PERIODS: usize = 8;

/// A way out.
#[derive(Clone, Debug, PartialEq)]
pub struct WayOut {
    /// Its period (s).
    pub period: f64,
    /// Inputs in each period, by robot.
    pub inputs: Vec<Vec<Point>>,
}

/// Motions that give way to the person; none: there are none on the lattice.
pub fn way_out(problem: &Problem, present: &Present, foresight: &Foresight) -> Option<WayOut> {
    let finer = Problem { period: problem.period / FINER as f64, periods: PERIODS, ..problem.clone() };
    let foresight = refined(foresight)?;
    let mut lattice = Lattice::new(&finer, present, &foresight, 0.5 / FINER as f64)?;
    let motions = [PERIODS, 1, 0].into_iter().find_map(|anywhere| {
        lattice.anywhere = anywhere;
        lattice.way_out()
    })?;
    Some(WayOut { period: finer.period, inputs: motions.into_iter().map(|motion| motion.inputs).collect() })
}

/// The prediction at the periods of ways out; the person stands at its end. None: it has no position.
fn refined(foresight: &Foresight) -> Option<Foresight> {
    let ways = &foresight.positions;
    let last = ways.len().checked_sub(1)?;
    let position = |index: usize| {
        let (from, to) = (ways[(index / FINER).min(last)], ways[(index / FINER + 1).min(last)]);
        let share = (index % FINER) as f64 / FINER as f64;
        [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]))
    };
    let positions = (0..=PERIODS).map(position).collect();
    Some(Foresight { positions, visits: Vec::new(), arrives: false, spread: Vec::new() })
}

impl Lattice<'_> {
    /// Motions of all robots, in turns; none: a robot cannot give way.
    fn way_out(&self) -> Option<Vec<Motion>> {
        let robots = 0..self.problem.robots.len();
        let active: Vec<usize> = robots.clone().filter(|robot| self.present.active[*robot]).collect();
        let every: Vec<usize> = (0..self.problem.targets.len()).collect();
        let mut motions: Vec<Motion> = robots.map(|robot| self.begin(robot, None)).collect();
        for robot in active.iter().copied().cycle().take(ROUNDS * active.len()) {
            let limits = (0..self.periods).map(|step| self.limits(robot, step, &motions)).collect();
            motions[robot] = self.plan(robot, limits, &every)?.1;
        }
        Some(motions)
    }
}
