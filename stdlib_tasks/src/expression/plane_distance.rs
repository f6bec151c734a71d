//! Height of a part of the robot above a plane that is fixed in the world or in a link.
//!
//! ```text
//! h = min over the part of n·x - d        h' = n·(J_a - J_b) v        [m], [m/s]
//! ```
//!
//! where both Jacobians are those of the lowest point of the part, as a point of its own link and of the plane's link.
//! Unlike a distance between parts, the height has a direction everywhere, also below the plane.

use nalgebra::Vector3;
use robot::{LinkId, Model, geometry};
use serde::{Deserialize, Serialize};

use crate::geometry::Geometry;
use crate::state::State;

/// A plane `n·x = d`, and the side that `n` points to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plane {
    /// Link that carries it; `None` for the world.
    pub link: Option<LinkId>,
    /// n: the unit normal, in the axes of that link or of the world.
    pub normal: Vector3<f64>,
    /// d: the distance of the plane from the origin of these axes along the normal, in m.
    pub offset: f64,
}

/// A part, and the plane below it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlaneDistance {
    /// The part.
    pub part: Geometry,
    /// The plane.
    pub plane: Plane,
}

/// Lowest point at this tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lowest {
    /// h in m.
    pub height: f64,
    /// The point in the world, in m.
    pub(super) at: Vector3<f64>,
    /// The normal in the world.
    normal: Vector3<f64>,
}

impl PlaneDistance {
    /// Checks that links exist, and that numbers are usable.
    pub(super) fn check(&self, model: &Model) -> Result<(), &'static str> {
        let ensure = |good: bool, message| if good { Ok(()) } else { Err(message) };
        self.part.check(model)?;
        let Plane { link, normal, offset } = &self.plane;
        ensure(link.is_none_or(|l| l.index() < model.links.len()), "a frame does not exist")?;
        ensure((normal.norm() - 1.0).abs() < 1e-6, "the normal of a plane is not of unit length")?;
        ensure(offset.is_finite(), "a plane is not finite")
    }

    /// Computes the lowest point. Allocates nothing.
    pub(super) fn find(&self, state: &State) -> Lowest {
        let Plane { link, normal, offset } = self.plane;
        let (normal, offset) = match link.map(|l| state.data.pose(l)) {
            None => (normal, offset),
            Some(pose) => {
                let n = pose.rotation * normal;
                (n, offset + n.dot(&pose.translation.vector))
            }
        };
        let pose = state.data.pose(self.part.link) * self.part.origin;
        let found = geometry::closest_plane(&self.part.shape, &pose, &normal, offset);
        Lowest { height: found.distance, at: found.on_a, normal }
    }

    /// Adds `scale` times the row of the height.
    pub(super) fn add_row(&self, state: &State, lowest: &Lowest, scale: f64, row: &mut [f64]) {
        let n = lowest.normal * scale;
        state.data.add_point(state.model, self.part.link, &lowest.at, &n, row);
        if let Some(link) = self.plane.link {
            state.data.add_point(state.model, link, &lowest.at, &-n, row);
        }
    }
}
