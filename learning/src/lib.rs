//! Learned model of a person who visits targets on a grid and leaves through an exit: the grid as a Markov decision process,
//! policies as small networks, their training from rewards or from demonstrations, and predictions of the person's way.
//!
//! Source: Caregnato-Neto et al., "ARMCHAIR: Integrated Inverse Reinforcement Learning and Model Predictive Control for
//! Human-Robot Collaboration", International Journal of Social Robotics 17 (2025), called *the paper* in this crate. The
//! algorithms are PPO (Schulman et al., 2017) and adversarial inverse reinforcement learning (Fu et al., 2018).
//!
//! All results are the same bit for bit on every machine: sums have a fixed order, and exponentials and logarithms come from
//! `libm`, not from the system.

pub mod airl;
pub mod demonstrations;
pub mod evaluate;
pub mod grid;
pub mod network;
pub mod paper;
pub mod policy;
pub mod ppo;
pub mod predict;
pub mod random;
mod tensor_file;
pub mod training;

pub use tensor_file::TensorFileError;
