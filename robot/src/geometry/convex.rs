//! Distance of two convex bodies by their farthest points along directions: the algorithm of Gilbert, Johnson and Keerthi
//! (IEEE Journal of Robotics and Automation 4(2), 1988).
//!
//! The distance of the bodies A and B is that of the origin from the set of all `a - b`. The set is approached by
//! simplices of up to four of its points; the nearest point of a simplex is the best of those of its faces.

use nalgebra::{Isometry3, Vector3};

use crate::hull::Hull;

/// A convex body in its own frame: the core of a shape, without the radius around it.
#[derive(Clone, Copy, Debug)]
pub(super) enum Body<'a> {
    /// The origin.
    Point,
    /// From `-half` to `half` on local z.
    Segment(f64),
    /// Half the edge lengths.
    Box([f64; 3]),
    /// Radius, and half the length along local z.
    Cylinder(f64, f64),
    /// A hull.
    Hull(&'a Hull),
    /// The hull of a few points.
    Corners(&'a [Vector3<f64>]),
}

/// A body at a pose, and the corner of a hull that was found last.
struct Placed<'a> {
    body: Body<'a>,
    X_WB: Isometry3<f64>,
    near: usize,
}

impl Placed<'_> {
    /// Point of the body that is farthest along a direction, in the world.
    fn farthest(&mut self, direction: &Vector3<f64>) -> Vector3<f64> {
        let d = self.X_WB.rotation.inverse() * direction;
        let p = match self.body {
            Body::Point => return self.X_WB.translation.vector,
            Body::Segment(half) => Vector3::new(0.0, 0.0, half.copysign(d.z)),
            Body::Box(half) => Vector3::new(half[0].copysign(d.x), half[1].copysign(d.y), half[2].copysign(d.z)),
            Body::Cylinder(radius, half) => {
                let across = d.x.hypot(d.y);
                let scale = if across > 1e-12 * d.z.abs() { radius / across } else { 0.0 };
                Vector3::new(d.x * scale, d.y * scale, half.copysign(d.z))
            }
            Body::Hull(hull) => {
                self.near = hull.farthest(&d, self.near);
                hull.corners()[self.near]
            }
            Body::Corners(corners) => {
                let higher = |best: Vector3<f64>, p: &Vector3<f64>| if p.dot(&d) > best.dot(&d) { *p } else { best };
                corners.iter().skip(1).fold(corners[0], higher)
            }
        };
        self.X_WB.rotation * p + self.X_WB.translation.vector
    }
}

/// Nearest points of two bodies, in the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearest {
    pub on_a: Vector3<f64>,
    pub on_b: Vector3<f64>,
    /// `on_a - on_b`, computed without the cancellation of large coordinates.
    pub between: Vector3<f64>,
}

/// A point `w = a - b` of the set of differences.
#[derive(Clone, Copy, Default)]
struct Vertex {
    w: Vector3<f64>,
    a: Vector3<f64>,
    b: Vector3<f64>,
}

/// Points with their weights, whose mean is the nearest point of a simplex.
#[derive(Clone, Copy, Default)]
struct Simplex {
    vertices: [Vertex; 4],
    weights: [f64; 4],
    len: usize,
    /// The nearest point to the origin.
    nearest: Vector3<f64>,
}

/// Largest number of steps. Bodies with corners take fewer than ten, round ones some twenty.
const MOST_STEPS: usize = 64;

/// Relative accuracy of the squared distance at which the search ends.
const ACCURACY: f64 = 1e-13;

/// Returns the nearest points of two bodies; they are equal, up to rounding, if the bodies intersect. Always ends; does
/// not allocate.
pub(super) fn nearest(a: Body, X_Wa: &Isometry3<f64>, b: Body, X_Wb: &Isometry3<f64>) -> Nearest {
    // The world's origin may be far away: all points are relative to the middle of a.
    let origin = X_Wa.translation.vector;
    let mut A = Placed { body: a, X_WB: Isometry3::from_parts(Default::default(), X_Wa.rotation), near: 0 };
    let mut B = Placed {
        body: b,
        X_WB: Isometry3::from_parts((X_Wb.translation.vector - origin).into(), X_Wb.rotation),
        near: 0,
    };
    let mut vertex = |direction: &Vector3<f64>| {
        let (a, b) = (A.farthest(&-direction), B.farthest(direction));
        Vertex { w: a - b, a, b }
    };
    let apart = origin - X_Wb.translation.vector;
    let towards = if apart.norm_squared() > 0.0 { apart } else { Vector3::x() };
    let first = vertex(&towards);
    let mut best = Simplex { nearest: first.w, len: 1, ..Simplex::default() };
    (best.vertices[0], best.weights[0]) = (first, 1.0);
    for _ in 0..MOST_STEPS {
        let v = best.nearest;
        let squared = v.norm_squared();
        if squared.is_nan() || squared <= 0.0 {
            break;
        }
        let new = vertex(&v);
        let known = best.vertices[..best.len].iter().any(|old| old.w == new.w);
        if known || squared - v.dot(&new.w) <= ACCURACY * squared {
            break;
        }
        let next = improved(&best, new);
        // Without progress, rounding decides, and the present point is as good as any.
        let reached = next.nearest.norm_squared();
        if next.len == 0 || reached.is_nan() || reached >= squared {
            break;
        }
        best = next;
    }
    let mean = |of: fn(&Vertex) -> Vector3<f64>| {
        let all = best.vertices[..best.len].iter().zip(&best.weights);
        all.fold(Vector3::zeros(), |sum, (vertex, weight)| sum + of(vertex) * *weight)
    };
    Nearest { on_a: mean(|x| x.a) + origin, on_b: mean(|x| x.b) + origin, between: best.nearest }
}

