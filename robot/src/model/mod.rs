//! The robot as it was built: links, joints, degrees of freedom. Read-only once made.

pub(crate) mod assemble;

use std::fmt;

use nalgebra::{Isometry3, Vector3};
use serde::{Deserialize, Serialize};

use crate::{Base, JointId, LinkId, PlacedShape, Visual};
use assemble::{Parts, Tape};

/// How a joint can move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum JointKind {
    /// Not at all.
    Fixed,
    /// Turns about its axis within limits \[rad\].
    Revolute,
    /// Turns about its axis without end \[rad\].
    Continuous,
    /// Slides along its axis \[m\].
    Prismatic,
}

/// What sets the position of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Drive {
    /// Nothing: the joint is fixed.
    Fixed,
    /// The degree of freedom with this index in [`Model::dofs`].
    Dof(usize),
    /// Follows a degree of freedom: `position = multiplier * q + offset`.
    Mimic {
        /// Index in [`Model::dofs`].
        dof: usize,
        /// Factor on the position (and so on the velocity) of the followed one.
        multiplier: f64,
        /// Position where the followed one is at zero \[rad or m\].
        offset: f64,
    },
    /// Held at this position \[rad or m\].
    Locked(f64),
}

/// A joint: the child frame is `origin`, then the motion about or along `axis`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// Name in the URDF.
    pub name: String,
    /// How it can move.
    pub kind: JointKind,
    /// The link it hangs on.
    pub parent: LinkId,
    /// The link it moves. Joint `k` always moves link `k + 1`.
    pub child: LinkId,
    /// Pose of the joint frame in the parent's frame.
    pub origin: Isometry3<f64>,
    /// Unit axis in the joint frame.
    pub axis: Vector3<f64>,
    /// What moves it.
    pub drive: Drive,
    /// Lowest position \[rad or m\]; -inf when there is none.
    #[serde(with = "crate::unlimited")]
    pub lower: f64,
    /// Highest position \[rad or m\]; inf when there is none.
    #[serde(with = "crate::unlimited")]
    pub upper: f64,
    /// Greatest speed \[rad/s or m/s\]; inf when there is none.
    #[serde(with = "crate::unlimited")]
    pub velocity: f64,
    /// Greatest effort \[N m or N\]; inf when there is none.
    #[serde(with = "crate::unlimited")]
    pub effort: f64,
    /// Greatest acceleration and deceleration \[rad/s² or m/s²\]; inf when there is none.
    #[serde(with = "crate::unlimited", default = "crate::unlimited::none")]
    pub acceleration: f64,
}

/// A rigid body and its frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Link {
    /// Name in the URDF.
    pub name: String,
    /// The joint that moves it; none for the root.
    pub parent_joint: Option<JointId>,
    /// Shapes for distances.
    pub collision: Vec<PlacedShape>,
    /// Shapes for drawing.
    pub visual: Vec<Visual>,
    /// Mass \[kg\]; 0 when the URDF gives none.
    pub mass: f64,
    /// Centre of that mass in the link's frame \[m\]; the link's origin when the URDF gives none.
    #[serde(default)]
    pub center_of_mass: Vector3<f64>,
}

/// Unit of a degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DofUnit {
    /// rad, and rad/s for its velocity.
    Radian,
    /// m, and m/s for its velocity.
    Metre,
}

/// A degree of freedom: one entry of the velocity `v`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Dof {
    /// The joint's name, or one of [`Base::dof_names`].
    pub name: String,
    /// The joint that it moves (mimicking ones apart); none for the base.
    pub joint: Option<JointId>,
    /// Its unit.
    pub unit: DofUnit,
    /// Index of its position in `q`; none for the base, whose `q` has other coordinates.
    pub q_index: Option<usize>,
    /// Lowest position; -inf when there is none.
    #[serde(with = "crate::unlimited")]
    pub lower: f64,
    /// Highest position; inf when there is none.
    #[serde(with = "crate::unlimited")]
    pub upper: f64,
    /// Greatest speed; inf when there is none.
    #[serde(with = "crate::unlimited")]
    pub velocity: f64,
    /// Greatest acceleration; inf when there is none.
    #[serde(with = "crate::unlimited", default = "crate::unlimited::none")]
    pub acceleration: f64,
}

