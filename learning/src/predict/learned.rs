//! Predictions by a policy: Algorithm 1, with the spread of ways that are drawn from it.

use super::walk::{Choice, walk};
use super::{Limits, Observation, Prediction, Predictor, occupancy};
use crate::grid::{StateError, World};
use crate::policy::{Policy, most_likely};

/// A trained policy as a predictor.
#[derive(Clone, PartialEq, Debug)]
pub struct Learned {
    policy: Policy,
}

impl Learned {
    /// Predicts with this policy, in its world.
    pub fn new(policy: Policy) -> Learned {
        Learned { policy }
    }

    /// The policy.
    pub fn policy(&self) -> &Policy {
        &self.policy
    }
}

impl Predictor for Learned {
    fn name(&self) -> &'static str {
        "policy"
    }

    fn world(&self) -> &World {
        self.policy.world()
    }

    fn predict(&self, from: &Observation, limits: &Limits) -> Result<Prediction, StateError> {
        self.world().check(&from.state)?;
        let mut evaluator = self.policy.evaluator();
        let walk = walk(self.world(), from.state, limits.steps, |state| {
            let probabilities = evaluator.probabilities(state);
            let action = most_likely(&probabilities);
            Some(Choice { action, probability: probabilities[action.index()] })
        });
        let probabilities = |state: &_| evaluator.probabilities(state);
        let occupancy = occupancy::drawn(self.world(), &walk, limits.samples, limits.seed, probabilities);
        Ok(Prediction { steps: walk.steps, end: walk.end, occupancy })
    }
}

#[cfg(test)]
mod tests {
    use super::super::End;
    use super::*;
    use crate::grid::{Action, State, Target};
    use crate::network::{Activation, Network, Shape};
    use crate::policy::{Method, Training};

    /// A corridor of five cells with the exit at its right end, and a policy without hidden layers: its outputs are sums of
    /// weights, so that each probability can be said by hand.
    fn corridor(weights: impl Fn(&World, &mut [f32])) -> Learned {
        let world = World::new(5, 1, &[], &[4], 1).unwrap();
        let shape = Shape::new(world.inputs(), &[], Action::COUNT, Activation::Relu).unwrap();
        let mut network = Network::zero(shape);
        weights(&world, network.parameters_mut());
        let training = Training { method: Method::Airl, seed: 0, steps: 0 };
        Learned::new(Policy::new(world, network, training).unwrap())
    }

    fn from(predictor: &Learned, cell: u16, targets: &[Target]) -> Observation {
        Observation { state: predictor.world().state(cell, targets).unwrap(), heading: None }
    }

    /// East with e³ : 1 against each other action.
    fn eastwards(world: &World, weights: &mut [f32]) {
        for cell in 0..world.cells() {
            weights[cell * Action::COUNT + Action::East.index()] = 3.0;
        }
    }

    #[test]
    fn the_most_likely_way_leads_to_the_exit() {
        let predictor = corridor(eastwards);
        let prediction = predictor.predict(&from(&predictor, 1, &[]), &Limits::default()).unwrap();
        assert_eq!(prediction.end, End::Exit);
        assert_eq!(prediction.waypoints().collect::<Vec<_>>(), [1, 2, 3, 4]);
        let p = 3_f64.exp() / (3_f64.exp() + 4.0);
        for (n, step) in prediction.steps.iter().enumerate() {
            assert!((step.product - p.powi(n as i32)).abs() < 1e-6, "{step:?}");
            assert!((step.probability - if n < 3 { p } else { 1.0 }).abs() < 1e-6, "{step:?}");
        }
    }

