//! Proximal policy optimisation (Schulman et al., 2017): an actor, the policy, and a critic, the value of states.
//!
//! A_t = Σ_k (γλ)^k δ_{t+k},  δ_t = r_t + γ V(s_{t+1}) - V(s_t)                     generalised advantages
//! L = mean min(ρ A, clip(ρ, 1-ε, 1+ε) A) + c H(π),  ρ = π(a|s) / π_old(a|s)        the actor climbs
//! (V(s_t) - A_t - V_old(s_t))² / 2                                                 the critic descends
//!
//! An iteration draws the same number of steps from several environments, then takes a few epochs over them. Actor and critic
//! share nothing, so that two threads can train them; environments have random numbers of their own, so that two threads can
//! draw them. No number depends on how many threads there are.

mod advantages;
mod learner;
mod rollout;
mod settings;

pub use advantages::{Advantages, LimitValue, advantages};
pub use learner::{ActorCritic, Batch, Learner, Update, UpdateFigures};
pub use rollout::{Draw, EpisodeEnd, Rollout, Running, Segment, Transition, draw};
pub use settings::{Settings, SettingsError};
