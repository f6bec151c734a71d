//! Triangles clipped by planes across a coordinate axis.

use nalgebra::Vector3;

pub(super) type Triangle = [Vector3<f64>; 3];

/// A plane across a coordinate axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plane {
    /// Index of the axis.
    pub axis: usize,
    /// Coordinate \[m\].
    pub at: f64,
    /// Distance up to which a point counts as on the plane \[m\].
    pub tolerance: f64,
}

/// The parts of triangles on both sides of a plane.
#[derive(Default)]
pub(super) struct Sides {
    pub below: Vec<Triangle>,
    pub above: Vec<Triangle>,
}

impl Plane {
    fn height(&self, p: &Vector3<f64>) -> f64 {
        let height = p[self.axis] - self.at;
        if height.abs() <= self.tolerance { 0.0 } else { height }
    }

    /// Splits a triangle. One in the plane belongs to the side that its normal points away from, where the solid is.
    pub fn split(&self, triangle: &Triangle, sides: &mut Sides) {
        let heights = triangle.map(|p| self.height(&p));
        let (low, high) = heights.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
        if low == 0.0 && high == 0.0 {
            let [a, b, c] = triangle;
            let normal = (b - a).cross(&(c - a))[self.axis];
            if normal > 0.0 { sides.below.push(*triangle) } else { sides.above.push(*triangle) }
        } else if high <= 0.0 {
            sides.below.push(*triangle);
        } else if low >= 0.0 {
            sides.above.push(*triangle);
        } else {
            self.cross(triangle, &heights, sides);
        }
    }

    /// Splits a triangle with corners on both sides.
    fn cross(&self, triangle: &Triangle, heights: &[f64; 3], sides: &mut Sides) {
        let (mut below, mut above) = (Vec::with_capacity(4), Vec::with_capacity(4));
        for i in 0..3 {
            let j = (i + 1) % 3;
            let (p, q, hp, hq) = (triangle[i], triangle[j], heights[i], heights[j]);
            if hp <= 0.0 {
                below.push(p);
            }
            if hp >= 0.0 {
                above.push(p);
            }
            if hp * hq < 0.0 {
                // From the lower end, so that both triangles of an edge get the same point.
                let (from, to, h, k) = if hp < hq { (p, q, hp, hq) } else { (q, p, hq, hp) };
                let mut crossing = from + (to - from) * (h / (h - k));
                crossing[self.axis] = self.at;
                below.push(crossing);
                above.push(crossing);
            }
        }
        fan(&below, &mut sides.below);
        fan(&above, &mut sides.above);
    }
}

/// Triangles of a convex polygon.
fn fan(polygon: &[Vector3<f64>], out: &mut Vec<Triangle>) {
    if let [first, rest @ ..] = polygon {
        out.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn area(t: &Triangle) -> f64 {
        0.5 * (t[1] - t[0]).cross(&(t[2] - t[0])).norm()
    }

    proptest! {
        #[test]
        fn both_sides_have_the_area_of_the_whole(
            corners in prop::array::uniform3(prop::array::uniform3(-1.0f64..1.0)),
            at in -1.0f64..1.0,
            axis in 0usize..3,
        ) {
            let triangle = corners.map(Vector3::from);
            let plane = Plane { axis, at, tolerance: 1e-9 };
            let mut sides = Sides::default();
            plane.split(&triangle, &mut sides);
            prop_assert!(sides.below.iter().flatten().all(|p| p[axis] <= at + 1e-9));
            prop_assert!(sides.above.iter().flatten().all(|p| p[axis] >= at - 1e-9));
            let whole: f64 = sides.below.iter().chain(&sides.above).map(area).sum();
            prop_assert!((whole - area(&triangle)).abs() < 1e-9);
        }
    }

    #[test]
    fn a_triangle_in_the_plane_is_on_the_side_of_its_solid() {
        let [a, b, c] = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]].map(Vector3::from);
        let plane = Plane { axis: 2, at: 1.0, tolerance: 1e-9 };
        let mut sides = Sides::default();
        plane.split(&[a, b, c], &mut sides);
        plane.split(&[a, c, b], &mut sides);
        assert_eq!((sides.below, sides.above), (vec![[a, b, c]], vec![[a, c, b]]));
    }
}
