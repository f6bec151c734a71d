//! Expressions of the robot's present state: a list of operations over values that depend on time alone and over
//! quantities of the robot's state, with the exact derivatives with respect to its velocity and to time.
//!
//! The compiler folds everything that depends on time alone into entries of the table of values, whose rates it knows;
//! an expression contains the rest. [`Evaluation`] is an expression prepared for evaluation: one forward sweep computes
//! the value, one reverse sweep each row.

mod bounded;
mod center_of_mass;
mod circle;
mod evaluation;
mod human_field;
mod manipulability;
mod operand;
mod plane_distance;
mod point_distance;
mod term;

use nalgebra::Vector3;
use robot::{LinkId, Model};
use serde::{Deserialize, Serialize};

use crate::dimension::Dimension;
use crate::field::FieldProgram;
use crate::geometry::Geometry;
use crate::slot::Slot;

pub use bounded::{BoundedPart, BoundedSide, bounded_parts};
pub use center_of_mass::center_of_mass;
pub(crate) use center_of_mass::{CenterOfMass, exists as has_mass};
pub use circle::Turning;
pub use evaluation::Evaluation;
pub use expressions::{Op, ROUNDING};
pub use manipulability::{Manipulability, MotionPart};
pub use operand::Operand;
pub use plane_distance::{Plane, PlaneDistance};
pub use point_distance::PointDistance;
pub use term::{Term, settle, turn_seeds};

/// Quantity of the robot's present state, of which expressions are made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Leaf {
    /// The position in the world of a point fixed in a link, in m: three numbers.
    Point {
        /// The link.
        link: LinkId,
        /// The point in the link's frame, in m.
        offset: Vector3<f64>,
    },
    /// The orientation of a link in the world: four numbers `w x y z`.
    Orientation(LinkId),
    /// The position of a degree of freedom that has one, in rad or m: one number.
    Joint(usize),
    /// The distance between two parts of the robot in m, negative if they overlap: one number.
    Distance(Box<(Geometry, Geometry)>),
    /// The height of a part of the robot above a plane in m, negative below it: one number.
    PlaneDistance(Box<PlaneDistance>),
    /// The position in the world of the robot's centre of mass, in m: three numbers.
    Com,
    /// The manipulability of a frame, in m³ or, for its axes alone, as a number: one number.
    Manipulability(Box<Manipulability>),
    /// A safety field, whose points are operations of the expression: one number.
    Field(Box<FieldProgram>),
    /// The distance from a part of the robot to a point or a segment, whose ends are operations of the expression, in
    /// m: one number.
    PointDistance(Box<PointDistance>),
}

impl Leaf {
    /// Number of its numbers.
    pub fn width(&self) -> usize {
        match self {
            Leaf::Point { .. } | Leaf::Com => 3,
            Leaf::Orientation(_) => 4,
            Leaf::Joint(_)
            | Leaf::Distance(_)
            | Leaf::PlaneDistance(_)
            | Leaf::Manipulability(_)
            | Leaf::Field(_)
            | Leaf::PointDistance(_) => 1,
        }
    }

    /// Checks the leaf; `ops` is the number of operations of the expression.
    fn check(&self, model: &Model, ops: usize) -> Result<(), &'static str> {
        let ensure = |good: bool, message| if good { Ok(()) } else { Err(message) };
        let link = |l: &LinkId| ensure(l.index() < model.links.len(), "a frame does not exist");
        match self {
            Leaf::Point { link: l, offset } => {
                link(l)?;
                ensure(offset.iter().all(|x| x.is_finite()), "a point is not finite")
            }
            Leaf::Orientation(l) => link(l),
            Leaf::Joint(dof) => {
                ensure(model.dofs.get(*dof).is_some_and(|d| d.q_index.is_some()), "a joint has no position")
            }
            Leaf::Distance(pair) => [&pair.0, &pair.1].into_iter().try_for_each(|g| g.check(model)),
            Leaf::PlaneDistance(above) => above.check(model),
            Leaf::Com => ensure(center_of_mass::exists(model), "no link has a mass, and there is no centre of mass"),
            Leaf::Manipulability(of) => of.check(model),
            Leaf::Field(field) => field.check(model, ops),
            Leaf::PointDistance(away) => away.check(model, ops),
        }
    }

    /// Operations that it reads.
    pub fn reads(&self) -> &[[usize; 3]] {
        match self {
            Leaf::Field(field) => &field.points,
            Leaf::PointDistance(away) => &away.ends,
            _ => &[],
        }
    }

    /// Copy with the operations that it reads renumbered.
    pub fn renumber(&self, f: impl Fn(usize) -> usize) -> Leaf {
        match self {
            Leaf::Field(field) => Leaf::Field(Box::new(field.renumber(f))),
            Leaf::PointDistance(away) => Leaf::PointDistance(Box::new(away.renumber(f))),
            other => other.clone(),
        }
    }
}

