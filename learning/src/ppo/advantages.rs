//! Generalised advantages (Schulman et al., 2016), and the returns that the critic learns.

use super::{EpisodeEnd, Rollout};
use crate::grid::World;
use crate::network::Network;

/// Value of the state in which an episode reaches its step limit.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum LimitValue {
    /// Nothing follows: the reward of the failure is all.
    Nothing,
    /// The value of the critic, because the process itself goes on.
    Critic,
}

/// Advantage and return of each step.
#[derive(Clone, PartialEq, Debug)]
pub struct Advantages {
    /// `A_t`, environment by environment.
    pub advantages: Vec<f32>,
    /// `A_t + V(s_t)`.
    pub returns: Vec<f32>,
}

/// Computes the advantages of all steps from their rewards.
pub fn advantages(
    rollout: &Rollout,
    rewards: &[f32],
    critic: &Network<f32>,
    world: &World,
    gamma: f64,
    lambda: f64,
    at_limit: LimitValue,
) -> Advantages {
    let (gamma, lambda) = (gamma as f32, lambda as f32);
    let (mut active, mut trace) = (Vec::new(), critic.trace());
    let mut value = |state| {
        world.features(state, &mut active);
        critic.forward(&active, &mut trace)[0]
    };
    let mut result = Advantages { advantages: vec![0.0; rewards.len()], returns: vec![0.0; rewards.len()] };
    let mut end_of_segment = rewards.len();
    for segment in rollout.segments.iter().rev() {
        let start = end_of_segment - segment.transitions.len();
        // Value and advantage of the step behind, in the same episode.
        let mut behind: Option<(f32, f32)> = None;
        for (t, transition) in segment.transitions.iter().enumerate().rev() {
            let (next_value, next_advantage) = match (transition.end, behind) {
                (Some(EpisodeEnd::Exit), _) => (0.0, 0.0),
                (Some(EpisodeEnd::Limit), _) if at_limit == LimitValue::Nothing => (0.0, 0.0),
                (Some(EpisodeEnd::Limit), _) | (None, None) => (value(&transition.next), 0.0),
                (None, Some(behind)) => behind,
            };
            let here = value(&transition.state);
            let delta = rewards[start + t] + gamma * next_value - here;
            let advantage = delta + gamma * lambda * next_advantage;
            result.advantages[start + t] = advantage;
            result.returns[start + t] = advantage + here;
            behind = Some((here, advantage));
        }
        end_of_segment = start;
    }
    result
}

#[cfg(test)]
mod tests {
    use super::super::{Running, Segment, Transition};
    use super::*;
    use crate::grid::Action;
    use crate::network::{Activation, Shape};

    /// With λ = 1 an advantage is the discounted sum of rewards, and of the value behind the last step, minus the value.
    #[test]
    fn advantages_agree_with_discounted_sums() {
        let world = World::new(4, 1, &[], &[3], 1).unwrap();
        let shape = Shape::new(world.inputs(), &[], 1, Activation::Relu).unwrap();
        let mut critic = Network::zero(shape);
        critic.parameters_mut()[..4].copy_from_slice(&[0.3, -0.2, 0.5, 9.0]);
        let value = [0.3_f32, -0.2, 0.5];
        let step = |from: u16, to: u16, end| Transition {
            state: world.state(from, &[]).unwrap(),
            action: Action::East,
            next: world.state(to, &[]).unwrap(),
            log_probability: 0.0,
            end,
        };
        let running = Running { state: world.state(0, &[]).unwrap(), steps: 0 };
        let first = vec![step(1, 2, None), step(2, 3, Some(EpisodeEnd::Exit)), step(0, 1, None), step(1, 2, None)];
        let second = vec![step(0, 1, Some(EpisodeEnd::Limit))];
        let segments = vec![Segment { transitions: first, running }, Segment { transitions: second, running }];
        let rollout = Rollout { segments };
        let rewards = [1.0, 2.0, 3.0, 4.0, 5.0];
        let of = |lambda, at_limit| advantages(&rollout, &rewards, &critic, &world, 0.9, lambda, at_limit);
        let a = of(1.0, LimitValue::Critic);
        let returns =
            [1.0 + 0.9 * 2.0, 2.0, 3.0 + 0.9 * (4.0 + 0.9 * value[2]), 4.0 + 0.9 * value[2], 5.0 + 0.9 * value[1]];
        let starts = [1, 2, 0, 1, 0];
        for t in 0..5 {
            assert!((a.returns[t] - returns[t]).abs() < 1e-5, "{t}: {a:?}");
            assert!((a.advantages[t] - (returns[t] - value[starts[t]])).abs() < 1e-5, "{t}: {a:?}");
        }
        assert!((of(1.0, LimitValue::Nothing).returns[4] - 5.0).abs() < 1e-6);
        // With λ = 0 it is the error of one step.
        let delta = 3.0 + 0.9 * value[1] - value[0];
        assert!((of(0.0, LimitValue::Critic).advantages[2] - delta).abs() < 1e-6);
    }
}