/// A motion column that moves a link, and the degree of freedom that drives it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Support {
    /// Index of the column in [`crate::Data::columns`].
    pub column: u32,
    /// Index in [`Model::dofs`], the row entry it adds to.
    pub dof: u32,
}

/// A tree of links. Made by [`Model::from_urdf`] or by deserialising; the public fields are for
/// reading: kinematics runs on a flat copy taken when the model was made.
///
/// `q` holds the base's numbers ([`Base`]), then one per joint degree of freedom; `v` the base's
/// velocities, then the same joints in the same order.
#[derive(Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Parts", into = "Parts")]
pub struct Model {
    /// Name of the robot.
    pub name: String,
    /// What carries the root.
    pub base: Base,
    /// Parents before children; `links[0]` is the root.
    pub links: Vec<Link>,
    /// Depth first, children in file order; `joints[k]` moves `links[k + 1]`.
    pub joints: Vec<Joint>,
    /// Base first, then joints in order.
    pub dofs: Vec<Dof>,
    pub(crate) tape: Tape,
}

impl Model {
    /// Numbers in a configuration.
    #[inline]
    pub fn nq(&self) -> usize {
        self.base.nq() + self.dofs.len() - self.base.nv()
    }

    /// Numbers in a velocity: the degrees of freedom.
    #[inline]
    pub fn nv(&self) -> usize {
        self.dofs.len()
    }

    /// The root link.
    #[inline]
    pub fn root(&self) -> LinkId {
        LinkId(0)
    }

    /// The link of this name.
    pub fn link(&self, name: &str) -> Option<LinkId> {
        self.links.iter().position(|l| l.name == name).map(|i| LinkId(i as u32))
    }

    /// The joint of this name.
    pub fn joint(&self, name: &str) -> Option<JointId> {
        self.joints.iter().position(|j| j.name == name).map(|i| JointId(i as u32))
    }

    /// The degree of freedom of this name (a joint's, or one of the base's).
    pub fn dof(&self, name: &str) -> Option<usize> {
        self.dofs.iter().position(|d| d.name == name)
    }

    /// The link with this index, which must come from this model.
    #[inline]
    pub fn link_ref(&self, id: LinkId) -> &Link {
        &self.links[id.index()]
    }

    /// The joint with this index, which must come from this model.
    #[inline]
    pub fn joint_ref(&self, id: JointId) -> &Joint {
        &self.joints[id.index()]
    }

    /// The link that `link` hangs on; none for the root.
    pub fn parent(&self, link: LinkId) -> Option<LinkId> {
        self.link_ref(link).parent_joint.map(|j| self.joint_ref(j).parent)
    }

    /// Whether the two links can move against each other.
    pub fn moves_between(&self, a: LinkId, b: LinkId) -> bool {
        self.support(a) != self.support(b)
    }

    /// Position of `joint` at `q`: the degree of freedom, what follows from it, or the locked
    /// value \[rad or m\]; 0 for a fixed joint.
    pub fn joint_position(&self, joint: JointId, q: &[f64]) -> f64 {
        let at = |dof: usize| self.dofs[dof].q_index.map_or(0.0, |i| q[i]);
        match self.joint_ref(joint).drive {
            Drive::Fixed => 0.0,
            Drive::Locked(position) => position,
            Drive::Dof(dof) => at(dof),
            Drive::Mimic { dof, multiplier, offset } => multiplier * at(dof) + offset,
        }
    }

    /// The columns that move `link`, the base's first, then from the root outwards.
    #[inline]
    pub fn support(&self, link: LinkId) -> &[Support] {
        let (start, end) = self.tape.ranges[link.index()];
        &self.tape.supports[start as usize..end as usize]
    }
}

impl fmt::Debug for Model {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Model")
            .field("name", &self.name)
            .field("base", &self.base)
            .field("links", &self.links.len())
            .field("joints", &self.joints.len())
            .field("dofs", &self.dofs.len())
            .finish_non_exhaustive()
    }
}
