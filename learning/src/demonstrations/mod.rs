//! Demonstrations: ways of a person, recorded or drawn from a policy, and their files.

mod file;

pub use file::{DemonstrationError, FaultOfLine, MAX_STEPS, read, write};

use crate::grid::{Action, Environments, State, Step, World};
use crate::policy::Policy;
use crate::random::{index, stream};

/// A way: its first state and its actions. The other states follow from them.
#[derive(Clone, PartialEq, Debug)]
pub struct Trajectory {
    /// The first state.
    pub start: State,
    /// The actions, in order.
    pub actions: Vec<Action>,
}

/// A step of a trajectory.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Demonstrated {
    /// State before.
    pub state: State,
    /// Action.
    pub action: Action,
    /// State after the step.
    pub step: Step,
}

impl Trajectory {
    /// The steps of the trajectory in its world.
    pub fn steps<'a>(&'a self, world: &'a World) -> impl Iterator<Item = Demonstrated> + 'a {
        self.actions.iter().scan(self.start, |state, action| {
            let step = world.step(state, *action);
            Some(Demonstrated { state: std::mem::replace(state, step.state), action: *action, step })
        })
    }
}

/// Draws the episode of a policy from this start: until an exit, or the step limit.
pub fn episode(policy: &Policy, start: State, generator: &mut crate::random::Pcg64) -> Trajectory {
    let world = policy.world();
    let mut evaluator = policy.evaluator();
    let (mut state, mut actions) = (start, Vec::new());
    while !world.is_exit(state.cell()) && (actions.len() as u32) < world.step_limit() {
        let action = Action::ALL[index(generator, &evaluator.probabilities(&state))];
        actions.push(action);
        state = world.step(&state, action).state;
    }
    Trajectory { start, actions }
}

/// Draws `count` episodes of a policy in random environments of its world. Each has random numbers of its own.
pub fn generate(policy: &Policy, environments: &Environments, count: usize, seed: u64) -> Vec<Trajectory> {
    let one = |i: usize| {
        let mut generator = stream(seed, "demonstration", &[i as u64]);
        let start = environments.draw(&mut generator);
        episode(policy, start, &mut generator)
    };
    (0..count).map(one).collect()
}
