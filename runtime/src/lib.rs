//! Compiled programs, the controller that runs them, and the simulated robot.
//!
//! A [`Program`] is plain data. [`Controller::new`] makes it ready, allocating everything that the loop needs;
//! [`Controller::step`] turns an observation into a command. Nothing here knows source text.

mod closed_loop;
mod conditioning;
pub mod controller;
pub mod csv;
pub mod evaluator;
pub mod expect;
pub mod fault;
pub mod feasibility;
mod locked_joint_motion;
pub mod missions;
mod motion;
mod period;
pub mod physics;
mod planning;
mod prediction;
pub mod program;
pub mod quantity;
pub mod record;
pub mod safety;
mod sampling;
pub mod signals;
pub mod simulate;
pub mod simulated_robot;
pub mod stopping;
pub mod text;
mod tick;
mod tracking;
pub mod trajectory;
mod values;
mod velocity;
pub mod world;

pub use controller::{Command, Controller, Intervals, Observation, Request};
pub use evaluator::{Built, Evaluator, LIMIT_TOLERANCE, Member, RestInputs, TickInputs, build_tasks};
pub use fault::{Fault, FaultKind};
pub use period::{HighGain, PeriodError, default_deadline};
pub use planning::deviates;
pub use program::{Program, ProgramError};
pub use signals::Signals;
pub use simulate::{RunError, Simulation};
pub use simulated_robot::SimulatedRobot;
pub use tick::{Recorder, Tick};
pub use world::{ExpectationMonitors, World};
