//! States of a plan from which a robot may not be able to give way.
//!
//! The end of the first period counts with each cell in which the person can be then, since the person may turn at once, and later states
//! with the predicted cells, since plans are made anew by then. States between those of the lattice are safe if a motion of two
//! periods leads to safe states of the lattice, clear of everywhere that the person can walk meanwhile.

use super::super::foresight::Foresight;
use super::super::motion::State;
use super::super::polygon::Point;
use super::super::problem::Problem;
use super::super::program::{Present, Trajectories};
use super::{Ground, LATER, Lattice, MARGIN, Motion};

/// Number of robots for which it is not known that they can give way after the first period of a plan.
pub fn exposed(
    problem: &Problem,
    ground: &Ground,
    present: &Present,
    foresight: &Foresight,
    of: &Trajectories,
) -> usize {
    let Some(from) = foresight.positions.first() else { return 0 };
    let active = (0..problem.robots.len()).filter(|robot| present.active[*robot]);
    let after = active.filter_map(|robot| Some((robot, *of.states.get(robot)?.get(1)?)));
    after.filter(|(robot, state)| !ground.can_give_way(problem, *robot, *state, *from)).count()
}

impl Ground {
    /// True if a robot in a state can always give way to the person, who was at a point a period before, or if nothing is known of the
    /// robot.
    pub fn can_give_way(&self, problem: &Problem, robot: usize, state: State, from: Point) -> bool {
        let Some(safe) = self.safe.get(robot).and_then(Option::as_ref) else { return true };
        let cells = safe.cells_after(from);
        match safe.state(self, state.at, state.velocity) {
            Some(state) => safe.holds(state, &cells),
            None => cells.iter().all(|cell| self.leads_to_safety(problem, robot, state, *cell)),
        }
    }

    /// True if a motion of two periods leads from a state, with the person in a cell, to a safe state of the lattice.
    fn leads_to_safety(&self, problem: &Problem, robot: usize, now: State, cell: usize) -> bool {
        let Some(safe) = &self.safe[robot] else { return true };
        let (who, time) = (&problem.robots[robot], problem.period);
        let discrete = who.over(time);
        let most = who.acceleration * time + 1e-9;
        let person = safe.middle(cell);
        let set = problem.person.body.sum(&who.body.reflected()).sum_with_points(&problem.strides(2.0 * time));
        let cells = safe.cells_within_two(cell);
        let clear = |points: &[Point]| {
            let parts = self.parts[robot].iter();
            let free = |at: &Point| {
                parts.clone().enumerate().fold(0_u64, |bits, (index, part)| {
                    let inside = part.faces().iter().all(|face| -face.outside(*at) >= MARGIN);
                    bits | u64::from(inside) << index
                })
            };
            let sides = |at: &Point| {
                set.faces().iter().enumerate().fold(0_u64, |bits, (index, face)| {
                    bits | u64::from(face.outside([at[0] - person[0], at[1] - person[1]]) >= MARGIN) << index
                })
            };
            points.iter().map(free).fold(u64::MAX, |a, b| a & b) != 0
                && points.iter().map(sides).fold(u64::MAX, |a, b| a & b) != 0
        };
        let velocities = safe.velocities();
        (0..self.len()).filter(|q| self.free[robot][*q] != 0).any(|q| {
            let at = self.point(q);
            let far = (0..2).any(|i| (at[i] - now.at[i]).abs() > 2.0 * who.speed * time);
            !far && (0..velocities.count()).any(|code| {
                let last = velocities.of(code);
                let half = if velocities.accelerates { 0.5 } else { 0.0 };
                let first =
                    [0, 1].map(|i| (at[i] - now.at[i]) / time - half * now.velocity[i] - (1.0 - half) * last[i]);
                let fits = (0..2).all(|i| {
                    first[i].abs() <= who.speed - 1e-9
                        && (first[i] - now.velocity[i]).abs() <= most
                        && (last[i] - first[i]).abs() <= most
                });
                if !fits || !safe.holds(q * velocities.count() + code, &cells) {
                    return false;
                }
                let input =
                    [0, 1].map(|i| (first[i] - discrete.velocity_velocity * now.velocity[i]) / discrete.velocity_input);
                let middle = discrete.step(now, input);
                clear(&[now.at, discrete.third(now), middle.at]) && clear(&[middle.at, discrete.third(middle), at])
            })
        })
    }
}

impl Lattice<'_> {
    /// By state of the lattice, true where a robot is exposed at the end of a period to the predicted person; none: nothing is known.
    pub(super) fn exposed_at(&self, robot: usize, step: usize) -> Option<Vec<bool>> {
        let safe = self.ground.safe.get(robot)?.as_ref()?;
        let cells = safe.cells(*self.foresight.positions.get(step)?);
        let states = 0..self.ground.len() * safe.velocities().count();
        Some(states.map(|state| !safe.holds(state, &cells)).collect())
    }

    /// True if a robot is exposed, in a state at the end of the first period. Only states of the lattice count as safe.
    pub(super) fn is_exposed(&self, robot: usize, end: State) -> bool {
        let Some(safe) = self.ground.safe.get(robot).and_then(Option::as_ref) else { return false };
        let cells = safe.cells_after(self.foresight.positions[0]);
        safe.state(self.ground, end.at, end.velocity).is_none_or(|state| !safe.holds(state, &cells))
    }

    /// Penalty for the exposed states of a motion.
    pub(super) fn exposure(&self, robot: usize, motion: &Motion) -> f64 {
        let Some(safe) = self.ground.safe.get(robot).and_then(Option::as_ref) else { return 0.0 };
        let later = motion.states.iter().enumerate().skip(2).filter(|(step, state)| {
            let cells = self.foresight.positions.get(*step).map(|at| safe.cells(*at)).unwrap_or_default();
            safe.state(self.ground, state.at, state.velocity).is_none_or(|state| !safe.holds(state, &cells))
        });
        let first = motion.states.get(1).is_some_and(|state| self.is_exposed(robot, *state));
        self.exposed * (LATER * later.count() as f64 + f64::from(u8::from(first)))
    }
}
