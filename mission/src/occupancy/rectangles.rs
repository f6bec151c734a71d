//! Blocked cells as rectangles, for drawings: runs of a row that are the same in the next rows are one rectangle.

use super::grid::{Cell, OccupancyGrid};

/// A run of cells that goes on over rows.
struct Open {
    from: usize,
    to: usize,
    since: usize,
}

impl OccupancyGrid {
    /// Returns the corners (m) of rectangles that cover the cells in a state, at most about `most`: on a map with more of
    /// them, cells are joined to squares of 2, 4, 8.. cells, which are in the state if one of their cells is.
    pub fn rectangles(&self, of: Cell, most: usize) -> Vec<[[f64; 2]; 4]> {
        let mut joined = 1;
        loop {
            let found = self.merged(of, joined);
            if found.len() <= most || joined >= self.columns.max(self.rows) {
                return found;
            }
            joined *= 2;
        }
    }

    fn merged(&self, of: Cell, joined: usize) -> Vec<[[f64; 2]; 4]> {
        let (columns, rows) = (self.columns.div_ceil(joined), self.rows.div_ceil(joined));
        let mut found = Vec::new();
        let mut open: Vec<Open> = Vec::new();
        for row in 0..=rows {
            let runs = if row < rows { self.runs_of(of, row, columns, joined) } else { Vec::new() };
            let mut going: Vec<Open> = Vec::new();
            for [from, to] in runs {
                let since = open.iter().find(|run| run.from == from && run.to == to).map_or(row, |run| run.since);
                going.push(Open { from, to, since });
            }
            for run in &open {
                if !going.iter().any(|next| next.from == run.from && next.to == run.to) {
                    found.push(self.corners_of(run, row, joined));
                }
            }
            open = going;
        }
        found
    }

    /// Runs of squares in a row of squares, each from its first one to behind its last one.
    fn runs_of(&self, of: Cell, row: usize, columns: usize, joined: usize) -> Vec<[usize; 2]> {
        let is = |column: usize| {
            let rows = row * joined..((row + 1) * joined).min(self.rows);
            let (left, right) = (column * joined, ((column + 1) * joined).min(self.columns));
            rows.into_iter().any(|y| self.cells()[y * self.columns + left..y * self.columns + right].contains(&of))
        };
        let mut runs: Vec<[usize; 2]> = Vec::new();
        for column in (0..columns).filter(|column| is(*column)) {
            match runs.last_mut() {
                Some([_, to]) if *to == column => *to = column + 1,
                _ => runs.push([column, column + 1]),
            }
        }
        runs
    }

    fn corners_of(&self, run: &Open, end: usize, joined: usize) -> [[f64; 2]; 4] {
        let x = |column: usize| (column * joined).min(self.columns) as f64;
        let y = |row: usize| (row * joined).min(self.rows) as f64;
        let (left, right, low, high) = (x(run.from), x(run.to), y(run.since), y(end));
        [[left, low], [right, low], [right, high], [left, high]].map(|corner| self.to_ground(corner))
    }
}
