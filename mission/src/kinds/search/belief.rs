//! Beliefs about where hidden objects are, srs (22) to (28), and the reward that looking has.
//!
//! An object of a group is in one of the cells of its region, with the same prior probability in each. A cell that has been
//! looked at with an exposure `x`, the sum over the agents of their detection rates times the times for which it was in sight,
//! leaves an object there undetected with the probability `exp(-x)`, (23) and (24). The belief follows by (26). Plans see one
//! number for each cell, its weight: the sum over all groups of the belief times the worth of what is left to find.

use super::geometry::inside;
use super::problem::{Hidden, Problem};
use super::sight::Sight;

/// Returns the prior probability of each cell for an object of a group; all are zero if no cell is in its region.
pub fn prior(sight: &Sight, object: &Hidden) -> Vec<f64> {
    let is_in = |at: &[f64; 2]| object.region.is_empty() || inside(*at, &object.region);
    let count = sight.middles().iter().filter(|at| is_in(at)).count();
    let share = 1.0 / count.max(1) as f64;
    sight.middles().iter().map(|at| if is_in(at) { share } else { 0.0 }).collect()
}

/// Returns the belief, srs (26): the probability that an object of a group which nobody has detected is in each cell. `exposure` is
/// that of each cell; empty: nobody has looked.
pub fn posterior(sight: &Sight, object: &Hidden, exposure: &[f64]) -> Vec<f64> {
    let mut belief = prior(sight, object);
    for (mass, exposed) in belief.iter_mut().zip(exposure) {
        *mass *= (-exposed).exp();
    }
    let sum: f64 = belief.iter().sum();
    if sum > 0.0 {
        belief.iter_mut().for_each(|mass| *mass /= sum);
    }
    belief
}

/// Returns the weight of each cell: the expected worth of the objects in it that are left to find, at the begin of the mission.
pub fn weights(problem: &Problem, sight: &Sight) -> Vec<f64> {
    let mut weights = vec![0.0; sight.len()];
    for object in problem.objects.iter().filter(|object| object.left() > 0) {
        let worth = object.worth * object.left() as f64;
        let belief = posterior(sight, object, &problem.exposure);
        weights.iter_mut().zip(belief).for_each(|(weight, mass)| *weight += worth * mass);
    }
    weights
}

/// A part of a motion that has one cell as its seat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dwell {
    /// The seat.
    pub seat: u32,
    /// Shares of the motion at its begin and at its end.
    pub shares: [f64; 2],
}

/// Cuts a motion into steps by where it sees from. `seat` gives the seat at a share of the motion; parts of equal steps with the
/// same seat become one.
pub fn dwells(count: usize, seat: impl Fn(f64) -> Option<u32>) -> Vec<Dwell> {
    let mut all: Vec<Dwell> = Vec::new();
    for step in 0..count {
        let shares = [step as f64, (step + 1) as f64].map(|edge| edge / count as f64);
        let Some(seat) = seat(0.5 * (shares[0] + shares[1])) else { continue };
        match all.last_mut().filter(|last| last.seat == seat && last.shares[1] >= shares[0]) {
            Some(last) => last.shares[1] = shares[1],
            None => all.push(Dwell { seat, shares }),
        }
    }
    all
}

/// The expected worth that is undetected in each cell, while a team looks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Undetected {
    /// Weight of each cell that is left.
    pub weights: Vec<f64>,
    /// Their sum.
    pub sum: f64,
}

impl Undetected {
    /// The worth of a problem at its start; without hidden objects it is empty.
    pub fn of(problem: &Problem) -> Undetected {
        if !problem.is_searching() {
            return Undetected::default();
        }
        let weights = weights(problem, &problem.sight());
        let sum = weights.iter().sum();
        Undetected { weights, sum }
    }

    /// The weight that an agent detects who sees from a cell with an exposure.
    pub fn gain(&self, sight: &Sight, seat: u32, within: f64, exposure: f64) -> f64 {
        let seen: f64 = sight.seen(seat, within).iter().map(|(_, cell)| self.weights[*cell as usize]).sum();
        -(-exposure).exp_m1() * seen
    }

    /// An agent sees from a cell with an exposure: what it detects is taken away. Returns its weight.
    pub fn look(&mut self, sight: &Sight, seat: u32, within: f64, exposure: f64) -> f64 {
        let left = (-exposure).exp();
        let mut seen = 0.0;
        for (_, cell) in sight.seen(seat, within) {
            let weight = &mut self.weights[*cell as usize];
            seen += *weight;
            *weight *= left;
        }
        let detected = (1.0 - left) * seen;
        self.sum = (self.sum - detected).max(0.0);
        detected
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dwells_with_one_seat_are_joined() {
        let seat = |share: f64| {
            if share < 0.5 {
                Some(3)
            } else if share < 0.75 {
                None
            } else {
                Some(3)
            }
        };
        let all = dwells(8, seat);
        assert_eq!(all, [Dwell { seat: 3, shares: [0.0, 0.5] }, Dwell { seat: 3, shares: [0.75, 1.0] }]);
    }
}
