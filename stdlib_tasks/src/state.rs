//! What a task sees at a tick, and where it writes its rows.

use robot::{Data, Model};

/// The robot at a tick.
pub struct State<'a> {
    /// The robot.
    pub model: &'a Model,
    /// Kinematics at `q`.
    pub data: &'a Data,
    /// Configuration, `nq` numbers.
    pub q: &'a [f64],
    /// This tick's parameter values.
    pub values: &'a [f64],
    /// Their time derivatives.
    pub rates: &'a [f64],
    /// The velocity that the reference moved with since the last tick, `nv` numbers; zero at the beginning.
    pub velocity: &'a [f64],
    /// The velocity that the hierarchy of the stack returned at the last tick, `nv` numbers. It differs from `velocity`
    /// during a blend alone, and equals `velocity` at the tick at which the stack is entered.
    pub stack_velocity: &'a [f64],
}

/// Where a task writes: its rows of `lower <= J v <= upper`, and what monitors and plots read.
pub struct Rows<'a> {
    /// Row-major, `stride` numbers a row, zero on entry.
    pub jacobian: &'a mut [f64],
    /// Numbers from one row to the next, at least `nv`.
    pub stride: usize,
    /// Lower bounds; minus infinity on entry.
    pub lower: &'a mut [f64],
    /// Upper bounds; infinity on entry.
    pub upper: &'a mut [f64],
    /// Limits only: `h` of each row, safe where not negative. Infinite on entry.
    pub margins: &'a mut [f64],
    /// Targets only: one number for each of [`crate::task::Task::measures`].
    pub measures: &'a mut [f64],
    /// Set to true where a row could not be defined at this configuration and was left free.
    pub undefined: &'a mut bool,
    /// Rows that are known to have no say: only their margins are wanted. Empty where all have one.
    pub idle: &'a [bool],
    /// The rows are only looked at, and are asked for once more before the tick ends: what the next tick's rows depend on
    /// stays as it is. What every update writes anew may change.
    pub trial: bool,
}

impl Rows<'_> {
    /// The coefficients of row `i`, `nv` or more numbers.
    pub fn row(&mut self, i: usize) -> &mut [f64] {
        &mut self.jacobian[i * self.stride..(i + 1) * self.stride]
    }

    /// Whether row `i` has no say, so that its coefficients and bounds need not be written.
    pub fn is_idle(&self, i: usize) -> bool {
        self.idle.get(i).copied().unwrap_or(false)
    }

    /// Makes row `i` an equality.
    pub fn equal(&mut self, i: usize, value: f64) {
        self.lower[i] = value;
        self.upper[i] = value;
    }
}
