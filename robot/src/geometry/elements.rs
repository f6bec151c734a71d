//! Distances of shapes to the convex hulls of a few corners, such as points and triangles with a radius around them.

use nalgebra::{Isometry3, Vector3};

use super::convex::{self, Body};
use super::{CORES_MEET, Closest, Degenerate, closest, ends, rounded};
use super::{closest_point_segment, closest_segment_triangle};
use crate::Shape;

/// A shape whose distances to many elements are computed, in their frame.
pub(crate) struct Query<'a> {
    shape: &'a Shape,
    pose: Isometry3<f64>,
    /// Ends of the core of a ball or a capsule.
    segment: Option<[Vector3<f64>; 2]>,
    /// Radius around the core.
    radius: f64,
}

/// A point seen from a shape.
pub(crate) struct Seen {
    /// Its distance to the surface of the shape \[m\]; not above it for a point inside.
    pub distance: f64,
    /// The point of the shape's core that is nearest to it; `None` for a point inside.
    pub core: Option<Vector3<f64>>,
}

/// Closest points of a shape and an element, and the point of the shape's core.
#[derive(Clone, Copy)]
pub(crate) struct Found {
    pub closest: Closest,
    pub core: Vector3<f64>,
}

impl<'a> Query<'a> {
    /// A shape at a pose in the frame of the elements.
    pub fn new(shape: &'a Shape, pose: Isometry3<f64>) -> Query<'a> {
        let centre = pose.translation.vector;
        let (segment, radius) = match *shape {
            Shape::Sphere { radius } => (Some([centre; 2]), radius),
            Shape::Capsule { radius, half_length } => (Some(ends(half_length, &pose)), radius),
            Shape::Box { .. } | Shape::Cylinder { .. } | Shape::Hull(_) => (None, 0.0),
        };
        Query { shape, pose, segment, radius }
    }

    /// Radius of a ball that contains the core \[m\].
    pub fn size(&self) -> f64 {
        self.shape.bounding_radius() - self.radius
    }

    /// True if the pose is finite.
    pub fn is_finite(&self) -> bool {
        // A rotation that is NaN, and none of the translation, makes distances NaN, which are no nearest.
        self.pose.translation.vector.iter().all(|x| x.is_finite()) && self.pose.rotation.coords.norm().is_finite()
    }

    /// A point, seen from the shape.
    pub fn see(&self, p: &Vector3<f64>) -> Seen {
        if let Some([s0, s1]) = &self.segment {
            let core = closest_point_segment(p, s0, s1).0;
            return Seen { distance: (p - core).norm() - self.radius, core: Some(core) };
        }
        let point = Shape::Sphere { radius: 0.0 };
        match closest(self.shape, &self.pose, &point, &Isometry3::translation(p.x, p.y, p.z)) {
            Ok(c) => Seen { distance: c.distance, core: (c.distance > 0.0).then_some(c.on_a) },
            Err(_) => Seen { distance: f64::NEG_INFINITY, core: None },
        }
    }

    /// Closest points of the shape and the hull of `corners` with a radius around it.
    pub fn closest(&self, corners: &[Vector3<f64>], radius: f64) -> Result<Found, Degenerate> {
        let (core, other) = match (corners, &self.segment) {
            ([p], Some([s0, s1])) => (closest_point_segment(p, s0, s1).0, *p),
            ([p], None) => {
                let point = Shape::Sphere { radius };
                let c = closest(self.shape, &self.pose, &point, &Isometry3::translation(p.x, p.y, p.z))?;
                return Ok(Found { closest: c, core: c.on_a });
            }
            (&[a, b, c], Some([s0, s1])) => closest_segment_triangle(s0, s1, &[a, b, c]),
            _ => {
                let own = rounded(self.shape).core;
                let near = convex::nearest(own, &self.pose, Body::Corners(corners), &Isometry3::identity());
                let distance = near.between.norm();
                if !(distance > CORES_MEET && distance < f64::INFINITY) {
                    return Err(Degenerate::Touching);
                }
                // The difference of the two points would lose digits.
                (near.on_a, near.on_a - near.between)
            }
        };
        Ok(Found { closest: Closest::of_cores(&core, self.radius, &other, radius)?, core })
    }
}
