//! Convex polygons in the plane: half-planes, Minkowski sums and Pontryagin differences (armchair, section 1.4).

use geo::{ConvexHull, MultiPoint};
use serde::{Deserialize, Serialize};

/// A point, or a vector (m).
pub type Point = [f64; 2];

/// Area (m^2) below which a polygon counts as degenerate.
const FLAT: f64 = 1e-9;
/// Length (m) below which two corners are one.
const SAME: f64 = 1e-9;

/// The half-plane `normal . y <= bound`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Unit vector that points out of the polygon.
    pub normal: Point,
    /// Distance of the line from the origin (m), negative if the origin is outside.
    pub bound: f64,
}

impl Face {
    /// Distance of a point outside of the half-plane (m); negative inside.
    pub fn outside(&self, at: Point) -> f64 {
        dot(self.normal, at) - self.bound
    }
}

impl Face {
    /// The half-plane on the other side of the line.
    pub fn opposite(&self) -> Face {
        Face { normal: [-self.normal[0], -self.normal[1]], bound: -self.bound }
    }
}

/// A convex polygon with an inside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<Point>", into = "Vec<Point>")]
pub struct Convex {
    /// Corners, counterclockwise.
    corners: Vec<Point>,
    faces: Vec<Face>,
}

impl TryFrom<Vec<Point>> for Convex {
    type Error = &'static str;

    fn try_from(corners: Vec<Point>) -> Result<Convex, Self::Error> {
        Convex::hull(&corners).ok_or("a convex polygon has an inside and finite corners")
    }
}

impl From<Convex> for Vec<Point> {
    fn from(of: Convex) -> Vec<Point> {
        of.corners
    }
}

impl Convex {
    /// The convex hull of points; none if it has no inside, or a number is not finite.
    pub fn hull(points: &[Point]) -> Option<Convex> {
        if points.iter().flatten().any(|x| !x.is_finite()) {
            return None;
        }
        let hull = MultiPoint::from_iter(points.iter().map(|[x, y]| (*x, *y))).convex_hull();
        let mut corners: Vec<Point> = Vec::new();
        // The ring of a polygon ends with its first point.
        for at in hull.exterior().points() {
            let at = [at.x(), at.y()];
            if corners.iter().all(|corner| distance(*corner, at) > SAME) {
                corners.push(at);
            }
        }
        Convex::of_corners(corners)
    }

    /// A polygon of corners in counterclockwise order.
    fn of_corners(corners: Vec<Point>) -> Option<Convex> {
        if corners.len() < 3 || area(&corners) < FLAT {
            return None;
        }
        let face = |i: usize| {
            let (from, to) = (corners[i], corners[(i + 1) % corners.len()]);
            let along = minus(to, from);
            let normal = [along[1] / norm(along), -along[0] / norm(along)];
            Face { normal, bound: dot(normal, from) }
        };
        let faces = (0..corners.len()).map(face).collect();
        Some(Convex { corners, faces })
    }

    /// A rectangle with its middle in the origin; `size` is its width and height (m), more than 0.
    pub fn rectangle([width, height]: Point) -> Option<Convex> {
        let (x, y) = (0.5 * width, 0.5 * height);
        Convex::hull(&[[-x, -y], [x, -y], [x, y], [-x, y]])
    }

    /// A regular polygon with its middle in the origin and its corners at this distance (m) from it, with the middle of a face
    /// on the x axis.
    pub fn regular(corners: usize, radius: f64) -> Option<Convex> {
        let corner = |i: usize| {
            let (sin, cos) = (std::f64::consts::TAU * (i as f64 + 0.5) / corners as f64).sin_cos();
            [radius * cos, radius * sin]
        };
        Convex::hull(&(0..corners).map(corner).collect::<Vec<Point>>())
    }

    /// Corners, counterclockwise.
    pub fn corners(&self) -> &[Point] {
        &self.corners
    }

