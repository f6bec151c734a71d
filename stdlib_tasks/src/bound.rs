//! Parameters after binding: numbers have become places in a table of values, names have become indices.
//!
//! The compiler writes these, a program stores them, and a task type reads its `Params` from them. Numbers may move
//! with time, so they are never stored here: a [`Slot`] says where this tick's value and its time derivative stand.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Point3, Vector3};
use robot::{LinkId, Model, Shape};
use serde::{Deserialize, Serialize};

use crate::expression::Expression;
use crate::task::{BuildError, Context};

/// A run of numbers in the table of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Slot {
    /// Index of the first number.
    pub at: usize,
    /// How many numbers: 1 for a scalar, 3 for a vector, 4 for a rotation as a unit quaternion `w x y z`.
    pub len: usize,
}

/// A shape fixed to a link: a point is a sphere of radius zero, a segment a capsule of radius zero.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Geometry {
    /// The name under which the spec knows it.
    pub name: String,
    /// The link that carries it.
    pub link: LinkId,
    /// Placement of the shape in the link's frame.
    pub origin: Isometry3<f64>,
    /// The shape.
    pub shape: Shape,
}

impl Geometry {
    /// A point of a link.
    pub fn point(name: impl Into<String>, link: LinkId, offset: Vector3<f64>) -> Self {
        let origin = Isometry3::translation(offset.x, offset.y, offset.z);
        Geometry { name: name.into(), link, origin, shape: Shape::Sphere { radius: 0.0 } }
    }

    /// Makes sure that the link exists, and that shape and placement are sound.
    ///
    /// # Errors
    /// What is wrong.
    pub fn check(&self, model: &Model) -> Result<(), &'static str> {
        let ensure = |good: bool, message| if good { Ok(()) } else { Err(message) };
        ensure(self.link.index() < model.links.len(), "a frame does not exist")?;
        let turn = self.origin.rotation.norm();
        let placed = self.origin.translation.vector.iter().all(|x| x.is_finite()) && (turn - 1.0).abs() < 1e-6;
        ensure(placed, "the placement of a shape is not finite")?;
        ensure(self.shape.is_sound(), "a shape has a negative or infinite size")
    }

    /// The point's place in the link's frame, in m (the centre, for other shapes).
    pub fn center(&self) -> Point3<f64> {
        Point3::from(self.origin.translation.vector)
    }
}

/// The frames of an arm that task types speak of.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Arm {
    /// Its name in the spec.
    pub name: String,
    /// Where the shoulder axes meet; needed by `swivel_angle`.
    pub shoulder: Option<LinkId>,
    /// The elbow; needed by `swivel_angle`.
    pub elbow: Option<LinkId>,
    /// The wrist; needed by `swivel_angle`.
    pub wrist: Option<LinkId>,
    /// The end-effector frame.
    pub tip: LinkId,
}

/// A bound parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Bound {
    /// Numbers.
    Value(Slot),
    /// A link, as a frame, with its name.
    Frame(String, LinkId),
    /// Several frames.
    Frames(Vec<(String, LinkId)>),
    /// An arm.
    Arm(Arm),
    /// Points, segments and shapes.
    Geometries(Vec<Geometry>),
    /// Degrees of freedom, by index.
    Joints(Vec<usize>),
    /// A number for each of some degrees of freedom.
    PerJoint(Vec<(usize, Slot)>),
    /// A number for each of some arms.
    PerArm(Vec<(Arm, Slot)>),
    /// One of the words that the parameter allows.
    Choice(String),
    /// An expression of the robot's present state.
    Expression(Expression),
    /// Parameters inside a parameter.
    Group(BTreeMap<String, Bound>),
    /// Another task of the program, by its index.
    Task(usize),
    /// A safety field of the program, by its index.
    Field(usize),
}

impl Bound {
    /// The places of all its numbers.
    pub fn slots(&self) -> Vec<Slot> {
        match self {
            Bound::Value(s) => vec![*s],
            Bound::PerJoint(l) => l.iter().map(|x| x.1).collect(),
            Bound::PerArm(l) => l.iter().map(|x| x.1).collect(),
            Bound::Expression(e) => e.slots().collect(),
            Bound::Group(map) => map.values().flat_map(Bound::slots).collect(),
            _ => Vec::new(),
        }
    }
}

/// The bound parameters of a task, by name. Optional ones that were left out are absent.
pub type BoundParams = BTreeMap<String, Bound>;

/// Makes sure that every index in the parameters points somewhere, so that a built task never looks outside a table.
///
/// # Errors
/// A link, a joint or a place in the table of values does not exist, or a shape has no sound size and placement.
pub fn check(params: &BoundParams, ctx: &Context) -> Result<(), BuildError> {
    for (name, bound) in params {
        check_one(bound, ctx).map_err(|message| BuildError::new(name, message))?;
    }
    Ok(())
}

fn check_one(bound: &Bound, ctx: &Context) -> Result<(), &'static str> {
    let ensure = |good: bool, message| if good { Ok(()) } else { Err(message) };
    let link = |l: &LinkId| ensure(l.index() < ctx.model.links.len(), "a frame does not exist");
    let dof = |d: &usize| ensure(*d < ctx.model.nv() && *d < ctx.speed.len(), "a joint does not exist");
    let slot = |s: &Slot| {
        let inside = s.at.checked_add(s.len).is_some_and(|end| end <= ctx.slot_count());
        ensure(inside, "a number has no place in the table of values")
    };
    let one = |s: &Slot| ensure(s.len == 1, "a single number is needed").and_then(|()| slot(s));
    let arm = |a: &Arm| {
        [Some(&a.tip), a.shoulder.as_ref(), a.elbow.as_ref(), a.wrist.as_ref()].into_iter().flatten().try_for_each(link)
    };
    match bound {
        Bound::Value(s) => slot(s),
        Bound::Frame(_, l) => link(l),
        Bound::Frames(list) => list.iter().try_for_each(|(_, l)| link(l)),
        Bound::Arm(a) => arm(a),
        Bound::Geometries(list) => list.iter().try_for_each(|g| g.check(ctx.model)),
        Bound::Joints(list) => list.iter().try_for_each(dof),
        Bound::PerJoint(list) => list.iter().try_for_each(|(d, s)| dof(d).and_then(|()| one(s))),
        Bound::PerArm(list) => list.iter().try_for_each(|(a, s)| arm(a).and_then(|()| one(s))),
        // The program knows which there are.
        Bound::Choice(_) | Bound::Task(_) | Bound::Field(_) => Ok(()),
        Bound::Expression(e) => e.check(ctx.model, ctx.slot_count()),
        Bound::Group(group) => group.values().try_for_each(|b| check_one(b, ctx)),
    }
}
