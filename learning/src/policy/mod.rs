//! Policies: a network whose outputs become the probabilities of the five actions of a person in a world.
//!
//! π(a|s) = exp z_a(s) / Σ_b exp z_b(s), with the outputs z of the network for the feature maps (6) of s
//!
//! A policy remembers its world and its training, and both are in its file.

mod file;

pub use file::PolicyFileError;

use crate::grid::{Action, State, World};
use crate::network::{Network, Trace};
use serde::{Deserialize, Serialize};

/// Origin of a policy.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Training {
    /// Algorithm.
    pub method: Method,
    /// Seed.
    pub seed: u64,
    /// Steps of environments.
    pub steps: u64,
}

/// Algorithm that trained a policy.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// PPO on known rewards: the synthetic person of the paper's Appendix A.
    Ppo,
    /// Adversarial inverse reinforcement learning from demonstrations (Appendix B).
    Airl,
}

/// A policy for the states of a world.
#[derive(Clone, PartialEq, Debug)]
pub struct Policy {
    world: World,
    network: Network<f32>,
    training: Training,
}

/// Reason why a network is not a policy for a world, or a policy not one for another world.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum PolicyError {
    /// The network has another number of inputs.
    #[error("the network has {found} inputs; the feature maps of the world have {expected}")]
    Inputs {
        /// Inputs of the network.
        found: usize,
        /// Inputs of the world.
        expected: usize,
    },
    /// The network has another number of outputs.
    #[error("the network has {found} outputs; there are {} actions", Action::COUNT)]
    Outputs {
        /// Outputs of the network.
        found: usize,
    },
    /// A parameter is not finite.
    #[error("a parameter of the network is not finite")]
    NotFinite,
    /// The grids differ.
    #[error("the policy is for a grid of {} x {} cells, and this one has {} x {}", .policy.0, .policy.1, .world.0, .world.1)]
    Grid {
        /// Columns and rows of the policy.
        policy: (usize, usize),
        /// Columns and rows of the world.
        world: (usize, usize),
    },
    /// The types differ.
    #[error("the policy is for {policy} types of targets, and there are {world}")]
    Types {
        /// Types of the policy.
        policy: usize,
        /// Types of the world.
        world: usize,
    },
    /// An obstacle or exit is at another place.
    #[error("cell {cell} is {policy} in the world of the policy, and {world} in this one")]
    Cell {
        /// The first cell that differs.
        cell: u16,
        /// Its content in the world of the policy.
        policy: &'static str,
        /// Its content in the other world.
        world: &'static str,
    },
}

impl Policy {
    /// A policy from a network with one input for each cell of each feature map, and one output for each action.
    pub fn new(world: World, network: Network<f32>, training: Training) -> Result<Policy, PolicyError> {
        let (found, expected) = (network.shape().inputs(), world.inputs());
        if found != expected {
            return Err(PolicyError::Inputs { found, expected });
        }
        if network.shape().outputs() != Action::COUNT {
            return Err(PolicyError::Outputs { found: network.shape().outputs() });
        }
        if network.parameters().iter().any(|p| !p.is_finite()) {
            return Err(PolicyError::NotFinite);
        }
        Ok(Policy { world, network, training })
    }

    /// The world of the policy.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The network.
    pub fn network(&self) -> &Network<f32> {
        &self.network
    }

    /// Origin of the policy.
    pub fn training(&self) -> Training {
        self.training
    }

    /// Tests whether the policy is for this world: the same grid, types, obstacles and exits. Step limits may differ.
    pub fn check(&self, world: &World) -> Result<(), PolicyError> {
        let size = |world: &World| (world.columns(), world.rows());
        if size(&self.world) != size(world) {
            return Err(PolicyError::Grid { policy: size(&self.world), world: size(world) });
        }
        if self.world.types() != world.types() {
            return Err(PolicyError::Types { policy: self.world.types(), world: world.types() });
        }
        let content = |world: &World, cell| match (world.is_obstacle(cell), world.is_exit(cell)) {
            (true, _) => "an obstacle",
            (_, true) => "an exit",
            _ => "free",
        };
        let differs = (0..world.cells() as u16).find(|cell| content(&self.world, *cell) != content(world, *cell));
        differs.map_or(Ok(()), |cell| {
            Err(PolicyError::Cell { cell, policy: content(&self.world, cell), world: content(world, cell) })
        })
    }

