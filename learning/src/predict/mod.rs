//! Predictions of a person's way (the paper, Section 3.2, Algorithm 1): from the observed state, the most likely action (8)
//! and the state that it leads to (9), until an exit.
//!
//! Algorithm 1 never ends if the most likely actions lead in a circle, or stay in a cell. A prediction is cut there, and its
//! [`End`] says so. It is also cut at a number of steps.
//!
//! Besides the most likely way, a prediction says how likely it is: the probability of each action, their product, and how
//! the position spreads at each step when actions are drawn from the policy. Predictors that draw nothing have the
//! probability 1 everywhere, which is no claim that they are right.

mod constant_velocity;
mod goal_directed;
mod learned;
mod occupancy;
mod walk;

pub use constant_velocity::ConstantVelocity;
pub use goal_directed::{GoalDirected, GoalError};
pub use learned::Learned;
pub use occupancy::Occupancy;

use crate::grid::{Action, Cell, State, StateError, Target, World};

/// Predicts the way of a person.
pub trait Predictor: Send + Sync {
    /// Name, `policy` for instance.
    fn name(&self) -> &'static str;

    /// The world in which it predicts.
    fn world(&self) -> &World;

    /// Predicts from an observation, which must be a state of the world.
    fn predict(&self, from: &Observation, limits: &Limits) -> Result<Prediction, StateError>;
}

/// An observation of a person.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Observation {
    /// Cell of the person and remaining targets.
    pub state: State,
    /// The last move; `None` if there was none. `Collect` is no direction.
    pub heading: Option<Action>,
}

/// Bounds of a prediction.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Limits {
    /// The most steps of the predicted way.
    pub steps: usize,
    /// Ways that are drawn for the occupancy; 0 for none, which leaves the occupancy out.
    pub samples: usize,
    /// Seed of the draws: the same seed and observation give the same prediction.
    pub seed: u64,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits { steps: 50, samples: 100, seed: 0 }
    }
}

/// A predicted way.
#[derive(Clone, PartialEq, Debug)]
pub struct Prediction {
    /// States along the way, from the observed one on. Never empty.
    pub steps: Vec<PredictedStep>,
    /// Reason why it ends.
    pub end: End,
    /// Spread of the position at each of the steps; empty without samples.
    pub occupancy: Vec<Occupancy>,
}

/// A state of a predicted way.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct PredictedStep {
    /// The state.
    pub state: State,
    /// The action that is predicted here; `None` at the end of the way.
    pub action: Option<Action>,
    /// Probability of this action in this state; 1 at the end of the way.
    pub probability: f64,
    /// Probability of the way up to this state: the product of the probabilities of all actions before.
    pub product: f64,
}

/// Reason why a prediction ends.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum End {
    /// The way reaches an exit.
    Exit,
    /// The last action leads back to an earlier state, so that the way would repeat itself for ever.
    Loop {
        /// Index of the earlier state in `steps`.
        to: usize,
    },
    /// The person stands still: no direction, a wall ahead, or no way to an exit.
    Standing,
    /// The way has as many steps as the limit allows.
    Limit,
}

impl Prediction {
    /// Cells along the way: the waypoints of Algorithm 1.
    pub fn waypoints(&self) -> impl Iterator<Item = Cell> + '_ {
        self.steps.iter().map(|step| step.state.cell())
    }

    /// The state in which the prediction ends. Its targets are those that the person is predicted to neglect, if the way
    /// reaches an exit.
    pub fn last(&self) -> &State {
        &self.steps[self.steps.len() - 1].state
    }

    /// Targets that are collected on the way, in order.
    pub fn collected(&self) -> impl Iterator<Item = Collected> + '_ {
        let pairs = self.steps.windows(2).enumerate();
        pairs.filter_map(|(step, pair)| {
            let gone = |target: &&Target| !pair[1].state.targets().contains(target);
            let target = pair[0].state.targets().iter().find(gone)?;
            Some(Collected { step: step + 1, target: *target })
        })
    }

    /// Tests whether the way reaches an exit. Otherwise it was cut.
    pub fn reaches_exit(&self) -> bool {
        self.end == End::Exit
    }
}

/// A target that is collected on a predicted way.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Collected {
    /// Index of the first state without the target.
    pub step: usize,
    /// The target.
    pub target: Target,
}
