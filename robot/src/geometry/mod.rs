//! Distances between shapes, in closed form.
//!
//! A shape is a core (a point, a segment, a box) with a radius around it. The distance of two shapes is the distance of
//! their cores minus the radii. The normal is the direction between the nearest points of the cores: it exists and is
//! continuous until the cores intersect.

use nalgebra::{Isometry3, Vector3};

use crate::Shape;

mod cuboid;
mod plane;
mod segment;

pub use cuboid::{PointBox, closest_box_box, closest_point_box, closest_segment_box};
pub use plane::closest_plane;
pub use segment::{closest_point_segment, closest_segment_segment};

/// Minimum distance of the cores for a reliable normal \[m\].
const CORES_MEET: f64 = 1e-9;

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

/// Core of a shape, without its radius.
enum Core {
    Point(Vector3<f64>),
    Segment(Vector3<f64>, Vector3<f64>),
    Box([f64; 3]),
}

fn core(shape: &Shape, X_WS: &Isometry3<f64>) -> (Core, f64) {
    let c = X_WS.translation.vector;
    match *shape {
        Shape::Sphere { radius } => (Core::Point(c), radius),
        Shape::Capsule { radius, half_length } if half_length > 0.0 => {
            let z = X_WS.rotation * Vector3::new(0.0, 0.0, half_length);
            (Core::Segment(c - z, c + z), radius)
        }
        Shape::Capsule { radius, .. } => (Core::Point(c), radius),
        Shape::Box { half } => (Core::Box(half), 0.0),
    }
}

/// Returns the closest points of `a` at `X_Wa` and `b` at `X_Wb`. Exact; does not allocate; never returns NaN, for any
/// input.
///
/// Overlapping round shapes have a negative distance, and so has a ball whose centre is inside a box.
/// [`Degenerate::Touching`] is returned if the cores intersect: coincident centres, crossing axes, an axis that enters
/// a box, boxes that touch.
pub fn closest(a: &Shape, X_Wa: &Isometry3<f64>, b: &Shape, X_Wb: &Isometry3<f64>) -> Result<Closest, Degenerate> {
    let (core_a, ra) = core(a, X_Wa);
    let (core_b, rb) = core(b, X_Wb);
    match (core_a, core_b) {
        (Core::Point(p), Core::Point(q)) => Closest::of_cores(&p, ra, &q, rb),
        (Core::Point(p), Core::Segment(s0, s1)) => {
            Closest::of_cores(&p, ra, &closest_point_segment(&p, &s0, &s1).0, rb)
        }
        (Core::Segment(s0, s1), Core::Point(p)) => {
            Closest::of_cores(&closest_point_segment(&p, &s0, &s1).0, ra, &p, rb)
        }
        (Core::Segment(a0, a1), Core::Segment(b0, b1)) => {
            let (p, q) = closest_segment_segment(&a0, &a1, &b0, &b1);
            Closest::of_cores(&p, ra, &q, rb)
        }
        (Core::Point(p), Core::Box(half)) => ball_box(&p, ra, X_Wb, &half),
        (Core::Box(half), Core::Point(p)) => ball_box(&p, rb, X_Wa, &half).map(Closest::swapped),
        (Core::Segment(s0, s1), Core::Box(half)) => capsule_box(&s0, &s1, ra, X_Wb, &half),
        (Core::Box(half), Core::Segment(s0, s1)) => capsule_box(&s0, &s1, rb, X_Wa, &half).map(Closest::swapped),
        (Core::Box(half_a), Core::Box(half_b)) => {
            let (p, q) = closest_box_box(X_Wa, &half_a, X_Wb, &half_b);
            Closest::of_cores(&p, 0.0, &q, 0.0)
        }
    }
}

fn ball_box(p_W: &Vector3<f64>, radius: f64, X_WB: &Isometry3<f64>, half: &[f64; 3]) -> Result<Closest, Degenerate> {
    let p_B = X_WB.rotation.inverse() * (p_W - X_WB.translation.vector);
    if !p_B.iter().all(|x| x.is_finite()) {
        return Err(Degenerate::Touching);
    }
    let near = closest_point_box(&p_B, half);
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

fn capsule_box(
    s0: &Vector3<f64>,
    s1: &Vector3<f64>,
    radius: f64,
    X_WB: &Isometry3<f64>,
    half: &[f64; 3],
) -> Result<Closest, Degenerate> {
    let to_box = X_WB.rotation.inverse();
    let centre = to_box * ((s0 + s1) * 0.5 - X_WB.translation.vector);
    let along = to_box * ((s1 - s0) * 0.5);
    let (p, q) = closest_segment_box(&centre, &along, half);
    let to_world = |v: &Vector3<f64>| X_WB.rotation * v + X_WB.translation.vector;
    Closest::of_cores(&to_world(&p), radius, &to_world(&q), 0.0)
}
