//! Figures of a training, for progress lines.

use crate::airl::DiscriminatorFigures;
use crate::grid::World;
use crate::ppo::{EpisodeEnd, Rollout, UpdateFigures};

/// Part of a training.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Stage {
    /// The synthetic person learns from rewards.
    Surrogate,
    /// Its policy, or that of a person, is recovered from demonstrations.
    Recovery,
}

/// Figures of the last iteration.
#[derive(Clone, PartialEq, Debug)]
pub struct Progress {
    /// Part that is at work.
    pub stage: Stage,
    /// Steps of this part so far.
    pub steps: u64,
    /// Steps of this part in all.
    pub of: u64,
    /// Means over the episodes that ended in the last iteration in which any did.
    pub episodes: EpisodeMeans,
    /// The update of the policy.
    pub update: UpdateFigures,
    /// The update of the discriminator.
    pub discriminator: Option<DiscriminatorFigures>,
}

/// Means over episodes.
#[derive(Clone, PartialEq, Debug)]
pub struct EpisodeMeans {
    /// Steps for each episode.
    pub length: f64,
    /// Collected targets for each episode, by type.
    pub collected: Vec<f64>,
    /// Collisions for each episode.
    pub collisions: f64,
    /// Share of the episodes that reached the step limit.
    pub failures: f64,
}

impl Progress {
    /// Before the first iteration of a part.
    pub(super) fn of(stage: Stage, steps: u64, world: &World) -> Progress {
        let collected = vec![0.0; world.types()];
        let episodes = EpisodeMeans { length: 0.0, collected, collisions: 0.0, failures: 0.0 };
        Progress { stage, steps: 0, of: steps, episodes, update: UpdateFigures::default(), discriminator: None }
    }

    /// Takes in an iteration. Steps count for the episodes that end in it, which is right in the mean.
    pub(super) fn iteration(&mut self, steps: u64, rollout: &Rollout, world: &World, update: UpdateFigures) {
        self.steps = steps;
        self.update = update;
        let ended = rollout.transitions().filter(|t| t.end.is_some()).count();
        if ended == 0 {
            return;
        }
        let mut sums =
            EpisodeMeans { length: 0.0, collected: vec![0.0; world.types()], collisions: 0.0, failures: 0.0 };
        for transition in rollout.transitions() {
            let step = world.step(&transition.state, transition.action);
            sums.length += 1.0;
            sums.collisions += f64::from(u8::from(step.collision));
            sums.failures += f64::from(u8::from(transition.end == Some(EpisodeEnd::Limit)));
            if let Some(target) = step.collected {
                sums.collected[usize::from(target.kind)] += 1.0;
            }
        }
        let n = ended as f64;
        self.episodes = EpisodeMeans {
            length: sums.length / n,
            collected: sums.collected.iter().map(|c| c / n).collect(),
            collisions: sums.collisions / n,
            failures: sums.failures / n,
        };
    }
}
