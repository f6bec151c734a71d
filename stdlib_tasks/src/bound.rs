//! Parameters after binding: numbers are indices into a table of values, and names are indices.
//!
//! The compiler writes these, a program stores them, and a task type reads its `Params` from them. Numbers may move
//! with time, so they are never stored here: a [`Slot`] locates this tick's value and its time derivative.

use std::collections::BTreeMap;

use robot::LinkId;
use serde::{Deserialize, Serialize};

use crate::expression::Expression;
pub use crate::geometry::Geometry;
pub use crate::obstacle::Obstacle;
pub use crate::slot::Slot;

/// Frames of an arm that task types use.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Arm {
    /// Its name in the spec.
    pub name: String,
    /// Link at the intersection of the shoulder axes; needed by `swivel_angle`.
    pub shoulder: Option<LinkId>,
    /// The elbow; needed by `swivel_angle`.
    pub elbow: Option<LinkId>,
    /// The wrist; needed by `swivel_angle`.
    pub wrist: Option<LinkId>,
    /// The end-effector frame.
    pub tip: LinkId,
}

/// Two links that a task leaves out, with the reason.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ExceptedPair {
    /// The two links, the one with the smaller index first.
    pub links: [LinkId; 2],
    /// Reason.
    pub why: Exception,
}

/// Reason for which a pair of links is left out.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Exception {
    /// The spec names the pair.
    Written,
    /// The robot's SRDF disables the pair, with this reason.
    Disabled(String),
    /// The two touch at every sampled posture: their shapes overlap by how they are drawn.
    Touching,
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
    /// Obstacles.
    Obstacles(Vec<Obstacle>),
    /// Pairs of links that are left out.
    Pairs(Vec<ExceptedPair>),
    /// Degrees of freedom, by index.
    Joints(Vec<usize>),
    /// A number for each of some degrees of freedom.
    PerJoint(Vec<(usize, Slot)>),
    /// A number for each of some arms.
    PerArm(Vec<(Arm, Slot)>),
    /// One of the words that the parameter allows.
    Choice(String),
    /// Axes, true for each of x, y and z that is chosen; at least one.
    Axes([bool; 3]),
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
    /// Slots of all its numbers.
    pub fn slots(&self) -> Vec<Slot> {
        match self {
            Bound::Value(s) => vec![*s],
            Bound::PerJoint(l) => l.iter().map(|x| x.1).collect(),
            Bound::PerArm(l) => l.iter().map(|x| x.1).collect(),
            Bound::Expression(e) => e.slots().collect(),
            Bound::Obstacles(all) => all.iter().flat_map(Obstacle::slots).collect(),
            Bound::Group(map) => map.values().flat_map(Bound::slots).collect(),
            _ => Vec::new(),
        }
    }
}

/// Bound parameters of a task, by name. Optional ones that were left out are absent.
pub type BoundParams = BTreeMap<String, Bound>;
