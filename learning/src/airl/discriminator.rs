//! The discriminator (7): networks of the reward g(s, a) and of the shaping h(s), and their logistic regression.

use super::Settings;
use crate::grid::{Action, State, World};
use crate::network::{Activation, Network, Shape, ShapeError, sigmoid, softplus};
use crate::ppo::Learner;
use crate::random::stream;

/// A step that is classified.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Example {
    /// State before.
    pub state: State,
    /// Action.
    pub action: Action,
    /// State after.
    pub next: State,
    /// `ln π(a|s)` of the present policy.
    pub log_probability: f32,
}

/// The networks g and h.
#[derive(Clone, PartialEq, Debug)]
pub struct Discriminator {
    /// g: one output for each action.
    pub reward: Learner,
    /// h: one output.
    pub shaping: Learner,
}

/// Figures of an update.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct DiscriminatorFigures {
    /// Mean of the two logistic losses; ln 2 if it cannot tell demonstrations from the policy.
    pub loss: f64,
    /// Share of the steps that are classified correctly.
    pub accuracy: f64,
}

impl Discriminator {
    /// Random networks.
    pub fn new(settings: &Settings, world: &World, seed: u64) -> Result<Discriminator, ShapeError> {
        let active = 3 + world.obstacles().count() + world.exits().count();
        let mut generator = stream(seed, "discriminator", &[]);
        let mut network = |outputs| {
            let shape = Shape::new(world.inputs(), &settings.hidden, outputs, Activation::Relu)?;
            Ok(Learner::new(Network::random(shape, active, 0.1, &mut generator)))
        };
        Ok(Discriminator { reward: network(Action::COUNT)?, shaping: network(1)? })
    }

    /// `f(s, a, s')` of each example.
    pub fn f<'a>(&'a self, world: &'a World, gamma: f64) -> impl FnMut(&State, Action, &State) -> f32 + use<'a> {
        let (mut active, mut trace) = (Vec::new(), self.reward.network.trace());
        let mut shaping_trace = self.shaping.network.trace();
        move |state, action, next| {
            world.features(state, &mut active);
            let g = self.reward.network.forward(&active, &mut trace)[action.index()];
            let h = self.shaping.network.forward(&active, &mut shaping_trace)[0];
            if world.is_exit(next.cell()) {
                return g - h;
            }
            world.features(next, &mut active);
            g + gamma as f32 * self.shaping.network.forward(&active, &mut shaping_trace)[0] - h
        }
    }

