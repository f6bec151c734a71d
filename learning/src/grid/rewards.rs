//! Rewards of the synthetic person (the paper, Table A1).

use super::{Step, World};
use serde::{Deserialize, Serialize};

/// Rewards and penalties of steps.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct Rewards {
    /// For collecting a target, by its type: `R_A`, `R_B`.
    pub targets: Vec<f64>,
    /// `R_C`: for walking into a wall or an obstacle.
    pub collision: f64,
    /// `R_M`: for each step, collecting included. The paper's figures agree with that: 12.7 steps at -0.1 and the targets of
    /// Table B3 give the return 0.16, and failures of one episode in two hundred the rest to 0.05.
    pub movement: f64,
    /// `R_F`: for an episode that reaches the step limit before an exit.
    pub failure: f64,
}

/// Reason why rewards cannot be used.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum RewardError {
    /// Not one reward for each type.
    #[error("there are {rewards} rewards of targets, and the world has {types} types")]
    Types {
        /// Rewards.
        rewards: usize,
        /// Types.
        types: usize,
    },
    /// A number that is not finite.
    #[error("the reward of {0} is not finite")]
    NotFinite(&'static str),
    /// A target that costs, which the paper excludes.
    #[error("the reward of targets of type {kind} is {value}, and must be more than 0")]
    Target {
        /// The type.
        kind: usize,
        /// Its reward.
        value: f64,
    },
    /// A penalty that pays.
    #[error("the penalty of {what} is {value}, and must not be more than 0")]
    Penalty {
        /// Its purpose.
        what: &'static str,
        /// Its value.
        value: f64,
    },
}

impl Rewards {
    /// Table A1, for two types.
    pub fn paper() -> Rewards {
        Rewards { targets: vec![0.5, 1.0], collision: -1.0, movement: -0.1, failure: -20.0 }
    }

    /// Checks the rewards for a world: one positive reward for each type, penalties of 0 or less.
    pub fn check(&self, world: &World) -> Result<(), RewardError> {
        if self.targets.len() != world.types() {
            return Err(RewardError::Types { rewards: self.targets.len(), types: world.types() });
        }
        for (kind, value) in self.targets.iter().copied().enumerate() {
            if !value.is_finite() {
                return Err(RewardError::NotFinite("a target"));
            }
            if value <= 0.0 {
                return Err(RewardError::Target { kind, value });
            }
        }
        for (what, value) in [("collisions", self.collision), ("movement", self.movement), ("failure", self.failure)] {
            if !value.is_finite() {
                return Err(RewardError::NotFinite(what));
            }
            if value > 0.0 {
                return Err(RewardError::Penalty { what, value });
            }
        }
        Ok(())
    }

    /// Reward of a step; `failed` if it was the last one of the step limit and did not reach an exit.
    pub fn of(&self, step: &Step, failed: bool) -> f64 {
        let collected = step.collected.and_then(|target| self.targets.get(usize::from(target.kind)));
        self.movement
            + collected.copied().unwrap_or(0.0)
            + if step.collision { self.collision } else { 0.0 }
            + if failed { self.failure } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Action, Target};
    use super::*;

    #[test]
    fn steps_have_the_rewards_of_the_table() {
        let world = World::new(3, 2, &[1], &[2], 2).unwrap();
        let rewards = Rewards::paper();
        rewards.check(&world).unwrap();
        let start = world.state(3, &[Target { cell: 3, kind: 1 }]).unwrap();
        let of = |action, failed| rewards.of(&world.step(&start, action), failed);
        assert!((of(Action::Collect, false) - 0.9).abs() < 1e-12);
        assert!((of(Action::North, false) + 1.1).abs() < 1e-12);
        assert!((of(Action::East, true) + 20.1).abs() < 1e-12);
    }

    #[test]
    fn wrong_rewards_are_refused() {
        let world = World::new(3, 2, &[1], &[2], 2).unwrap();
        let wrong = |change: fn(&mut Rewards)| {
            let mut rewards = Rewards::paper();
            change(&mut rewards);
            rewards.check(&world).unwrap_err().to_string()
        };
        assert_eq!(wrong(|r| r.targets.truncate(1)), "there are 1 rewards of targets, and the world has 2 types");
        assert_eq!(wrong(|r| r.targets[1] = -1.0), "the reward of targets of type 1 is -1, and must be more than 0");
        assert_eq!(wrong(|r| r.movement = f64::NAN), "the reward of movement is not finite");
        assert_eq!(wrong(|r| r.failure = 3.0), "the penalty of failure is 3, and must not be more than 0");
    }
}
