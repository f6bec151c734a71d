//! A tick as it was, and who is shown it.

use solver::{Problem, Solution};

use crate::controller::Controller;
use crate::evaluator::Evaluator;
use crate::fault::Fault;

/// A margin counts as passed below minus this, in the row's SI unit. The solver meets a bound to about 1e-11 of the
/// row's size, and a joint that rests at its limit has a margin of zero up to rounding.
pub const MARGIN_TOLERANCE: f64 = 1e-9;

/// One tick, as recorders see it.
pub struct Tick<'a> {
    /// Its number, from 0.
    pub index: usize,
    /// Time, in s.
    pub time: f64,
    /// The robot's true configuration at the start of the tick.
    pub q: &'a [f64],
    /// The velocity that the hierarchy chose.
    pub v: &'a [f64],
    /// The velocity that was commanded.
    pub command: &'a [f64],
    /// The place of the stack that runs among [`Controller::stages`].
    pub stage: usize,
    /// The state of the machine, by its path; empty where there is none.
    pub state: &'a str,
    /// Its index.
    pub state_index: usize,
    /// The controller, after the tick.
    pub controller: &'a Controller,
    /// Margins and errors at the true configuration.
    pub evaluator: &'a Evaluator,
    /// The table of signals at this tick, with people where they truly are.
    pub signals: &'a [f64],
    /// What the solver was asked.
    pub problem: &'a Problem,
    /// The solver's answer.
    pub solution: &'a Solution,
    /// The fault that was found at this tick, or that keeps the robot still.
    pub fault: Option<Fault>,
    /// How long the controller took, in s, by the caller's clock.
    pub elapsed: f64,
}

/// Sees every tick. An error stops the run.
pub trait Recorder {
    /// Called once a tick.
    ///
    /// # Errors
    /// What was recorded could not be kept, for instance because the disk is full.
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()>;
}
