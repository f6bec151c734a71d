//! The objective of a plan: (10a) of armchair without the rewards of the person, and two terms that the paper does not have.
//!
//! - A target is worth [`DELAY`] less with each period that passes before it is taken. Without this term a plan may take a target in
//!   the last moment before the person is expected at the exit, and loses it if the person is there earlier.
//! - A reserve of distances to the person that is missing at the end of the first period has a cost, [`RESERVE_COST`]. A person
//!   who turns around leaves the robots at least the reserve, with which they can follow or give way in the period after.

use super::foresight::Foresight;
use super::polygon::dot;
use super::problem::{Problem, Target};
use super::program::{Present, Trajectories};

/// Share of its worth that a target loses with each period.
pub const DELAY: f64 = 0.004;
/// Cost of a metre of reserve that is missing at the end of the first period.
pub const RESERVE_COST: f64 = 4.0;

/// The reserve (m) of distances from the person and of connections to the person at the end of the first period.
pub fn reserve(problem: &Problem) -> f64 {
    0.3 * problem.person.speed * problem.period
}

/// Gain of a robot that takes a target at the end of a period.
pub fn gain(target: &Target, step: usize) -> f64 {
    target.worth * (1.0 - DELAY * step as f64)
}

/// The terms of the objective; the plan with the least sum is the best one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Costs {
    /// The rewards of the targets that robots take; zero or less.
    pub rewards: f64,
    /// Cost of the periods before targets are taken.
    pub delay: f64,
    /// The 1-norm of all inputs, without its weight.
    pub inputs: f64,
    /// Weight of the inputs.
    pub weight: f64,
    /// Cost of what is missing of the reserve.
    pub reserve: f64,
}

impl Costs {
    /// Costs of a plan.
    pub fn of(problem: &Problem, present: &Present, foresight: &Foresight, of: &Trajectories) -> Costs {
        let worth = |target: usize| problem.targets[target].worth;
        Costs {
            rewards: 0.0 - of.visits.iter().map(|visit| worth(visit.target)).sum::<f64>(),
            delay: of.visits.iter().map(|visit| DELAY * visit.step as f64 * worth(visit.target)).sum(),
            inputs: of.inputs.iter().flatten().flatten().map(|u| u.abs()).sum(),
            weight: problem.effort,
            reserve: lacking(problem, present, foresight, of),
        }
    }

    /// Their sum.
    pub fn total(&self) -> f64 {
        self.rewards + self.delay + self.weight * self.inputs + self.reserve
    }
}

/// `(cost - bound) / |bound|`, zero or more.
pub fn gap(cost: f64, bound: f64) -> f64 {
    ((cost - bound) / bound.abs().max(1.0)).max(0.0)
}

/// Cost of the reserve that motions lack at the end of their first period.
fn lacking(problem: &Problem, present: &Present, foresight: &Foresight, of: &Trajectories) -> f64 {
    let (Some(from), reserve) = (foresight.positions.first(), reserve(problem)) else { return 0.0 };
    let strides = problem.strides(problem.period);
    let active = (0..problem.robots.len()).filter(|robot| present.active[*robot] && of.states[*robot].len() > 1);
    let (mut short, mut link) = (0.0, f64::INFINITY);
    for robot in active {
        let at = of.states[robot][1].at;
        let near = [at[0] - from[0], at[1] - from[1]];
        let safe = problem.person.body.sum(&problem.robots[robot].body.reflected()).sum_with_points(&strides);
        short += (reserve - safe.outside(near)).clamp(0.0, reserve);
        let left = problem.connection.faces().iter().map(|face| {
            let stride = strides.iter().map(|s| dot(face.normal, *s)).fold(0.0, f64::max);
            -face.outside(near) - stride
        });
        link = f64::min(link, (reserve - left.fold(f64::INFINITY, f64::min)).max(0.0));
    }
    // One connection to the person is enough; without any the plan is refused anyway.
    RESERVE_COST * (short + if link.is_finite() { link.min(reserve) } else { 0.0 })
}
