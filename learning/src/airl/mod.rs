//! Adversarial inverse reinforcement learning (Fu et al., 2018; the paper, Section 3.1): a discriminator learns to tell steps
//! of the demonstrations from steps of the policy, and the policy learns to be taken for the demonstrations.
//!
//! D(s, a, s') = exp f(s, a, s') / (exp f(s, a, s') + π(a|s))                                                (7)
//! f(s, a, s') = g(s, a) + γ h(s') - h(s)                        g: reward, h: shaping, 0 on an exit
//! r(s, a, s') = ln D - ln(1 - D) = f(s, a, s') - ln π(a|s)      reward of the policy, which PPO trains
//!
//! The discriminator is a logistic regression with the logit `f - ln π`: it descends the mean of `-ln D` over demonstrations
//! plus that of `-ln(1 - D)` over steps of the policy.

mod discriminator;
mod settings;

pub use discriminator::{Discriminator, DiscriminatorFigures, Example};
pub use settings::Settings;
