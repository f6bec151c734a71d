//! Plans on a lattice: good motions of the robots within milliseconds, from which the mixed-integer program starts, and which stand
//! if it finds nothing better in time.
//!
//! One robot at a time is planned exactly over positions half a cell apart and the velocities between them, with the motions of the
//! others as they are: a dynamic program over time, position, velocity and the targets taken. The robots take turns, so that one
//! that keeps the team connected frees another one to go farther. What a motion must not do is what the program forbids, with
//! the same three points of each period; constraints that involve others cost a penalty while those have not moved yet.
//!
//! Turns lead nowhere if nobody gains by the first move: a robot does not go where nobody keeps the connection yet, and nobody keeps one that
//! is not needed. Turns therefore also begin with a robot that goes [`ahead`], as if the others were wherever a connection needs them.

mod ahead;
mod deadline;
mod exposed;
mod ground;
mod limits;
mod safe;
mod turns;
mod velocities;
mod way_out;

use super::foresight::Foresight;
use super::motion::State;
use super::objective::{Costs, gain, gap};
use super::polygon::Point;
use super::problem::Problem;
use super::program::{Present, Trajectories, Visit};

pub use self::deadline::Deadline;
pub use self::exposed::exposed;
pub use self::ground::Ground;
use self::limits::Bits;
pub use self::way_out::{WayOut, safe_way_out, way_out};

/// Penalty of a period in which a constraint with others is not met.
const PENALTY: f64 = 1e3;
/// Penalty of a first period after which a robot may not be able to give way.
pub const EXPOSED: f64 = 50.0;
/// Share of it for a later state: plans are made anew by then.
const LATER: f64 = 0.02;
/// Targets of which one robot considers all subsets.
const MOST_TARGETS: usize = 4;
/// Rounds in which each robot is planned once.
const ROUNDS: usize = 3;
/// Distance (m) that is kept beyond each constraint: more than the program asks for.
const MARGIN: f64 = 3e-4;
/// The most parts of the ground that one mask holds.
const MOST_PARTS: usize = 64;

/// The end of the planning on the lattice.
#[derive(Clone, Copy, Debug)]
pub struct Aim<'a> {
    /// A lower bound on the cost of every plan: a plan within the gap of it is good enough.
    pub bound: f64,
    /// The end of the search; a turn that it interrupts does not count.
    pub until: &'a Deadline,
}

/// Plans on the lattice, until a plan is good enough or the time is over; none: no motion was found that meets all constraints.
pub fn construct(
    problem: &Problem,
    ground: &Ground,
    present: &Present,
    foresight: &Foresight,
    last: Option<&Trajectories>,
    aim: &Aim<'_>,
) -> Option<Trajectories> {
    let lattice = Lattice::new(problem, ground, present, foresight, aim.until)?;
    let count = problem.robots.len();
    let mut best: Option<(f64, Trajectories)> = None;
    let starts = (0..count).filter(|first| present.active[*first]);
    let starts: Vec<(bool, usize)> = starts.flat_map(|first| [(true, first), (false, first)]).collect();
    for (ahead, first) in starts {
        let Some(motions) = lattice.take_turns(first, ahead, last) else { continue };
        let trajectories = lattice.trajectories(&motions);
        let exposed = exposed(problem, ground, present, foresight, &trajectories);
        let cost = Costs::of(problem, present, foresight, &trajectories).total() + EXPOSED * exposed as f64;
        if best.as_ref().is_none_or(|(known, _)| cost < known - 1e-9) {
            best = Some((cost, trajectories));
        }
        if best.as_ref().is_some_and(|(cost, _)| gap(*cost, aim.bound) <= problem.planner.gap) {
            break;
        }
    }
    best.map(|(_, trajectories)| trajectories)
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
    ground: &'p Ground,
    present: &'p Present,
    foresight: &'p Foresight,
    periods: usize,
    /// Periods in which the person may walk anywhere; in later ones the person walks as predicted.
    anywhere: usize,
    /// Penalty of a first period after which a robot may not be able to give way.
    exposed: f64,
    until: &'p Deadline,
}

