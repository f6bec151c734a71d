//! Shapes that links carry.

use nalgebra::{Isometry3, Point3, Vector3};
use robot::{LinkId, Model, Shape};
use serde::{Deserialize, Serialize};

/// A shape fixed to a link: a point is a sphere of radius zero, a segment a capsule of radius zero.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Geometry {
    /// Name in the spec.
    pub name: String,
    /// Link that carries it.
    pub link: LinkId,
    /// Placement of the shape in the link's frame.
    pub origin: Isometry3<f64>,
    /// The shape.
    pub shape: Shape,
}

impl Geometry {
    /// A point of a link.
    pub fn point(name: impl Into<String>, link: LinkId, offset: Vector3<f64>) -> Self {
        let origin = Isometry3::translation(offset.x, offset.y, offset.z);
        Geometry { name: name.into(), link, origin, shape: Shape::Sphere { radius: 0.0 } }
    }

    /// Checks that the link exists, and that shape and placement are sound.
    ///
    /// # Errors
    /// Description of the first error.
    pub fn check(&self, model: &Model) -> Result<(), &'static str> {
        let ensure = |good: bool, message| if good { Ok(()) } else { Err(message) };
        ensure(self.link.index() < model.links.len(), "a frame does not exist")?;
        let turn = self.origin.rotation.norm();
        let placed = self.origin.translation.vector.iter().all(|x| x.is_finite()) && (turn - 1.0).abs() < 1e-6;
        ensure(placed, "the placement of a shape is not finite")?;
        ensure(self.shape.is_sound(), "a shape has a negative or infinite size")
    }

    /// Position of the point in the link's frame, in m (the centre, for other shapes).
    pub fn center(&self) -> Point3<f64> {
        Point3::from(self.origin.translation.vector)
    }
}
