//! Convex hull of points of a plane, and what is left of it within a margin: the polygon over which a robot stands.

use nalgebra::Vector2;

/// Twice the area in m² up to which three points count as on one line.
const ON_A_LINE: f64 = 1e-12;

/// Twice the area of the triangle `a b c`, positive if it goes round anticlockwise.
fn turn(a: &Vector2<f64>, b: &Vector2<f64>, c: &Vector2<f64>) -> f64 {
    (b - a).perp(&(c - a))
}

/// Convex hull of a fixed number of points, with the storage to compute it.
#[derive(Clone, Debug)]
pub struct Hull {
    /// Points from left to right.
    order: Vec<usize>,
    /// Corners, anticlockwise; the first one is not repeated.
    corners: Vec<usize>,
}

/// An edge of a hull, as indices of points: the inside is on its left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// Its first corner.
    pub from: usize,
    /// Its second corner.
    pub to: usize,
}

impl Hull {
    /// Creates the storage for so many points.
    pub fn new(points: usize) -> Self {
        Hull { order: (0..points).collect(), corners: Vec::with_capacity(2 * points + 1) }
    }

    /// Computes the corners by Andrew's monotone chain. Points on an edge are no corners. Never allocates, if `points` are
    /// as many as the storage is for.
    pub fn compute(&mut self, points: &[Vector2<f64>]) {
        let less = |a: &Vector2<f64>, b: &Vector2<f64>| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y));
        self.order.sort_unstable_by(|&a, &b| less(&points[a], &points[b]).then(a.cmp(&b)));
        self.corners.clear();
        let count = self.order.len();
        for half in 0..2 {
            let first = self.corners.len();
            for i in 0..count {
                let k = self.order[if half == 0 { i } else { count - 1 - i }];
                while let [.., a, b] = self.corners[first..]
                    && turn(&points[a], &points[b], &points[k]) <= ON_A_LINE
                {
                    self.corners.pop();
                }
                self.corners.push(k);
            }
            // It is the first corner of the other half.
            self.corners.pop();
        }
        if let [a, b] = self.corners[..]
            && (points[a] - points[b]).norm_squared() <= ON_A_LINE
        {
            self.corners.truncate(1);
        }
    }

    /// Its edges, anticlockwise.
    pub fn edges(&self) -> impl Iterator<Item = Edge> + '_ {
        let n = self.corners.len();
        (0..n).map(move |i| Edge { from: self.corners[i], to: self.corners[(i + 1) % n] })
    }

    /// Largest distance in m that a point inside can keep from all edges. Allocates.
    pub fn inradius(&self, points: &[Vector2<f64>]) -> f64 {
        let corners: Vec<Vector2<f64>> = self.corners.iter().map(|&k| points[k]).collect();
        let far = corners.iter().flat_map(|a| corners.iter().map(move |b| (a - b).norm())).fold(0.0, f64::max);
        let (mut low, mut high) = (0.0, far);
        // Halved 60 times, the interval is at the resolution of a double.
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            match leaves_something(&corners, middle) {
                true => low = middle,
                false => high = middle,
            }
        }
        low
    }
}

/// Returns true if some point of a convex polygon keeps a distance from all of its edges.
fn leaves_something(corners: &[Vector2<f64>], distance: f64) -> bool {
    let n = corners.len();
    if n < 3 {
        return false;
    }
    let mut left = corners.to_vec();
    for i in 0..n {
        let (a, b) = (corners[i], corners[(i + 1) % n]);
        let along = (b - a).normalize();
        let height = |p: &Vector2<f64>| along.perp(&(p - a)) - distance;
        let mut cut = Vec::with_capacity(left.len() + 1);
        for k in 0..left.len() {
            let (p, q) = (left[k], left[(k + 1) % left.len()]);
            let (hp, hq) = (height(&p), height(&q));
            if hp >= 0.0 {
                cut.push(p);
            }
            if (hp >= 0.0) != (hq >= 0.0) {
                cut.push(p + (q - p) * (hp / (hp - hq)));
            }
        }
        left = cut;
    }
    !left.is_empty()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn corners(points: &[Vector2<f64>]) -> (Hull, Vec<Edge>) {
        let mut hull = Hull::new(points.len());
        hull.compute(points);
        let edges = hull.edges().collect();
        (hull, edges)
    }

    #[test]
    fn a_rectangle_with_points_on_its_edges_has_four_corners() {
        let points: Vec<_> = [[0.0, 0.0], [0.2, 0.0], [0.1, 0.0], [0.2, 0.1], [0.0, 0.1], [0.05, 0.05], [0.0, 0.05]]
            .map(Vector2::from)
            .into();
        let (hull, edges) = corners(&points);
        assert_eq!(edges.iter().map(|e| e.from).collect::<Vec<_>>(), [0, 1, 3, 4]);
        assert!((hull.inradius(&points) - 0.05).abs() < 1e-12);
    }

    #[test]
    fn points_of_a_line_leave_nothing_inside() {
        let points: Vec<_> = (0..5).map(|i| Vector2::new(0.1 * f64::from(i), 0.2 * f64::from(i))).collect();
        let (hull, edges) = corners(&points);
        assert_eq!(edges.len(), 2);
        assert_eq!(hull.inradius(&points), 0.0);
        let (_, edges) = corners(&[Vector2::zeros(); 3]);
        assert!(edges.len() <= 1);
    }

    proptest! {
        /// A point is inside if it is in a triangle of three of the points, by Carathéodory.
        #[test]
        fn the_left_of_all_edges_is_a_mix_of_the_points(
            coordinates in prop::collection::vec((-1.0..1.0f64, -1.0..1.0f64), 3..10),
            x in -1.0..1.0f64,
            y in -1.0..1.0f64,
        ) {
            let points: Vec<_> = coordinates.iter().map(|&(x, y)| Vector2::new(x, y)).collect();
            let p = Vector2::new(x, y);
            let (_, edges) = corners(&points);
            let inside = edges.iter().all(|e| turn(&points[e.from], &points[e.to], &p) >= 0.0);
            let within = |a: usize, b: usize, c: usize| {
                let sides = [turn(&points[a], &points[b], &p), turn(&points[b], &points[c], &p), turn(&points[c], &points[a], &p)];
                sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0)
            };
            let n = points.len();
            let mixed = (0..n).any(|a| (0..a).any(|b| (0..b).any(|c| within(a, b, c))));
            let near = edges.iter().any(|e| turn(&points[e.from], &points[e.to], &p).abs() < 1e-9);
            prop_assert!(near || inside == mixed);
        }
    }
}
