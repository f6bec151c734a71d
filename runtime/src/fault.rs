//! Faults of a running program, as small values that the control loop can create without allocating.

use serde::{Deserialize, Serialize};

/// Largest violation of a margin that does not count, in the row's SI unit. The solver meets a bound to about 1e-11 of
/// the row's size, and a joint at rest on its limit has a margin of zero up to rounding.
pub const MARGIN_TOLERANCE: f64 = 1e-9;

/// Tolerance of a limit at run time, in the unit of its row: a margin below minus this counts as passed. The reference ends a
/// tick on the limit up to rounding.
pub(crate) const PASSED: f64 = 1e-6;

/// A fault. The robot comes to rest from the tick at which one is found, within the limits of the stack that moved it. A machine that has a
/// transition for the fault continues from there. Otherwise the robot stands still until the controller is restarted. [`crate::Controller::describe`] names the
/// indices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// An observed position, or the time, is not finite.
    Observation {
        /// Index in the configuration; `None` for the time.
        index: Option<usize>,
    },
    /// A tick came later than the robot's deadline allows, or the time went back.
    Deadline {
        /// Time since the previous tick, in s.
        gap: f64,
    },
    /// A signal that the state needs is absent, or was received too long ago.
    Stale {
        /// Its index.
        signal: usize,
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
        /// Its index in the table of values.
        at: usize,
    },
    /// A variable would have been set to a value that is not finite.
    Variable {
        /// Index of the variable among the signals.
        signal: usize,
    },
    /// Two parts of the robot overlap so deeply that no separating direction is defined.
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
    /// The robot passed a limit of a hard level, or a limit is violated and a transition of the state is triggered by it.
    Limit {
        /// Index of the task in the stack's order.
        member: usize,
        /// Its row.
        row: usize,
    },
    /// The solver returned no usable answer.
    Solver {
        /// The level's index.
        level: usize,
    },
    /// A degree of freedom does not follow what it is told.
    Tracking {
        /// Its index.
        dof: usize,
        /// Motion that was commanded in the last moments, and that was measured, in rad or m.
        told: f64,
        /// See `told`.
        moved: f64,
    },
    /// A reading that a degree of freedom cannot have reached since the last one.
    Jump {
        /// Its index.
        dof: usize,
        /// Difference from the last reading, in rad or m.
        by: f64,
    },
    /// The measured robot has passed a limit of a hard level, which its reference keeps.
    Beyond {
        /// Index of the task in the stack's order.
        member: usize,
        /// Its row.
        row: usize,
        /// How far, in the unit of the row.
        by: f64,
    },
}

/// The kinds of fault, as transitions and logs name them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultKind {
    /// [`Fault::Observation`], [`Fault::NotFinite`]
    NotFinite,
    /// [`Fault::Deadline`]
    Deadline,
    /// [`Fault::Stale`]
    Stale,
    /// [`Fault::Value`], [`Fault::Variable`], [`Fault::Gain`]
    Value,
    /// [`Fault::Crossed`]
    Crossed,
    /// [`Fault::Overlap`]
    Overlap,
    /// [`Fault::Infeasible`]
    Infeasible,
    /// [`Fault::Limit`]
    Limit,
    /// [`Fault::Solver`]
    Solver,
    /// [`Fault::Tracking`]
    Tracking,
    /// [`Fault::Jump`]
    Jump,
    /// [`Fault::Beyond`]
    Beyond,
}

impl FaultKind {
    /// All kinds.
    pub const ALL: [FaultKind; 12] = [
        FaultKind::NotFinite,
        FaultKind::Deadline,
        FaultKind::Stale,
        FaultKind::Value,
        FaultKind::Crossed,
        FaultKind::Overlap,
        FaultKind::Infeasible,
        FaultKind::Limit,
        FaultKind::Solver,
        FaultKind::Tracking,
        FaultKind::Jump,
        FaultKind::Beyond,
    ];

    /// Name of the kind in specs and logs.
    pub fn word(self) -> &'static str {
        match self {
            FaultKind::NotFinite => "not_finite",
            FaultKind::Deadline => "deadline",
            FaultKind::Stale => "stale",
            FaultKind::Value => "value",
            FaultKind::Crossed => "crossed",
            FaultKind::Overlap => "overlap",
            FaultKind::Infeasible => "infeasible",
            FaultKind::Limit => "limit",
            FaultKind::Solver => "solver",
            FaultKind::Tracking => "tracking",
            FaultKind::Jump => "jump",
            FaultKind::Beyond => "beyond",
        }
    }
}

impl Fault {
    /// Its kind.
    pub fn kind(&self) -> FaultKind {
        match self {
            Fault::Observation { .. } | Fault::NotFinite { .. } => FaultKind::NotFinite,
            Fault::Deadline { .. } => FaultKind::Deadline,
            Fault::Stale { .. } => FaultKind::Stale,
            Fault::Value { .. } | Fault::Variable { .. } | Fault::Gain { .. } => FaultKind::Value,
            Fault::Crossed { .. } => FaultKind::Crossed,
            Fault::Overlap { .. } => FaultKind::Overlap,
            Fault::Infeasible { .. } => FaultKind::Infeasible,
            Fault::Limit { .. } => FaultKind::Limit,
            Fault::Solver { .. } => FaultKind::Solver,
            Fault::Tracking { .. } => FaultKind::Tracking,
            Fault::Jump { .. } => FaultKind::Jump,
            Fault::Beyond { .. } => FaultKind::Beyond,
        }
    }
}
