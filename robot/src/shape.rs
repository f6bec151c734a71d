//! Shapes of links: those for distance computations, and those for drawing only.

use nalgebra::{Isometry3, Vector3};
use serde::{Deserialize, Serialize};

use crate::hull::{Hull, HullError};

/// A convex shape in its own frame, centred at the origin. Lengths in metres.
///
/// By default, a URDF cylinder is stored as a capsule of the same radius whose straight part is the cylinder's axis: it
/// contains the cylinder and extends beyond both ends by one radius.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Shape {
    /// A ball.
    Sphere {
        /// Radius \[m\].
        radius: f64,
    },
    /// All points within `radius` of the segment from `-half_length` to `half_length` on local z.
    Capsule {
        /// Radius \[m\].
        radius: f64,
        /// Half the distance between the centres of the two caps \[m\].
        half_length: f64,
    },
    /// A box with faces normal to the local axes.
    Box {
        /// Half the edge lengths along x, y, z \[m\].
        half: [f64; 3],
    },
    /// A cylinder about local z.
    Cylinder {
        /// Radius \[m\].
        radius: f64,
        /// Half the length \[m\].
        half_length: f64,
    },
    /// The convex hull of points.
    Hull(Hull),
}

/// A shape fixed to a link.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlacedShape {
    /// Pose of the shape's frame in the link's frame, X_LS.
    pub origin: Isometry3<f64>,
    /// The shape.
    pub shape: Shape,
}

impl PlacedShape {
    /// The convex hull of points in the frame of a link \[m\].
    ///
    /// # Errors
    /// There are no points, or one is not finite.
    pub fn hull(points: &[Vector3<f64>]) -> Result<PlacedShape, HullError> {
        let (middle, hull) = Hull::around(points)?;
        Ok(PlacedShape { origin: Isometry3::translation(middle.x, middle.y, middle.z), shape: Shape::Hull(hull) })
    }
}

/// A shape for drawing. It is not used in computations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Visual {
    /// Pose in the link's frame.
    pub origin: Isometry3<f64>,
    /// Geometry.
    pub geometry: VisualGeometry,
    /// Red, green, blue, alpha in 0..1, if the URDF defines a colour.
    pub color: Option<[f64; 4]>,
}

/// The geometry of a [`Visual`], as written in the URDF.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum VisualGeometry {
    /// A box.
    Box {
        /// Full edge lengths \[m\].
        size: [f64; 3],
    },
    /// A cylinder about local z.
    Cylinder {
        /// Radius \[m\].
        radius: f64,
        /// Height \[m\].
        length: f64,
    },
    /// A capsule about local z.
    Capsule {
        /// Radius \[m\].
        radius: f64,
        /// Distance between the centres of the caps \[m\].
        length: f64,
    },
    /// A ball.
    Sphere {
        /// Radius \[m\].
        radius: f64,
    },
    /// A mesh file.
    Mesh {
        /// Address as written, `package://` included.
        path: String,
        /// Factor on each coordinate.
        scale: [f64; 3],
    },
}

impl Shape {
    /// Returns true if all sizes are finite and not negative.
    pub fn is_sound(&self) -> bool {
        let good = |x: f64| x.is_finite() && x >= 0.0;
        match *self {
            Shape::Sphere { radius } => good(radius),
            Shape::Capsule { radius, half_length } | Shape::Cylinder { radius, half_length } => {
                good(radius) && good(half_length)
            }
            // Hulls are made of finite points alone.
            Shape::Hull(_) => true,
            Shape::Box { half } => half.iter().all(|&x| good(x)),
        }
    }

    /// Returns the volume \[m³\].
    pub fn volume(&self) -> f64 {
        use std::f64::consts::PI;
        match *self {
            Shape::Sphere { radius } => 4.0 / 3.0 * PI * radius.powi(3),
            Shape::Capsule { radius, half_length } => PI * radius * radius * (2.0 * half_length + 4.0 / 3.0 * radius),
            Shape::Box { half: [x, y, z] } => 8.0 * x * y * z,
            Shape::Cylinder { radius, half_length } => PI * radius * radius * 2.0 * half_length,
            Shape::Hull(ref hull) => hull.volume(),
        }
    }

    /// Returns the radius of the ball about the shape's origin that contains the shape \[m\].
    pub fn bounding_radius(&self) -> f64 {
        match *self {
            Shape::Sphere { radius } => radius,
            Shape::Capsule { radius, half_length } => radius + half_length,
            Shape::Box { half: [x, y, z] } => (x * x + y * y + z * z).sqrt(),
            Shape::Cylinder { radius, half_length } => radius.hypot(half_length),
            Shape::Hull(ref hull) => hull.radius(),
        }
    }
}
