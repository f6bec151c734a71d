//! Exploration: robots take over the targets that a person leaves, Caregnato-Neto et al. 2025, "ARMCHAIR: Integrated Inverse
//! Reinforcement Learning and Model Predictive Control for Human-Robot Collaboration" (`armchair`).
//!
//! [`problem::Problem`] describes region, targets, robots and the person, [`check`] reports mistakes. [`grid`] is the grid over which the
//! person walks, [`mind`] the models of the person, whose prediction is a [`foresight::Foresight`]. [`program`] is the mixed-integer program of a plan,
//! [`lattice`] finds good plans fast, [`bound`] says how good any plan can be, [`solve`] solves the program from there, [`validate::validate`] checks a plan against the problem alone. [`execution`] simulates the world in which
//! plans are made anew at each period. [`polygon`] and [`motion`] are the geometry and the dynamics of all of them.

mod blocks;
pub mod bound;
mod build;
pub mod chart;
pub mod check;
mod event;
pub mod execution;
pub mod foresight;
pub mod grid;
pub mod lattice;
pub mod map;
mod mind;
mod mission;
pub mod motion;
pub mod objective;
mod pages;
pub mod plan;
pub mod planned;
pub mod polygon;
pub mod problem;
pub mod program;
pub mod solve;
mod text;
pub mod validate;

pub use self::mission::{Explore, KIND};