/// Nearest simplex among those that contain the new vertex and some of the old ones: only these can be nearer.
fn improved(old: &Simplex, new: Vertex) -> Simplex {
    let mut best = Simplex::default();
    let mut least = f64::INFINITY;
    for chosen in 0..1usize << old.len {
        let mut candidate = Simplex { len: 1, ..Simplex::default() };
        candidate.vertices[0] = new;
        for i in (0..old.len).filter(|i| chosen >> i & 1 == 1) {
            if candidate.len < 4 {
                candidate.vertices[candidate.len] = old.vertices[i];
                candidate.len += 1;
            }
        }
        if !project(&mut candidate) {
            continue;
        }
        let squared = candidate.nearest.norm_squared();
        if squared < least {
            (best, least) = (candidate, squared);
        }
    }
    best
}

/// Computes the weights of the point of the plane through the vertices that is nearest to the origin. False if it is
/// outside the simplex, or if the simplex is degenerate.
fn project(s: &mut Simplex) -> bool {
    let w = s.vertices.map(|x| x.w);
    let weights = match s.len {
        1 => Some([1.0, 0.0, 0.0, 0.0]),
        2 => on_segment(&w[0], &w[1]),
        3 => on_triangle(&w[0], &w[1], &w[2]),
        _ => in_tetrahedron(&w),
    };
    let Some(weights) = weights else { return false };
    s.weights = weights;
    s.nearest = match s.len {
        4 => Vector3::zeros(),
        // The component along the plane is only rounding.
        3 => {
            let n = (w[1] - w[0]).cross(&(w[2] - w[0]));
            n * (n.dot(&w[0]) / n.norm_squared())
        }
        len => w[..len].iter().zip(&weights).fold(Vector3::zeros(), |sum, (w, weight)| sum + w * *weight),
    };
    true
}

fn on_segment(p: &Vector3<f64>, q: &Vector3<f64>) -> Option<[f64; 4]> {
    let d = q - p;
    let length2 = d.norm_squared();
    let t = -p.dot(&d) / length2;
    (t > 0.0 && t < 1.0).then_some([1.0 - t, t, 0.0, 0.0])
}

fn on_triangle(p: &Vector3<f64>, q: &Vector3<f64>, r: &Vector3<f64>) -> Option<[f64; 4]> {
    let (d, e) = (q - p, r - p);
    let n = d.cross(&e);
    let n2 = n.norm_squared();
    if n2.is_nan() || n2 <= 1e-24 * d.norm_squared() * e.norm_squared() {
        return None;
    }
    // Areas of the triangles with the projected origin, relative to that of the whole.
    let v = e.cross(p).dot(&n) / n2;
    let w = p.cross(&d).dot(&n) / n2;
    let u = 1.0 - v - w;
    (u > 0.0 && v > 0.0 && w > 0.0).then_some([u, v, w, 0.0])
}

fn in_tetrahedron(w: &[Vector3<f64>; 4]) -> Option<[f64; 4]> {
    let [a, b, c] = [w[1] - w[0], w[2] - w[0], w[3] - w[0]];
    let volume = a.cross(&b).dot(&c);
    if volume.is_nan() || volume.abs() <= 1e-14 * a.norm() * b.norm() * c.norm() {
        return None;
    }
    let o = -w[0];
    let u = o.cross(&b).dot(&c) / volume;
    let v = a.cross(&o).dot(&c) / volume;
    let x = a.cross(&b).dot(&o) / volume;
    let rest = 1.0 - u - v - x;
    (u > 0.0 && v > 0.0 && x > 0.0 && rest > 0.0).then_some([rest, u, v, x])
}
