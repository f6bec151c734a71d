//! Distances between shapes: in closed form where there is one, else by [`convex`].
//!
//! A shape is a core (a point, a segment, a box, a cylinder, a hull) with a radius around it. The distance of two shapes
//! is the distance of their cores minus the radii. The normal is the direction between the nearest points of the cores: it exists and is
//! continuous until the cores intersect.

use nalgebra::{Isometry3, Vector3};

use crate::Shape;
use crate::hull::{Depth, Hull};
use convex::Body;

mod capsules;
mod convex;
mod cuboid;
mod cylinder;
mod elements;
mod plane;
mod segment;
mod triangle;

pub use capsules::{CAPSULES_AT_ONCE, Capsule, closest_capsules};
pub use cuboid::{PointBox, closest_box_box, closest_point_box, closest_segment_box};
pub use cylinder::{closest_point_cylinder, closest_segment_cylinder};
pub(crate) use elements::{Found, Query, Seen};
pub use plane::closest_plane;
pub use segment::{closest_point_segment, closest_segment_segment};
pub use triangle::{closest_point_triangle, closest_segment_triangle};

/// Minimum distance of the cores for a reliable normal \[m\].
const CORES_MEET: f64 = 1e-9;

/// Square of the sine of the angle between axes up to which these count as nearly parallel.
const PARALLEL: f64 = 1e-6;

/// The closest points of two shapes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// Distance of the surfaces \[m\]; negative if they overlap.
    pub distance: f64,
    /// Point on the surface of `a`, in the world \[m\].
    pub on_a: Vector3<f64>,
    /// Point on the surface of `b`, in the world \[m\].
    pub on_b: Vector3<f64>,
    /// Unit vector from `b` to `a`: `distance = normal · (on_a - on_b)`, and a motion of `a` along it increases the
    /// distance at unit rate.
    pub normal: Vector3<f64>,
}

/// Reason why the closest points do not exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Degenerate {
    /// The cores intersect, or a number is not finite, so that there is no normal. The caller keeps its last normal or
    /// reports a fault.
    #[error("the shapes overlap so deeply that no direction leads apart")]
    Touching,
}

impl Closest {
    /// Returns the result with the two shapes exchanged.
    pub fn swapped(self) -> Closest {
        Closest { distance: self.distance, on_a: self.on_b, on_b: self.on_a, normal: -self.normal }
    }

    /// Returns the result in the frame in which its present one has a pose.
    pub(crate) fn moved(self, X: &Isometry3<f64>) -> Closest {
        let point = |p: &Vector3<f64>| X.rotation * p + X.translation.vector;
        Closest { on_a: point(&self.on_a), on_b: point(&self.on_b), normal: X.rotation * self.normal, ..self }
    }

    /// Computes the result from the nearest points of two cores and their radii.
    fn of_cores(a: &Vector3<f64>, radius_a: f64, b: &Vector3<f64>, radius_b: f64) -> Result<Closest, Degenerate> {
        let away = a - b;
        let distance = away.norm();
        // An infinite distance has no direction either.
        if distance > CORES_MEET && distance < f64::INFINITY {
            let normal = away / distance;
            Ok(Closest {
                distance: distance - radius_a - radius_b,
                on_a: a - normal * radius_a,
                on_b: b + normal * radius_b,
                normal,
            })
        } else {
            Err(Degenerate::Touching)
        }
    }
}

/// Core of a shape, and the radius around it.
struct Rounded<'a> {
    core: Body<'a>,
    radius: f64,
}

fn rounded(shape: &Shape) -> Rounded<'_> {
    let (core, radius) = match *shape {
        Shape::Sphere { radius } => (Body::Point, radius),
        Shape::Capsule { radius, half_length } if half_length > 0.0 => (Body::Segment(half_length), radius),
        Shape::Capsule { radius, .. } => (Body::Point, radius),
        Shape::Box { half } => (Body::Box(half), 0.0),
        Shape::Cylinder { radius, half_length } => (Body::Cylinder(radius, half_length), 0.0),
        Shape::Hull(ref hull) => (Body::Hull(hull), 0.0),
    };
    Rounded { core, radius }
}

/// Ends of a segment of this half length along local z.
fn ends(half: f64, X_WS: &Isometry3<f64>) -> [Vector3<f64>; 2] {
    let z = half * axis(X_WS);
    [X_WS.translation.vector - z, X_WS.translation.vector + z]
}

/// Direction of local z: the third column of the rotation, in fewer operations than to turn a vector.
fn axis(X_WS: &Isometry3<f64>) -> Vector3<f64> {
    let q = &X_WS.rotation;
    Vector3::new(2.0 * (q.i * q.k + q.w * q.j), 2.0 * (q.j * q.k - q.w * q.i), 1.0 - 2.0 * (q.i * q.i + q.j * q.j))
}

