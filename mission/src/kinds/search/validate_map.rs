//! The validator's own walk over an occupancy grid: ways are cut at the borders of cells, and around each piece the cells within
//! the radius are measured. It shares only the grid's data with the planner.

use super::geometry::Point;
use crate::occupancy::{CellIndex, OccupancyGrid};

/// Returns the middle (m) of a blocked cell that is nearer than `radius` (m) to a way, or into which it leads.
pub(super) fn enters_blocked(map: &OccupancyGrid, radius: f64, way: &[Point]) -> Option<Point> {
    let reach = radius.max(0.0) / map.resolution;
    let around = reach.ceil() as i64 + 1;
    for leg in way.windows(2) {
        let (a, b) = (map.to_cells(leg[0]), map.to_cells(leg[1]));
        let at = |share: f64| [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])];
        let shares = borders(a, b);
        for piece in shares.windows(2) {
            let (from, to) = (at(piece[0]), at(piece[1]));
            let inside = at(0.5 * (piece[0] + piece[1])).map(|x| x.floor() as i64);
            for row in inside[1] - around..=inside[1] + around {
                for column in inside[0] - around..=inside[0] + around {
                    let index = CellIndex { column, row };
                    if !map.is_blocked(index) {
                        continue;
                    }
                    let (is_in, gap) = ([column, row] == inside, gap(from, to, [column as f64, row as f64]));
                    if is_in || gap < reach {
                        return Some(map.middle(index));
                    }
                }
            }
        }
    }
    None
}

/// Returns true if blocked cells hide the two ends of a line from one another: it leads into one, or between two that touch at
/// a corner.
pub(super) fn hides(map: &OccupancyGrid, a: Point, b: Point) -> bool {
    let (a, b) = (map.to_cells(a), map.to_cells(b));
    let shares = borders(a, b);
    // Rounding at a corner makes pieces without a length.
    let pieces = shares.windows(2).filter(|piece| piece[1] - piece[0] > 1e-9);
    let cell = |piece: &[f64]| {
        let share = 0.5 * (piece[0] + piece[1]);
        [0, 1].map(|axis| (a[axis] + share * (b[axis] - a[axis])).floor() as i64)
    };
    let cells: Vec<[i64; 2]> = pieces.map(cell).collect();
    let blocked = |column: i64, row: i64| map.is_blocked(CellIndex { column, row });
    let between = |two: &[[i64; 2]]| {
        let ([c0, r0], [c1, r1]) = (two[0], two[1]);
        c0 != c1 && r0 != r1 && blocked(c0, r1) && blocked(c1, r0)
    };
    cells.iter().any(|[column, row]| blocked(*column, *row)) || cells.windows(2).any(between)
}

/// Shares of the line from `a` to `b` at which it passes the border of a cell, with both ends.
fn borders(a: Point, b: Point) -> Vec<f64> {
    let mut shares = vec![0.0, 1.0];
    for axis in 0..2 {
        let along = b[axis] - a[axis];
        let (low, high) = (a[axis].min(b[axis]).ceil() as i64, a[axis].max(b[axis]).floor() as i64);
        if along != 0.0 {
            shares.extend((low..=high).map(|border| ((border as f64 - a[axis]) / along).clamp(0.0, 1.0)));
        }
    }
    shares.sort_by(f64::total_cmp);
    shares.dedup();
    shares
}

/// Distance between a piece of a line inside a cell and the unit square of another cell at a corner: the two do not cross, so
/// that it is the distance of an end of the piece from the square, or of a corner of the square from the piece.
fn gap(from: Point, to: Point, corner: Point) -> f64 {
    let (x, y) = (to[0] - from[0], to[1] - from[1]);
    let squared = x * x + y * y;
    let off_square = |p: Point| {
        let nearest = [0, 1].map(|axis| p[axis].clamp(corner[axis], corner[axis] + 1.0));
        f64::hypot(p[0] - nearest[0], p[1] - nearest[1])
    };
    let off_piece = |p: Point| {
        let share = ((p[0] - from[0]) * x + (p[1] - from[1]) * y) / squared;
        let share = if squared > 0.0 { share.clamp(0.0, 1.0) } else { 0.0 };
        f64::hypot(from[0] + share * x - p[0], from[1] + share * y - p[1])
    };
    let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
    let of_corners = corners.into_iter().map(|d| off_piece([corner[0] + d[0], corner[1] + d[1]]));
    of_corners.chain([off_square(from), off_square(to)]).fold(f64::INFINITY, f64::min)
}
