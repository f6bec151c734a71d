//! Distance of a shape to a half-space.

use nalgebra::{Isometry3, Vector3};

use crate::hull::Hull;
use crate::{Closest, Shape};

/// Returns the point of the shape that is lowest along the unit vector `n_W`, and its distance above the plane
/// `n·x = offset`: `distance = min over the shape of n·x - offset` \[m\].
///
/// `on_a` is that point of the shape, `on_b` its projection onto the plane, `normal` is `n_W`. If a face, an edge or
/// the axis of a capsule is parallel to the plane, its middle is returned. The result always exists.
pub fn closest_plane(shape: &Shape, X_WS: &Isometry3<f64>, n_W: &Vector3<f64>, offset: f64) -> Closest {
    let c = X_WS.translation.vector;
    // Sign that is zero if the feature is parallel to the plane.
    let against = |x: f64| if x.abs() <= 1e-12 { 0.0 } else { -x.signum() };
    let on_a = match *shape {
        Shape::Sphere { radius } => c - n_W * radius,
        Shape::Capsule { radius, half_length } => {
            let z = X_WS.rotation * Vector3::z();
            c + z * (half_length * against(z.dot(n_W))) - n_W * radius
        }
        Shape::Box { half } => {
            let n_S = X_WS.rotation.inverse() * n_W;
            let corner = Vector3::new(half[0] * against(n_S.x), half[1] * against(n_S.y), half[2] * against(n_S.z));
            c + X_WS.rotation * corner
        }
        Shape::Cylinder { radius, half_length } => {
            let n_S = X_WS.rotation.inverse() * n_W;
            let across = n_S.x.hypot(n_S.y);
            let rim = if across > 1e-12 { -radius / across } else { 0.0 };
            c + X_WS.rotation * Vector3::new(n_S.x * rim, n_S.y * rim, half_length * against(n_S.z))
        }
        Shape::Hull(ref hull) => c + X_WS.rotation * lowest(hull, &(X_WS.rotation.inverse() * n_W)),
    };
    let distance = n_W.dot(&on_a) - offset;
    Closest { distance, on_a, on_b: on_a - n_W * distance, normal: *n_W }
}

/// Lowest corner of a hull along a unit vector; the mean of the lowest ones if there are several.
fn lowest(hull: &Hull, n: &Vector3<f64>) -> Vector3<f64> {
    let least = hull.corners()[hull.farthest(&-n, 0)].dot(n);
    let level = least + 1e-12 * hull.radius();
    let (mut sum, mut count) = (Vector3::zeros(), 0.0);
    for p in hull.corners().iter().filter(|p| p.dot(n) <= level) {
        sum += p;
        count += 1.0;
    }
    sum / count
}
