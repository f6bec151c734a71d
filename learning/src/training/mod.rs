//! The whole training (the paper, Appendices A and B): a synthetic person by PPO on known rewards, demonstrations drawn from
//! it, and its policy recovered from them by adversarial inverse reinforcement learning. With demonstrations of a person,
//! only the last part.
//!
//! A run goes on step by step, and can be written and read between two steps: the same settings give the same bits, however
//! often it was interrupted, and with one thread or two.

mod checkpoint;
mod phase;
mod progress;
mod settings;

pub use checkpoint::CheckpointError;
pub use progress::{EpisodeMeans, Progress, Stage};
pub use settings::{Settings, TrainingError};

use crate::airl::{Discriminator, Example};
use crate::demonstrations::{Demonstrated, Trajectory, generate};
use crate::grid::{Action, Environments, World};
use crate::network::log_softmax;
use crate::policy::{Method, Policy, Training};
use crate::ppo::{LimitValue, Rollout};
use crate::random::{below, stream};
use phase::{Drawn, Phase};

/// A training that goes on.
#[derive(Clone, Debug)]
pub struct Run {
    settings: Settings,
    environments: Environments,
    threads: usize,
    /// The synthetic person; `None` before it is trained, and for demonstrations from elsewhere.
    surrogate: Option<Policy>,
    demonstrations: Vec<Trajectory>,
    /// The steps of the demonstrations.
    demonstrated: Vec<Demonstrated>,
    part: Part,
    progress: Progress,
}

/// The part that is at work.
#[derive(Clone, Debug)]
enum Part {
    Surrogate(Phase),
    Recovery(Phase, Box<Discriminator>),
}

impl Run {
    /// A run that begins with the synthetic person.
    pub fn new(world: &World, settings: Settings) -> Result<Run, TrainingError> {
        let environments = settings.check(world)?;
        let phase = Phase::new(&settings.surrogate, world, settings.seed, "surrogate")?;
        Ok(Run {
            progress: Progress::of(Stage::Surrogate, settings.surrogate_steps, world),
            settings,
            environments,
            threads: 1,
            surrogate: None,
            demonstrations: Vec::new(),
            demonstrated: Vec::new(),
            part: Part::Surrogate(phase),
        })
    }

    /// A run that recovers a policy from demonstrations, at least one, in the world that they were read for.
    pub fn from_demonstrations(
        world: &World,
        settings: Settings,
        demonstrations: Vec<Trajectory>,
    ) -> Result<Run, TrainingError> {
        let mut run = Run::new(world, settings)?;
        if demonstrations.iter().all(|trajectory| trajectory.actions.is_empty()) {
            return Err(TrainingError::NoDemonstrations);
        }
        run.recover(demonstrations)?;
        Ok(run)
    }

    /// The same run with at most this number of threads, of which it uses two. The result does not depend on it.
    pub fn with_threads(mut self, threads: usize) -> Run {
        self.threads = threads;
        self
    }

    /// Settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The world.
    pub fn world(&self) -> &World {
        self.environments.world()
    }

    /// The synthetic person, once it is trained.
    pub fn surrogate(&self) -> Option<&Policy> {
        self.surrogate.as_ref()
    }

    /// The demonstrations, once they are there.
    pub fn demonstrations(&self) -> &[Trajectory] {
        &self.demonstrations
    }

    /// Figures of the last iteration.
    pub fn progress(&self) -> &Progress {
        &self.progress
    }

    /// Tests whether all parts are done.
    pub fn is_done(&self) -> bool {
        matches!(&self.part, Part::Recovery(phase, _) if phase.steps >= self.settings.recovery_steps)
    }

    /// The policy that is recovered from the demonstrations, as far as it is trained; `None` before this part begins.
    pub fn recovered(&self) -> Option<Policy> {
        match &self.part {
            Part::Surrogate(_) => None,
            Part::Recovery(phase, _) => Some(self.policy(phase, Method::Airl)),
        }
    }