/// Returns the closest points of `a` at `X_Wa` and `b` at `X_Wb`. Exact up to rounding; a cylinder against a box, a
/// cylinder or a hull is approached, and its distance is exact to 1e-10 of the shapes' sizes. Does not allocate; never
/// returns NaN, for any input.
///
/// The normal is continuous while the cores are apart. The closest points of two bodies with parallel faces or edges are
/// not unique, and may jump from one end to the other when the bodies turn.
///
/// Overlapping round shapes have a negative distance, and so has a ball whose centre is inside another shape.
/// [`Degenerate::Touching`] is returned if the cores intersect: coincident centres, crossing axes, an axis that enters
/// a box, boxes that touch.
pub fn closest(a: &Shape, X_Wa: &Isometry3<f64>, b: &Shape, X_Wb: &Isometry3<f64>) -> Result<Closest, Degenerate> {
    let (a, b) = (rounded(a), rounded(b));
    let (ra, rb) = (a.radius, b.radius);
    let (pa, pb) = (X_Wa.translation.vector, X_Wb.translation.vector);
    match (a.core, b.core) {
        (Body::Point, Body::Point) => Closest::of_cores(&pa, ra, &pb, rb),
        (Body::Point, Body::Segment(half)) => {
            let [s0, s1] = ends(half, X_Wb);
            Closest::of_cores(&pa, ra, &closest_point_segment(&pa, &s0, &s1).0, rb)
        }
        (Body::Segment(half), Body::Point) => {
            let [s0, s1] = ends(half, X_Wa);
            Closest::of_cores(&closest_point_segment(&pb, &s0, &s1).0, ra, &pb, rb)
        }
        (Body::Segment(half_a), Body::Segment(half_b)) => {
            let ([a0, a1], [b0, b1]) = (ends(half_a, X_Wa), ends(half_b, X_Wb));
            let (p, q) = closest_segment_segment(&a0, &a1, &b0, &b1);
            Closest::of_cores(&p, ra, &q, rb)
        }
        (Body::Point, Body::Box(_) | Body::Cylinder(..) | Body::Hull(_)) => ball(&pa, ra, X_Wb, b.core),
        (Body::Box(_) | Body::Cylinder(..) | Body::Hull(_), Body::Point) => {
            ball(&pb, rb, X_Wa, a.core).map(Closest::swapped)
        }
        (Body::Segment(half), Body::Box(_) | Body::Cylinder(..)) => capsule(ends(half, X_Wa), ra, X_Wb, b.core),
        (Body::Box(_) | Body::Cylinder(..), Body::Segment(half)) => {
            capsule(ends(half, X_Wb), rb, X_Wa, a.core).map(Closest::swapped)
        }
        (Body::Box(half_a), Body::Box(half_b)) => {
            let (p, q) = closest_box_box(X_Wa, &half_a, X_Wb, &half_b);
            Closest::of_cores(&p, 0.0, &q, 0.0)
        }
        _ => {
            let near = convex::nearest(a.core, X_Wa, b.core, X_Wb);
            let distance = near.between.norm();
            if !(distance > CORES_MEET && distance < f64::INFINITY) {
                return Err(Degenerate::Touching);
            }
            let normal = near.between / distance;
            let (on_a, on_b) = (near.on_a - normal * ra, near.on_b + normal * rb);
            Ok(Closest { distance: distance - ra - rb, on_a, on_b, normal })
        }
    }
}

/// A ball against a box, a cylinder or a hull.
fn ball(p_W: &Vector3<f64>, radius: f64, X_WB: &Isometry3<f64>, core: Body) -> Result<Closest, Degenerate> {
    let p_B = X_WB.rotation.inverse() * (p_W - X_WB.translation.vector);
    if !p_B.iter().all(|x| x.is_finite()) {
        return Err(Degenerate::Touching);
    }
    let near = match core {
        Body::Box(half) => closest_point_box(&p_B, &half),
        Body::Cylinder(radius, half) => closest_point_cylinder(&p_B, radius, half),
        Body::Hull(hull) => point_hull(&p_B, hull).ok_or(Degenerate::Touching)?,
        Body::Point | Body::Segment(_) | Body::Corners(_) => return Err(Degenerate::Touching),
    };
    let normal = X_WB.rotation * near.normal;
    let distance = near.distance - radius;
    if !distance.is_finite() {
        return Err(Degenerate::Touching);
    }
    Ok(Closest {
        distance,
        on_a: p_W - normal * radius,
        on_b: X_WB.rotation * near.on_box + X_WB.translation.vector,
        normal,
    })
}

/// The surface point of a hull nearest to a point (both in the hull's frame). `None` on the surface of a flat hull.
fn point_hull(p: &Vector3<f64>, hull: &Hull) -> Option<PointBox> {
    let at = Isometry3::translation(p.x, p.y, p.z);
    let near = convex::nearest(Body::Point, &at, Body::Hull(hull), &Isometry3::identity());
    let distance = near.between.norm();
    if distance > CORES_MEET {
        return Some(PointBox { distance, on_box: near.on_b, normal: near.between / distance });
    }
    let Depth { depth, normal } = hull.depth(p)?;
    Some(PointBox { distance: -depth, on_box: p + normal * depth, normal })
}

/// A capsule around the segment `s0 s1` against a box or a cylinder.
fn capsule([s0, s1]: [Vector3<f64>; 2], radius: f64, X_WB: &Isometry3<f64>, core: Body) -> Result<Closest, Degenerate> {
    let to_body = X_WB.rotation.inverse();
    let centre = to_body * ((s0 + s1) * 0.5 - X_WB.translation.vector);
    let along = to_body * ((s1 - s0) * 0.5);
    let (p, q) = match core {
        Body::Box(half) => closest_segment_box(&centre, &along, &half),
        Body::Cylinder(radius, half) => closest_segment_cylinder(&centre, &along, radius, half),
        Body::Point | Body::Segment(_) | Body::Hull(_) | Body::Corners(_) => return Err(Degenerate::Touching),
    };
    let to_world = |v: &Vector3<f64>| X_WB.rotation * v + X_WB.translation.vector;
    Closest::of_cores(&to_world(&p), radius, &to_world(&q), 0.0)
}
