//! Steps of an actor in several environments. Episodes go on from one iteration to the next; a new one is drawn when one
//! has ended.

use crate::grid::{Action, Environments, State, World};
use crate::network::{Network, log_softmax};
use crate::random::{index, stream};
use serde::{Deserialize, Serialize};

/// An episode that goes on.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Running {
    /// Its state.
    pub state: State,
    /// Steps so far.
    pub steps: u32,
}

/// Reason why an episode has ended with a step.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub enum EpisodeEnd {
    /// The person is on an exit.
    Exit,
    /// The step limit was reached before an exit.
    Limit,
}

/// A step of an episode.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Transition {
    /// State before.
    pub state: State,
    /// Action.
    pub action: Action,
    /// State after.
    pub next: State,
    /// `ln π(a|s)` of the actor that drew it.
    pub log_probability: f32,
    /// End of the episode, if it ended here.
    pub end: Option<EpisodeEnd>,
}

/// The steps of one environment, in order.
#[derive(Clone, PartialEq, Debug)]
pub struct Segment {
    /// The steps.
    pub transitions: Vec<Transition>,
    /// The episode that goes on afterwards.
    pub running: Running,
}

/// The steps of an iteration, by environment.
#[derive(Clone, PartialEq, Debug)]
pub struct Rollout {
    /// One segment for each environment.
    pub segments: Vec<Segment>,
}

impl Rollout {
    /// All steps, environment by environment.
    pub fn transitions(&self) -> impl Iterator<Item = &Transition> + '_ {
        self.segments.iter().flat_map(|segment| &segment.transitions)
    }
}

/// Random numbers and length of a rollout.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Draw<'a> {
    /// Seed of the training.
    pub seed: u64,
    /// Name of the phase, for the streams of its random numbers.
    pub name: &'a str,
    /// Number of the iteration.
    pub iteration: u64,
    /// Steps of each environment.
    pub horizon: usize,
    /// Threads that may be used; the result does not depend on them.
    pub threads: usize,
}

/// Goes on with each running episode; those of `None` begin.
pub fn draw(actor: &Network<f32>, environments: &Environments, running: &[Option<Running>], of: &Draw) -> Rollout {
    let segment = |i: usize| one(actor, environments, running[i], of, i);
    let (first, second) = (0..running.len()).partition::<Vec<_>, _>(|i| of.threads < 2 || 2 * i < running.len());
    let segments = std::thread::scope(|scope| {
        let other =
            (!second.is_empty()).then(|| scope.spawn(|| second.iter().map(|i| segment(*i)).collect::<Vec<_>>()));
        let mut segments: Vec<Segment> = first.iter().map(|i| segment(*i)).collect();
        // A panic of the other thread is one of this program, and goes on here.
        segments.extend(other.map(|other| other.join().expect("no panic")).unwrap_or_default());
        segments
    });
    Rollout { segments }
}

fn one(
    actor: &Network<f32>,
    environments: &Environments,
    running: Option<Running>,
    of: &Draw,
    environment: usize,
) -> Segment {
    let world: &World = environments.world();
    let mut generator = stream(of.seed, of.name, &[of.iteration, environment as u64]);
    let mut running = running.unwrap_or_else(|| Running { state: environments.draw(&mut generator), steps: 0 });
    let (mut active, mut trace) = (Vec::new(), actor.trace());
    let mut transitions = Vec::with_capacity(of.horizon);
    for _ in 0..of.horizon {
        let state = running.state;
        world.features(&state, &mut active);
        let mut logarithms = [0.0_f32; Action::COUNT];
        log_softmax(actor.forward(&active, &mut trace), &mut logarithms);
        let drawn = index(&mut generator, &logarithms.map(|l| f64::from(libm::expf(l))));
        let action = Action::ALL[drawn];
        let step = world.step(&state, action);
        running = Running { state: step.state, steps: running.steps + 1 };
        let end = if step.arrived {
            Some(EpisodeEnd::Exit)
        } else {
            (running.steps >= world.step_limit()).then_some(EpisodeEnd::Limit)
        };
        transitions.push(Transition { state, action, next: step.state, log_probability: logarithms[drawn], end });
        if end.is_some() {
            running = Running { state: environments.draw(&mut generator), steps: 0 };
        }
    }
    Segment { transitions, running }
}
