//! What is the case outside of the robot at a tick.

use crate::program::{Program, Times};

/// What is the case outside of the robot at a tick.
#[derive(Clone, Copy, Debug)]
pub struct Moment<'a> {
    /// The clocks.
    pub times: Times,
    /// The table of signals.
    pub signals: &'a [f64],
    /// The velocity that the reference moved with since the last tick, `nv` numbers.
    pub velocity: &'a [f64],
    /// The velocity that the stack's hierarchy returned then; see [`stdlib_tasks::task::State::stack_velocity`].
    pub stack_velocity: &'a [f64],
}

/// A robot that stands, no signal, and variables as they are at the start: a moment for those who look at a stack without running it.
#[derive(Clone, Debug)]
pub struct Rest {
    signals: Vec<f64>,
    velocity: Vec<f64>,
}

impl Rest {
    /// For a program.
    pub fn new(program: &Program) -> Rest {
        Rest { signals: program.interface.absent(), velocity: vec![0.0; program.robot.model.nv()] }
    }

    /// The moment at which the clocks show these times.
    pub fn at(&self, times: Times) -> Moment<'_> {
        Moment { times, signals: &self.signals, velocity: &self.velocity, stack_velocity: &self.velocity }
    }
}