    fn policy(&self, phase: &Phase, method: Method) -> Policy {
        let training = Training { method, seed: self.settings.seed, steps: phase.steps };
        let network = phase.networks.actor.network.clone();
        Policy::new(self.world().clone(), network, training).expect("the networks have the shape of the world")
    }

    /// Goes on until `budget` more steps of environments were taken, in whole iterations of the settings' length, or the
    /// run is done.
    pub fn step(&mut self, budget: u64) -> Result<&Progress, TrainingError> {
        let mut taken = 0;
        while taken < budget && !self.is_done() {
            taken += self.iterate()?;
        }
        Ok(&self.progress)
    }

    /// One iteration; returns its steps.
    fn iterate(&mut self) -> Result<u64, TrainingError> {
        let (seed, threads) = (self.settings.seed, self.threads);
        match &mut self.part {
            Part::Surrogate(phase) => {
                let drawn = phase.draw(&self.environments, &self.settings.surrogate, seed, threads);
                let rewards = known_rewards(&drawn.rollout, &self.settings, &self.environments);
                let world = self.environments.world();
                let settings = decayed(&self.settings.surrogate, phase.steps, self.settings.surrogate_steps);
                let update = phase.learn(&drawn, &rewards, world, &settings, seed, threads, LimitValue::Nothing);
                self.progress.iteration(phase.steps, &drawn.rollout, world, update);
                check_finite(phase)?;
                if phase.steps >= self.settings.surrogate_steps {
                    let phase = phase.clone();
                    let surrogate = self.policy(&phase, Method::Ppo);
                    let demonstrations = generate(&surrogate, &self.environments, self.settings.demonstrations, seed);
                    self.surrogate = Some(surrogate);
                    self.recover(demonstrations)?;
                }
                Ok(drawn.steps())
            }
            Part::Recovery(phase, discriminator) => {
                let of = &self.settings.airl;
                let world = self.environments.world();
                let drawn = phase.draw(&self.environments, &of.policy, seed, threads);
                let generated: Vec<Example> = drawn.rollout.transitions().map(Example::from).collect();
                let mut figures = Default::default();
                let mut generator = stream(seed, "examples", &[phase.iteration]);
                let actor = &phase.networks.actor.network;
                let (mut active, mut trace) = (Vec::new(), actor.trace());
                for _ in 0..of.updates {
                    let mut example = |demonstrated: &Demonstrated| {
                        world.features(&demonstrated.state, &mut active);
                        let mut logarithms = [0.0; Action::COUNT];
                        log_softmax(actor.forward(&active, &mut trace), &mut logarithms);
                        Example {
                            state: demonstrated.state,
                            action: demonstrated.action,
                            next: demonstrated.step.state,
                            log_probability: logarithms[demonstrated.action.index()],
                        }
                    };
                    let expert = (0..of.batch).map(|_| below(&mut generator, self.demonstrated.len()));
                    let expert: Vec<usize> = expert.collect();
                    let expert: Vec<Example> = expert.into_iter().map(|i| example(&self.demonstrated[i])).collect();
                    let own = (0..of.batch).map(|_| generated[below(&mut generator, generated.len())]);
                    let own: Vec<Example> = own.collect();
                    figures = discriminator.update(world, of, &expert, &own);
                }
                let mut f = discriminator.f(world, of.policy.gamma);
                let reward = |e: &Example| f(&e.state, e.action, &e.next) - e.log_probability;
                let rewards: Vec<f32> = generated.iter().map(reward).collect();
                let settings = decayed(&of.policy, phase.steps, self.settings.recovery_steps);
                let update = phase.learn(&drawn, &rewards, world, &settings, seed, threads, LimitValue::Critic);
                self.progress.iteration(phase.steps, &drawn.rollout, world, update);
                self.progress.discriminator = Some(figures);
                check_finite(phase)?;
                Ok(drawn.steps())
            }
        }
    }

