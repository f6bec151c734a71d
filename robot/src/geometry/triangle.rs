//! Nearest points of triangles, points and segments.

use nalgebra::Vector3;

use super::segment::{closest_point_segment, closest_segment_segment};

/// Returns the point of a triangle nearest to `p`: its projection, or a point of an edge. A triangle without area has only
/// edges.
pub fn closest_point_triangle(p: &Vector3<f64>, [a, b, c]: &[Vector3<f64>; 3]) -> Vector3<f64> {
    // With the normal, a thin triangle loses fewer digits than with products of lengths along its edges.
    if let Some(n) = normal(a, b, c) {
        let inside = |s: &Vector3<f64>, t: &Vector3<f64>| (t - s).cross(&(p - s)).dot(&n) >= 0.0;
        if inside(a, b) && inside(b, c) && inside(c, a) {
            return p - n * (n.dot(&(p - a)) / n.norm_squared());
        }
    }
    let on = |s, t| closest_point_segment(p, s, t).0;
    let (ab, bc, ca) = (on(a, b), on(b, c), on(c, a));
    let gap = |q: &Vector3<f64>| (p - q).norm_squared();
    let nearer = if gap(&bc) < gap(&ab) { bc } else { ab };
    if gap(&ca) < gap(&nearer) { ca } else { nearer }
}

/// Normal of a triangle; `None` if it is so thin that its edges are as near to everything as it is, up to 1e-7 of its size.
fn normal(a: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>) -> Option<Vector3<f64>> {
    let (ab, ac) = (b - a, c - a);
    let n = ab.cross(&ac);
    (n.norm_squared() > 1e-14 * ab.norm_squared() * ac.norm_squared()).then_some(n)
}

/// Returns the nearest points of the segment `s0 s1` and a triangle: first that of the segment. They are equal if the
/// segment crosses the triangle.
///
/// Unless it does, one of both points is on an edge of the triangle, or an end of the segment.
pub fn closest_segment_triangle(
    s0: &Vector3<f64>,
    s1: &Vector3<f64>,
    triangle: &[Vector3<f64>; 3],
) -> (Vector3<f64>, Vector3<f64>) {
    let [a, b, c] = triangle;
    if let Some(n) = normal(a, b, c) {
        let (above, below) = (n.dot(&(s0 - a)), n.dot(&(s1 - a)));
        if above * below < 0.0 {
            let crossing = s0 + (s1 - s0) * (above / (above - below));
            let inside = |p: &Vector3<f64>, q: &Vector3<f64>| (q - p).cross(&(crossing - p)).dot(&n) >= 0.0;
            if inside(a, b) && inside(b, c) && inside(c, a) {
                return (crossing, crossing);
            }
        }
    }
    let mut best = (*s0, closest_point_triangle(s0, triangle));
    let mut least = (best.0 - best.1).norm_squared();
    let mut consider = |pair: (Vector3<f64>, Vector3<f64>)| {
        let squared = (pair.0 - pair.1).norm_squared();
        if squared < least {
            (best, least) = (pair, squared);
        }
    };
    consider((*s1, closest_point_triangle(s1, triangle)));
    for (p, q) in [(a, b), (b, c), (c, a)] {
        consider(closest_segment_segment(s0, s1, p, q));
    }
    best
}
