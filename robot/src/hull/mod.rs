//! Convex hulls of points: corners, their neighbours along the edges, and faces.
//!
//! The corner farthest along a direction is found by walking along edges from the last one: on a convex body, a corner
//! without a higher neighbour is the highest.

mod faces;
mod flat;

use std::sync::Arc;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Up to this number of corners, all of them are compared: faster than walking.
const FEW: usize = 24;

/// Distance from their plane, relative to the size, up to which points are flat.
const FLAT: f64 = 1e-8;

/// Largest coordinate of a point \[m\].
const FARTHEST: f64 = 1e4;

/// A convex polyhedron, or the convex hull of points in a plane or on a line. Copies share their corners.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<[f64; 3]>", into = "Vec<[f64; 3]>")]
pub struct Hull(Arc<Corners>);

#[derive(Debug)]
struct Corners {
    corners: Vec<Vector3<f64>>,
    /// Neighbours of corner `i`: `neighbours[first[i]..first[i + 1]]`. Empty for a flat hull, and for a small one.
    first: Vec<u32>,
    neighbours: Vec<u32>,
    faces: Vec<Face>,
    triangles: Vec<[u32; 3]>,
    radius: f64,
}

impl PartialEq for Corners {
    fn eq(&self, other: &Self) -> bool {
        self.corners == other.corners
    }
}

/// Plane of a face: all corners have `normal·x <= offset`.
#[derive(Clone, Copy, Debug)]
struct Face {
    normal: Vector3<f64>,
    offset: f64,
}

/// Depth of a point in a hull.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Depth {
    /// Distance to the nearest face \[m\]; positive inside.
    pub depth: f64,
    /// Outward normal of that face.
    pub normal: Vector3<f64>,
}

/// Reason why points have no hull.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum HullError {
    /// There are none.
    #[error("it has no vertex")]
    Empty,
    /// A coordinate is not finite, or beyond 10 km.
    #[error("a vertex is not finite, or farther away than 10 km")]
    NotFinite,
}

impl Hull {
    /// Computes the hull of points \[m\], moved so that the middle of its extents is the origin. Returns that middle too.
    ///
    /// # Errors
    /// There are no points, or one is not finite.
    pub fn around(points: &[Vector3<f64>]) -> Result<(Vector3<f64>, Hull), HullError> {
        let first = points.first().ok_or(HullError::Empty)?;
        if points.iter().flatten().any(|x| !x.is_finite() || x.abs() > FARTHEST) {
            return Err(HullError::NotFinite);
        }
        let (low, high) = points.iter().fold((*first, *first), |(low, high), p| (low.inf(p), high.sup(p)));
        let middle = 0.5 * (low + high);
        let mut centred: Vec<Vector3<f64>> = points.iter().map(|p| p - middle).collect();
        centred.sort_by(|a, b| {
            a.iter().zip(b).map(|(a, b)| a.total_cmp(b)).find(|o| o.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
        });
        centred.dedup();
        Ok((middle, Hull(Arc::new(Corners::of(centred)))))
    }

    /// Corners in the hull's frame \[m\].
    pub fn corners(&self) -> &[Vector3<f64>] {
        &self.0.corners
    }

    /// Triangles of the surface, as indices of corners, anticlockwise from outside; empty for a flat hull.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.0.triangles
    }

    /// Triangles that cover the surface \[m\], of a flat hull once; `None` if rounding defeated the search for faces, and all
    /// points are corners.
    pub fn faces(&self) -> Option<Vec<[Vector3<f64>; 3]>> {
        let corners = &self.0.corners;
        if !self.0.triangles.is_empty() {
            return Some(self.0.triangles.iter().map(|t| t.map(|i| corners[i as usize])).collect());
        }
        match self.outline()?.as_slice() {
            [] => Some(Vec::new()),
            &[p] => Some(vec![[p; 3]]),
            &[p, q] => Some(vec![[p, q, q]]),
            [first, rest @ ..] => Some(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]).collect()),
        }
    }

    /// Corners without points of a flat hull that are no corners \[m\].
    pub fn outer_corners(&self) -> Vec<Vector3<f64>> {
        let outline = if self.0.triangles.is_empty() { self.outline() } else { None };
        outline.unwrap_or_else(|| self.0.corners.clone())
    }

    /// Corners of a flat hull; `None` if its points are in no plane.
    fn outline(&self) -> Option<Vec<Vector3<f64>>> {
        let outline = flat::outline(&self.0.corners);
        let is_flat = match outline.as_slice() {
            [a, b, c, ..] => {
                let normal = (b - a).cross(&(c - a)).normalize();
                self.0.corners.iter().all(|p| normal.dot(&(p - a)).abs() <= FLAT * self.0.radius)
            }
            _ => true,
        };
        is_flat.then_some(outline)
    }

    /// Volume \[m³\]; zero for a flat hull.
    pub fn volume(&self) -> f64 {
        let corner = |i: u32| self.0.corners[i as usize];
        let six_times = |t: &[u32; 3]| corner(t[0]).dot(&corner(t[1]).cross(&corner(t[2])));
        self.0.triangles.iter().map(six_times).sum::<f64>() / 6.0
    }

    /// Radius of the ball about the origin that contains the hull \[m\].
    pub fn radius(&self) -> f64 {
        self.0.radius
    }

    /// Index of the corner that is farthest along a direction; `near` is where the search begins.
    pub(crate) fn farthest(&self, direction: &Vector3<f64>, near: usize) -> usize {
        let Corners { corners, first, neighbours, .. } = &*self.0;
        if first.is_empty() {
            let height = |i: usize| corners[i].dot(direction);
            return (1..corners.len()).fold(0, |best, i| if height(i) > height(best) { i } else { best });
        }
        let mut at = near.min(corners.len() - 1);
        let mut height = corners[at].dot(direction);
        loop {
            let mut next = at;
            for &n in &neighbours[first[at] as usize..first[at + 1] as usize] {
                let other = corners[n as usize].dot(direction);
                if other > height {
                    (next, height) = (n as usize, other);
                }
            }
            if next == at {
                return at;
            }
            at = next;
        }
    }

    /// Depth of a point inside; `None` for a flat hull.
    pub(crate) fn depth(&self, p: &Vector3<f64>) -> Option<Depth> {
        let depth = |f: &Face| Depth { depth: f.offset - f.normal.dot(p), normal: f.normal };
        self.0.faces.iter().map(depth).min_by(|a, b| a.depth.total_cmp(&b.depth))
    }
}

