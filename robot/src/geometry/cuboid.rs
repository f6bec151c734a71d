//! Distances of boxes to points, segments and boxes. A box is centred and axis-aligned in its own frame; `half` are
//! half its edge lengths.

use nalgebra::{Isometry3, Vector3};

/// Result of a point against a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointBox {
    /// Signed distance \[m\], negative inside.
    pub distance: f64,
    /// Nearest point on the surface of the box, in the box's frame.
    pub on_box: Vector3<f64>,
    /// Unit vector from the box to the point (outwards, also for a point inside).
    pub normal: Vector3<f64>,
}

/// Returns the surface point of the box nearest to `p` (both in the box's frame). For a point inside it is on the
/// nearest face; of equally near faces, the first in the order x, y, z.
pub fn closest_point_box(p: &Vector3<f64>, half: &[f64; 3]) -> PointBox {
    let h = Vector3::from(*half);
    let on_box = p.zip_map(&h, |x, h| x.clamp(-h, h));
    let away = p - on_box;
    let distance = away.norm();
    if distance > 1e-12 {
        return PointBox { distance, on_box, normal: away / distance };
    }
    let depth = |i: usize| h[i] - p[i].abs();
    let mut axis = 0;
    for i in 1..3 {
        if depth(i) < depth(axis) {
            axis = i;
        }
    }
    let side = if p[axis] < 0.0 { -1.0 } else { 1.0 };
    let mut normal = Vector3::zeros();
    normal[axis] = side;
    let mut on_box = *p;
    on_box[axis] = side * h[axis];
    PointBox { distance: -depth(axis), on_box, normal }
}

/// Returns the nearest points of the segment `centre ± along` and the box, all in the box's frame: first the point of
/// the segment, then that of the box. They are equal if the two intersect.
///
/// f(t) = Σ_i max(|c_i + t d_i| - h_i, 0)² for t in -1..1 is convex with a piecewise linear derivative. Its kinks are
/// the intersections of the line with the planes of the faces; between two kinks the zero is computed exactly. If f is
/// flat at its minimum (the segment is parallel to a face), the middle of the flat part is returned.
pub fn closest_segment_box(
    centre: &Vector3<f64>,
    along: &Vector3<f64>,
    half: &[f64; 3],
) -> (Vector3<f64>, Vector3<f64>) {
    let slope = |t: f64| {
        let mut sum = 0.0;
        for i in 0..3 {
            let x = centre[i] + t * along[i];
            sum += along[i] * (x - x.clamp(-half[i], half[i]));
        }
        sum
    };
    let mut kinks = [1.0_f64; 8];
    kinks[0] = -1.0;
    let mut n = 1;
    for i in 0..3 {
        if along[i] != 0.0 {
            for face in [-half[i], half[i]] {
                let t = (face - centre[i]) / along[i];
                if t > -1.0 && t < 1.0 {
                    let mut k = n;
                    while kinks[k - 1] > t {
                        kinks[k] = kinks[k - 1];
                        k -= 1;
                    }
                    kinks[k] = t;
                    n += 1;
                }
            }
        }
    }
    kinks[n] = 1.0;
    n += 1;
    // Smallest t with slope >= 0 and largest t with slope <= 0.
    let mut first = 1.0;
    let mut last = 1.0;
    let mut found = false;
    let mut before = (-1.0, slope(-1.0));
    if before.1 >= 0.0 {
        (first, last, found) = (-1.0, -1.0, true);
    }
    for &t in &kinks[1..n] {
        let g = slope(t);
        if !found && g >= 0.0 {
            let rise = g - before.1;
            first = if rise > 0.0 { before.0 - before.1 * (t - before.0) / rise } else { t };
            last = first;
            found = true;
        }
        if g <= 0.0 {
            last = t;
        } else if found {
            break;
        }
        before = (t, g);
    }
    let p = centre + along * (0.5 * (first + last)).clamp(-1.0, 1.0);
    let on_box = Vector3::new(p.x.clamp(-half[0], half[0]), p.y.clamp(-half[1], half[1]), p.z.clamp(-half[2], half[2]));
    (p, on_box)
}

/// Returns the nearest points of two boxes, in the world; they are equal if the boxes intersect.
///
/// Two separate polytopes are nearest at a corner and a face or at two edges, and every corner is the end of an edge:
/// it suffices to test the edges of each box against the other box. If the boxes intersect, an edge of one enters the
/// other.
pub fn closest_box_box(
    X_Wa: &Isometry3<f64>,
    half_a: &[f64; 3],
    X_Wb: &Isometry3<f64>,
    half_b: &[f64; 3],
) -> (Vector3<f64>, Vector3<f64>) {
    let X_ba = X_Wb.inv_mul(X_Wa);
    let X_ab = X_Wa.inv_mul(X_Wb);
    let (p, q, pq) = edges_against_box(&X_ba, half_a, half_b);
    let (r, s, rs) = edges_against_box(&X_ab, half_b, half_a);
    let to_world = |X: &Isometry3<f64>, v: &Vector3<f64>| X.rotation * v + X.translation.vector;
    if pq <= rs { (to_world(X_Wb, &p), to_world(X_Wb, &q)) } else { (to_world(X_Wa, &s), to_world(X_Wa, &r)) }
}

/// Returns the nearest points of the edges of box `e` (at `X_fe`) and box `f`, in the frame of `f`, with their squared
/// distance.
fn edges_against_box(X_fe: &Isometry3<f64>, half_e: &[f64; 3], half_f: &[f64; 3]) -> (Vector3<f64>, Vector3<f64>, f64) {
    let R = X_fe.rotation.to_rotation_matrix().into_inner();
    let mut best = (Vector3::zeros(), Vector3::zeros(), f64::INFINITY);
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let along = R.column(axis) * half_e[axis];
        for (su, sv) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            let centre = X_fe.translation.vector + R.column(u) * (su * half_e[u]) + R.column(v) * (sv * half_e[v]);
            let (p, q) = closest_segment_box(&centre, &along, half_f);
            let d2 = (p - q).norm_squared();
            if d2 < best.2 {
                best = (p, q, d2);
            }
        }
    }
    best
}
