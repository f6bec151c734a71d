//! Distances of points and straight motions from the blocked cells of a grid.

use super::grid::{CellIndex, OccupancyGrid};

/// Distance of a point from the segment `a b`.
fn to_segment(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let squared = along[0] * along[0] + along[1] * along[1];
    let share = if squared > 0.0 { ((p[0] - a[0]) * along[0] + (p[1] - a[1]) * along[1]) / squared } else { 0.0 };
    let share = share.clamp(0.0, 1.0);
    f64::hypot(a[0] + share * along[0] - p[0], a[1] + share * along[1] - p[1])
}

/// Distance of a point from a box.
fn to_box(p: [f64; 2], low: [f64; 2], high: [f64; 2]) -> f64 {
    let outside = |axis: usize| (low[axis] - p[axis]).max(p[axis] - high[axis]).max(0.0);
    f64::hypot(outside(0), outside(1))
}

/// The shares of the segment `a b` between which a coordinate lies in an interval; none: it never does.
fn part(a: f64, b: f64, low: f64, high: f64) -> Option<[f64; 2]> {
    if a == b {
        return (low <= a && a <= high).then_some([0.0, 1.0]);
    }
    let (one, other) = ((low - a) / (b - a), (high - a) / (b - a));
    let (from, to) = (one.min(other).max(0.0), one.max(other).min(1.0));
    (from <= to).then_some([from, to])
}

/// Distance of the segment `a b` from a box.
fn segment_to_box(a: [f64; 2], b: [f64; 2], low: [f64; 2], high: [f64; 2]) -> f64 {
    let in_both = [0, 1].map(|axis| part(a[axis], b[axis], low[axis], high[axis]));
    if let [Some(x), Some(y)] = in_both
        && x[0].max(y[0]) <= x[1].min(y[1])
    {
        return 0.0;
    }
    let corners = [low, [high[0], low[1]], high, [low[0], high[1]]];
    let near = corners.into_iter().map(|corner| to_segment(corner, a, b)).fold(f64::INFINITY, f64::min);
    near.min(to_box(a, low, high)).min(to_box(b, low, high))
}

impl OccupancyGrid {
    /// Returns true if a straight motion between two points (m) keeps at least this distance (m) from every blocked cell and
    /// from the edge of the map.
    pub fn clear(&self, a: [f64; 2], b: [f64; 2], distance: f64) -> bool {
        self.too_near(a, b, distance).is_none()
    }

    /// Returns a blocked cell that is nearer than `distance` (m) to a straight motion between two points (m); a cell outside
    /// the map stands for its edge.
    pub fn too_near(&self, a: [f64; 2], b: [f64; 2], distance: f64) -> Option<CellIndex> {
        let (a, b) = (self.to_cells(a), self.to_cells(b));
        let reach = distance / self.resolution;
        let size = [self.columns as f64, self.rows as f64];
        for end in [a, b] {
            if (0..2).any(|axis| !(end[axis] >= reach && end[axis] <= size[axis] - reach)) {
                let [column, row] = end.map(|x| x.floor() as i64);
                let outside = |i: i64, count: usize, x: f64| match () {
                    () if x < reach => -1,
                    () if x > count as f64 - reach => count as i64,
                    () => i,
                };
                let (column, row) = (outside(column, self.columns, end[0]), outside(row, self.rows, end[1]));
                return Some(CellIndex { column, row });
            }
        }
        // The motion is inside the map, so that rows and columns are not negative.
        let within = |x: f64, count: usize| (x.max(0.0) as usize).min(count - 1);
        let first = within(a[1].min(b[1]) - reach, self.rows);
        let last = within(a[1].max(b[1]) + reach, self.rows);
        for row in first..=last {
            let (low, high) = (row as f64, row as f64 + 1.0);
            // The columns near the part of the motion that is near this row.
            let Some(part) = part(a[1], b[1], low - reach, high + reach) else { continue };
            let ends = part.map(|share| a[0] + share * (b[0] - a[0]));
            let from = within(ends[0].min(ends[1]) - reach, self.columns);
            let to = within(ends[0].max(ends[1]) + reach, self.columns);
            let mut found = None;
            self.blocked_in_row(row, from, to, |column| {
                let (left, right) = (column as f64, column as f64 + 1.0);
                let gap = segment_to_box(a, b, [left, low], [right, high]);
                if gap < reach {
                    found = Some(CellIndex { column: column as i64, row: row as i64 });
                }
                found.is_none()
            });
            if found.is_some() {
                return found;
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_segment_has_a_distance_from_a_box() {
        let (low, high) = ([2.0, 1.0], [3.0, 2.0]);
        assert_eq!(segment_to_box([0.0, 0.0], [1.0, 0.0], low, high), f64::hypot(1.0, 1.0));
        assert_eq!(segment_to_box([0.0, 1.5], [4.0, 1.5], low, high), 0.0);
        assert_eq!(segment_to_box([2.5, 1.5], [2.5, 1.5], low, high), 0.0);
        assert_eq!(segment_to_box([1.0, 3.0], [4.0, 3.0], low, high), 1.0);
        // Past a corner: the line x + y = 2 is nearest to the lower left one.
        assert!((segment_to_box([0.0, 2.0], [2.0, 0.0], low, high) - 0.5_f64.sqrt()).abs() < 1e-12);
    }
}
