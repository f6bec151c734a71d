//! A way of states by a rule that chooses an action in each, cut where it would never end.

use super::{End, PredictedStep};
use crate::grid::{Action, State, World};
use std::collections::BTreeMap;

/// A chosen action and its probability.
#[derive(Clone, Copy, Debug)]
pub(super) struct Choice {
    pub action: Action,
    pub probability: f64,
}

/// A way and the reason why it ends.
pub(super) struct Walk {
    pub steps: Vec<PredictedStep>,
    pub end: End,
}

/// Follows `choose` from a state until an exit, a repeated state, `None`, or `limit` steps.
pub(super) fn walk(world: &World, from: State, limit: usize, mut choose: impl FnMut(&State) -> Option<Choice>) -> Walk {
    let mut steps: Vec<PredictedStep> = Vec::new();
    let mut visited = BTreeMap::new();
    let (mut state, mut product) = (from, 1.0);
    let end = loop {
        if let Some(to) = visited.insert(state, steps.len()) {
            // The state stands in the way already: the step before leads back to it.
            break End::Loop { to };
        }
        steps.push(PredictedStep { state, action: None, probability: 1.0, product });
        if world.is_exit(state.cell()) {
            break End::Exit;
        }
        if steps.len() > limit {
            break End::Limit;
        }
        let Some(choice) = choose(&state) else { break End::Standing };
        if let Some(step) = steps.last_mut() {
            step.action = Some(choice.action);
            step.probability = choice.probability;
        }
        product *= choice.probability;
        state = world.step(&state, choice.action).state;
    };
    Walk { steps, end }
}
