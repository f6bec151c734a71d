//! Expressions: typing with dimensions, lowering to operations on numbers, exact differentiation in time.

mod choices;
pub mod frames;
mod functions;
mod graph;
mod helps;
mod lower;
mod ops;
mod present;
mod rotations;

pub use frames::{Axes, Frame};
pub use functions::{FUNCTIONS, Function};
pub use graph::Graph;
pub use helps::bracketed;
pub use lower::{Lowering, MEASURES, Meaning, Scope, Symbol};
pub(crate) use present::PRESENT;
pub use present::{Now, Plane};

use dsl::Span;
use stdlib_tasks::dimension::Dimension;

/// What kind of thing an expression is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// One number.
    Scalar,
    /// Three numbers.
    Vector,
    /// A unit quaternion `w x y z`.
    Rotation,
    /// One number: 1 for true, -1 for false.
    Truth,
}

impl Kind {
    /// What a person calls it.
    pub fn describe(self) -> &'static str {
        match self {
            Kind::Scalar => "a number",
            Kind::Vector => "a vector",
            Kind::Rotation => "an orientation",
            Kind::Truth => "a truth value",
        }
    }
}

/// A typed expression: nodes of a [`Graph`], in SI.
#[derive(Clone, Debug)]
pub struct Typed {
    /// Its kind.
    pub kind: Kind,
    /// Its dimension; none for rotations.
    pub dimension: Dimension,
    /// 1, 3 or 4 nodes.
    pub nodes: Vec<usize>,
    /// A bare number was written where nothing says what it counts: no unit, no `pi`, no name.
    pub bare: bool,
    /// Of a vector or orientation: the axes that its numbers count along.
    pub axes: Axes,
    /// Where.
    pub span: Span,
}
