//! Nearest points of points and segments.

use nalgebra::Vector3;

use super::PARALLEL;

/// Returns the point of the segment from `s0` to `s1` nearest to `p`, and its parameter in 0..1.
#[inline]
pub fn closest_point_segment(p: &Vector3<f64>, s0: &Vector3<f64>, s1: &Vector3<f64>) -> (Vector3<f64>, f64) {
    let d = s1 - s0;
    let length2 = d.norm_squared();
    let t = if length2 > 0.0 { ((p - s0).dot(&d) / length2).clamp(0.0, 1.0) } else { 0.0 };
    (s0 + d * t, t)
}

/// Returns the nearest points of the segments `a0 a1` and `b0 b1`; for overlapping parallel segments, the middle of the
/// overlap.
///
/// If the directions differ clearly, these are the nearest points of the lines, clamped into a, then into b, then into
/// a again. Source: Ericson, Real-Time Collision Detection (2005), 5.1.9. For nearly parallel lines this is
/// ill-conditioned: all four ends are tried as well.
pub fn closest_segment_segment(
    a0: &Vector3<f64>,
    a1: &Vector3<f64>,
    b0: &Vector3<f64>,
    b1: &Vector3<f64>,
) -> (Vector3<f64>, Vector3<f64>) {
    let (da, db, r) = (a1 - a0, b1 - b0, b0 - a0);
    let n = da.cross(&db);
    let (n2, aa, bb) = (n.norm_squared(), da.norm_squared(), db.norm_squared());
    if n2 > PARALLEL * aa * bb {
        let s = (r.cross(&db).dot(&n) / n2).clamp(0.0, 1.0);
        let t = (da * s - r).dot(&db) / bb;
        if (0.0..=1.0).contains(&t) {
            return (a0 + da * s, b0 + db * t);
        }
        let t = t.clamp(0.0, 1.0);
        let s = ((r + db * t).dot(&da) / aa).clamp(0.0, 1.0);
        return (a0 + da * s, b0 + db * t);
    }
    if n2 <= 1e-24 * aa * bb && aa > 0.0 && bb > 0.0 {
        // Parallel: the part of a that overlaps b.
        let (u, v) = (r.dot(&da) / aa, (r + db).dot(&da) / aa);
        let (low, high) = (u.min(v).max(0.0), u.max(v).min(1.0));
        if low < high {
            let p = a0 + da * (0.5 * (low + high));
            return (p, closest_point_segment(&p, b0, b1).0);
        }
    }
    nearest_by_ends(a0, a1, b0, b1)
}

/// Tries the four ends, and the lines' nearest points if these are defined; returns the best pair.
#[cold]
fn nearest_by_ends(
    a0: &Vector3<f64>,
    a1: &Vector3<f64>,
    b0: &Vector3<f64>,
    b1: &Vector3<f64>,
) -> (Vector3<f64>, Vector3<f64>) {
    let (da, db) = (a1 - a0, b1 - b0);
    let n = da.cross(&db);
    let n2 = n.norm_squared();
    let of_lines = if n2 > 0.0 { (b0 - a0).cross(&db).dot(&n) / n2 } else { 0.0 };
    // Alternating projection can only reduce the distance.
    let on_b = closest_point_segment(&(a0 + da * of_lines.clamp(0.0, 1.0)), b0, b1).0;
    let mut best = (closest_point_segment(&on_b, a0, a1).0, on_b);
    for pair in [
        (*a0, closest_point_segment(a0, b0, b1).0),
        (*a1, closest_point_segment(a1, b0, b1).0),
        (closest_point_segment(b0, a0, a1).0, *b0),
        (closest_point_segment(b1, a0, a1).0, *b1),
    ] {
        if (pair.0 - pair.1).norm_squared() < (best.0 - best.1).norm_squared() {
            best = pair;
        }
    }
    best
}
