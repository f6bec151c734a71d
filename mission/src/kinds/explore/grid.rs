//! The grid over which the person walks: cells of the region, those that obstacles block, and the shortest ways between them.

use std::collections::VecDeque;

use super::polygon::{Convex, Point};
use super::problem::{MAX_SIDE, Problem};

/// Overlap (m) of a cell and an obstacle that does not count.
const TOUCHES: f64 = 1e-6;

/// The grid of a problem. Cells are numbered in rows from the lower left corner of the region, as in the models of people.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Number of columns.
    pub columns: usize,
    /// Number of rows.
    pub rows: usize,
    /// Width of a cell (m).
    pub cell: f64,
    /// Cells that are outside of the region or in an obstacle.
    pub blocked: Vec<bool>,
    /// Cells whose middle is in the exit.
    pub exit: Vec<bool>,
    origin: Point,
}

impl Grid {
    /// The grid of a problem; none: it would have too many cells, or none.
    pub fn new(problem: &Problem) -> Option<Grid> {
        Grid::of(&problem.area, &problem.exit, problem.obstacles.iter().map(|of| &of.shape), problem.person.cell)
    }

    /// The grid of a region.
    pub fn of<'o>(
        area: &Convex,
        exit: &Convex,
        obstacles: impl Iterator<Item = &'o Convex> + Clone,
        cell: f64,
    ) -> Option<Grid> {
        let [low, high] = area.bounds();
        // A region that is a multiple of the cell but for rounding has that many cells.
        let count = |axis: usize| ((high[axis] - low[axis]) / cell + 1e-6).floor();
        let (columns, rows) = (count(0), count(1));
        if !(1.0..=MAX_SIDE as f64).contains(&columns) || !(1.0..=MAX_SIDE as f64).contains(&rows) {
            return None;
        }
        let (columns, rows) = (columns as usize, rows as usize);
        let mut grid = Grid { columns, rows, cell, blocked: Vec::new(), exit: Vec::new(), origin: low };
        let square = Convex::rectangle([cell, cell])?;
        for index in 0..columns * rows {
            let middle = grid.middle(index);
            let body = square.moved(middle);
            let outside = body.corners().iter().any(|corner| !area.contains(*corner, TOUCHES));
            let solid = obstacles.clone().any(|of| of.gap(&body) < -TOUCHES);
            grid.blocked.push(outside || solid);
            grid.exit.push(exit.contains(middle, 0.0));
        }
        Some(grid)
    }

    /// Number of cells.
    pub fn count(&self) -> usize {
        self.columns * self.rows
    }

    /// The middle of a cell (m).
    pub fn middle(&self, index: usize) -> Point {
        let (column, row) = (index % self.columns, index / self.columns);
        [self.origin[0] + (column as f64 + 0.5) * self.cell, self.origin[1] + (row as f64 + 0.5) * self.cell]
    }

    /// The cell of a point; none outside of the grid.
    pub fn at(&self, at: Point) -> Option<usize> {
        let place = |axis: usize, count: usize| {
            let place = ((at[axis] - self.origin[axis]) / self.cell).floor();
            (0.0..count as f64).contains(&place).then_some(place as usize)
        };
        Some(place(1, self.rows)? * self.columns + place(0, self.columns)?)
    }

    /// The free cell whose middle is nearest to a point; none: there is none.
    pub fn nearest_free(&self, at: Point) -> Option<usize> {
        let free = (0..self.count()).filter(|cell| !self.blocked[*cell]);
        free.min_by(|a, b| {
            let far = |cell: usize| super::polygon::distance(self.middle(cell), at);
            far(*a).total_cmp(&far(*b))
        })
    }

    /// The free cells beside a cell: north, south, west, east, as far as there are any.
    pub fn neighbours(&self, index: usize) -> impl Iterator<Item = usize> + use<'_> {
        let (column, row) = (index % self.columns, index / self.columns);
        let north = (row + 1 < self.rows).then(|| index + self.columns);
        let south = row.checked_sub(1).map(|_| index - self.columns);
        let west = column.checked_sub(1).map(|_| index - 1);
        let east = (column + 1 < self.columns).then_some(index + 1);
        [north, south, west, east].into_iter().flatten().filter(|cell| !self.blocked[*cell])
    }

    /// Numbers of steps from each cell to the nearest of these; none: there is no way.
    pub fn steps_to(&self, goals: impl Iterator<Item = usize>) -> Vec<Option<usize>> {
        let mut steps = vec![None; self.count()];
        let mut queue = VecDeque::new();
        for goal in goals.filter(|goal| !self.blocked[*goal]) {
            steps[goal] = Some(0);
            queue.push_back(goal);
        }
        while let Some(cell) = queue.pop_front() {
            let next = steps[cell].map(|count: usize| count + 1);
            for beside in self.neighbours(cell) {
                if steps[beside].is_none() {
                    steps[beside] = next;
                    queue.push_back(beside);
                }
            }
        }
        steps
    }

    /// The cells of the exit that can be entered.
    pub fn exits(&self) -> impl Iterator<Item = usize> + use<'_> {
        (0..self.count()).filter(|cell| self.exit[*cell] && !self.blocked[*cell])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_numbered_in_rows_and_ways_go_around_obstacles() {
        let area = Convex::rectangle([3.0, 3.0]).unwrap();
        let exit = Convex::rectangle([1.0, 1.0]).unwrap().moved([1.0, 1.0]);
        let obstacle = Convex::rectangle([2.0, 1.0]).unwrap().moved([0.5, 0.0]);
        let grid = Grid::of(&area, &exit, [&obstacle].into_iter(), 1.0).unwrap();
        assert_eq!((grid.columns, grid.rows), (3, 3));
        assert_eq!(grid.blocked, [false, false, false, false, true, true, false, false, false]);
        assert_eq!(grid.exits().collect::<Vec<_>>(), [8]);
        let steps = grid.steps_to(grid.exits());
        assert_eq!(steps[2], Some(6));
        assert_eq!((grid.at([-1.0, 1.0]), grid.at([9.0, 0.0])), (Some(6), None));
        assert_eq!(grid.middle(6), [-1.0, 1.0]);
        assert_eq!(grid.nearest_free([0.6, 0.1]), Some(8));
    }
}