impl Corners {
    fn of(points: Vec<Vector3<f64>>) -> Corners {
        let radius = points.iter().map(|p| p.norm()).fold(0.0, f64::max);
        solid(&points, radius).unwrap_or(Corners {
            corners: points,
            first: Vec::new(),
            neighbours: Vec::new(),
            faces: Vec::new(),
            triangles: Vec::new(),
            radius,
        })
    }
}

/// Hull of points that span a volume; `None` for other points.
fn solid(points: &[Vector3<f64>], radius: f64) -> Option<Corners> {
    let found = faces::faces(points, radius)?;
    let mut used: Vec<usize> = found.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let index = |point: usize| used.partition_point(|u| *u < point) as u32;
    let corners: Vec<Vector3<f64>> = used.iter().map(|&i| points[i]).collect();
    let triangles: Vec<[u32; 3]> = found.iter().map(|f| f.map(index)).collect();
    let mut faces = Vec::with_capacity(triangles.len());
    let mut edges: Vec<(u32, u32)> = Vec::new();
    for t in &triangles {
        let [a, b, c] = t.map(|i| corners[i as usize]);
        edges.extend([(t[0], t[1]), (t[1], t[2]), (t[2], t[0])].into_iter().flat_map(|(i, j)| [(i, j), (j, i)]));
        let normal = (b - a).cross(&(c - a)).normalize();
        faces.push(Face { normal, offset: normal.dot(&a) });
    }
    // If rounding left a point outside, all points stay: the hull is slower then, but right.
    let outside = |f: &Face| points.iter().any(|p| f.normal.dot(p) - f.offset > 1e-9 * radius);
    if faces.iter().any(outside) {
        return None;
    }
    edges.sort_unstable();
    edges.dedup();
    let (mut first, mut neighbours) = (Vec::new(), Vec::new());
    if corners.len() > FEW {
        first = (0..=corners.len()).map(|i| edges.partition_point(|e| (e.0 as usize) < i) as u32).collect();
        neighbours = edges.iter().map(|e| e.1).collect();
    }
    Some(Corners { corners, first, neighbours, faces, triangles, radius })
}

impl TryFrom<Vec<[f64; 3]>> for Hull {
    type Error = HullError;

    fn try_from(corners: Vec<[f64; 3]>) -> Result<Hull, HullError> {
        let points: Vec<Vector3<f64>> = corners.into_iter().map(Vector3::from).collect();
        if points.is_empty() {
            return Err(HullError::Empty);
        }
        if points.iter().flatten().any(|x| !x.is_finite() || x.abs() > 2.0 * FARTHEST) {
            return Err(HullError::NotFinite);
        }
        Ok(Hull(Arc::new(Corners::of(points))))
    }
}

impl From<Hull> for Vec<[f64; 3]> {
    fn from(hull: Hull) -> Self {
        hull.corners().iter().map(|p| [p.x, p.y, p.z]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn points() -> impl Strategy<Value = Vec<Vector3<f64>>> {
        (proptest::collection::vec(prop::array::uniform3(-1.0f64..1.0), 1..120), 0usize..3).prop_map(
            |(points, flat)| {
                let flatten = |mut p: Vector3<f64>| {
                    p.iter_mut().take(flat).for_each(|x| *x = 0.25);
                    p
                };
                points.into_iter().map(|p| flatten(Vector3::from(p))).collect()
            },
        )
    }

    proptest! {
        #[test]
        fn the_farthest_corner_is_that_of_all_points(
            points in points(),
            directions in proptest::collection::vec(prop::array::uniform3(-1.0f64..1.0), 8),
        ) {
            let (middle, hull) = Hull::around(&points).unwrap();
            let mut near = 0;
            for d in directions {
                let d = Vector3::from(d);
                near = hull.farthest(&d, near);
                let most = points.iter().map(|p| (p - middle).dot(&d)).fold(f64::NEG_INFINITY, f64::max);
                prop_assert!((hull.corners()[near].dot(&d) - most).abs() <= 1e-9);
            }
        }

        #[test]
        fn a_hull_is_read_back_as_written(points in points()) {
            let (_, hull) = Hull::around(&points).unwrap();
            let text = serde_json::to_string(&hull).unwrap();
            let read: Hull = serde_json::from_str(&text).unwrap();
            let sorted = |h: &Hull| {
                let mut all: Vec<[u64; 3]> = h.corners().iter().map(|p| [p.x, p.y, p.z].map(f64::to_bits)).collect();
                all.sort_unstable();
                all
            };
            prop_assert_eq!(sorted(&read), sorted(&hull));
        }
    }

    #[test]
    fn points_that_have_no_hull() {
        assert_eq!(Hull::around(&[]).unwrap_err(), HullError::Empty);
        assert_eq!(Hull::around(&[Vector3::new(0.0, f64::NAN, 0.0)]).unwrap_err(), HullError::NotFinite);
        assert_eq!(Hull::around(&[Vector3::new(0.0, 1e5, 0.0)]).unwrap_err(), HullError::NotFinite);
    }
}
