//! Comparison of policies (the paper, Table B3): means over random environments, with bootstrap confidence intervals.
//!
//! [`accuracy`] compares predictions with what a person then did.
//!
//! All policies begin in the same environments, so that a difference between them is not one of the environments.

mod predictions;

pub use predictions::{Accuracy, accuracy};

use crate::demonstrations::episode;
use crate::grid::{Environments, Rewards};
use crate::policy::Policy;
use crate::random::{below, stream};

/// Resamples of a confidence interval.
const RESAMPLES: usize = 2000;

/// A mean with its confidence interval of 95 %.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Estimate {
    /// Mean.
    pub mean: f64,
    /// The 2.5 % quantile of the means of resamples.
    pub low: f64,
    /// The 97.5 % quantile.
    pub high: f64,
}

/// Figures of a policy.
#[derive(Clone, PartialEq, Debug)]
pub struct Figures {
    /// Steps of an episode.
    pub length: Estimate,
    /// Collected targets of an episode, by type.
    pub collected: Vec<Estimate>,
    /// Collisions of an episode.
    pub collisions: Estimate,
    /// Sum of the rewards of an episode, without discount.
    pub reward: Estimate,
    /// Share of the episodes that reach the step limit. Table B3 does not list it, and the return contains it.
    pub failures: Estimate,
}

/// Figures of one episode.
struct Episode {
    length: f64,
    collected: Vec<f64>,
    collisions: f64,
    reward: f64,
    failed: f64,
}

/// Evaluates a policy in `count` environments of this seed, at least one.
pub fn evaluate(policy: &Policy, environments: &Environments, rewards: &Rewards, count: usize, seed: u64) -> Figures {
    let episodes: Vec<Episode> = (0..count.max(1)).map(|i| one(policy, environments, rewards, seed, i)).collect();
    let estimate = |of: &dyn Fn(&Episode) -> f64| {
        let values: Vec<f64> = episodes.iter().map(of).collect();
        bootstrap(&values, seed)
    };
    let types = environments.world().types();
    Figures {
        length: estimate(&|e| e.length),
        collected: (0..types).map(|kind| estimate(&|e| e.collected[kind])).collect(),
        collisions: estimate(&|e| e.collisions),
        reward: estimate(&|e| e.reward),
        failures: estimate(&|e| e.failed),
    }
}

fn one(policy: &Policy, environments: &Environments, rewards: &Rewards, seed: u64, number: usize) -> Episode {
    let world = environments.world();
    let start = environments.draw(&mut stream(seed, "environment", &[number as u64]));
    let trajectory = episode(policy, start, &mut stream(seed, "actions", &[number as u64]));
    let mut of = Episode {
        length: trajectory.actions.len() as f64,
        collected: vec![0.0; world.types()],
        collisions: 0.0,
        reward: 0.0,
        failed: 0.0,
    };
    for (i, step) in trajectory.steps(world).enumerate() {
        let failed = i + 1 == world.step_limit() as usize && !step.step.arrived;
        of.reward += rewards.of(&step.step, failed);
        of.failed += f64::from(u8::from(failed));
        of.collisions += f64::from(u8::from(step.step.collision));
        if let Some(target) = step.step.collected {
            of.collected[usize::from(target.kind)] += 1.0;
        }
    }
    of
}

/// Mean of some values, and the quantiles of the means of resamples of them. Without values, all are NaN.
pub fn bootstrap(values: &[f64], seed: u64) -> Estimate {
    if values.is_empty() {
        return Estimate { mean: f64::NAN, low: f64::NAN, high: f64::NAN };
    }
    let n = values.len() as f64;
    let mut means: Vec<f64> = (0..RESAMPLES as u64)
        .map(|resample| {
            let mut generator = stream(seed, "bootstrap", &[resample]);
            (0..values.len()).map(|_| values[below(&mut generator, values.len())]).sum::<f64>() / n
        })
        .collect();
    means.sort_by(f64::total_cmp);
    let quantile = |p: f64| means[(p * (RESAMPLES - 1) as f64) as usize];
    Estimate { mean: values.iter().sum::<f64>() / n, low: quantile(0.025), high: quantile(0.975) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::{Action, World};
    use crate::network::{Activation, Network, Shape};
    use crate::policy::{Method, Training};

    /// The interval of a mean is about 1.96 standard errors on each side.
    #[test]
    fn intervals_agree_with_the_normal_distribution() {
        let values: Vec<f64> = (0..400).map(|i| f64::from(i % 4)).collect();
        let estimate = bootstrap(&values, 7);
        let error = 1.96 * (1.25_f64 / 400.0).sqrt();
        assert_eq!(estimate.mean, 1.5);
        assert!((estimate.low - (1.5 - error)).abs() < 0.02 && (estimate.high - (1.5 + error)).abs() < 0.02);
    }

    /// A policy that always goes east in a corridor: an episode is as long as the way, and one that goes west fails.
    #[test]
    fn figures_of_certain_policies_are_known() {
        let world = World::new(6, 1, &[], &[5], 1).unwrap().with_step_limit(9).unwrap();
        let environments = Environments::new(&world, 0, 0).unwrap();
        let rewards = Rewards { targets: vec![1.0], collision: -1.0, movement: -0.1, failure: -20.0 };
        let figures = |action: Action| {
            let shape = Shape::new(world.inputs(), &[], Action::COUNT, Activation::Relu).unwrap();
            let mut network = Network::zero(shape);
            let bias = network.parameters().len() - Action::COUNT;
            network.parameters_mut()[bias + action.index()] = 200.0;
            let training = Training { method: Method::Ppo, seed: 0, steps: 0 };
            let policy = Policy::new(world.clone(), network, training).unwrap();
            evaluate(&policy, &environments, &rewards, 500, 1)
        };
        let east = figures(Action::East);
        // Starts are uniform over five cells, at 1 to 5 steps.
        assert!((east.length.mean - 3.0).abs() < 0.25 && east.length.low < 3.0 && 3.0 < east.length.high);
        assert!((east.reward.mean + 0.1 * east.length.mean).abs() < 1e-9);
        assert_eq!((east.collisions.mean, east.failures.mean), (0.0, 0.0));
        let north = figures(Action::North);
        assert_eq!((north.length.mean, north.collisions.mean, north.failures.mean), (9.0, 9.0, 1.0));
        assert!((north.reward.mean + 9.0 * 1.1 + 20.0).abs() < 1e-9);
    }
}
