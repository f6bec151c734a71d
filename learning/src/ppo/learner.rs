//! The update of actor and critic over the steps of an iteration.

use super::advantages::Advantages;
use super::{Rollout, Settings, Transition};
use crate::grid::{Action, World};
use crate::network::{Adam, Network, ShapeError, clip, log_softmax};
use crate::random::{shuffle, stream};

/// A network with its optimiser.
#[derive(Clone, PartialEq, Debug)]
pub struct Learner {
    /// The network.
    pub network: Network<f32>,
    /// Its optimiser.
    pub adam: Adam<f32>,
}

impl Learner {
    /// A learner before its first step.
    pub fn new(network: Network<f32>) -> Learner {
        let adam = Adam::new(network.parameters().len());
        Learner { network, adam }
    }

    /// Takes a step against a gradient, which is shortened to `most`.
    pub fn descend(&mut self, gradient: &mut [f32], rate: f64, most: f64) {
        clip(gradient, most);
        self.adam.step(self.network.parameters_mut(), gradient, rate);
    }
}

/// The two learners of PPO.
#[derive(Clone, PartialEq, Debug)]
pub struct ActorCritic {
    /// The policy: one output for each action.
    pub actor: Learner,
    /// The value of states: one output.
    pub critic: Learner,
}

/// Figures of an update.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct UpdateFigures {
    /// Mean entropy of the policy in the last epoch, in nats.
    pub entropy: f64,
    /// Share of the steps whose ratio was clipped in the last epoch.
    pub clipped: f64,
}

impl ActorCritic {
    /// Random networks.
    pub fn new(settings: &Settings, world: &World, seed: u64, name: &str) -> Result<ActorCritic, ShapeError> {
        // Inputs that are 1 at a time: the person, a few targets, obstacles and exits.
        let active = 3 + world.obstacles().count() + world.exits().count();
        let mut generator = stream(seed, name, &[]);
        let actor = settings.shape(world.inputs(), Action::COUNT)?;
        // Nearly uniform probabilities at first.
        let actor = Network::random(actor, active, 0.01, &mut generator);
        let critic = Network::random(settings.shape(world.inputs(), 1)?, active, 1.0, &mut generator);
        Ok(ActorCritic { actor: Learner::new(actor), critic: Learner::new(critic) })
    }

    /// Trains on the steps of a rollout, in `name`d random order.
    pub fn update(&mut self, batch: &Batch, of: &Update) -> UpdateFigures {
        let ActorCritic { actor, critic } = self;
        if of.threads < 2 {
            update_critic(critic, batch, of);
            return update_actor(actor, batch, of);
        }
        std::thread::scope(|scope| {
            let other = scope.spawn(|| update_critic(critic, batch, of));
            let figures = update_actor(actor, batch, of);
            other.join().expect("no panic");
            figures
        })
    }
}

/// The steps of an update, and their advantages and returns.
#[derive(Clone, Copy, Debug)]
pub struct Batch<'a> {
    /// The world of the states.
    pub world: &'a World,
    /// The steps.
    pub rollout: &'a Rollout,
    /// Advantages and returns, in the order of the steps.
    pub advantages: &'a Advantages,
}

/// Settings and random numbers of an update.
#[derive(Clone, Copy, Debug)]
pub struct Update<'a> {
    /// Settings.
    pub settings: &'a Settings,
    /// Seed of the training.
    pub seed: u64,
    /// Number of the iteration.
    pub iteration: u64,
    /// Threads that may be used; the result does not depend on them.
    pub threads: usize,
}

impl Update<'_> {
    /// Calls `minibatch` with the indices of each minibatch of each epoch.
    fn epochs(&self, name: &str, steps: usize, mut minibatch: impl FnMut(usize, &[usize])) {
        let mut order: Vec<usize> = (0..steps).collect();
        for epoch in 0..self.settings.epochs {
            let mut generator = stream(self.seed, name, &[self.iteration, epoch as u64]);
            shuffle(&mut generator, &mut order);
            order.chunks(self.settings.minibatch).for_each(|indices| minibatch(epoch, indices));
        }
    }
}

fn update_critic(critic: &mut Learner, batch: &Batch, of: &Update) {
    let transitions: Vec<&Transition> = batch.rollout.transitions().collect();
    let mut active = Vec::new();
    let mut trace = critic.network.trace();
    let mut gradient = vec![0.0; critic.network.parameters().len()];
    of.epochs("critic", transitions.len(), |_, indices| {
        gradient.fill(0.0);
        let weight = 1.0 / indices.len() as f32;
        for i in indices {
            batch.world.features(&transitions[*i].state, &mut active);
            let value = critic.network.forward(&active, &mut trace)[0];
            let error = weight * (value - batch.advantages.returns[*i]);
            critic.network.backward(&active, &mut trace, &[error], &mut gradient);
        }
        critic.descend(&mut gradient, of.settings.rate, of.settings.gradient);
    });
}