impl<'p> Lattice<'p> {
    /// The lattice of a situation; none: the prediction is too short.
    fn new(
        problem: &'p Problem,
        ground: &'p Ground,
        present: &'p Present,
        foresight: &'p Foresight,
        until: &'p Deadline,
    ) -> Option<Lattice<'p>> {
        let periods = foresight.periods().min(problem.periods);
        (periods >= 3).then_some(Lattice {
            problem,
            ground,
            present,
            foresight,
            periods,
            anywhere: periods,
            exposed: EXPOSED,
            until,
        })
    }

    /// Plans the robots in turns from the one with this index on; `ahead`: it plans as if the others kept every connection. None: the
    /// motions do not meet all constraints, or the time was over before the first turn.
    fn take_turns(&self, first: usize, ahead: bool, last: Option<&Trajectories>) -> Option<Vec<Motion>> {
        if self.until.is_over() {
            return None;
        }
        let count = self.problem.robots.len();
        let order: Vec<usize> =
            (0..count).map(|turn| (first + turn) % count).filter(|robot| self.present.active[*robot]).collect();
        let begin = last.filter(|_| !ahead);
        let mut motions: Vec<Motion> = (0..count).map(|robot| self.begin(robot, begin)).collect();
        let mut turns: Vec<usize> = order.iter().copied().cycle().take(ROUNDS * order.len()).collect();
        if ahead {
            if order.len() < 2 {
                return None;
            }
            let limits = (0..self.periods).map(|step| self.limits_ahead(first, step)).collect();
            motions[first] = self.plan(first, limits, &[])?.1;
            turns.remove(0);
        }
        let mut cost = f64::INFINITY;
        let mut since = 0;
        for robot in turns {
            let limits = (0..self.periods).map(|step| self.limits(robot, step, &motions)).collect();
            let taken = self.taken_by_others(robot, &motions);
            let Some((own, motion)) = self.plan(robot, limits, &taken) else {
                if self.until.is_over() {
                    break;
                }
                continue;
            };
            motions[robot] = motion;
            // The penalties that the last robot sees are those of all: it sees the others as they are.
            let all = own + self.effort_of_others(robot, &motions);
            since = if all < cost - 1e-9 { 0 } else { since + 1 };
            cost = all;
            if since >= order.len() {
                break;
            }
        }
        self.is_sound(&motions).then_some(motions)
    }

    /// Targets that the motions of the others take.
    fn taken_by_others(&self, robot: usize, motions: &[Motion]) -> Vec<usize> {
        let others = motions.iter().enumerate().filter(|(other, _)| *other != robot);
        others.flat_map(|(_, motion)| motion.visits.iter().map(|(target, _)| *target)).collect()
    }

    /// Cost of the motions of the others, without their penalties for what involves others.
    fn effort_of_others(&self, robot: usize, motions: &[Motion]) -> f64 {
        let others = motions.iter().enumerate().filter(|(other, _)| *other != robot);
        let cost = |motion: &Motion| {
            let inputs: f64 = motion.inputs.iter().flatten().map(|u| u.abs()).sum();
            let gains = motion.visits.iter().map(|(target, step)| gain(&self.problem.targets[*target], *step));
            self.problem.effort * inputs - gains.sum::<f64>()
        };
        others.map(|(other, motion)| cost(motion) + self.exposure(other, motion)).sum()
    }

    /// Vectors whose hull holds all by which the person can be off the [`person_at`](Self::person_at) at the end of a period (m).
    fn strides(&self, step: usize) -> Vec<Point> {
        if step < self.anywhere { self.problem.strides(self.problem.period).to_vec() } else { vec![[0.0; 2]] }
    }

    /// Position of the person in a period (m), after a share of it: where the period begins, or as predicted. Straight motion is one with three
    /// points too, so that differences of the points of a robot and of these bound the relative motion.
    fn person_at(&self, step: usize, share: f64) -> Point {
        let [from, to] = [self.foresight.positions[step], self.foresight.positions[step + 1]];
        let share = if step < self.anywhere { 0.0 } else { share };
        [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]))
    }

    /// Shares of a period that have passed at the three points of a motion.
    fn grown(&self, robot: usize) -> [f64; 3] {
        [0.0, self.problem.robots[robot].over(self.problem.period).middle / self.problem.period, 1.0]
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
