//! Robots as data: URDF to [`Model`], forward kinematics, Jacobians, shapes and distances.
//!
//! A [`Model`] describes the robot and never changes; a [`Data`] holds what is computed for one
//! configuration. Reading may fail and says where ([`UrdfMessage`]); after that nothing in here
//! allocates or fails, apart from a pair of shapes that has no normal ([`Degenerate`]).
//!
//! Conventions: SI units; twists and wrenches are `[linear; angular]`; velocities and Jacobians
//! are expressed in the world frame; `X_WL` is the pose of link frame L in the world W.

#![allow(non_snake_case, reason = "frames stand in the names: X_WL, p_W")]

mod base;
mod data;
pub mod geometry;
mod id;
mod kinematics;
mod manifold;
pub mod markup;
mod mesh;
mod model;
mod sample;
mod shape;
mod unlimited;
pub mod urdf;

pub use base::Base;
pub use data::{Data, Motion};
pub use geometry::{Closest, Degenerate, closest};
pub use id::{JointId, LinkId};
pub use model::{Dof, DofUnit, Drive, Joint, JointKind, Link, Model, Support};
pub use shape::{PlacedShape, Shape, Visual, VisualGeometry};
pub use urdf::{Options, UrdfCode, UrdfMessage};
