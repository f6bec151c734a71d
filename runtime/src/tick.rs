//! A tick as it was, and the trait of its recorders.

pub use crate::fault::MARGIN_TOLERANCE;
use solver::{Problem, Solution};

use crate::controller::Controller;
use crate::evaluator::Evaluator;
use crate::fault::Fault;
use crate::physics::PlantRecord;

/// One tick, as it is passed to recorders.
pub struct Tick<'a> {
    /// Index of the tick, from 0.
    pub index: usize,
    /// Time, in s.
    pub time: f64,
    /// True configuration of the robot at the start of the tick.
    pub q: &'a [f64],
    /// Velocity that the hierarchy chose.
    pub v: &'a [f64],
    /// Velocity that was commanded.
    pub command: &'a [f64],
    /// Index of the running stack in [`Controller::stacks`].
    pub stack: usize,
    /// Path of the machine's state; empty if there is no machine.
    pub state: &'a str,
    /// Index of that state.
    pub state_index: usize,
    /// The controller, after the tick.
    pub controller: &'a Controller,
    /// Margins and errors at the true configuration.
    pub evaluator: &'a Evaluator,
    /// Table of signals at this tick, with the true positions of people.
    pub signals: &'a [f64],
    /// Problem that the solver solved.
    pub problem: &'a Problem,
    /// Solution of that problem.
    pub solution: &'a Solution,
    /// Fault that was found at this tick, or that keeps the robot standing still or halted.
    pub fault: Option<Fault>,
    /// Computing time of the controller, in s, by the caller's clock.
    pub elapsed: f64,
}

impl Tick<'_> {
    /// Returns true if the robot was kept still at this tick, by a fault, because a signal is awaited, or because it takes no commands: nothing was
    /// solved.
    pub fn is_still(&self) -> bool {
        self.fault.is_some() || self.controller.awaited().is_some() || self.controller.is_held()
    }
}

/// Receiver of every tick. An error stops the run.
pub trait Recorder {
    /// Called once per tick.
    ///
    /// # Errors
    /// The record could not be stored, for instance because the disk is full.
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()>;

    /// Called before the first tick of a run whose robot has masses, with the physics that moves it.
    fn moved_by(&mut self, _plant: &PlantRecord) {}

    /// Called after the last tick of a run that ended because the simulation of its robot has diverged, with a sentence that
    /// says when, and what helps.
    fn diverged(&mut self, _why: &str) {}
}
