//! The robot model: links, joints, degrees of freedom. It is read-only after construction.

pub(crate) mod assemble;
mod bases;
mod circle;
mod merge;

use std::fmt;

use nalgebra::{Isometry3, Vector3};
use serde::{Deserialize, Serialize};

use crate::{JointId, LinkId, PlacedShape, Visual};
use assemble::{Parts, Tape};

pub use bases::MobileBase;
pub use circle::nearest_turn;
pub use merge::{MergeError, Merged, Placed, WORLD};

/// Motion type of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum JointKind {
    /// No motion.
    Fixed,
    /// Turns about its axis within limits \[rad\].
    Revolute,
    /// Turns about its axis without limits \[rad\].
    Continuous,
    /// Slides along its axis \[m\].
    Prismatic,
}

/// Source of a joint's position.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Drive {
    /// None: the joint is fixed.
    Fixed,
    /// The degree of freedom with this index in [`Model::dofs`].
    Dof(usize),
    /// Follows a degree of freedom: `position = multiplier * q + offset`.
    Mimic {
        /// Index in [`Model::dofs`].
        dof: usize,
        /// Factor on the position (and so on the velocity) of the leader.
        multiplier: f64,
        /// Position of this joint if the leader is at zero \[rad or m\].
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
    /// Motion type.
    pub kind: JointKind,
    /// Link that carries the joint.
    pub parent: LinkId,
    /// Link that the joint moves. Joint `k` always moves link `k + 1`.
    pub child: LinkId,
    /// Pose of the joint frame in the parent's frame.
    pub origin: Isometry3<f64>,
    /// Unit axis in the joint frame.
    pub axis: Vector3<f64>,
    /// Source of its position.
    pub drive: Drive,
    /// Lowest position \[rad or m\]; -inf if there is no limit.
    #[serde(with = "crate::unlimited")]
    pub lower: f64,
    /// Highest position \[rad or m\]; inf if there is no limit.
    #[serde(with = "crate::unlimited")]
    pub upper: f64,
    /// Maximum speed \[rad/s or m/s\]; inf if there is no limit.
    #[serde(with = "crate::unlimited")]
    pub velocity: f64,
    /// Maximum effort \[N m or N\]; inf if there is no limit.
    #[serde(with = "crate::unlimited")]
    pub effort: f64,
    /// Maximum acceleration and deceleration \[rad/s² or m/s²\]; inf if there is no limit.
    #[serde(with = "crate::unlimited", default = "crate::unlimited::none")]
    pub acceleration: f64,
}

/// A rigid body and its frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Link {
    /// Name in the URDF.
    pub name: String,
    /// Joint that moves the link; none for the root.
    pub parent_joint: Option<JointId>,
    /// Shapes for distance computations.
    pub collision: Vec<PlacedShape>,
    /// Shapes for drawing.
    pub visual: Vec<Visual>,
    /// Mass \[kg\]; 0 if the URDF has none.
    pub mass: f64,
    /// Centre of mass in the link's frame \[m\]; the link's origin if the URDF has none.
    #[serde(default)]
    pub center_of_mass: Vector3<f64>,
    /// Inertia about the centre of mass, along the axes of the link's frame: `ixx, iyy, izz, ixy, ixz, iyz` \[kg m²\]; zeros if
    /// the URDF has none. The kinematics does not use it.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub inertia: [f64; 6],
}

fn is_zero(inertia: &[f64; 6]) -> bool {
    *inertia == [0.0; 6]
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

impl DofUnit {
    /// Returns the one of two values that belongs to the unit.
    pub fn select<T>(self, metre: T, radian: T) -> T {
        match self {
            DofUnit::Metre => metre,
            DofUnit::Radian => radian,
        }
    }
}

/// A degree of freedom: one entry of the velocity `v`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Dof {
    /// The joint's name, or one of [`crate::Base::dof_names`] after the prefix of the robot.
    pub name: String,
    /// Joint that the degree of freedom drives directly, without its followers; none for that of a base.
    pub joint: Option<JointId>,
    /// Unit.
    pub unit: DofUnit,
    /// Index of its position in `q`; none for that of a base, whose configuration has other coordinates.
    pub q_index: Option<usize>,
    /// Lowest position; -inf if there is no limit.
    #[serde(with = "crate::unlimited")]
    pub lower: f64,
    /// Highest position; inf if there is no limit.
    #[serde(with = "crate::unlimited")]
    pub upper: f64,
    /// Maximum speed; inf if there is no limit.
    #[serde(with = "crate::unlimited")]
    pub velocity: f64,
    /// Maximum acceleration; inf if there is no limit.
    #[serde(with = "crate::unlimited", default = "crate::unlimited::none")]
    pub acceleration: f64,
}

