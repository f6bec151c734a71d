//! Distances of shapes to the convex hulls of a few corners, such as points and triangles with a radius around them.

use nalgebra::{Isometry3, Vector3};

use super::convex::{self, Body};
use super::{CORES_MEET, Closest, Degenerate, closest, ends, rounded};
use super::{closest_point_segment, closest_point_triangle, closest_segment_triangle};
use crate::Shape;

/// A shape whose distances to many elements are computed, in their frame.
pub(crate) struct Query<'a> {
    shape: &'a Shape,
    pose: Isometry3<f64>,
    /// Ends of the core of a ball or a capsule.
    segment: Option<[Vector3<f64>; 2]>,
    /// Radius around the core.
    radius: f64,
    /// Direction of the axis of a capsule; zero for another shape.
    axis: Vector3<f64>,
}

/// A point seen from a shape.
pub(crate) struct Seen {
    /// Its distance to the surface of the shape \[m\]; not above it for a point inside.
    pub distance: f64,
    /// Unit vector from the point to the shape; zero for a point inside.
    pub towards: Vector3<f64>,
    /// The point of a shape that is neither ball nor capsule that is nearest to it; NaN for a point inside.
    pub on: Option<Vector3<f64>>,
}

/// Closest points of a shape and an element.
#[derive(Clone, Copy)]
pub(crate) struct Found {
    pub closest: Closest,
    /// Height of the nearest point of a capsule's axis from its middle \[m\]; zero for another shape.
    pub along: f64,
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
        let axis = match shape {
            Shape::Capsule { .. } => pose.rotation * Vector3::z(),
            _ => Vector3::zeros(),
        };
        Query { shape, pose, segment, radius, axis }
    }

    /// Half the length of the axis of a capsule \[m\]; zero for another shape.
    pub fn half_length(&self) -> f64 {
        match *self.shape {
            Shape::Capsule { half_length, .. } => half_length,
            _ => 0.0,
        }
    }

    /// Half the size of a shape that is neither ball nor capsule \[m\]; infinite for these.
    pub fn size(&self) -> f64 {
        if self.segment.is_some() { f64::INFINITY } else { self.shape.bounding_radius() }
    }

    /// True if the pose is finite.
    pub fn is_finite(&self) -> bool {
        // A rotation that is NaN, and none of the translation, makes distances NaN, which are no nearest.
        self.pose.translation.vector.iter().all(|x| x.is_finite()) && self.pose.rotation.coords.norm().is_finite()
    }

    /// A point, seen from the shape.
    pub fn see(&self, p: &Vector3<f64>) -> Seen {
        if let Some([s0, s1]) = &self.segment {
            let away = closest_point_segment(p, s0, s1).0 - p;
            let distance = away.norm();
            let towards = if distance > CORES_MEET { away / distance } else { Vector3::zeros() };
            return Seen { distance: distance - self.radius, towards, on: None };
        }
        let point = Shape::Sphere { radius: 0.0 };
        match closest(self.shape, &self.pose, &point, &Isometry3::translation(p.x, p.y, p.z)) {
            Ok(c) if c.distance > CORES_MEET => Seen { distance: c.distance, towards: c.normal, on: Some(c.on_a) },
            found => Seen {
                distance: found.map_or(f64::NEG_INFINITY, |c| c.distance),
                towards: Vector3::zeros(),
                on: Some(Vector3::repeat(f64::NAN)),
            },
        }
    }

    /// Height of a point along the axis of a capsule from its middle \[m\], and the direction of the axis; zero for another shape.
    pub fn along(&self, p: &Vector3<f64>) -> (f64, Vector3<f64>) {
        (self.axis.dot(&(p - self.pose.translation.vector)), self.axis)
    }

    /// Distance of a point to a ball or a capsule \[m\]; `None` for others, and if there are more corners.
    pub fn distance(&self, corners: &[Vector3<f64>]) -> Option<f64> {
        match (corners, &self.segment) {
            ([p], Some([s0, s1])) => Some((closest_point_segment(p, s0, s1).0 - p).norm() - self.radius),
            _ => None,
        }
    }

    /// Closest points of the shape and the hull of `corners` with a radius around it.
    pub fn closest(&self, corners: &[Vector3<f64>], radius: f64) -> Result<Found, Degenerate> {
        let (core, other) = match (corners, &self.segment) {
            ([p], Some([s0, s1])) => (closest_point_segment(p, s0, s1).0, *p),
            ([p], None) => {
                let point = Shape::Sphere { radius };
                let c = closest(self.shape, &self.pose, &point, &Isometry3::translation(p.x, p.y, p.z))?;
                return Ok(Found { closest: c, along: 0.0 });
            }
            (&[a, b, c], Some([s0, s1])) if s0 == s1 => (*s0, closest_point_triangle(s0, &[a, b, c])),
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
        let along = self.axis.dot(&(core - self.pose.translation.vector));
        Ok(Found { closest: Closest::of_cores(&core, self.radius, &other, radius)?, along })
    }
}
