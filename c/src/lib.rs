//! Hierarq for C and C++: the functions of `include/hierarq.h`.
//!
//! A spec is compiled by `hierarq compile --format json`, and its program is loaded here: the library knows neither the language nor files.
//! Each function guards itself against null pointers and wrong lengths, and lets no panic reach the host.

mod controller;
mod program;
mod text;

pub use controller::*;
pub use program::*;

/// Outcome of a tick: `HIERARQ_RESULT_OK`, the kind of a fault (above 0), or a mistake of the host (below 0). With all but the first the
/// velocity is zero, unless a transition of the machine answers the fault.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Result {
    /// A pointer is null.
    NullPointer = -1,
    /// An array has another length than the robot has numbers.
    WrongLength = -2,
    /// The library has failed. The controller stands still until it is restarted.
    Internal = -3,
    /// The velocity is that of the hierarchy.
    Ok = 0,
    /// A number of the configuration, or of a solution, is not finite.
    NotFinite = 1,
    /// The tick came too late, or its time goes back.
    Deadline = 2,
    /// A signal is too old, or was never sent.
    Stale = 3,
    /// The value of an expression is out of its range.
    Value = 4,
    /// The bounds of a row cross.
    Crossed = 5,
    /// Shapes overlap, so that no direction leads apart.
    Overlap = 6,
    /// A hard level cannot be met.
    Infeasible = 7,
    /// A hard limit is passed.
    Limit = 8,
    /// The solver has not found the solution.
    Solver = 9,
    /// A joint does not follow what it is told.
    Tracking = 10,
    /// A joint cannot have reached its reading since the last one.
    Jump = 11,
    /// The measured robot has passed a hard limit.
    Beyond = 12,
}

impl From<runtime::FaultKind> for Result {
    fn from(kind: runtime::FaultKind) -> Result {
        use runtime::FaultKind as Kind;
        match kind {
            Kind::NotFinite => Result::NotFinite,
            Kind::Deadline => Result::Deadline,
            Kind::Stale => Result::Stale,
            Kind::Value => Result::Value,
            Kind::Crossed => Result::Crossed,
            Kind::Overlap => Result::Overlap,
            Kind::Infeasible => Result::Infeasible,
            Kind::Limit => Result::Limit,
            Kind::Solver => Result::Solver,
            Kind::Tracking => Result::Tracking,
            Kind::Jump => Result::Jump,
            Kind::Beyond => Result::Beyond,
        }
    }
}
