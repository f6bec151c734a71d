//! Plane geometry: distances of points and segments, polygons, ways as polylines.

/// A point of the ground (m).
pub type Point = [f64; 2];

/// Returns `a + share (b - a)`.
pub fn between(a: Point, b: Point, share: f64) -> Point {
    [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]
}

/// Returns the distance of two points (m).
pub fn distance(a: Point, b: Point) -> f64 {
    // Coordinates are at most 1e6 m, so that squares are exact enough and far from overflow. `hypot` took a quarter of the
    // time of growing trees.
    let [x, y] = [b[0] - a[0], b[1] - a[1]];
    (x * x + y * y).sqrt()
}

/// Returns the point of the segment `a b` that is nearest to `p`.
pub fn nearest_on_segment(p: Point, a: Point, b: Point) -> Point {
    let along = [b[0] - a[0], b[1] - a[1]];
    let squared = along[0] * along[0] + along[1] * along[1];
    let share = if squared > 0.0 { ((p[0] - a[0]) * along[0] + (p[1] - a[1]) * along[1]) / squared } else { 0.0 };
    between(a, b, share.clamp(0.0, 1.0))
}

/// Returns the distance of a point from a segment (m).
pub fn to_segment(p: Point, a: Point, b: Point) -> f64 {
    distance(p, nearest_on_segment(p, a, b))
}

/// Twice the signed area of a triangle, positive counterclockwise.
fn turn(a: Point, b: Point, c: Point) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Returns true if the insides of two segments cross.
pub fn cross(a: Point, b: Point, c: Point, d: Point) -> bool {
    let sides = |p: Point, q: Point, r: Point, s: Point| turn(p, q, r) * turn(p, q, s) < 0.0;
    sides(a, b, c, d) && sides(c, d, a, b)
}

/// Returns the distance of two segments (m); zero if they cross.
pub fn segments(a: Point, b: Point, c: Point, d: Point) -> f64 {
    if cross(a, b, c, d) {
        return 0.0;
    }
    let ends = [to_segment(a, c, d), to_segment(b, c, d), to_segment(c, a, b), to_segment(d, a, b)];
    ends.into_iter().fold(f64::INFINITY, f64::min)
}

/// Returns the edges of a polygon, each from a corner to the next.
pub fn edges(polygon: &[Point]) -> impl Iterator<Item = [Point; 2]> + '_ {
    (0..polygon.len()).map(|i| [polygon[i], polygon[(i + 1) % polygon.len()]])
}

/// Returns true if a point is inside a polygon, by the number of edges that a ray crosses. Points of the boundary are on
/// either side.
pub fn inside(p: Point, polygon: &[Point]) -> bool {
    let crosses = |[a, b]: [Point; 2]| {
        (a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    };
    edges(polygon).filter(|edge| crosses(*edge)).count() % 2 == 1
}

/// Returns the area of a polygon (m^2).
pub fn area(polygon: &[Point]) -> f64 {
    edges(polygon).map(|[a, b]| a[0] * b[1] - b[0] * a[1]).sum::<f64>().abs() / 2.0
}

/// Returns the mean of the points; that of nothing is the origin.
pub fn middle(points: &[Point]) -> Point {
    let count = points.len().max(1) as f64;
    let sum = points.iter().fold([0.0; 2], |sum, p| [sum[0] + p[0], sum[1] + p[1]]);
    [sum[0] / count, sum[1] / count]
}

/// Returns true if two edges of a polygon that are no neighbours cross.
pub fn crosses_itself(polygon: &[Point]) -> bool {
    let all: Vec<[Point; 2]> = edges(polygon).collect();
    let pairs = (0..all.len()).flat_map(|i| (i + 2..all.len()).map(move |j| (i, j)));
    pairs.filter(|(i, j)| !(*i == 0 && *j == all.len() - 1)).any(|(i, j)| {
        let ([a, b], [c, d]) = (all[i], all[j]);
        segments(a, b, c, d) == 0.0
    })
}

/// The least box that holds points, as its least and its greatest corner. Without points it is empty: infinite, reversed.
pub fn bounds(points: impl IntoIterator<Item = Point>) -> [Point; 2] {
    points.into_iter().fold([[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]], |[low, high], p| {
        [[low[0].min(p[0]), low[1].min(p[1])], [high[0].max(p[0]), high[1].max(p[1])]]
    })
}

/// Returns the length of a polyline (m).
pub fn length(points: &[Point]) -> f64 {
    points.windows(2).map(|two| distance(two[0], two[1])).sum()
}

/// A place on a way: position and direction of motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Position (m).
    pub at: Point,
    /// Direction (rad), from the x axis.
    pub heading: f64,
}

/// Returns the pose at a share of the length of a polyline, 0 to 1. `heading` stands in where nothing moves.
pub fn along(points: &[Point], share: f64, heading: f64) -> Pose {
    let mut left = share.clamp(0.0, 1.0) * length(points);
    let mut pose = Pose { at: points.first().copied().unwrap_or_default(), heading };
    for two in points.windows(2) {
        let step = distance(two[0], two[1]);
        if step <= 0.0 {
            continue;
        }
        pose.heading = f64::atan2(two[1][1] - two[0][1], two[1][0] - two[0][0]);
        pose.at = between(two[0], two[1], (left / step).min(1.0));
        left -= step;
        if left <= 0.0 {
            break;
        }
    }
    pose
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_that_cross_have_no_distance() {
        assert_eq!(segments([0.0, 0.0], [2.0, 2.0], [0.0, 2.0], [2.0, 0.0]), 0.0);
        assert_eq!(segments([0.0, 0.0], [1.0, 0.0], [3.0, -1.0], [3.0, 1.0]), 2.0);
        assert_eq!(segments([0.0, 0.0], [1.0, 0.0], [0.5, 0.0], [0.5, 3.0]), 0.0);
    }

    #[test]
    fn a_polygon_knows_its_inside() {
        let horseshoe =
            [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [3.0, 3.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
        assert!(inside([0.5, 2.0], &horseshoe) && inside([3.5, 2.0], &horseshoe) && !inside([2.0, 2.0], &horseshoe));
        assert_eq!(area(&horseshoe), 8.0);
        assert!(!crosses_itself(&horseshoe));
        assert!(crosses_itself(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]));
    }

    #[test]
    fn a_way_is_followed_by_its_length() {
        let way = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0]];
        let pose = along(&way, 0.5, 9.0);
        assert_eq!((pose.at, pose.heading), ([2.0, 0.0], 0.0));
        assert_eq!(along(&way, 1.0, 9.0).at, [3.0, 1.0]);
        assert_eq!(along(&way[..1], 0.3, 9.0), Pose { at: [0.0, 0.0], heading: 9.0 });
    }
}
