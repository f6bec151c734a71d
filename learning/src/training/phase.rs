//! The parts that PPO on known rewards and AIRL share: networks, running episodes, and the way from a rollout to an update.

use crate::grid::{Environments, World};
use crate::network::ShapeError;
use crate::ppo::{
    ActorCritic, Batch, Draw, LimitValue, Rollout, Running, Settings, Update, UpdateFigures, advantages, draw,
};

/// Actor and critic in the middle of a training.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Phase {
    /// Name of its random numbers.
    pub name: &'static str,
    pub networks: ActorCritic,
    /// Running episodes; `None` before the first iteration.
    pub running: Vec<Option<Running>>,
    pub iteration: u64,
    pub steps: u64,
}

/// Steps of an iteration.
pub(super) struct Drawn {
    pub rollout: Rollout,
    iteration: u64,
}

impl Phase {
    pub fn new(settings: &Settings, world: &World, seed: u64, name: &'static str) -> Result<Phase, ShapeError> {
        let networks = ActorCritic::new(settings, world, seed, name)?;
        Ok(Phase { name, networks, running: vec![None; settings.environments], iteration: 0, steps: 0 })
    }

    /// Draws the steps of the next iteration.
    pub fn draw(&mut self, environments: &Environments, settings: &Settings, seed: u64, threads: usize) -> Drawn {
        self.iteration += 1;
        let (name, iteration, horizon) = (self.name, self.iteration, settings.horizon);
        let of = Draw { seed, name, iteration, horizon, threads };
        let rollout = draw(&self.networks.actor.network, environments, &self.running, &of);
        self.running = rollout.segments.iter().map(|segment| Some(segment.running)).collect();
        self.steps += rollout.transitions().count() as u64;
        Drawn { rollout, iteration }
    }

    /// Trains actor and critic on these rewards.
    #[expect(clippy::too_many_arguments, reason = "each is a setting of its own")]
    pub fn learn(
        &mut self,
        drawn: &Drawn,
        rewards: &[f32],
        world: &World,
        settings: &Settings,
        seed: u64,
        threads: usize,
        at_limit: LimitValue,
    ) -> UpdateFigures {
        let critic = &self.networks.critic.network;
        let of = advantages(&drawn.rollout, rewards, critic, world, settings.gamma, settings.lambda, at_limit);
        let batch = Batch { world, rollout: &drawn.rollout, advantages: &of };
        self.networks.update(&batch, &Update { settings, seed, iteration: drawn.iteration, threads })
    }
}
