//! Description of the parameters of a task type: name, type, unit, range, default and text, written once.
//!
//! The macro [`params!`](crate::params!) turns one listing into a documented struct, the static table from which
//! schema, docs, completion and checks derive, and the reader that fills the struct from [`BoundParams`].

use crate::bound::{Arm, Bound, BoundParams, ExceptedPair, Geometry, Obstacle, Slot};
use crate::dimension::Dimension;
use crate::expression::Expression;
pub use crate::expression::Operand;
pub use quantities::{Presence, Quantity};
use robot::LinkId;

/// Type of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParamType {
    /// A number; it may move with time unless `constant`.
    Scalar(Quantity),
    /// `auto`, or a number.
    AutoScalar(Quantity),
    /// Three numbers; they may move with time.
    Vector(Dimension),
    /// One number for the axes x, y and z, or a vector with one for each; they may move with time.
    PerAxis(Quantity),
    /// Vectors of constants.
    Vectors {
        /// Smallest number of vectors.
        least: usize,
        /// Largest number of vectors.
        most: usize,
        /// Dimension of their numbers.
        dimension: Dimension,
    },
    /// An orientation; it may move with time.
    Rotation,
    /// One rate for all, or one for each of these names.
    Gains(&'static [&'static str]),
    /// A link of the robot.
    Frame,
    /// Links, or arms, which are represented by their tips.
    Frames,
    /// A declared arm.
    Arm,
    /// Points, segments, links (with their collision shapes), and groups of them.
    Geometries,
    /// Declared obstacles.
    Obstacles,
    /// Pairs of links that are left out. Unless the parameter of this name is written, the compiler adds the pairs that
    /// the robot's SRDF disables, and those that touch at every sampled posture.
    Pairs(&'static str),
    /// Joints and groups of joints.
    Joints,
    /// A position for each joint: rad or m.
    JointPositions,
    /// A velocity for each joint: rad/s or m/s.
    JointVelocities,
    /// An acceleration for each joint: rad/s^2 or m/s^2.
    JointAccelerations,
    /// A number for each of some arms.
    PerArm(Dimension),
    /// Parameters for each of some frames, which are links, or arms, which are represented by their tips. Vectors among them
    /// are in the axes of the frame. Bound as a group of groups, each with its frame as `frame`.
    PerFrame(&'static [ParamInfo]),
    /// One of these words.
    Choice(&'static [&'static str]),
    /// Some of the axes x, y and z.
    Axes,
    /// An expression that may read the robot's present state.
    Expression(Form),
    /// Parameters inside a parameter.
    Group(&'static [ParamInfo]),
    /// A declared task.
    Task,
    /// A declared safety field.
    Field,
    /// Positions and orientations of the task that the parameter `task` names, each with parameters of its deviation.
    Deviations,
}

/// Form of an expression of the robot's present state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// A number or a vector of any dimension; if `orientation` is true, also an orientation or a pose. It must read the
    /// state.
    Value {
        /// True if it may be an orientation or a pose.
        orientation: bool,
    },
    /// The kind and dimension of another parameter, which is bound before.
    Like(&'static str),
    /// A number.
    Number(Quantity),
    /// A vector of a dimension, along the world's axes.
    Vector(Dimension),
    /// `auto`, or a constant number, zero or more, of the dimension of another parameter, which is bound before. It must not
    /// read the state.
    Size(&'static str),
}

/// One parameter of a task type.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParamInfo {
    /// Its name in a spec.
    pub name: &'static str,
    /// Its description in Markdown, one string per line.
    pub doc: &'static [&'static str],
    /// Its type.
    pub ty: ParamType,
    /// Treatment if it is left out.
    pub presence: Presence,
}

impl ParamInfo {
    /// The description in one line.
    pub fn text(&self) -> String {
        self.doc.iter().map(|l| l.trim()).collect::<Vec<_>>().join(" ")
    }
}

/// A bound parameter does not have the form that its task type declares. The compiler never produces one; a program
/// that was edited by hand may contain one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WrongForm {
    /// The parameter.
    pub param: String,
}

/// A Rust type that a bound parameter can be read into.
pub trait FromBound: Sized {
    /// Reads it; `None` for a wrong form.
    fn from_bound(bound: Option<&Bound>) -> Option<Self>;
}

impl<T: FromBound> FromBound for Option<T> {
    fn from_bound(bound: Option<&Bound>) -> Option<Self> {
        match bound {
            None => Some(None),
            some => T::from_bound(some).map(Some),
        }
    }
}

/// `N` numbers that may move with time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Input<const N: usize> {
    /// Index of the first number.
    pub at: usize,
}

impl<const N: usize> Input<N> {
    /// This tick's values (or rates, from the table of rates). NaN if the table is too short, which
    /// [`crate::build::check`] excludes when a task is built.
    pub fn of(&self, table: &[f64]) -> [f64; N] {
        let mut out = [f64::NAN; N];
        if let Some(s) = table.get(self.at..).and_then(|rest| rest.get(..N)) {
            out.copy_from_slice(s);
        }
        out
    }
}

