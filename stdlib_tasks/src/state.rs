//! Inputs of a task at a tick, and the rows that it writes.

use robot::{Data, Model};

/// State of the robot at a tick.
pub struct State<'a> {
    /// Model of the robot.
    pub model: &'a Model,
    /// Kinematics at `q`.
    pub data: &'a Data,
    /// Configuration, `nq` numbers.
    pub q: &'a [f64],
    /// This tick's parameter values.
    pub values: &'a [f64],
    /// Their time derivatives.
    pub rates: &'a [f64],
    /// Velocity of the reference since the last tick, `nv` numbers; zero at the beginning.
    pub velocity: &'a [f64],
    /// Velocity that the hierarchy of the stack returned at the last tick, `nv` numbers. It differs from `velocity`
    /// during a blend only, and equals `velocity` at the tick at which the stack is entered.
    pub stack_velocity: &'a [f64],
}

/// Outputs of a task: its rows of `lower <= J v <= upper`, and numbers for monitors and plots.
pub struct Rows<'a> {
    /// Row-major, `stride` numbers per row, zero on entry.
    pub jacobian: &'a mut [f64],
    /// Number of numbers from one row to the next, at least `nv`.
    pub stride: usize,
    /// Lower bounds; minus infinity on entry.
    pub lower: &'a mut [f64],
    /// Upper bounds; infinity on entry.
    pub upper: &'a mut [f64],
    /// Limits only: `h` of each row, safe if not negative. Infinite on entry.
    pub margins: &'a mut [f64],
    /// Targets only: one number for each of [`crate::task::Task::measures`].
    pub measures: &'a mut [f64],
    /// Set to true if a row was undefined at this configuration and was left free.
    pub undefined: &'a mut bool,
    /// True for rows that are known to have no effect: only their margins are needed. Empty if all have an effect.
    pub idle: &'a [bool],
    /// Trial evaluation: the rows are computed again before the tick ends. Do not change state that the next tick's
    /// rows depend on; numbers that every update writes anew may change.
    pub trial: bool,
}

impl Rows<'_> {
    /// Coefficients of row `i`, `nv` or more numbers.
    pub fn row(&mut self, i: usize) -> &mut [f64] {
        &mut self.jacobian[i * self.stride..(i + 1) * self.stride]
    }

    /// Returns true if row `i` has no effect, so that its coefficients and bounds need not be written.
    pub fn is_idle(&self, i: usize) -> bool {
        self.idle.get(i).copied().unwrap_or(false)
    }

    /// Makes row `i` an equality.
    pub fn equal(&mut self, i: usize, value: f64) {
        self.lower[i] = value;
        self.upper[i] = value;
    }
}
