//! Faces of the convex hull of points: quickhull (Barber, Dobkin and Huhdanpaa, ACM Transactions on Mathematical Software
//! 22(4), 1996).
//!
//! Each face keeps the points above it. The highest one becomes a corner: the faces that it sees give way to triangles from
//! their horizon to the point.

use std::collections::BTreeMap;

use nalgebra::Vector3;

/// Height over a face, relative to the size of the hull, up to which a point counts as on it.
const ON_FACE: f64 = 1e-10;

/// A triangle, anticlockwise from outside.
struct Face {
    corners: [usize; 3],
    normal: Vector3<f64>,
    offset: f64,
    /// Points above it that no other face keeps.
    above: Vec<usize>,
    is_replaced: bool,
}

/// A hull as it grows.
struct Growing<'p> {
    points: &'p [Vector3<f64>],
    faces: Vec<Face>,
    /// The face to the left of each directed edge.
    left: BTreeMap<(usize, usize), usize>,
    tolerance: f64,
    smallest_area: f64,
}

/// Triangles of the hull of points within `size` m of the origin, as indices of points, anticlockwise from outside. `None`
/// if the points do not span a volume, or if rounding defeats the search.
pub(super) fn faces(points: &[Vector3<f64>], size: f64) -> Option<Vec<[usize; 3]>> {
    let tolerance = ON_FACE * size;
    let mut hull =
        Growing { points, faces: Vec::new(), left: BTreeMap::new(), tolerance, smallest_area: 1e-14 * size * size };
    let [a, b, c, d] = first_four(points, tolerance)?;
    for corners in [[a, b, c], [a, d, b], [b, d, c], [c, d, a]] {
        hull.add(corners)?;
    }
    hull.assign(0, (0..points.len()).filter(|i| ![a, b, c, d].contains(i)));
    let mut next = 0;
    while next < hull.faces.len() {
        if hull.faces[next].is_replaced || hull.faces[next].above.is_empty() {
            next += 1;
            continue;
        }
        hull.extend(next)?;
    }
    Some(hull.faces.iter().filter(|f| !f.is_replaced).map(|f| f.corners).collect())
}

/// Four points that span a volume, such that `d` is below the triangle `a b c`.
fn first_four(points: &[Vector3<f64>], tolerance: f64) -> Option<[usize; 4]> {
    let farthest = |of: &dyn Fn(&Vector3<f64>) -> f64| {
        (0..points.len()).max_by(|i, j| of(&points[*i]).total_cmp(&of(&points[*j])))
    };
    let a = farthest(&|p| p.norm_squared())?;
    let b = farthest(&|p| (p - points[a]).norm_squared())?;
    let axis = (points[b] - points[a]).try_normalize(tolerance)?;
    let c = farthest(&|p| axis.cross(&(p - points[a])).norm_squared())?;
    let normal = axis.cross(&(points[c] - points[a])).try_normalize(tolerance)?;
    let height = |p: &Vector3<f64>| normal.dot(&(p - points[a]));
    let d = farthest(&|p| height(p).abs())?;
    match height(&points[d]) {
        h if h.abs() <= tolerance => None,
        h if h < 0.0 => Some([a, b, c, d]),
        _ => Some([a, c, b, d]),
    }
}

