//! Settings of a whole training.

use crate::airl;
use crate::grid::{Environments, EnvironmentsError, RewardError, Rewards, World};
use crate::network::ShapeError;
use crate::ppo::{self, SettingsError};
use serde::{Deserialize, Serialize};

/// Settings of a training; [`Settings::paper`] has those of the paper.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Seed of all random numbers.
    pub seed: u64,
    /// Least number of targets of a random environment.
    pub least_targets: usize,
    /// Greatest number of targets.
    pub most_targets: usize,
    /// Rewards of the synthetic person.
    pub rewards: Rewards,
    /// PPO of the synthetic person.
    pub surrogate: ppo::Settings,
    /// Steps of the synthetic person.
    pub surrogate_steps: u64,
    /// Demonstrations that it gives.
    pub demonstrations: usize,
    /// Recovery of its policy.
    pub airl: airl::Settings,
    /// Steps of the recovery.
    pub recovery_steps: u64,
}

/// Reason why a training cannot begin or go on.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum TrainingError {
    /// The random environments.
    #[error(transparent)]
    Environments(#[from] EnvironmentsError),
    /// The rewards.
    #[error(transparent)]
    Rewards(#[from] RewardError),
    /// Settings of PPO or AIRL.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Impossible networks for this world.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// No steps.
    #[error("a training of 0 steps trains nothing")]
    NoSteps,
    /// No demonstrations.
    #[error("there are no demonstrations with actions")]
    NoDemonstrations,
    /// Parameters that are not finite.
    #[error("the training has diverged: after {0} steps a parameter is not finite; a lower learning rate may help")]
    Diverged(u64),
}

impl Settings {
    /// Appendices A and B: rewards of Table A1, 1.6e6 steps and 8000 demonstrations of the synthetic person, Table B2 and
    /// 3.5e6 steps of the recovery. The rate and the entropy of the synthetic person are not in the paper.
    pub fn paper() -> Settings {
        Settings {
            seed: 0,
            least_targets: 0,
            most_targets: 4,
            rewards: Rewards::paper(),
            surrogate: ppo::Settings { rate: 2e-3, entropy: 0.03, ..ppo::Settings::paper() },
            surrogate_steps: 1_600_000,
            demonstrations: 8000,
            airl: airl::Settings::paper(),
            recovery_steps: 3_500_000,
        }
    }

    /// Checks the settings for a world, and returns its random environments.
    pub fn check(&self, world: &World) -> Result<Environments, TrainingError> {
        let environments = Environments::new(world, self.least_targets, self.most_targets)?;
        self.rewards.check(world)?;
        self.surrogate.check()?;
        self.airl.check()?;
        if self.surrogate_steps == 0 || self.recovery_steps == 0 {
            return Err(TrainingError::NoSteps);
        }
        if self.demonstrations == 0 {
            return Err(TrainingError::NoDemonstrations);
        }
        Ok(environments)
    }
}
