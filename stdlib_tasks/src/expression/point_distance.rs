//! Distance of a part of the robot from a point, or from a segment between two points, as a leaf of an expression: the
//! ends are operations that come before it, like the points of people.
//!
//! ```text
//! d = |p_a - p_b|,  p_b = (1 - s) b_0 + s b_1       d' = n·J_a v - n·((1 - s) b_0' + s b_1')       [m], [m/s]
//! ```
//!
//! with the unit vector `n` from the segment to the part, and the share `s` of the nearest point of the segment. A
//! change of `s` contributes nothing: `n` is perpendicular to the segment, or `s` remains at an end.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use robot::{Model, Shape, geometry};
use serde::{Deserialize, Serialize};

use crate::closest_points::{SeparationError, overlap};
use crate::geometry::Geometry;
use crate::state::State;

/// A part, and the point or segment from which its distance is measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointDistance {
    /// The part.
    pub part: Geometry,
    /// Numbers x, y, z of both ends in the world, in m: operations of the expression that come before its own. For a
    /// point both ends are equal.
    pub ends: [[usize; 3]; 2],
}

/// Last valid separation.
#[derive(Clone, Copy, Debug)]
struct Last {
    /// Direction from the segment to the part, in the world.
    normal: Vector3<f64>,
    /// Closest point of the part, in the frame of its link.
    on_part: Point3<f64>,
    /// Share of the closest point of the segment.
    share: f64,
}

/// Closest point at this tick.
#[derive(Clone, Copy, Debug)]
struct Nearest {
    normal: Vector3<f64>,
    /// Point on the part, in the world.
    at: Vector3<f64>,
    share: f64,
}

/// Prepared leaf, with memory for configurations without a direction of separation.
#[derive(Clone, Debug)]
pub(super) struct Ready {
    away: PointDistance,
    last: Option<Last>,
    nearest: Option<Nearest>,
}

impl PointDistance {
    /// Checks that the part can be used and that the ends are below `end`.
    pub(super) fn check(&self, model: &Model, end: usize) -> Result<(), &'static str> {
        self.part.check(model)?;
        let inside = self.ends.iter().flatten().all(|&at| at < end);
        if inside { Ok(()) } else { Err("a point that a part is away from is nowhere") }
    }

    /// Copy with renumbered ends.
    pub(super) fn renumber(&self, f: impl Fn(usize) -> usize) -> PointDistance {
        PointDistance { ends: self.ends.map(|e| e.map(&f)), ..self.clone() }
    }
}

/// Segment as a shape with its pose.
fn segment(ends: &[Vector3<f64>; 2]) -> (Shape, Isometry3<f64>) {
    let along = ends[1] - ends[0];
    let middle = Translation3::from((ends[0] + ends[1]) * 0.5);
    let half_length = 0.5 * along.norm();
    if half_length <= 0.0 {
        return (Shape::Sphere { radius: 0.0 }, Isometry3::from_parts(middle, UnitQuaternion::identity()));
    }
    let turn = UnitQuaternion::rotation_between(&Vector3::z(), &along);
    // Opposite to z, the rotation is not unique.
    let turn = turn.unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    (Shape::Capsule { radius: 0.0, half_length }, Isometry3::from_parts(middle, turn))
}

impl Ready {
    pub fn new(away: &PointDistance) -> Self {
        Ready { away: away.clone(), last: None, nearest: None }
    }

    /// Forgets the last separation.
    pub fn forget(&mut self) {
        (self.last, self.nearest) = (None, None);
    }

    /// Distance at this tick in m; `registers` are the values of the operations before it. It is negative if the part
    /// is rounded and overlaps the segment. If the part's core intersects the segment, the last direction is used.
    /// Allocates nothing.
    ///
    /// # Errors
    /// A number is not finite, or the core intersects the segment and always did.
    pub fn find(&mut self, state: &State, registers: &[f64]) -> Result<f64, SeparationError> {
        let at = |i: usize| registers.get(i).copied().unwrap_or(f64::NAN);
        let ends = self.away.ends.map(|e| Vector3::from(e.map(at)));
        let part = &self.away.part;
        let link = state.data.pose(part.link);
        let pose = link * part.origin;
        if !pose.translation.vector.iter().all(|x| x.is_finite()) {
            return Err(SeparationError::NotFinite);
        }
        if !ends.iter().flatten().all(|x| x.is_finite()) {
            // The point of an absent signal, in the branch of an `if` that may not be chosen.
            self.nearest = None;
            return Ok(f64::NAN);
        }
        let (shape, place) = segment(&ends);
        let along = ends[1] - ends[0];
        match geometry::closest(&part.shape, &pose, &shape, &place) {
            Ok(c) => {
                let length = along.norm_squared();
                let share = if length > 0.0 { ((c.on_b - ends[0]).dot(&along) / length).clamp(0.0, 1.0) } else { 0.0 };
                let on_part = link.inverse_transform_point(&Point3::from(c.on_a));
                self.last = Some(Last { normal: c.normal, on_part, share });
                self.nearest = Some(Nearest { normal: c.normal, at: c.on_a, share });
                Ok(c.distance)
            }
            Err(_) => {
                let Last { normal, on_part, share } = self.last.ok_or(SeparationError::Overlap)?;
                self.nearest = Some(Nearest { normal, at: (link * on_part).coords, share });
                Ok(overlap(&part.shape, &shape))
            }
        }
    }

    /// Propagates the adjoint `g` of the distance to the operations of the ends.
    pub fn pull(&self, g: f64, adjoints: &mut [f64]) {
        let Some(Nearest { normal, share, .. }) = self.nearest else { return };
        for (end, share) in self.away.ends.iter().zip([1.0 - share, share]) {
            for (&op, n) in end.iter().zip(normal.iter()) {
                if let Some(adjoint) = adjoints.get_mut(op) {
                    *adjoint -= g * share * n;
                }
            }
        }
    }

    /// Adds its row for the adjoint `g`. Returns the magnitude of the terms that were summed.
    pub fn add_row(&self, state: &State, g: f64, row: &mut [f64]) -> f64 {
        let Some(Nearest { normal, at, .. }) = self.nearest else { return 0.0 };
        state.data.add_point(state.model, self.away.part.link, &at, &(normal * g), row);
        g.abs() * (1.0 + at.norm())
    }
}