    /// Ways with the distribution of the corridor, by its transition matrix instead of draws.
    #[test]
    fn occupancy_agrees_with_the_transition_matrix() {
        let predictor = corridor(eastwards);
        let samples = 20_000;
        let limits = Limits { samples, ..Limits::default() };
        let prediction = predictor.predict(&from(&predictor, 1, &[]), &limits).unwrap();
        let east = 3_f64.exp() / (3_f64.exp() + 4.0);
        let other = (1.0 - east) / 4.0;
        let mut p = [0.0, 1.0, 0.0, 0.0, 0.0];
        for (n, occupancy) in prediction.occupancy.iter().enumerate() {
            let mean: f64 = (0..5).map(|c| p[c] * c as f64).sum();
            let variance: f64 = (0..5).map(|c| p[c] * (c as f64 - mean).powi(2)).sum();
            // Four standard deviations of a share are at most 4 · √(0.25 / 20,000) = 0.0142.
            assert!((occupancy.share - p[n + 1]).abs() < 0.0142, "{n}: {occupancy:?} {p:?}");
            assert!((occupancy.mean[0] - mean).abs() < 0.04 && occupancy.mean[1] == 0.0);
            assert!((occupancy.covariance[0][0] - variance).abs() < 0.06, "{n}: {occupancy:?} {variance}");
            let mut next = [0.0; 5];
            next[4] = p[4];
            for c in 0..4 {
                next[c + 1] += p[c] * east;
                next[c.saturating_sub(1)] += p[c] * other;
                next[c] += p[c] * 3.0 * other;
            }
            p = next;
        }
        assert_eq!(prediction.occupancy.len(), prediction.steps.len());
    }

    #[test]
    fn ways_in_a_circle_are_cut_and_said() {
        // East in cell 1, west in cell 2.
        let circle = |_: &World, weights: &mut [f32]| {
            weights[Action::COUNT + Action::East.index()] = 1.0;
            weights[2 * Action::COUNT + Action::West.index()] = 1.0;
            weights[Action::East.index()] = 1.0;
        };
        let predictor = corridor(circle);
        let prediction = predictor.predict(&from(&predictor, 0, &[]), &Limits::default()).unwrap();
        assert_eq!(prediction.end, End::Loop { to: 1 });
        assert_eq!(prediction.waypoints().collect::<Vec<_>>(), [0, 1, 2]);
        assert!(!prediction.reaches_exit());
        // Collecting where nothing is left repeats the state at once.
        let idle = corridor(|_, weights| weights[Action::Collect.index()] = 1.0);
        let prediction = idle.predict(&from(&idle, 0, &[]), &Limits::default()).unwrap();
        assert_eq!((prediction.end, prediction.steps.len()), (End::Loop { to: 0 }, 1));
    }

    #[test]
    fn long_ways_are_cut_and_said() {
        let predictor = corridor(eastwards);
        let limits = Limits { steps: 2, ..Limits::default() };
        let prediction = predictor.predict(&from(&predictor, 0, &[]), &limits).unwrap();
        assert_eq!((prediction.end, prediction.steps.len()), (End::Limit, 3));
        assert_eq!(prediction.occupancy.len(), 3);
    }

    #[test]
    fn targets_on_the_way_are_collected_or_neglected() {
        // Collects the target of cell 2, which is worth more than going on.
        let predictor = corridor(|world, weights| {
            eastwards(world, weights);
            weights[(world.cells() + 2) * Action::COUNT + Action::Collect.index()] = 5.0;
            weights[(world.cells() + 2) * Action::COUNT + Action::East.index()] = -1.0;
            weights[Action::COUNT + Action::East.index()] = 9.0;
        });
        let (here, there) = (Target { cell: 2, kind: 0 }, Target { cell: 3, kind: 0 });
        let prediction = predictor.predict(&from(&predictor, 1, &[there, here]), &Limits::default()).unwrap();
        let collected: Vec<_> = prediction.collected().map(|c| (c.step, c.target)).collect();
        assert_eq!(collected, [(2, here)]);
        assert_eq!(prediction.last().targets(), [there]);
        assert_eq!(prediction.end, End::Exit);
    }

    #[test]
    fn states_of_other_worlds_are_refused() {
        let predictor = corridor(eastwards);
        let other = World::new(9, 9, &[], &[0], 1).unwrap();
        let state: State = other.state(80, &[]).unwrap();
        let refused = predictor.predict(&Observation { state, heading: None }, &Limits::default());
        assert_eq!(refused.unwrap_err(), StateError::Outside { cell: 80, cells: 5 });
    }

    #[test]
    fn the_same_seed_gives_the_same_prediction() {
        let predictor = corridor(eastwards);
        let observation = from(&predictor, 0, &[]);
        let of = |seed| predictor.predict(&observation, &Limits { seed, ..Limits::default() }).unwrap();
        assert_eq!(of(3), of(3));
        assert_ne!(of(3).occupancy, of(4).occupancy);
    }
}