impl<const N: usize> FromBound for Input<N> {
    fn from_bound(bound: Option<&Bound>) -> Option<Self> {
        match bound {
            Some(Bound::Value(Slot { at, len })) if *len == N => Some(Input { at: *at }),
            _ => None,
        }
    }
}

/// Several vectors of constants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Vectors(Slot);

impl Vectors {
    /// The vectors. Empty if the table is too short, which [`crate::build::check`] excludes when a task is built.
    pub fn of(self, table: &[f64]) -> impl Iterator<Item = [f64; 3]> + '_ {
        let numbers = table.get(self.0.at..).and_then(|rest| rest.get(..self.0.len)).unwrap_or_default();
        numbers.chunks_exact(3).map(|c| [c[0], c[1], c[2]])
    }
}

impl FromBound for Vectors {
    fn from_bound(bound: Option<&Bound>) -> Option<Self> {
        match bound {
            Some(Bound::Value(slot)) if slot.len % 3 == 0 && slot.len > 0 => Some(Vectors(*slot)),
            _ => None,
        }
    }
}

/// Parameters of each of some frames, by the name of the frame.
impl FromBound for Vec<(String, BoundParams)> {
    fn from_bound(bound: Option<&Bound>) -> Option<Self> {
        let Some(Bound::Group(all)) = bound else { return None };
        let one = |(name, params): (&String, &Bound)| match params {
            Bound::Group(params) => Some((name.clone(), params.clone())),
            _ => None,
        };
        all.iter().map(one).collect()
    }
}

/// `auto`, or a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Auto {
    /// The task computes it.
    Auto,
    /// This number.
    Given(Input<1>),
}

impl FromBound for Auto {
    fn from_bound(bound: Option<&Bound>) -> Option<Self> {
        match bound {
            Some(Bound::Choice(word)) if word == "auto" => Some(Auto::Auto),
            value => Input::from_bound(value).map(Auto::Given),
        }
    }
}

impl FromBound for Operand {
    fn from_bound(bound: Option<&Bound>) -> Option<Self> {
        match bound {
            Some(Bound::Value(slot)) if matches!(slot.len, 1 | 3 | 4 | 7) => Some(Operand::Slot(*slot)),
            Some(Bound::Expression(e)) => Some(Operand::Expression(e.clone())),
            _ => None,
        }
    }
}

macro_rules! from_bound {
    ($variant:ident, $ty:ty) => {
        impl FromBound for $ty {
            fn from_bound(bound: Option<&Bound>) -> Option<Self> {
                match bound {
                    Some(Bound::$variant(x)) => Some(x.clone()),
                    _ => None,
                }
            }
        }
    };
}
from_bound!(Frames, Vec<(String, LinkId)>);
from_bound!(Arm, Arm);
from_bound!(Geometries, Vec<Geometry>);
from_bound!(Obstacles, Vec<Obstacle>);
from_bound!(Pairs, Vec<ExceptedPair>);
from_bound!(Joints, Vec<usize>);
from_bound!(PerJoint, Vec<(usize, Slot)>);
from_bound!(PerArm, Vec<(Arm, Slot)>);
from_bound!(Choice, String);
from_bound!(Expression, Expression);
from_bound!(Group, BoundParams);
from_bound!(Task, usize);

/// A declared safety field, by its index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FieldIndex(pub usize);

impl FromBound for FieldIndex {
    fn from_bound(bound: Option<&Bound>) -> Option<Self> {
        match bound {
            Some(Bound::Field(field)) => Some(FieldIndex(*field)),
            _ => None,
        }
    }
}

impl FromBound for (String, LinkId) {
    fn from_bound(bound: Option<&Bound>) -> Option<Self> {
        match bound {
            Some(Bound::Frame(name, link)) => Some((name.clone(), *link)),
            _ => None,
        }
    }
}

/// Lists the parameters of a task type: `name: RustType = ParamType, presence;` with a doc comment each.
#[macro_export]
macro_rules! params {
    (
        $(#[doc = $top:literal])*
        $vis:vis struct $Name:ident {
            $( $(#[doc = $doc:literal])* $field:ident : $ty:ty = $kind:expr, $presence:expr; )*
        }
    ) => {
        $(#[doc = $top])*
        #[derive(Clone, Debug)]
        $vis struct $Name { $( $(#[doc = $doc])* pub $field: $ty, )* }

        impl $Name {
            /// The table that schema, docs, completion and checks derive from.
            pub const INFO: &'static [$crate::params::ParamInfo] = &[$(
                $crate::params::ParamInfo { name: stringify!($field), doc: &[$($doc),*], ty: $kind, presence: $presence },
            )*];

            /// Reads bound parameters.
            ///
            /// # Errors
            /// A parameter has another form than [`Self::INFO`] declares.
            pub fn from_bound(bound: &$crate::bound::BoundParams) -> Result<Self, $crate::params::WrongForm> {
                Ok($Name { $(
                    $field: $crate::params::FromBound::from_bound(bound.get(stringify!($field)))
                        .ok_or_else(|| $crate::params::WrongForm { param: stringify!($field).to_string() })?,
                )* })
            }
        }
    };
}
