//! Separation of two parts of the robot: closest points and the direction between them. The last valid direction is
//! kept for configurations without one.
//!
//! ```text
//! d = |p_a - p_b|       d' = n·(J_a - J_b) v,   n from p_b to p_a        thesis (3.21) to (3.24)
//! ```

use nalgebra::{Point3, Vector3};
use robot::{Shape, geometry};

use crate::geometry::Geometry;
use crate::state::State;

/// Two parts, and their last valid separation.
#[derive(Clone, Debug)]
pub struct Pair {
    /// One part.
    pub a: Geometry,
    /// The other.
    pub b: Geometry,
    last: Option<Last>,
}

/// Last valid separation.
#[derive(Clone, Copy, Debug)]
struct Last {
    /// From b to a, in the world.
    normal: Vector3<f64>,
    /// The closest points, in the frames of the two links.
    on_a: Point3<f64>,
    on_b: Point3<f64>,
}

/// Distance of two parts, with the closest points.
#[derive(Clone, Copy, Debug)]
pub struct Separation {
    /// Distance of the surfaces in m; negative if they overlap.
    pub distance: f64,
    /// Closest point of a in the world, in m.
    pub on_a: Vector3<f64>,
    /// Closest point of b in the world, in m.
    pub on_b: Vector3<f64>,
    /// Unit vector from b to a.
    pub normal: Vector3<f64>,
}

/// Reason why two parts have no direction of separation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeparationError {
    /// A pose is not finite.
    NotFinite,
    /// The cores of the parts intersect, and did so from the beginning.
    Overlap,
}

/// Distance of two parts whose cores intersect, in m: minus the radius around each.
pub(crate) fn overlap(a: &Shape, b: &Shape) -> f64 {
    let radius = |s: &Shape| match *s {
        Shape::Sphere { radius } | Shape::Capsule { radius, .. } => radius,
        Shape::Box { .. } | Shape::Cylinder { .. } | Shape::Hull(_) => 0.0,
    };
    -radius(a) - radius(b)
}

impl Pair {
    /// Two parts without a known separation.
    pub fn new(a: Geometry, b: Geometry) -> Self {
        Pair { a, b, last: None }
    }

    /// Forgets the last separation.
    pub fn forget(&mut self) {
        self.last = None;
    }

    /// Computes the closest points. If the cores intersect, the last valid direction and points are used. Allocates
    /// nothing.
    ///
    /// # Errors
    /// A pose is not finite, or the cores intersect and always did.
    pub fn find(&mut self, state: &State) -> Result<Separation, SeparationError> {
        let (link_a, link_b) = (state.data.pose(self.a.link), state.data.pose(self.b.link));
        let (pose_a, pose_b) = (link_a * self.a.origin, link_b * self.b.origin);
        match geometry::closest(&self.a.shape, &pose_a, &self.b.shape, &pose_b) {
            Ok(c) => {
                let (on_a, on_b) = (Point3::from(c.on_a), Point3::from(c.on_b));
                self.last = Some(Last {
                    normal: c.normal,
                    on_a: link_a.inverse_transform_point(&on_a),
                    on_b: link_b.inverse_transform_point(&on_b),
                });
                Ok(Separation { distance: c.distance, on_a: c.on_a, on_b: c.on_b, normal: c.normal })
            }
            Err(_) => {
                // A rotation that is NaN makes the translation NaN too.
                if !pose_a.translation.vector.iter().chain(&pose_b.translation.vector).all(|x| x.is_finite()) {
                    return Err(SeparationError::NotFinite);
                }
                let last = self.last.ok_or(SeparationError::Overlap)?;
                let (on_a, on_b) = (link_a * last.on_a, link_b * last.on_b);
                let distance = overlap(&self.a.shape, &self.b.shape);
                Ok(Separation { distance, on_a: on_a.coords, on_b: on_b.coords, normal: last.normal })
            }
        }
    }

    /// Adds `scale` times the row of the distance.
    pub fn add_row(&self, state: &State, separation: &Separation, scale: f64, row: &mut [f64]) {
        let n = separation.normal * scale;
        state.data.add_point(state.model, self.a.link, &separation.on_a, &n, row);
        state.data.add_point(state.model, self.b.link, &separation.on_b, &-n, row);
    }
}
