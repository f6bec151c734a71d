//! Plans on a lattice: good motions of the robots within milliseconds, from which the mixed-integer program starts, and which stand
//! if it finds nothing better in time.
//!
//! One robot at a time is planned exactly over positions half a cell apart and the velocities between them, with the motions of the
//! others as they are: a dynamic program over time, position, velocity and the targets taken. The robots take turns, so that one
//! that keeps the team connected frees another one to go farther. What a motion must not do is what the program forbids, with
//! the same three points of each period; constraints that involve others cost a penalty while those have not moved yet.

mod limits;
mod turns;

use super::foresight::Foresight;
use super::grid::Grid;
use super::motion::{Dynamics, State};
use super::polygon::{Convex, Point, plus};
use super::problem::Problem;
use super::program::{Present, Trajectories, Visit, free};

use self::limits::Bits;

/// Penalty of a period in which a constraint with others is not met.
const PENALTY: f64 = 1e3;
/// Targets of which one robot considers all subsets.
const MOST_TARGETS: usize = 4;
/// Rounds in which each robot is planned once.
const ROUNDS: usize = 3;
/// Distance (m) that is kept beyond each constraint: more than the program asks for.
const MARGIN: f64 = 3e-4;
/// The most parts of the ground that one mask holds.
const MOST_PARTS: usize = 64;

/// Plans on the lattice; none: a robot has dynamics that no lattice fits, or no motion meets all constraints.
pub fn construct(
    problem: &Problem,
    present: &Present,
    foresight: &Foresight,
    last: Option<&Trajectories>,
) -> Option<Trajectories> {
    let lattice = Lattice::new(problem, present, foresight)?;
    let count = problem.robots.len();
    let orders: Vec<Vec<usize>> =
        (0..count).map(|first| (0..count).map(|turn| (first + turn) % count).collect()).collect();
    let mut best: Option<(f64, Vec<Motion>)> = None;
    for order in orders {
        let mut motions: Vec<Motion> = (0..count).map(|robot| lattice.begin(robot, last)).collect();
        let mut cost = f64::INFINITY;
        for _ in 0..ROUNDS {
            let mut all = 0.0;
            for robot in order.iter().copied().filter(|robot| present.active[*robot]) {
                if let Some((own, motion)) = lattice.plan(robot, &motions) {
                    motions[robot] = motion;
                    all = own;
                }
            }
            // The penalties that the last robot sees are those of all: it sees the others as they are.
            if all >= cost - 1e-9 {
                break;
            }
            cost = all;
        }
        if lattice.is_sound(&motions) {
            let cost = lattice.cost(&motions);
            if best.as_ref().is_none_or(|(known, _)| cost < known - 1e-9) {
                best = Some((cost, motions));
            }
        }
    }
    best.map(|(_, motions)| lattice.trajectories(&motions))
}

/// The motion of a robot.
#[derive(Clone, Debug, PartialEq)]
struct Motion {
    /// States at the present and at the end of each period.
    states: Vec<State>,
    inputs: Vec<Point>,
    /// Targets with the periods at whose ends they are taken.
    visits: Vec<(usize, usize)>,
}

/// The three points that bound the motion of a robot in a period.
type Three = [Point; 3];

struct Lattice<'p> {
    problem: &'p Problem,
    present: &'p Present,
    foresight: &'p Foresight,
    periods: usize,
    /// Distance of positions (m), and step of velocities (m/s).
    spacing: f64,
    columns: usize,
    rows: usize,
    origin: Point,
    parts: Vec<Vec<Convex>>,
}

