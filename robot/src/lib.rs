//! Robot models: URDF to [`Model`], SRDF to [`Srdf`], forward kinematics, Jacobians, shapes and distances.
//!
//! A [`Model`] describes the robot and never changes; a [`Data`] holds the results for one configuration. Reading a
//! URDF may fail, with the location of each error ([`UrdfMessage`]). The computations that follow do not allocate,
//! except to create a workspace, and do not fail, except for a pair of shapes without a normal ([`Degenerate`]).
//!
//! Conventions: SI units; twists and wrenches are `[linear; angular]`; velocities and Jacobians
//! are expressed in the world frame; `X_WL` is the pose of link frame L in the world W.

#![allow(non_snake_case, reason = "frames stand in the names: X_WL, p_W")]

mod base;
pub mod contacts;
mod data;
mod excess;
mod followers;
pub mod geometry;
mod heights;
mod hull;
mod id;
mod kinematics;
mod manifold;
pub mod markup;
mod mesh;
mod model;
mod pieces;
mod points;
pub mod random;
mod sample;
mod shape;
mod soup;
pub mod srdf;
mod surface;
mod unlimited;
pub mod urdf;

pub use base::Base;
pub use data::{Data, Motion};
pub use excess::Excess;
pub use followers::Limits;
pub use geometry::{Closest, Degenerate, closest};
pub use heights::Heights;
pub use hull::{Hull, HullError};
pub use id::{JointId, LinkId};
pub use mesh::triangles as mesh_triangles;
pub use mesh::vertices as mesh_vertices;
pub use model::nearest_turn;
pub use model::{
    Dof, DofUnit, Drive, Joint, JointKind, Link, MergeError, Merged, MobileBase, Model, Placed, Support, WORLD,
};
pub use pieces::{FEWEST_KEPT, FilePieces, MOST_PIECES, MeshFile, PIECES_FOLDER, Pieces};
pub use points::{Points, points};
pub use shape::{PlacedShape, Shape, Visual, VisualGeometry};
pub use soup::{Frontier, MOST_CORNERS, MOST_ELEMENTS, Search, Soup, SoupError, Spot};
pub use srdf::{Srdf, SrdfCode, SrdfMessage};
pub use surface::{Surface, SurfaceError};
pub use urdf::{LinkMesh, Options, ReadUrdf, ShapeKind, Shapes, UrdfCode, UrdfMessage};