    /// Probabilities of the actions in a state, by [`Action::index`]. The state must be one of the policy's world, as
    /// [`World::check`] tests.
    pub fn probabilities(&self, state: &State) -> [f64; Action::COUNT] {
        self.evaluator().probabilities(state)
    }

    /// The policy with storage of its own, for many states.
    pub fn evaluator(&self) -> Evaluator<'_> {
        Evaluator { policy: self, active: Vec::with_capacity(self.world.cells()), trace: self.network.trace() }
    }
}

/// A policy with storage for its evaluation, so that states after the first cost no allocation.
#[derive(Clone, Debug)]
pub struct Evaluator<'a> {
    policy: &'a Policy,
    active: Vec<u32>,
    trace: Trace<f32>,
}

impl Evaluator<'_> {
    /// Probabilities of the actions, like [`Policy::probabilities`].
    pub fn probabilities(&mut self, state: &State) -> [f64; Action::COUNT] {
        self.policy.world.features(state, &mut self.active);
        let outputs = self.policy.network.forward(&self.active, &mut self.trace);
        let greatest = outputs.iter().fold(f32::NEG_INFINITY, |a, b| a.max(*b));
        let mut probabilities = [0.0; Action::COUNT];
        for (p, z) in probabilities.iter_mut().zip(outputs) {
            *p = libm::exp(f64::from(z - greatest));
        }
        let sum: f64 = probabilities.iter().sum();
        probabilities.map(|p| p / sum)
    }
}

/// The most likely action (8); the first one of several.
pub fn most_likely(probabilities: &[f64; Action::COUNT]) -> Action {
    let better = |best: Action, action: Action| {
        if probabilities[action.index()] > probabilities[best.index()] { action } else { best }
    };
    Action::ALL.into_iter().fold(Action::North, better)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Target;
    use crate::network::{Activation, Shape};
    use crate::random::stream;

    pub(super) fn policy() -> Policy {
        let world = World::new(3, 2, &[1], &[2], 2).unwrap();
        let shape = Shape::new(world.inputs(), &[7], Action::COUNT, Activation::Relu).unwrap();
        let network = Network::random(shape, 5, 1.0, &mut stream(4, "test", &[]));
        Policy::new(world, network, Training { method: Method::Ppo, seed: 4, steps: 0 }).unwrap()
    }

    #[test]
    fn probabilities_are_the_softmax_of_the_outputs() {
        let policy = policy();
        let state = policy.world().state(4, &[Target { cell: 0, kind: 1 }]).unwrap();
        let probabilities = policy.probabilities(&state);
        let mut active = Vec::new();
        policy.world().features(&state, &mut active);
        let mut trace = policy.network().trace();
        let z: Vec<f64> = policy.network().forward(&active, &mut trace).iter().map(|z| f64::from(*z)).collect();
        let sum: f64 = z.iter().map(|z| z.exp()).sum();
        for (p, z) in probabilities.iter().zip(&z) {
            assert!((p - z.exp() / sum).abs() < 1e-7, "{probabilities:?}");
        }
        assert!((probabilities.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let best = most_likely(&probabilities);
        assert!(probabilities.iter().all(|p| *p <= probabilities[best.index()]));
    }

    #[test]
    fn policies_of_other_worlds_are_refused() {
        let policy = policy();
        assert_eq!(policy.check(policy.world()), Ok(()));
        let error = |world: World| policy.check(&world).unwrap_err().to_string();
        assert_eq!(
            error(World::new(4, 2, &[], &[2], 2).unwrap()),
            "the policy is for a grid of 3 x 2 cells, and this one has 4 x 2"
        );
        assert_eq!(
            error(World::new(3, 2, &[1], &[2], 1).unwrap()),
            "the policy is for 2 types of targets, and there are 1"
        );
        assert_eq!(
            error(World::new(3, 2, &[1], &[5], 2).unwrap()),
            "cell 2 is an exit in the world of the policy, and free in this one"
        );
        let other = World::new(3, 3, &[], &[2], 2).unwrap();
        let refused = Policy::new(other, policy.network().clone(), policy.training());
        assert_eq!(refused.unwrap_err(), PolicyError::Inputs { found: 60, expected: 95 });
    }
}