    /// Begins the last part.
    fn recover(&mut self, demonstrations: Vec<Trajectory>) -> Result<(), TrainingError> {
        let (seed, of) = (self.settings.seed, &self.settings.airl);
        let world = self.environments.world();
        let phase = Phase::new(&of.policy, world, seed, "recovery")?;
        let discriminator = Discriminator::new(of, world, seed)?;
        self.demonstrated = demonstrations.iter().flat_map(|t| t.steps(world)).collect();
        self.demonstrations = demonstrations;
        self.progress = Progress::of(Stage::Recovery, self.settings.recovery_steps, world);
        self.part = Part::Recovery(phase, Box::new(discriminator));
        Ok(())
    }
}

/// Learning rate and weight of the entropy fall linearly to a tenth: the policy explores first, and does not wander at last.
fn decayed(settings: &crate::ppo::Settings, steps: u64, of: u64) -> crate::ppo::Settings {
    let factor = 1.0 - 0.9 * (steps as f64 / of as f64).min(1.0);
    let (rate, entropy) = (settings.rate * factor, settings.entropy * factor);
    crate::ppo::Settings { rate, entropy, ..settings.clone() }
}

fn known_rewards(rollout: &Rollout, settings: &Settings, environments: &Environments) -> Vec<f32> {
    let world = environments.world();
    let reward = |t: &crate::ppo::Transition| {
        let failed = t.end == Some(crate::ppo::EpisodeEnd::Limit);
        settings.rewards.of(&world.step(&t.state, t.action), failed) as f32
    };
    rollout.transitions().map(reward).collect()
}

fn check_finite(phase: &Phase) -> Result<(), TrainingError> {
    let finite = |parameters: &[f32]| parameters.iter().all(|p| p.is_finite());
    let networks = &phase.networks;
    if finite(networks.actor.network.parameters()) && finite(networks.critic.network.parameters()) {
        return Ok(());
    }
    Err(TrainingError::Diverged(phase.steps))
}

impl From<&crate::ppo::Transition> for Example {
    fn from(t: &crate::ppo::Transition) -> Example {
        Example { state: t.state, action: t.action, next: t.next, log_probability: t.log_probability }
    }
}

