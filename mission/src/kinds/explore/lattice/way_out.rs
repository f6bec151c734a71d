//! Ways out of a situation without a plan: motions on the lattice that give way to the person first, and meet the other
//! constraints in as many periods as they can.
//!
//! A robot that is driven by the distance alone flees ahead of the person, into a dead end if there is one. These
//! motions look ahead, on a lattice that is finer in space and time than that of plans, as there may be no plan because a robot cannot turn a corner
//! in time. They keep out of everywhere the person can walk; if no motion does, out of everywhere the person can walk at first and of the predicted
//! way then, and at last out of the predicted way.
//!
//! Robots in [safe states](super::safe) need none of this: a motion of the lattice of plans leads from safe states to safe ones, and is taken
//! if robots do not stand in each other's way.

use super::super::foresight::Foresight;
use super::super::polygon::{Convex, Point};
use super::super::problem::Problem;
use super::super::program::{Present, Trajectories};
use super::super::validate::validate;
use super::ground::{Ground, SHARE};
use super::{Deadline, Lattice, Motion, PENALTY, ROUNDS, exposed};

/// Periods of a way out in each period of a plan.
const FINER: usize = 2;
/// Periods that a way out looks ahead.
const PERIODS: usize = 12;

/// A range of connections (m) beyond every region.
const FAR: f64 = 1e6;

/// A way out.
#[derive(Clone, Debug, PartialEq)]
pub struct WayOut {
    /// Its period (s).
    pub period: f64,
    /// Inputs in each period, by robot.
    pub inputs: Vec<Vec<Point>>,
    /// In its first period all constraints but connections are met wherever the person walks, and then all robots can give way again.
    pub is_safe: bool,
}

/// Motions that give way to the person; none: there are none on the lattice, or the time is over.
pub fn way_out(
    problem: &Problem,
    ground: Option<&Ground>,
    present: &Present,
    foresight: &Foresight,
    until: &Deadline,
) -> Option<WayOut> {
    ground.and_then(|ground| safe_way_out(problem, ground, present, foresight, until)).or_else(|| {
        let finer = Problem { period: problem.period / FINER as f64, periods: PERIODS, ..problem.clone() };
        let foresight = refined(foresight, PERIODS, FINER)?;
        let ground = Ground::with_spacing(&finer, SHARE / FINER as f64)?;
        let mut lattice = Lattice::new(&finer, &ground, present, &foresight, until)?;
        let motions = [PERIODS, 1, 0].into_iter().find_map(|anywhere| {
            lattice.anywhere = anywhere;
            lattice.way_out()
        })?;
        let inputs = motions.into_iter().map(|motion| motion.inputs).collect();
        Some(WayOut { period: finer.period, inputs, is_safe: false })
    })
}

/// Motions on the lattice of plans that lead to safe states; none: there are none, nothing is known of safe states, or the time is over.
pub fn safe_way_out(
    problem: &Problem,
    ground: &Ground,
    present: &Present,
    foresight: &Foresight,
    until: &Deadline,
) -> Option<WayOut> {
    let mut active = (0..problem.robots.len()).filter(|robot| present.active[*robot]);
    if active.any(|robot| ground.safe.get(robot).is_none_or(Option::is_none)) {
        return None;
    }
    let foresight = refined(foresight, PERIODS / FINER, 1)?;
    let shorter = Problem { periods: PERIODS / FINER, ..problem.clone() };
    let mut lattice = Lattice::new(&shorter, ground, present, &foresight, until)?;
    lattice.anywhere = 1;
    // Connections give way.
    lattice.exposed = 1e2 * PENALTY;
    let trajectories = lattice.trajectories(&lattice.way_out()?);
    let first = Trajectories {
        states: trajectories.states.iter().map(|states| states[..2].to_vec()).collect(),
        inputs: trajectories.inputs.iter().map(|inputs| inputs[..1].to_vec()).collect(),
        visits: Vec::new(),
    };
    let begin = Foresight { positions: foresight.positions[..2].to_vec(), ..foresight.clone() };
    let apart = Problem { connection: Convex::rectangle([FAR, FAR])?, ..problem.clone() };
    let holds = exposed(problem, ground, present, &foresight, &trajectories) == 0
        && validate(&apart, present, &begin, &first).is_empty();
    holds.then_some(WayOut { period: problem.period, inputs: trajectories.inputs, is_safe: true })
}

/// The prediction at so many periods, of which there are `finer` in each of its own; the person stands at its end. None: it has no position.
fn refined(foresight: &Foresight, periods: usize, finer: usize) -> Option<Foresight> {
    let ways = &foresight.positions;
    let last = ways.len().checked_sub(1)?;
    let position = |index: usize| {
        let (from, to) = (ways[(index / finer).min(last)], ways[(index / finer + 1).min(last)]);
        let share = (index % finer) as f64 / finer as f64;
        [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]))
    };
    let positions = (0..=periods).map(position).collect();
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