impl<'p> Lattice<'p> {
    fn new(problem: &'p Problem, present: &'p Present, foresight: &'p Foresight) -> Option<Lattice<'p>> {
        let lag = |robot: &super::problem::Robot| matches!(robot.dynamics, Dynamics::Lag(_));
        let periods = foresight.periods().min(problem.periods);
        if problem.robots.iter().any(lag) || periods < 3 {
            return None;
        }
        let grid = Grid::new(problem)?;
        let [low, _] = problem.area.bounds();
        let spacing = 0.5 * grid.cell;
        let parts: Vec<Vec<Convex>> = (0..problem.robots.len()).map(|robot| free(problem, robot)).collect();
        if parts.iter().any(|parts| parts.is_empty() || parts.len() > MOST_PARTS) {
            return None;
        }
        Some(Lattice {
            problem,
            present,
            foresight,
            periods,
            spacing,
            columns: 2 * grid.columns + 1,
            rows: 2 * grid.rows + 1,
            origin: low,
            parts,
        })
    }

    fn len(&self) -> usize {
        self.columns * self.rows
    }

    fn point(&self, index: usize) -> Point {
        let (column, row) = (index % self.columns, index / self.columns);
        plus(self.origin, [column as f64 * self.spacing, row as f64 * self.spacing])
    }

    /// The factor from steps of the lattice to velocities (m/s): an acceleration leads to the mean of both velocities.
    fn pace(&self, robot: usize) -> f64 {
        match self.problem.robots[robot].dynamics {
            Dynamics::Acceleration => 2.0 * self.spacing / self.problem.period,
            _ => self.spacing / self.problem.period,
        }
    }

    /// The motion with which the planning begins: the rest of the last plan, or braking.
    fn begin(&self, robot: usize, last: Option<&Trajectories>) -> Motion {
        let discrete = self.problem.robots[robot].over(self.problem.period);
        let now = self.present.states[robot];
        let of_last = last.and_then(|last| last.inputs.get(robot)).map_or(&[][..], Vec::as_slice);
        let (mut states, mut inputs) = (vec![now], Vec::new());
        for step in 0..self.periods {
            let state = states[step];
            let brakes = state.velocity.map(|v| -discrete.velocity_velocity * v / discrete.velocity_input);
            let input =
                if self.present.active[robot] { of_last.get(step).copied().unwrap_or(brakes) } else { [0.0; 2] };
            inputs.push(input);
            states.push(if self.present.active[robot] { discrete.step(state, input) } else { now });
        }
        let visits = last.iter().flat_map(|last| &last.visits);
        let own = visits.filter(|visit| visit.robot == robot && self.is_open(visit.target));
        Motion { states, inputs, visits: own.map(|visit| (visit.target, visit.step)).collect() }
    }

    /// True for a target that robots may take.
    fn is_open(&self, target: usize) -> bool {
        self.present.open[target] && self.foresight.visits.iter().all(|(of, _)| *of != target)
    }

    fn three(&self, robot: usize, motion: &Motion, step: usize) -> Three {
        let discrete = self.problem.robots[robot].over(self.problem.period);
        [motion.states[step].at, discrete.third(motion.states[step]), motion.states[step + 1].at]
    }

    /// True if the motions meet all constraints together.
    fn is_sound(&self, motions: &[Motion]) -> bool {
        (0..motions.len()).filter(|robot| self.present.active[*robot]).all(|robot| {
            (0..self.periods).all(|step| {
                let limits = self.limits(robot, step, motions);
                let three = self.three(robot, &motions[robot], step);
                let bits = (0..3).map(|place| limits.bits(three[place], place)).reduce(Bits::both);
                bits.is_some_and(|bits| bits.part != 0 && bits.person != 0 && limits.penalty(bits) == 0.0)
            })
        })
    }

    fn cost(&self, motions: &[Motion]) -> f64 {
        let effort: f64 = motions.iter().flat_map(|motion| motion.inputs.iter().flatten()).map(|u| u.abs()).sum();
        let visits = motions.iter().flat_map(|motion| &motion.visits);
        self.problem.effort * effort - visits.map(|(target, _)| self.problem.targets[*target].worth).sum::<f64>()
    }

    fn trajectories(&self, motions: &[Motion]) -> Trajectories {
        let visits = motions.iter().enumerate().flat_map(|(robot, motion)| {
            motion.visits.iter().map(move |(target, step)| Visit { robot, target: *target, step: *step })
        });
        Trajectories {
            states: motions.iter().map(|motion| motion.states.clone()).collect(),
            inputs: motions.iter().map(|motion| motion.inputs.clone()).collect(),
            visits: visits.collect(),
        }
    }
}
