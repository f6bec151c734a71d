//! What can go wrong while a program runs, as small values that the control loop can make without allocating.

/// A fault. The controller answers every fault in the same way: it commands zero velocity from that tick on, which
/// keeps every static limit whose margin is not negative (mathematics, velocity scaling of limits), and stays there
/// until it is started again. [`crate::Controller::describe`] puts names to the indices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// An observed position, or the time, is not finite.
    Observation {
        /// Index in the configuration; `None` for the time.
        index: Option<usize>,
    },
    /// A row of a task holds a number that is not finite.
    NotFinite {
        /// Index of the task in the stack's order.
        member: usize,
        /// Its row.
        row: usize,
    },
    /// A moving parameter left its range, or is not finite.
    Value {
        /// Its place in the table of values.
        at: usize,
    },
    /// Two parts of the robot overlap so deeply that no direction leads apart.
    Overlap {
        /// Index of the task in the stack's order.
        member: usize,
        /// Its row.
        row: usize,
    },
    /// A gain that depends on the robot's state is negative, or overshoots within one period.
    Gain {
        /// Index of the task in the stack's order.
        member: usize,
    },
    /// The lower limit of a row lies above the upper one.
    Crossed {
        /// Index of the task in the stack's order.
        member: usize,
        /// Its row.
        row: usize,
    },
    /// A hard level cannot be met.
    Infeasible {
        /// Its index.
        level: usize,
    },
    /// The solver gave no usable answer.
    Solver {
        /// The level's index.
        level: usize,
    },
    /// The robot is further from the reference than [`crate::controller::TRACKING_LIMIT`].
    Tracking {
        /// The degree of freedom.
        dof: usize,
    },
}

impl Fault {
    /// A word for the kind, as it stands in logs.
    pub fn kind(&self) -> &'static str {
        match self {
            Fault::Observation { .. } | Fault::NotFinite { .. } => "not_finite",
            Fault::Value { .. } | Fault::Gain { .. } => "value",
            Fault::Crossed { .. } => "crossed",
            Fault::Overlap { .. } => "overlap",
            Fault::Infeasible { .. } => "infeasible",
            Fault::Solver { .. } => "solver",
            Fault::Tracking { .. } => "tracking",
        }
    }
}
