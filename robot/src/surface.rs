//! The surface of a mesh: distances of points to it, and its inside if it is closed.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Vector3};

use crate::mesh::bounding_capsule;
use crate::soup::{Soup, SoupError};
use crate::{MOST_ELEMENTS, PlacedShape, Shape};

/// Way by which a point on the surface is moved to find the triangle on which it is \[m\].
const OFF: f64 = 1e-6;

/// Smallest share of a corner of a triangle in a point that is clearly inside of the triangle.
const CLEARLY_INSIDE: f64 = 1e-6;

/// Reason why triangles are no surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SurfaceError {
    /// There are none.
    #[error("it has no triangle")]
    Empty,
    /// There are too many.
    #[error("it has {0} triangles, and {MOST_ELEMENTS} are the most")]
    TooMany(usize),
    /// A coordinate is not finite, or beyond 10 km.
    #[error("a vertex is not finite, or farther away than 10 km")]
    NotFinite,
}

/// Triangles of a mesh in a tree.
#[derive(Clone, Debug)]
pub struct Surface {
    soup: Soup,
    triangles: Vec<[Vector3<f64>; 3]>,
    is_closed: bool,
}

impl Surface {
    /// Builds the tree of triangles \[m\], which are anticlockwise from outside, or all clockwise.
    ///
    /// # Errors
    /// There are no triangles or too many, or a coordinate is not finite.
    pub fn new(triangles: &[[Vector3<f64>; 3]]) -> Result<Surface, SurfaceError> {
        let mut triangles = triangles.to_vec();
        let is_closed = is_closed(&triangles);
        if is_closed && volume(&triangles) < 0.0 {
            triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        let soup = Soup::new(&triangles, 0.0).map_err(|e| match e {
            SoupError::Empty | SoupError::Corners(_) => SurfaceError::Empty,
            SoupError::TooMany(n) => SurfaceError::TooMany(n),
            SoupError::NotFinite => SurfaceError::NotFinite,
        })?;
        Ok(Surface { soup, triangles, is_closed })
    }

    /// Triangles \[m\]; those of a closed surface are anticlockwise from outside.
    pub fn triangles(&self) -> &[[Vector3<f64>; 3]] {
        &self.triangles
    }

    /// True if each edge of a triangle is that of another one, in the opposite direction: there is an inside.
    pub fn is_closed(&self) -> bool {
        self.is_closed
    }

    /// Volume inside \[m³\]; `None` for an open surface.
    pub fn volume(&self) -> Option<f64> {
        self.is_closed.then(|| volume(&self.triangles))
    }

    /// Corners of the triangles \[m\].
    pub fn points(&self) -> Vec<Vector3<f64>> {
        self.triangles.iter().flatten().copied().collect()
    }

    /// The capsule around it, in its frame; `None` if it has no finite point.
    pub fn capsule(&self) -> Option<PlacedShape> {
        bounding_capsule(&self.points()).map(|(origin, shape)| PlacedShape { origin, shape })
    }

    /// Diameter of a ball that contains the surface \[m\].
    pub fn extent(&self) -> f64 {
        self.soup.extent()
    }

    /// Distance of a point to the surface \[m\].
    pub fn distance(&self, p: &Vector3<f64>) -> f64 {
        self.nearest(p, None).map_or(0.0, |near| near.distance)
    }

    /// Distance of a point to the surface \[m\], negative inside of a closed one.
    pub fn signed_distance(&self, p: &Vector3<f64>) -> f64 {
        let Some(near) = self.nearest(p, None) else { return 0.0 };
        let is_inside = self.is_closed && near.is_inside.unwrap_or_else(|| self.contains(p));
        if is_inside { -near.distance } else { near.distance }
    }

    /// Looks at a point from the surface; `direction` leads away from the surface if the point is on it. A point that cannot be
    /// inside is not tried, which takes a while beside edges. An element `hint` that is near makes it faster.
    pub(crate) fn look(
        &self,
        p: &Vector3<f64>,
        direction: &Vector3<f64>,
        may_be_inside: bool,
        hint: Option<usize>,
    ) -> Seen {
        if let Some(near) = self.nearest(p, hint) {
            let is_inside = || may_be_inside && self.is_closed && near.is_inside.unwrap_or_else(|| self.contains(p));
            let element = Some(near.element);
            return Seen { distance: near.distance, triangle: Some(near.triangle), is_inside: is_inside(), element };
        }
        let off = || Some(p + direction.try_normalize(0.0)? * OFF);
        let near = off().and_then(|p| self.nearest(&p, hint));
        let (triangle, element) = (near.as_ref().map(|near| near.triangle), near.as_ref().map(|near| near.element));
        Seen { distance: 0.0, triangle, is_inside: false, element }
    }

    /// True if a triangle meets none of the surface.
    pub(crate) fn is_clear_of(&self, triangle: &[Vector3<f64>; 3]) -> bool {
        let Ok(placed) = PlacedShape::hull(triangle) else { return false };
        self.soup.nearest(&placed.shape, &placed.origin, &Isometry3::identity()).is_ok()
    }

    /// True if a point is inside, by its winding number. Points on the surface may be either.
    pub fn contains(&self, p: &Vector3<f64>) -> bool {
        self.is_closed && winding_number(&self.triangles, p).abs() > 0.5
    }

    /// `None` for a point on the surface.
    fn nearest(&self, p: &Vector3<f64>, hint: Option<usize>) -> Option<Near> {
        let at = Isometry3::translation(p.x, p.y, p.z);
        let spot = self.soup.nearest_from(hint, &Shape::Sphere { radius: 0.0 }, &at, &Isometry3::identity()).ok()?;
        let &[a, b, c] = self.soup.corners(spot.element) else { return None };
        let normal = (b - a).cross(&(c - a));
        let share = |q: &Vector3<f64>, r: &Vector3<f64>| {
            (r - q).cross(&(spot.closest.on_b - q)).dot(&normal) / normal.norm_squared()
        };
        let is_clear = [(a, b), (b, c), (c, a)].iter().all(|(q, r)| share(q, r) > CLEARLY_INSIDE);
        // At an edge or a corner, the side of one triangle is not that of all.
        let is_inside = is_clear.then(|| (p - a).dot(&normal) < 0.0);
        Some(Near { distance: spot.closest.distance, triangle: [a, b, c], is_inside, element: spot.element })
    }
}

/// A point, seen from a surface.
pub(crate) struct Seen {
    /// Its distance \[m\].
    pub distance: f64,
    /// A triangle that is nearest to it, or nearly so.
    pub triangle: Option<[Vector3<f64>; 3]>,
    /// True if it may be inside of a closed surface, and is.
    pub is_inside: bool,
    /// The number of the triangle.
    pub element: Option<usize>,
}

/// The part of a surface that is nearest to a point.
struct Near {
    distance: f64,
    triangle: [Vector3<f64>; 3],
    /// True on the inner side of the triangle; `None` if the nearest point is at an edge.
    is_inside: Option<bool>,
    /// The number of the triangle.
    element: usize,
}

/// Six times the volume below a triangle is a determinant.
fn volume(triangles: &[[Vector3<f64>; 3]]) -> f64 {
    // From a point of the mesh, so that one that is far from the origin loses no digits.
    let o = triangles.first().map_or_else(Vector3::zeros, |t| t[0]);
    triangles.iter().map(|[a, b, c]| (a - o).dot(&(b - o).cross(&(c - o))) / 6.0).sum()
}

/// True if each directed edge is there as often as its opposite.
fn is_closed(triangles: &[[Vector3<f64>; 3]]) -> bool {
    // Zero is written with both signs.
    let key = |p: &Vector3<f64>| [p.x, p.y, p.z].map(|x| (x + 0.0).to_bits());
    let mut balance = BTreeMap::new();
    for [a, b, c] in triangles {
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let (p, q) = (key(p), key(q));
            if p != q {
                *balance.entry((p.min(q), p.max(q))).or_insert(0) += if p < q { 1 } else { -1 };
            }
        }
    }
    balance.values().all(|n| *n == 0)
}

/// Winding number of the surface around a point: the sum of the solid angles of its triangles over 4π (Van Oosterom and
/// Strackee, IEEE Transactions on Biomedical Engineering 30(2), 1983).
fn winding_number(triangles: &[[Vector3<f64>; 3]], p: &Vector3<f64>) -> f64 {
    let half_angle = |t: &[Vector3<f64>; 3]| {
        let [a, b, c] = t.map(|q| q - p);
        let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
        let above = a.dot(&b.cross(&c));
        let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
        above.atan2(below)
    };
    triangles.iter().map(half_angle).sum::<f64>() / (2.0 * std::f64::consts::PI)
}
