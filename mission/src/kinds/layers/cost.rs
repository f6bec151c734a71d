//! Cost of a layered plan, thesis (6.1) to (6.7), term by term: `J = beta sum omega_h + gamma sum e_r + eta mu`.

use serde::{Deserialize, Serialize};

use super::problem::{Body, Problem};
use super::scales::Scales;
use super::steps::Step;
use crate::numbers::Energy;

/// Cost of a layered plan. The three terms are as in the tables of the thesis: normalised, not weighted.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    /// `sum of omega_h` (6.2).
    pub workload: f64,
    /// `sum of e_r` (6.6).
    pub energy: f64,
    /// `mu` (6.1), measured from time 0.
    pub makespan: f64,
    /// `J` (6.7).
    total: f64,
}

impl Cost {
    /// Returns `J` (6.7): the weighted sum of the three terms.
    pub fn total(&self) -> f64 {
        self.total
    }
}

/// Computes the energy of a distance (m) at a speed (m/s), (6.4) (J): `varrho_1 d / v + varrho_2 d + varrho_3 v d`.
pub(super) fn energy_at(energy: &Energy, way: f64, speed: f64) -> f64 {
    if way == 0.0 { 0.0 } else { way * (energy.standby / speed + energy.friction + energy.drag * speed) }
}

/// Returns `value / scale`, or 0 if the scale is 0: then the value is 0 too.
pub(super) fn scaled(value: f64, scale: f64) -> f64 {
    if scale > 0.0 { value / scale } else { 0.0 }
}

/// Computes the cost of these steps.
pub fn cost(problem: &Problem, steps: &[Step]) -> Cost {
    cost_at(problem, &Scales::of(problem), steps)
}

/// Computes the cost of these steps with given scales.
pub(super) fn cost_at(problem: &Problem, scales: &Scales, steps: &[Step]) -> Cost {
    let mut cost = Cost::default();
    for step in steps {
        let Some(who) = problem.agents.get(step.agent) else { continue };
        let scale = scales.of_agent[step.agent];
        match who.body {
            Body::Robot { energy, .. } => {
                let way = problem.distance(step.agent, step.task, step.object);
                cost.energy += scaled(energy_at(&energy, way, step.speed), scale);
            }
            // (6.16): the duration of the task times the mass; 0 without an object.
            Body::Human { .. } => {
                let mass = problem.mass(step.object).unwrap_or(0.0);
                cost.workload += scaled((step.end - step.start) * mass, scale);
            }
        }
    }
    let end = steps.iter().map(|step| step.end).reduce(f64::max).unwrap_or(0.0);
    cost.makespan = scaled(end, scales.makespan);
    let weights = problem.weights;
    cost.total = weights.workload * cost.workload + weights.energy * cost.energy + weights.makespan * cost.makespan;
    cost
}