fn update_actor(actor: &mut Learner, batch: &Batch, of: &Update) -> UpdateFigures {
    let transitions: Vec<&Transition> = batch.rollout.transitions().collect();
    let mut active = Vec::new();
    let mut trace = actor.network.trace();
    let mut gradient = vec![0.0; actor.network.parameters().len()];
    let mut figures = UpdateFigures::default();
    of.epochs("actor", transitions.len(), |epoch, indices| {
        gradient.fill(0.0);
        let weight = 1.0 / indices.len() as f32;
        for i in indices {
            let transition = transitions[*i];
            batch.world.features(&transition.state, &mut active);
            let mut logarithms = [0.0; Action::COUNT];
            log_softmax(actor.network.forward(&active, &mut trace), &mut logarithms);
            let objective = Objective::of(&logarithms, transition, batch.advantages.advantages[*i], of.settings);
            let error = objective.gradient.map(|g| -weight * g);
            actor.network.backward(&active, &mut trace, &error, &mut gradient);
            if epoch + 1 == of.settings.epochs {
                figures.entropy += f64::from(objective.entropy) / transitions.len() as f64;
                figures.clipped += f64::from(u8::from(objective.clipped)) / transitions.len() as f64;
            }
        }
        actor.descend(&mut gradient, of.settings.rate, of.settings.gradient);
    });
    figures
}

/// The objective of the actor at one step.
#[derive(Clone, Copy, Debug)]
struct Objective {
    /// Its derivatives by the outputs of the network.
    gradient: [f32; Action::COUNT],
    #[cfg(test)]
    value: f32,
    entropy: f32,
    clipped: bool,
}

impl Objective {
    fn of(logarithms: &[f32; Action::COUNT], transition: &Transition, advantage: f32, of: &Settings) -> Objective {
        let (clip, weight) = (of.clip as f32, of.entropy as f32);
        let action = transition.action.index();
        let probabilities = logarithms.map(libm::expf);
        let ratio = libm::expf(logarithms[action] - transition.log_probability);
        let clipped = if advantage > 0.0 { ratio > 1.0 + clip } else { ratio < 1.0 - clip };
        // The derivative of ρ by ln π is ρ; behind the clip the objective is constant.
        let slope = if clipped { 0.0 } else { ratio * advantage };
        let entropy = -(0..Action::COUNT).map(|b| probabilities[b] * logarithms[b]).sum::<f32>();
        let mut gradient = [0.0; Action::COUNT];
        for (b, g) in gradient.iter_mut().enumerate() {
            let chosen = if b == action { 1.0 } else { 0.0 };
            *g = slope * (chosen - probabilities[b]) - weight * probabilities[b] * (logarithms[b] + entropy);
        }
        Objective {
            gradient,
            #[cfg(test)]
            value: (ratio * advantage).min(ratio.clamp(1.0 - clip, 1.0 + clip) * advantage) + weight * entropy,
            entropy,
            clipped,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Derivatives of the objective by the outputs, on both sides of the clip. The differences are of `f32`, whose rounding
    /// 6e-8 over a step of 1e-2 gives errors of some 1e-5.
    #[test]
    fn the_gradient_of_the_actor_agrees_with_central_differences() {
        let world = World::new(2, 1, &[], &[1], 1).unwrap();
        let state = world.state(0, &[]).unwrap();
        let settings = Settings { entropy: 0.3, ..Settings::paper() };
        let outputs = [0.3_f32, -0.4, 0.1, 1.2, -0.7];
        for (old, advantage) in [(-0.8, 1.5), (-0.8, -1.5), (-2.0, 1.5), (-2.0, -1.5), (-0.3, -1.5), (-0.3, 1.5)] {
            let transition = Transition { state, action: Action::East, next: state, log_probability: old, end: None };
            let at = |outputs: &[f32]| {
                let mut logarithms = [0.0; Action::COUNT];
                log_softmax(outputs, &mut logarithms);
                Objective::of(&logarithms, &transition, advantage, &settings)
            };
            let gradient = at(&outputs).gradient;
            for b in 0..Action::COUNT {
                let shifted = |by: f32| {
                    let mut outputs = outputs;
                    outputs[b] += by;
                    at(&outputs).value
                };
                let expected = (shifted(1e-2) - shifted(-1e-2)) / 2e-2;
                assert!((gradient[b] - expected).abs() < 3e-4, "{old} {advantage} {b}: {} {expected}", gradient[b]);
            }
        }
    }
}