impl Growing<'_> {
    fn height(&self, face: usize, point: usize) -> f64 {
        self.faces[face].normal.dot(&self.points[point]) - self.faces[face].offset
    }

    /// Adds a face; `None` for a sliver, which has no normal.
    fn add(&mut self, corners: [usize; 3]) -> Option<()> {
        let [a, b, c] = corners.map(|i| self.points[i]);
        let normal = (b - a).cross(&(c - a)).try_normalize(self.smallest_area)?;
        let index = self.faces.len();
        for (i, j) in edges(corners) {
            self.left.insert((i, j), index);
        }
        self.faces.push(Face { corners, normal, offset: normal.dot(&a), above: Vec::new(), is_replaced: false });
        Some(())
    }

    /// Gives each point to the first face from `first` on that is below it; points inside are dropped.
    fn assign(&mut self, first: usize, points: impl Iterator<Item = usize>) {
        for point in points {
            let below = (first..self.faces.len()).find(|&f| self.height(f, point) > self.tolerance);
            if let Some(face) = below {
                self.faces[face].above.push(point);
            }
        }
    }

    /// Makes the highest point above a face a corner.
    fn extend(&mut self, face: usize) -> Option<()> {
        let above = &self.faces[face].above;
        let apex = *above.iter().max_by(|i, j| self.height(face, **i).total_cmp(&self.height(face, **j)))?;
        let (mut seen, mut open) = (vec![face], vec![face]);
        self.faces[face].is_replaced = true;
        let mut horizon = Vec::new();
        while let Some(f) = open.pop() {
            for (i, j) in edges(self.faces[f].corners) {
                let beyond = *self.left.get(&(j, i))?;
                if self.faces[beyond].is_replaced {
                    // A face that was replaced earlier has no edges left.
                    continue;
                }
                if self.height(beyond, apex) > self.tolerance {
                    self.faces[beyond].is_replaced = true;
                    seen.push(beyond);
                    open.push(beyond);
                } else {
                    horizon.push((i, j));
                }
            }
        }
        let mut free: Vec<usize> = Vec::new();
        for &f in &seen {
            free.append(&mut self.faces[f].above);
            for edge in edges(self.faces[f].corners) {
                if self.left.get(&edge) == Some(&f) {
                    self.left.remove(&edge);
                }
            }
        }
        // Around the apex, each corner of the horizon is left once and reached once.
        let mut starts: Vec<usize> = horizon.iter().map(|e| e.0).collect();
        starts.sort_unstable();
        if horizon.len() < 3 || starts.windows(2).any(|w| w[0] == w[1]) {
            return None;
        }
        let first = self.faces.len();
        for (i, j) in horizon {
            self.add([i, j, apex])?;
        }
        free.retain(|p| *p != apex);
        self.assign(first, free.into_iter());
        Some(())
    }
}

fn edges([a, b, c]: [usize; 3]) -> [(usize, usize); 3] {
    [(a, b), (b, c), (c, a)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_point_is_below_every_face_and_edges_are_shared(
            points in proptest::collection::vec(prop::array::uniform3(-1.0f64..1.0), 4..200),
        ) {
            let points: Vec<Vector3<f64>> = points.into_iter().map(Vector3::from).collect();
            let faces = faces(&points, 2.0).expect("random points span a volume");
            let mut count = BTreeMap::new();
            for f in &faces {
                let [a, b, c] = f.map(|i| points[i]);
                let normal = (b - a).cross(&(c - a)).normalize();
                prop_assert!(points.iter().all(|p| normal.dot(&(p - a)) <= 1e-9));
                for (i, j) in edges(*f) {
                    *count.entry((i.min(j), i.max(j))).or_insert(0) += if i < j { 1 } else { -1 };
                }
            }
            // Each edge is there once in each direction, and corners, edges and faces satisfy Euler's formula.
            prop_assert!(count.values().all(|n| *n == 0));
            let corners: std::collections::BTreeSet<usize> = faces.iter().flatten().copied().collect();
            prop_assert_eq!(corners.len() + faces.len(), count.len() + 2);
        }
    }

    #[test]
    fn a_cube_of_a_grid_has_its_eight_corners() {
        let at = |i: usize| -0.5 + i as f64 * 0.1;
        let grid =
            (0..11).flat_map(|i| (0..11).flat_map(move |j| (0..11).map(move |k| Vector3::new(at(i), at(j), at(k)))));
        let points: Vec<Vector3<f64>> = grid.collect();
        let faces = faces(&points, 1.0).expect("a volume");
        let corners: std::collections::BTreeSet<usize> = faces.iter().flatten().copied().collect();
        assert!(corners.iter().all(|i| points[*i].iter().all(|x| (x.abs() - 0.5).abs() < 1e-12)), "{corners:?}");
        assert_eq!((corners.len(), faces.len()), (8, 12));
    }

    #[test]
    fn what_spans_no_volume_has_no_faces() {
        let flat: Vec<Vector3<f64>> = (0..20).map(|i| Vector3::new(f64::from(i), f64::from(i * i % 7), 0.0)).collect();
        assert!(faces(&flat, 20.0).is_none());
        assert!(faces(&[Vector3::zeros(); 5], 1.0).is_none());
    }
}
