//! Distances of cylinders to points and segments. A cylinder is centred at the origin of its frame, its axis is local z.

use nalgebra::Vector3;

use super::PointBox;

/// Returns the surface point of the cylinder nearest to `p` (both in the cylinder's frame). For a point inside it is on
/// the side or on an end, whichever is nearer; on the axis, the direction of local x is used.
pub fn closest_point_cylinder(p: &Vector3<f64>, radius: f64, half_length: f64) -> PointBox {
    let across = p.x.hypot(p.y);
    let outward = if across > 0.0 { Vector3::new(p.x / across, p.y / across, 0.0) } else { Vector3::x() };
    let on = Vector3::new(0.0, 0.0, p.z.clamp(-half_length, half_length)) + outward * across.min(radius);
    let away = p - on;
    let distance = away.norm();
    if distance > 1e-12 {
        return PointBox { distance, on_box: on, normal: away / distance };
    }
    let (side, end) = (radius - across, half_length - p.z.abs());
    if side <= end {
        PointBox { distance: -side, on_box: Vector3::new(0.0, 0.0, p.z) + outward * radius, normal: outward }
    } else {
        let normal = Vector3::new(0.0, 0.0, 1.0f64.copysign(p.z));
        PointBox { distance: -end, on_box: Vector3::new(p.x, p.y, half_length.copysign(p.z)), normal }
    }
}

/// Returns the nearest points of the segment `centre ± along` and the cylinder, all in the cylinder's frame: first the
/// point of the segment, then that of the cylinder. They are equal if the two intersect.
///
/// Half the squared distance of the point at t from a convex set is convex, with the derivative
/// `along·(p(t) - nearest(p(t)))`, which is continuous and does not fall. Its zeros are enclosed from both sides; if the
/// derivative is zero on an interval (the segment is parallel to the surface), the middle of the interval is returned.
pub fn closest_segment_cylinder(
    centre: &Vector3<f64>,
    along: &Vector3<f64>,
    radius: f64,
    half_length: f64,
) -> (Vector3<f64>, Vector3<f64>) {
    let nearest = |t: f64| {
        let p = centre + along * t;
        let across = p.x.hypot(p.y);
        let scale = if across > radius { radius / across } else { 1.0 };
        (p, Vector3::new(p.x * scale, p.y * scale, p.z.clamp(-half_length, half_length)))
    };
    let slope = |t: f64| {
        let (p, on) = nearest(t);
        along.dot(&(p - on))
    };
    // Slopes below this are rounding.
    let flat = 1e-13 * along.norm() * (along.norm() + radius + half_length);
    let lowest = enclosed(&|t| slope(t) >= -flat);
    let highest = enclosed(&|t| slope(t) > flat);
    nearest(0.5 * (lowest + highest))
}

/// Smallest t in -1..1 from which on a condition holds, up to rounding; 1 if it never does.
fn enclosed(holds: &dyn Fn(f64) -> bool) -> f64 {
    if holds(-1.0) {
        return -1.0;
    }
    if !holds(1.0) {
        return 1.0;
    }
    let (mut low, mut high) = (-1.0, 1.0);
    // Halves the interval until it is rounding.
    for _ in 0..54 {
        let middle = 0.5 * (low + high);
        if holds(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    0.5 * (low + high)
}