    /// Takes a step of the logistic regression on demonstrated steps and on steps of the policy.
    pub fn update(
        &mut self,
        world: &World,
        settings: &Settings,
        demonstrated: &[Example],
        generated: &[Example],
    ) -> DiscriminatorFigures {
        let gamma = settings.policy.gamma as f32;
        let (g, h) = (&self.reward.network, &self.shaping.network);
        let mut gradient_g = vec![0.0; g.parameters().len()];
        let mut gradient_h = vec![0.0; h.parameters().len()];
        let (mut active, mut active_next) = (Vec::new(), Vec::new());
        let (mut trace_g, mut trace_h, mut trace_next) = (g.trace(), h.trace(), h.trace());
        let mut figures = DiscriminatorFigures::default();
        for (examples, is_demonstrated) in [(demonstrated, true), (generated, false)] {
            let weight = 1.0 / examples.len() as f32;
            for example in examples {
                world.features(&example.state, &mut active);
                let reward = g.forward(&active, &mut trace_g)[example.action.index()];
                let before = h.forward(&active, &mut trace_h)[0];
                let arrives = world.is_exit(example.next.cell());
                let mut f = reward - before;
                if !arrives {
                    world.features(&example.next, &mut active_next);
                    f += gamma * h.forward(&active_next, &mut trace_next)[0];
                }
                let logit = f - example.log_probability;
                // Derivative of the loss by the logit, and so by f.
                let error = weight * (sigmoid(logit) - if is_demonstrated { 1.0 } else { 0.0 });
                let mut errors = [0.0; Action::COUNT];
                errors[example.action.index()] = error;
                g.backward(&active, &mut trace_g, &errors, &mut gradient_g);
                h.backward(&active, &mut trace_h, &[-error], &mut gradient_h);
                if !arrives {
                    h.backward(&active_next, &mut trace_next, &[gamma * error], &mut gradient_h);
                }
                let loss = if is_demonstrated { softplus(-logit) } else { softplus(logit) };
                figures.loss += f64::from(weight * loss) / 2.0;
                figures.accuracy += f64::from(u8::from((logit > 0.0) == is_demonstrated)) * f64::from(weight) / 2.0;
            }
        }
        self.reward.descend(&mut gradient_g, settings.rate, settings.policy.gradient);
        self.shaping.descend(&mut gradient_h, settings.rate, settings.policy.gradient);
        figures
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ppo;

    /// Without hidden layers, g is a table over the cells of an empty corridor. The regression of two known densities has its
    /// least loss at the logarithm of their ratio, whatever the policy says.
    #[test]
    fn the_logarithm_of_the_density_ratio_is_recovered() {
        let world = World::new(4, 1, &[], &[3], 1).unwrap();
        let policy = ppo::Settings { hidden: Vec::new(), gradient: 1e6, ..ppo::Settings::paper() };
        let settings = Settings { policy, hidden: Vec::new(), rate: 0.01, batch: 1, updates: 1 };
        let mut discriminator = Discriminator::new(&settings, &world, 3).unwrap();
        // Counts of (cell, action) in demonstrations and in steps of the policy, and what the policy says of them.
        let counts =
            [(0, Action::East, 8, 4), (0, Action::West, 1, 3), (1, Action::East, 6, 2), (1, Action::West, 1, 7)];
        let example = |cell: u16, action| {
            let state = world.state(cell, &[]).unwrap();
            let next = world.step(&state, action).state;
            Example { state, action, next, log_probability: if action == Action::East { -0.4 } else { -1.1 } }
        };
        let repeated = |of: fn(&(u16, Action, usize, usize)) -> usize| -> Vec<Example> {
            counts.iter().flat_map(|c| vec![example(c.0, c.1); of(c)]).collect()
        };
        let (demonstrated, generated) = (repeated(|c| c.2), repeated(|c| c.3));
        let mut figures = DiscriminatorFigures::default();
        for _ in 0..4000 {
            figures = discriminator.update(&world, &settings, &demonstrated, &generated);
        }
        let mut f = discriminator.f(&world, settings.policy.gamma);
        for (cell, action, demonstrations, steps) in counts {
            let example = example(cell, action);
            let logit = f(&example.state, action, &example.next) - example.log_probability;
            let expected = ((demonstrations as f64 / 16.0) / (steps as f64 / 16.0)).ln();
            assert!((f64::from(logit) - expected).abs() < 0.02, "{cell} {action:?}: {logit} {expected}");
        }
        // East in both cells is right 14 times of 16, west 10 of 16.
        assert!((figures.accuracy - 0.75).abs() < 1e-6, "{figures:?}");
    }

    /// The update follows the derivative of the loss: with a small rate the loss of the same examples falls.
    #[test]
    fn updates_reduce_the_loss_with_hidden_layers_and_shaping() {
        let world = World::new(4, 2, &[], &[3], 1).unwrap();
        let settings = Settings { hidden: vec![16], rate: 1e-3, ..Settings::paper() };
        let mut discriminator = Discriminator::new(&settings, &world, 1).unwrap();
        let example = |cell: u16, action| {
            let state = world.state(cell, &[]).unwrap();
            Example { state, action, next: world.step(&state, action).state, log_probability: -1.6 }
        };
        let demonstrated: Vec<_> = [0, 1, 2, 4].map(|cell| example(cell, Action::East)).to_vec();
        let generated: Vec<_> = [0, 1, 2, 4].map(|cell| example(cell, Action::North)).to_vec();
        let mut losses = Vec::new();
        for _ in 0..100 {
            losses.push(discriminator.update(&world, &settings, &demonstrated, &generated).loss);
        }
        assert!(losses.windows(2).all(|pair| pair[1] < pair[0] + 1e-6), "{losses:?}");
        assert!(losses[99] < 0.5 * losses[0]);
    }
}