    /// Its half-planes, in the order of the corners at which their lines begin.
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// The greatest value of `normal . y` over the polygon (m).
    pub fn support(&self, normal: Point) -> f64 {
        self.corners.iter().map(|corner| dot(normal, *corner)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The smallest box around it: its lower left and its upper right corner (m).
    pub fn bounds(&self) -> [Point; 2] {
        let each = |axis: usize, pick: fn(f64, f64) -> f64, from: f64| {
            self.corners.iter().map(|corner| corner[axis]).fold(from, pick)
        };
        let (least, most) = (f64::INFINITY, f64::NEG_INFINITY);
        [[each(0, f64::min, least), each(1, f64::min, least)], [each(0, f64::max, most), each(1, f64::max, most)]]
    }

    /// Distance of a point outside of its farthest half-plane (m): negative inside, zero on the boundary.
    pub fn outside(&self, at: Point) -> f64 {
        self.faces.iter().map(|face| face.outside(at)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Returns true for a point inside, or outside by at most `slack` (m).
    pub fn contains(&self, at: Point, slack: f64) -> bool {
        self.outside(at) <= slack
    }

    /// The mean of its corners (m).
    pub fn middle(&self) -> Point {
        let sum = self.corners.iter().fold([0.0; 2], |sum, at| plus(sum, *at));
        sum.map(|x| x / self.corners.len() as f64)
    }

    /// The polygon moved by a vector (m).
    pub fn moved(&self, by: Point) -> Convex {
        let corners = self.corners.iter().map(|corner| plus(*corner, by)).collect();
        let faces = self.faces.iter().map(|face| Face { bound: face.bound + dot(face.normal, by), ..*face }).collect();
        Convex { corners, faces }
    }

    /// The polygon reflected in the origin.
    pub fn reflected(&self) -> Convex {
        let corners = self.corners.iter().map(|[x, y]| [-x, -y]).collect();
        let face = |face: &Face| Face { normal: [-face.normal[0], -face.normal[1]], bound: face.bound };
        Convex { corners, faces: self.faces.iter().map(face).collect() }
    }

    /// The Minkowski sum of both: all sums of a point of one and a point of the other. The sum of convex polygons is the hull of
    /// the sums of their corners.
    pub fn sum(&self, other: &Convex) -> Convex {
        self.sum_with_points(&other.corners)
    }

    /// The Minkowski sum with the hull of points, which may have no inside.
    pub fn sum_with_points(&self, points: &[Point]) -> Convex {
        let sums: Vec<Point> =
            points.iter().flat_map(|p| self.corners.iter().map(|corner| plus(*corner, *p))).collect();
        Convex::hull(&sums).unwrap_or_else(|| self.clone())
    }

    /// The Pontryagin difference: all points to which `other` can be moved without leaving this polygon. None: it has no inside.
    pub fn difference(&self, other: &Convex) -> Option<Convex> {
        let shrunk = self.faces.iter().map(|face| Face { bound: face.bound - other.support(face.normal), ..*face });
        // Wherever `other` is, one of its points is in this polygon.
        let around = self.moved(other.middle().map(|x| -x));
        shrunk.into_iter().try_fold(around, |rest, face| rest.cut(&face))
    }

    /// The part of the polygon in a half-plane; none: it has no inside.
    pub fn cut(&self, face: &Face) -> Option<Convex> {
        let mut kept = Vec::new();
        for (i, from) in self.corners.iter().enumerate() {
            let to = self.corners[(i + 1) % self.corners.len()];
            let (a, b) = (face.outside(*from), face.outside(to));
            if a <= 0.0 {
                kept.push(*from);
            }
            if (a < 0.0 && b > 0.0) || (a > 0.0 && b < 0.0) {
                let share = a / (a - b);
                kept.push([0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis])));
            }
        }
        Convex::hull(&kept)
    }

    /// The greatest distance between both along a normal of a face of one of them (m): positive if they are apart, negative if
    /// they overlap. For polygons that overlap it is the depth of the overlap.
    pub fn gap(&self, other: &Convex) -> f64 {
        let along = |of: &Convex, to: &Convex| {
            let gaps = of
                .faces
                .iter()
                .map(|face| to.corners.iter().map(|corner| face.outside(*corner)).fold(f64::INFINITY, f64::min));
            gaps.fold(f64::NEG_INFINITY, f64::max)
        };
        along(self, other).max(along(other, self))
    }
}

/// The largest convex parts of a polygon that are on the outer side of a face of each hole. Together they cover what the holes
/// leave of it.
pub fn parts_around(whole: &Convex, holes: &[Convex]) -> Vec<Convex> {
    let mut parts = vec![whole.clone()];
    for hole in holes {
        let (mut next, mut touched): (Vec<Convex>, Vec<Convex>) = (Vec::new(), Vec::new());
        for part in parts {
            match part.gap(hole) >= -SAME {
                true => next.push(part),
                false => touched.extend(hole.faces().iter().filter_map(|face| part.cut(&face.opposite()))),
            }
        }
        next.extend(touched);
        // A part within another one adds nothing.
        let mut kept: Vec<Convex> = Vec::new();
        for part in next {
            let within = |other: &Convex| part.corners.iter().all(|corner| other.contains(*corner, SAME));
            if kept.iter().any(within) {
                continue;
            }
            kept.retain(|other| !other.corners.iter().all(|corner| part.contains(*corner, SAME)));
            kept.push(part);
        }
        parts = kept;
    }
    parts
}

/// Returns true if corners are those of a convex polygon, in either order, without a corner that the hull lacks.
pub fn is_convex(corners: &[Point]) -> bool {
    Convex::hull(corners).is_some_and(|hull| {
        let perimeter = |of: &[Point]| -> f64 { (0..of.len()).map(|i| distance(of[i], of[(i + 1) % of.len()])).sum() };
        // A polygon around the same hull in another order, or with a corner inside, is longer than the hull.
        (perimeter(corners) - perimeter(hull.corners())).abs() <= 1e-9 * perimeter(corners).max(1.0)
    })
}

/// Twice the area is the sum of the cross products; positive for counterclockwise corners.
fn area(corners: &[Point]) -> f64 {
    let cross = |i: usize| {
        let ([x, y], [u, v]) = (corners[i], corners[(i + 1) % corners.len()]);
        x * v - y * u
    };
    0.5 * (0..corners.len()).map(cross).sum::<f64>()
}

/// Scalar product.
pub fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Sum.
pub fn plus(a: Point, b: Point) -> Point {
    [a[0] + b[0], a[1] + b[1]]
}

/// Difference.
pub fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

/// Length.
pub fn norm(a: Point) -> f64 {
    f64::hypot(a[0], a[1])
}

/// Distance.
pub fn distance(a: Point, b: Point) -> f64 {
    norm(minus(a, b))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn polygon() -> impl Strategy<Value = Convex> {
        let point = [-5.0..5.0_f64, -5.0..5.0_f64];
        prop::collection::vec(point, 3..9).prop_filter_map("no inside", |points| Convex::hull(&points))
    }

    #[test]
    fn known_polygons() {
        let square = Convex::rectangle([2.0, 2.0]).unwrap();
        let octagon = Convex::regular(8, 4.0).unwrap();
        assert_eq!(octagon.faces().len(), 8);
        // The faces of an inscribed octagon are cos(22.5 deg) of the radius away.
        assert!((octagon.support([1.0, 0.0]) - 4.0 * (std::f64::consts::PI / 8.0).cos()).abs() < 1e-12);
        assert_eq!(square.sum(&square).bounds(), [[-2.0, -2.0], [2.0, 2.0]]);
        assert!(square.difference(&square).is_none());
        let half = Convex::rectangle([1.0, 1.0]).unwrap();
        assert_eq!(square.difference(&half).unwrap().bounds(), [[-0.5, -0.5], [0.5, 0.5]]);
        assert!((square.gap(&half.moved([3.0, 0.0])) - 1.5).abs() < 1e-12);
        assert!((square.gap(&half.moved([1.0, 0.0])) + 0.5).abs() < 1e-12);
        assert!(Convex::hull(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]).is_none());
        assert!(Convex::hull(&[[0.0, 0.0], [1.0, f64::NAN], [2.0, 0.0]]).is_none());
        assert!(is_convex(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]));
        assert!(is_convex(&[[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]));
        assert!(!is_convex(&[[0.0, 0.0], [1.0, 0.0], [0.2, 0.2], [0.0, 1.0]]));
        assert!(!is_convex(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]));
    }