impl Drawn {
    fn steps(&self) -> u64 {
        self.rollout.transitions().count() as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Rewards;
    use crate::ppo;

    fn world() -> World {
        World::new(3, 3, &[4], &[8], 2).unwrap().with_step_limit(12).unwrap()
    }

    fn settings() -> Settings {
        let small =
            |of: ppo::Settings| ppo::Settings { hidden: vec![8], environments: 3, horizon: 16, minibatch: 16, ..of };
        let paper = Settings::paper();
        let airl = crate::airl::Settings { policy: small(paper.airl.policy), hidden: vec![8], batch: 16, ..paper.airl };
        let surrogate = small(paper.surrogate);
        Settings {
            seed: 5,
            surrogate,
            surrogate_steps: 150,
            demonstrations: 20,
            airl,
            recovery_steps: 150,
            ..Settings::paper()
        }
    }

    fn finished(mut run: Run) -> Run {
        run.step(u64::MAX).unwrap();
        assert!(run.is_done());
        run
    }

    fn bytes(run: &Run) -> Vec<Vec<u8>> {
        vec![run.surrogate().unwrap().to_bytes(), run.recovered().unwrap().to_bytes(), run.checkpoint()]
    }

    /// After every iteration the run is written, and another one goes on from the file.
    #[test]
    fn interrupted_runs_give_the_same_bits() {
        let whole = bytes(&finished(Run::new(&world(), settings()).unwrap()));
        let mut run = Run::new(&world(), settings()).unwrap();
        let mut interruptions = 0;
        while !run.is_done() {
            run.step(1).unwrap();
            run = Run::resume(&run.checkpoint()).unwrap();
            interruptions += 1;
        }
        assert_eq!(interruptions, 8);
        assert_eq!(bytes(&run), whole);
    }

    #[test]
    fn threads_do_not_change_the_bits() {
        let one = finished(Run::new(&world(), settings()).unwrap());
        let two = finished(Run::new(&world(), settings()).unwrap().with_threads(2));
        assert_eq!(bytes(&one), bytes(&two));
        let other = Settings { seed: 6, ..settings() };
        assert_ne!(bytes(&one), bytes(&finished(Run::new(&world(), other).unwrap())));
    }

    /// A corridor of three cells with a target of great value: the person learns to collect it and to leave.
    #[test]
    fn rewards_teach_to_collect_and_to_leave() {
        let world = World::new(3, 1, &[], &[2], 1).unwrap().with_step_limit(12).unwrap();
        let rewards = Rewards { targets: vec![1.0], ..Rewards::paper() };
        let surrogate = ppo::Settings { rate: 5e-3, entropy: 0.1, ..settings().surrogate };
        let settings =
            Settings { rewards, surrogate, surrogate_steps: 12_000, least_targets: 1, most_targets: 1, ..settings() };
        let run = finished(Run::new(&world, settings.clone()).unwrap());
        let environments = settings.check(&world).unwrap();
        let figures = crate::evaluate::evaluate(run.surrogate().unwrap(), &environments, &settings.rewards, 200, 1);
        assert!(figures.collected[0].mean > 0.9 && figures.failures.mean < 0.05, "{figures:?}");
        assert!(figures.length.mean < 5.0, "{figures:?}");
    }

    #[test]
    fn runs_from_demonstrations_need_some() {
        let refused = Run::from_demonstrations(&world(), settings(), Vec::new());
        assert_eq!(refused.map(|_| ()).unwrap_err(), TrainingError::NoDemonstrations);
        let start = world().state(0, &[]).unwrap();
        let trajectory = Trajectory { start, actions: vec![Action::East, Action::East, Action::North, Action::North] };
        let run = Run::from_demonstrations(&world(), settings(), vec![trajectory]).unwrap();
        let run = finished(Run::resume(&run.checkpoint()).unwrap());
        assert_eq!((run.surrogate(), run.demonstrations().len()), (None, 1));
        let training = Training { method: Method::Airl, seed: 5, steps: 192 };
        assert_eq!(run.recovered().unwrap().training(), training);
    }

    #[test]
    fn damaged_checkpoints_are_refused() {
        let mut run = Run::new(&world(), settings()).unwrap();
        run.step(1).unwrap();
        let file = run.checkpoint();
        let error = |file: &[u8]| Run::resume(file).map(|_| ()).unwrap_err().to_string();
        assert!(error(&file[..file.len() / 2]).starts_with("not a safetensors file"));
        let replaced = |from: &str, to: &str| {
            // Texts of the same length, so that the container stays whole.
            assert_eq!(from.len(), to.len());
            let at = file.windows(from.len()).position(|part| part == from.as_bytes()).unwrap();
            let mut file = file.clone();
            file[at..at + to.len()].copy_from_slice(to.as_bytes());
            error(&file)
        };
        assert_eq!(replaced("checkpoint", "somethings"), "the file is a somethings and not a checkpoint");
        assert_eq!(replaced("recovers\\\":false", "recovers\\\":true "), "the checkpoint holds no demonstrations");
        assert_eq!(replaced("hidden\\\":[8]", "hidden\\\":[9]").split(" has").next(), Some("`actor.parameters`"));
        assert_eq!(
            replaced("environments\\\":3", "environments\\\":4"),
            "the checkpoint has 3 environments; 4 are expected"
        );
        let policy = run.policy(&Phase::new(&settings().surrogate, &world(), 1, "x").unwrap(), Method::Ppo);
        assert_eq!(error(&policy.to_bytes()), "the file is a policy and not a checkpoint");
    }
}