/// An expression of the present state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Expression {
    /// Operations, operands before users. [`Op::Input`] reads `inputs`, [`Op::State`] the numbers of `leaves`, counted
    /// through all leaves; [`Op::T`], [`Op::Time`] and [`Op::Signal`] do not occur.
    pub ops: Vec<Op>,
    /// Indices into the table of values.
    pub inputs: Vec<usize>,
    /// Quantities of the robot's present state.
    pub leaves: Vec<Leaf>,
    /// Operations that compute the value: 1 for a number, 3 for a vector, 4 for an orientation `w x y z`, 7 for a pose
    /// (its position and its orientation).
    pub outputs: Vec<usize>,
    /// Dimension of the value; none for an orientation or a pose.
    pub dimension: Dimension,
}

impl Expression {
    /// Checks that every index is valid and every number is usable.
    ///
    /// # Errors
    /// Description of the first error.
    pub fn check(&self, model: &Model, slots: usize) -> Result<(), &'static str> {
        let ensure = |good: bool, message| if good { Ok(()) } else { Err(message) };
        self.leaves.iter().try_for_each(|l| l.check(model, self.ops.len()))?;
        let width: usize = self.leaves.iter().map(Leaf::width).sum();
        for (i, op) in self.ops.iter().enumerate() {
            match *op {
                Op::State(k) => {
                    ensure(k < width, "an operation reads a state that does not exist")?;
                    let points = self.leaf_of(k).map_or(&[][..], Leaf::reads);
                    ensure(points.iter().flatten().all(|&o| o < i), "a leaf reads a point that comes later")?;
                }
                Op::T | Op::Time | Op::Signal(_) | Op::Trajectory(_) => {
                    return Err("an expression of the state reads the time or a signal by itself");
                }
                _ => {}
            }
        }
        self.check_table(slots)
    }

    /// Checks that operations read earlier ones and existing values.
    fn check_table(&self, slots: usize) -> Result<(), &'static str> {
        let ensure = |good: bool, message| if good { Ok(()) } else { Err(message) };
        for (i, op) in self.ops.iter().enumerate() {
            ensure(op.operands().iter().flatten().all(|&o| o < i), "an operation reads one that comes later")?;
            if let Op::Input(k) = *op {
                ensure(k < self.inputs.len(), "an operation reads a value that does not exist")?;
            }
        }
        ensure(self.inputs.iter().all(|&at| at < slots), "a value has no place in the table of values")?;
        ensure(matches!(self.outputs.len(), 1 | 3 | 4 | 7), "an expression is no number, vector, orientation or pose")?;
        ensure(self.outputs.iter().all(|&o| o < self.ops.len()), "a result points nowhere")
    }

    /// Checks that an expression that reads nothing of a robot's state can be evaluated over so many values.
    ///
    /// # Errors
    /// Description of the first error.
    pub fn check_alone(&self, slots: usize) -> Result<(), &'static str> {
        let read = |op: &Op| matches!(op, Op::T | Op::Time | Op::Signal(_) | Op::Trajectory(_) | Op::State(_));
        if !self.leaves.is_empty() || self.ops.iter().any(read) {
            return Err("an expression reads the state of a robot, and there is none");
        }
        self.check_table(slots)
    }

    /// Leaf whose first number is number `k` of the leaves.
    fn leaf_of(&self, k: usize) -> Option<&Leaf> {
        let mut at = 0;
        self.leaves.iter().find(|leaf| {
            at += leaf.width();
            at - leaf.width() == k
        })
    }

    /// Entries of the table of values that it reads.
    pub fn slots(&self) -> impl Iterator<Item = Slot> {
        self.inputs.iter().map(|&at| Slot { at, len: 1 })
    }
}
