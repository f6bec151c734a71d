//! Arguments of functions: their types, and the errors of a call.

use stdlib_tasks::dimension::NONE;

use super::{Graph, Kind, Typed, ops};

/// Error of a call.
pub(super) enum CallError {
    /// Argument `index` must be `wanted`.
    Argument { index: usize, wanted: String },
    /// Two arguments must have the same dimension.
    Different { first: usize, second: usize },
    /// Two arguments must be expressed in the same axes.
    Axes { first: usize, second: usize },
    /// The value is undefined at all times.
    Undefined(&'static str),
}

fn wanted(index: usize, wanted: &str) -> CallError {
    CallError::Argument { index, wanted: wanted.into() }
}

/// A number of any dimension as argument.
pub(super) fn quantity(args: &[Typed], index: usize) -> Result<&Typed, CallError> {
    match args.get(index) {
        Some(a) if a.kind == Kind::Scalar => Ok(a),
        _ => Err(wanted(index, "a number")),
    }
}

/// A vector as argument.
pub(super) fn vector(args: &[Typed], index: usize) -> Result<&Typed, CallError> {
    match args.get(index) {
        Some(a) if a.kind == Kind::Vector => Ok(a),
        _ => Err(wanted(index, "a vector")),
    }
}

/// A bare number as argument.
pub(super) fn number(args: &[Typed], index: usize) -> Result<usize, CallError> {
    let a = quantity(args, index)?;
    if a.dimension == NONE { Ok(a.nodes[0]) } else { Err(wanted(index, "a bare number")) }
}

/// An angle, or a bare number in radians, as argument.
pub(super) fn angle(g: &Graph, args: &[Typed], index: usize) -> Result<usize, CallError> {
    let a = quantity(args, index)?;
    if a.dimension.is_number() || ops::is_zero(g, a) { Ok(a.nodes[0]) } else { Err(wanted(index, "an angle")) }
}

/// The quaternion of an orientation as argument.
pub(super) fn orientation(args: &[Typed], index: usize) -> Result<&[usize], CallError> {
    match args.get(index) {
        Some(a) if a.kind == Kind::Rotation => Ok(&a.nodes),
        _ => Err(wanted(index, "an orientation")),
    }
}
