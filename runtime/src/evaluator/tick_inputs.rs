//! Inputs of a tick other than the configuration of the robot.

use crate::program::{Program, Times};

/// Inputs of a tick other than the configuration of the robot.
#[derive(Clone, Copy, Debug)]
pub struct TickInputs<'a> {
    /// Clocks.
    pub times: Times,
    /// Table of signals.
    pub signals: &'a [f64],
    /// Velocity of the reference since the last tick, `nv` numbers.
    pub velocity: &'a [f64],
    /// Velocity that the stack's hierarchy returned then; see [`stdlib_tasks::task::State::stack_velocity`].
    pub stack_velocity: &'a [f64],
}

/// Robot at rest, no signals, and variables at their initial values: the inputs for the evaluation of a stack that does
/// not run.
#[derive(Clone, Debug)]
pub struct RestInputs {
    signals: Vec<f64>,
    velocity: Vec<f64>,
}

impl RestInputs {
    /// Prepares the inputs for a program.
    pub fn new(program: &Program) -> RestInputs {
        RestInputs { signals: program.interface.absent(), velocity: vec![0.0; program.robot.model.nv()] }
    }

    /// Prepares the inputs with every signal present: numbers and vectors are zero, orientations are those of the world,
    /// and variables have their initial values.
    pub fn present(program: &Program) -> RestInputs {
        let mut rest = RestInputs::new(program);
        for s in program.interface.signals.iter().filter(|s| s.variable.is_none() || s.age_of.is_some()) {
            rest.signals[s.at..s.at + s.width()].fill(0.0);
            (rest.signals[s.at], rest.signals[s.known_at()]) = (1.0, 1.0);
            if matches!(s.len, 4 | 7) {
                rest.signals[s.at + 1 + s.len - 4] = 1.0;
            }
        }
        rest
    }

    /// Returns the inputs at these times.
    pub fn at(&self, times: Times) -> TickInputs<'_> {
        TickInputs { times, signals: &self.signals, velocity: &self.velocity, stack_velocity: &self.velocity }
    }
}