    proptest! {
        /// By their definitions, on random points.
        #[test]
        fn sums_and_differences_are_what_they_are_defined_as(a in polygon(), b in polygon(), weights in prop::collection::vec(0.01..1.0_f64, 16), at in [-9.0..9.0_f64, -9.0..9.0_f64]) {
            let inside = |of: &Convex, from: usize| {
                let total: f64 = (0..of.corners().len()).map(|i| weights[(from + i) % 16]).sum();
                let sum = of.corners().iter().enumerate().fold([0.0; 2], |sum, (i, corner)| plus(sum, corner.map(|x| x * weights[(from + i) % 16])));
                sum.map(|x| x / total)
            };
            let (p, q) = (inside(&a, 0), inside(&b, 5));
            prop_assert!(a.contains(p, 1e-9) && a.sum(&b).contains(plus(p, q), 1e-9));
            let fits = b.corners().iter().all(|corner| a.contains(plus(at, *corner), 0.0));
            match a.difference(&b) {
                Some(difference) => prop_assert!(fits == difference.contains(at, 0.0) || difference.outside(at).abs() < 1e-6),
                None => prop_assert!(!b.corners().iter().all(|corner| a.contains(plus(at, *corner), -1e-4))),
            }
        }

        /// Two polygons overlap if and only if the origin is in the sum of one and the other one reflected.
        #[test]
        fn gaps_are_those_of_the_difference_set(a in polygon(), b in polygon()) {
            let set = a.sum(&b.reflected());
            prop_assert!((a.gap(&b) - set.outside([0.0; 2])).abs() < 1e-6, "{} {}", a.gap(&b), set.outside([0.0; 2]));
        }
    }
}
