//! A straight line over a grid, cell by cell (Amanatides and Woo 1987).

use super::grid::{CellIndex, OccupancyGrid};

impl OccupancyGrid {
    /// Returns true if the straight line between two points (m) enters a blocked cell, or leaves the map. A line that passes
    /// the corner that two diagonal cells share is crossed if both of the others are blocked.
    pub fn crosses(&self, a: [f64; 2], b: [f64; 2]) -> bool {
        !self.walk(a, b, |index| !self.is_blocked(index))
    }

    /// Visits the cells on the straight line between two points (m), from `a` to `b`, until `visit` returns false; returns
    /// true if it never did. Where the line passes a corner, the two cells beside it are no part of it; a pair of which
    /// `visit` refuses both stops the walk too.
    pub fn walk(&self, a: [f64; 2], b: [f64; 2], mut visit: impl FnMut(CellIndex) -> bool) -> bool {
        let (from, to) = (self.to_cells(a), self.to_cells(b));
        let mut at = from.map(|x| x.floor() as i64);
        let end = to.map(|x| x.floor() as i64);
        let index = |[column, row]: [i64; 2]| CellIndex { column, row };
        if !visit(index(at)) {
            return false;
        }
        let mut step = [0_i64; 2];
        // Shares of the line at which the next border of a column or a row is passed, and between two borders.
        let (mut next, mut width) = ([f64::INFINITY; 2], [f64::INFINITY; 2]);
        for axis in 0..2 {
            let along = to[axis] - from[axis];
            if along == 0.0 || !along.is_finite() {
                continue;
            }
            step[axis] = if along > 0.0 { 1 } else { -1 };
            let border = at[axis] as f64 + if along > 0.0 { 1.0 } else { 0.0 };
            next[axis] = (border - from[axis]) / along;
            width[axis] = 1.0 / along.abs();
        }
        while at != end {
            // Rounding may not lead past the last cell of an axis.
            let open = [0, 1].map(|axis| at[axis] != end[axis]);
            let corner = open[0] && open[1] && (next[0] - next[1]).abs() <= 1e-12;
            if corner {
                let beside = [[at[0] + step[0], at[1]], [at[0], at[1] + step[1]]];
                let refused = beside.into_iter().filter(|cell| !visit(index(*cell))).count();
                if refused == 2 {
                    return false;
                }
                (at[0], at[1]) = (at[0] + step[0], at[1] + step[1]);
                (next[0], next[1]) = (next[0] + width[0], next[1] + width[1]);
            } else {
                let axis = if !open[1] || (open[0] && next[0] < next[1]) { 0 } else { 1 };
                at[axis] += step[axis];
                next[axis] += width[axis];
            }
            if !visit(index(at)) {
                return false;
            }
        }
        true
    }
}
