//! Expressions: types with dimensions, lowering to operations on numbers, and exact differentiation in time.

mod arguments;
mod arithmetic;
mod calls;
mod choices;
pub(crate) mod constants;
pub(crate) mod dimension_check;
pub(crate) mod environment;
pub(crate) mod errors;
pub mod frames;
mod functions;
pub(crate) mod functions_of_arguments;
mod graph;
mod helps;
mod humans;
mod interval;
mod lower;
mod names;
mod ops;
mod poses;
mod robot_state;
mod scope;
mod signals;
mod task_outputs;
mod trajectories;
mod unusual;
mod vector_bounds;

pub use frames::{Axes, Frame};
pub use functions::{FUNCTIONS, Family, Function, function, functions_markdown};
pub use graph::Graph;
pub use helps::bracketed;
pub(crate) use humans::{field_symbol, symbol};
pub use interval::Interval;
pub use lower::Lowering;
pub(crate) use poses::root;
pub(crate) use robot_state::PRESENT;
pub use robot_state::{Plane, RobotStateTerm};
pub(crate) use scope::not_measured;
pub use scope::{MEASURES, MOTION, Meaning, REACHED, SETTLED, Scope, Symbol};
pub(crate) use signals::{AGE, VELOCITIES, part_of_signal};
pub(crate) use task_outputs::output_symbol;
pub use trajectories::{Named, Start, TRAJECTORIES, Trajectory, needs_from};
pub(crate) use unusual::{unusual, unusual_angle};
pub use vector_bounds::{Known, VectorBound};

use dsl::Span;
use stdlib_tasks::dimension::Dimension;

/// Kind of an expression.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// One number.
    Scalar,
    /// Three numbers.
    Vector,
    /// A unit quaternion `w x y z`.
    Rotation,
    /// A position `x y z` in m and a unit quaternion `w x y z`.
    Pose,
    /// One number: 1 for true, -1 for false.
    Truth,
}

impl Kind {
    /// Number of nodes.
    pub fn width(self) -> usize {
        match self {
            Kind::Scalar | Kind::Truth => 1,
            Kind::Vector => 3,
            Kind::Rotation => 4,
            Kind::Pose => 7,
        }
    }

    /// Description in messages.
    pub fn describe(self) -> &'static str {
        match self {
            Kind::Scalar => "a number",
            Kind::Vector => "a vector",
            Kind::Rotation => "an orientation",
            Kind::Pose => "a pose",
            Kind::Truth => "a truth value",
        }
    }
}

/// A typed expression: nodes of a [`Graph`], in SI.
#[derive(Clone, Debug)]
pub struct Typed {
    /// Kind.
    pub kind: Kind,
    /// Dimension; `NONE` for rotations and poses.
    pub dimension: Dimension,
    /// 1, 3, 4 or 7 nodes.
    pub nodes: Vec<usize>,
    /// True for a bare number whose quantity is unknown: without a unit, `pi`, or a name.
    pub bare: bool,
    /// For a vector, orientation or pose: axes in which its numbers are expressed.
    pub axes: Axes,
    /// Source span.
    pub span: Span,
}

impl Typed {
    /// A number whose dimension is known.
    pub(crate) fn scalar(node: usize, dimension: Dimension, span: Span) -> Typed {
        Typed { kind: Kind::Scalar, dimension, nodes: vec![node], bare: false, axes: Axes::default(), span }
    }
}