/// A motion column of a link, and the degree of freedom that drives it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Support {
    /// Index of the column in [`crate::Data::columns`].
    pub column: u32,
    /// Index in [`Model::dofs`]: the entry of a Jacobian row that the column adds to.
    pub dof: u32,
}

/// A tree of links, created by [`Model::from_urdf`] or by deserialising. The public fields are for reading only:
/// kinematics runs on a flat copy that is made at construction.
///
/// `q` holds, robot by robot, the coordinates of its base ([`crate::Base`]), then one per joint degree of freedom; `v` the
/// velocities of its base, then the same joints in the same order.
#[derive(Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Parts", into = "Parts")]
pub struct Model {
    /// Name of the robot.
    pub name: String,
    /// Bases that move, in the order of their degrees of freedom.
    pub bases: Vec<MobileBase>,
    /// Links, parents before children; `links[0]` is the root.
    pub links: Vec<Link>,
    /// Joints, depth first, children in file order; `joints[k]` moves `links[k + 1]`.
    pub joints: Vec<Joint>,
    /// Degrees of freedom, robot by robot: those of its base, then those of its joints in order.
    pub dofs: Vec<Dof>,
    /// First links of the robots that [`Model::merged`] made the model of, in order; empty for the model of one URDF.
    pub roots: Vec<LinkId>,
    pub(crate) tape: Tape,
}

impl Model {
    /// Length of a configuration `q`.
    #[inline]
    pub fn nq(&self) -> usize {
        self.tape.nq
    }

    /// Length of a velocity `v`: the number of degrees of freedom.
    #[inline]
    pub fn nv(&self) -> usize {
        self.dofs.len()
    }

    /// Returns the root link.
    #[inline]
    pub fn root(&self) -> LinkId {
        LinkId(0)
    }

    /// Returns the link with this name.
    pub fn link(&self, name: &str) -> Option<LinkId> {
        self.links.iter().position(|l| l.name == name).map(|i| LinkId(i as u32))
    }

    /// Returns the joint with this name.
    pub fn joint(&self, name: &str) -> Option<JointId> {
        self.joints.iter().position(|j| j.name == name).map(|i| JointId(i as u32))
    }

    /// Returns the index of the degree of freedom with this name (of a joint or of the base).
    pub fn dof(&self, name: &str) -> Option<usize> {
        self.dofs.iter().position(|d| d.name == name)
    }

    /// Returns the link with this index, which must come from this model.
    #[inline]
    pub fn link_ref(&self, id: LinkId) -> &Link {
        &self.links[id.index()]
    }

    /// Returns the joint with this index, which must come from this model.
    #[inline]
    pub fn joint_ref(&self, id: JointId) -> &Joint {
        &self.joints[id.index()]
    }

    /// Returns the parent link of `link`; none for the root.
    pub fn parent(&self, link: LinkId) -> Option<LinkId> {
        self.link_ref(link).parent_joint.map(|j| self.joint_ref(j).parent)
    }

    /// Returns true if the two links can move relative to each other.
    pub fn moves_between(&self, a: LinkId, b: LinkId) -> bool {
        self.support(a) != self.support(b)
    }

    /// Returns the position of `joint` at `q`: its degree of freedom, the position that a follower derives from its
    /// leader, or the locked value \[rad or m\]; 0 for a fixed joint.
    pub fn joint_position(&self, joint: JointId, q: &[f64]) -> f64 {
        let at = |dof: usize| self.dofs[dof].q_index.map_or(0.0, |i| q[i]);
        match self.joint_ref(joint).drive {
            Drive::Fixed => 0.0,
            Drive::Locked(position) => position,
            Drive::Dof(dof) => at(dof),
            Drive::Mimic { dof, multiplier, offset } => multiplier * at(dof) + offset,
        }
    }

    /// Returns the columns that move `link`: those of the base, then from the root outwards.
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
            .field("bases", &self.bases)
            .field("links", &self.links.len())
            .field("joints", &self.joints.len())
            .field("dofs", &self.dofs.len())
            .finish_non_exhaustive()
    }
}
