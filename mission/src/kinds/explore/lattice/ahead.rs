//! Limits of a robot that goes ahead: as if the others were wherever its connection needs them.
//!
//! A robot that goes ahead may be where it sees the person, or where another robot can stand that sees the person and that it sees. Positions of that
//! other robot are those of the lattice that are free, clear of the person and near enough to be reached by then. Each point of a motion is
//! looked at by itself, and robots do not stand in each other's way: the others are planned afterwards around what
//! the robot ahead does, and the plan counts only if it meets all constraints.

use super::super::polygon::{Point, dot, minus};
use super::limits::Limits;
use super::{Lattice, MARGIN};

impl<'p> Lattice<'p> {
    /// Limits of a robot that goes ahead, in a period.
    pub(super) fn limits_ahead<'l>(&'l self, robot: usize, step: usize) -> Limits<'l, 'p> {
        let relays = [0, 1, 2].map(|place| self.relays(robot, step, place));
        Limits::of(self, robot, step, Vec::new(), vec![false, true], Some(relays))
    }

    /// Positions of others that see the person, at one of the three points of a period.
    fn relays(&self, robot: usize, step: usize, place: usize) -> Vec<Point> {
        let problem = self.problem;
        let strides = self.strides(step);
        let others = (0..problem.robots.len()).filter(|other| *other != robot && self.present.active[*other]);
        // Positions are looked at for one of the others after the other.
        let mut seen = vec![false; self.ground.len()];
        for other in others {
            let (who, state) = (&problem.robots[other], self.present.states[other]);
            let share = self.grown(other)[place];
            let passed = problem.period * (step + usize::from(place > 0)) as f64;
            let gained = |axis: usize| state.velocity[axis].abs() * passed + 0.5 * who.acceleration * passed * passed;
            let reach = [0, 1].map(|axis| f64::min(who.speed * passed, gained(axis)) + MARGIN);
            let grown: Vec<Point> = strides.iter().map(|s| [s[0] * share, s[1] * share]).collect();
            let safe = problem.person.body.sum(&who.body.reflected()).sum_with_points(&grown);
            let fits = |at: &Point| {
                let near = minus(*at, self.person_at(step, share));
                let sees = problem.connection.faces().iter().all(|face| {
                    let far = strides.iter().map(|s| dot(face.normal, *s)).fold(0.0, f64::max);
                    face.outside(near) + share * far <= -MARGIN
                });
                (0..2).all(|axis| (at[axis] - state.at[axis]).abs() <= reach[axis])
                    && sees
                    && safe.outside(near) >= MARGIN
            };
            for (index, seen) in seen.iter_mut().enumerate().filter(|(_, seen)| !**seen) {
                *seen = self.ground.free[other][index] != 0 && fits(&self.ground.point(index));
            }
        }
        (0..seen.len()).filter(|index| seen[*index]).map(|index| self.ground.point(index)).collect()
    }
}
