//! The free ground of a body: the area without the walls that it does not pass, with its clearance.

use super::geometry::{Point, area, bounds, distance, edges, inside, segments, to_segment};
use super::problem::{Agent, Problem};
use crate::occupancy::OccupancyGrid;

/// Least clearance (m): a wall is not touched.
const LEAST: f64 = 1e-6;
/// Least width of a cell of the raster (m).
const CELL: f64 = 0.1;
/// The most cells of the raster.
const MOST_CELLS: f64 = 250_000.0;
/// The most cells of the raster of a map, whose cells it joins if there are more.
const MOST_MAP_CELLS: usize = 1_000_000;
/// Buckets that a segment may cover before all walls are looked at.
const MOST_BUCKETS: usize = 64;

/// Properties of an agent that its ground depends on.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Distance that its middle keeps from walls (m).
    pub radius: f64,
    /// Indices of the walls that it passes, in order.
    pub passes: Vec<usize>,
}

impl Body {
    /// The body of an agent.
    pub fn of(agent: &Agent) -> Body {
        let mut passes = agent.passes.clone();
        passes.sort_unstable();
        passes.dedup();
        Body { radius: agent.radius, passes }
    }
}

/// The free ground of a body.
#[derive(Clone, Debug)]
pub struct Ground {
    area: Vec<Point>,
    solids: Vec<Vec<Point>>,
    /// Lines that it does not touch.
    lines: Vec<[Point; 2]>,
    clearance: f64,
    /// Least and greatest corner (m).
    pub corners: [Point; 2],
    /// Lines near each bucket, row by row.
    buckets: Vec<Vec<u32>>,
    columns: usize,
    rows: usize,
    width: f64,
    map: Option<OccupancyGrid>,
}

impl Ground {
    /// The free ground of a body.
    pub fn new(problem: &Problem, body: &Body) -> Ground {
        let mut lines: Vec<[Point; 2]> = edges(&problem.area).collect();
        let mut solids = Vec::new();
        for (index, wall) in problem.walls.iter().enumerate() {
            if body.passes.contains(&index) {
                continue;
            }
            if wall.solid {
                lines.extend(edges(&wall.points));
                solids.push(wall.points.clone());
            } else {
                lines.extend(wall.points.windows(2).map(|two| [two[0], two[1]]));
            }
        }
        let corners = problem.bounds();
        let size = [corners[1][0] - corners[0][0], corners[1][1] - corners[0][1]];
        let width = (f64::max(size[0], size[1]) / 64.0).max(0.5);
        let count = |length: f64| ((length / width).ceil() as usize).clamp(1, 128);
        let (columns, rows) = (count(size[0]), count(size[1]));
        let mut ground = Ground {
            area: problem.area.clone(),
            solids,
            lines: Vec::new(),
            clearance: body.radius.max(LEAST),
            corners,
            buckets: vec![Vec::new(); columns * rows],
            columns,
            rows,
            width,
            map: problem.occupancy.clone(),
        };
        for (index, line) in lines.iter().enumerate() {
            let [low, high] = bounds(*line);
            let [[c0, r0], [c1, r1]] = ground.covered(low, high, ground.clearance);
            for row in r0..=r1 {
                for column in c0..=c1 {
                    ground.buckets[row * columns + column].push(index as u32);
                }
            }
        }
        ground.lines = lines;
        ground
    }

    /// Buckets around a box with a margin: least and greatest column and row.
    fn covered(&self, low: Point, high: Point, margin: f64) -> [[usize; 2]; 2] {
        let index =
            |x: f64, least: f64, count: usize| (((x - least) / self.width).floor().max(0.0) as usize).min(count - 1);
        let corner =
            |p: Point| [index(p[0], self.corners[0][0], self.columns), index(p[1], self.corners[0][1], self.rows)];
        [corner([low[0] - margin, low[1] - margin]), corner([high[0] + margin, high[1] + margin])]
    }

    /// Returns true if the body fits at a point.
    pub fn fits(&self, p: Point) -> bool {
        let [[column, row], _] = self.covered(p, p, 0.0);
        let far = |index: &u32| {
            let [a, b] = self.lines[*index as usize];
            to_segment(p, a, b) >= self.clearance
        };
        inside(p, &self.area)
            && !self.solids.iter().any(|solid| inside(p, solid))
            && self.buckets[row * self.columns + column].iter().all(far)
            && self.map.as_ref().is_none_or(|map| map.clear(p, p, self.clearance))
    }

    /// Returns true if the body fits everywhere on a segment between two points where it fits.
    pub fn clear(&self, a: Point, b: Point) -> bool {
        self.clear_of_lines(a, b) && self.map.as_ref().is_none_or(|map| map.clear(a, b, self.clearance))
    }

    fn clear_of_lines(&self, a: Point, b: Point) -> bool {
        let [low, high] = bounds([a, b]);
        let far = |line: &[Point; 2]| {
            let [c, d] = *line;
            // A cheap rejection by boxes comes first.
            let apart = f64::max(c[0], d[0]) + self.clearance < low[0]
                || f64::min(c[0], d[0]) - self.clearance > high[0]
                || f64::max(c[1], d[1]) + self.clearance < low[1]
                || f64::min(c[1], d[1]) - self.clearance > high[1];
            apart || segments(a, b, c, d) >= self.clearance
        };
        let [[c0, r0], [c1, r1]] = self.covered(low, high, 0.0);
        if (c1 - c0 + 1) * (r1 - r0 + 1) > MOST_BUCKETS {
            return self.lines.iter().all(far);
        }
        let mut cells = (r0..=r1).flat_map(|row| (c0..=c1).map(move |column| row * self.columns + column));
        cells.all(|cell| self.buckets[cell].iter().all(|index| far(&self.lines[*index as usize])))
    }

    /// Returns true if the body fits between any two points where it fits: there is no wall and no map, and the area is convex.
    pub fn clear_everywhere(&self) -> bool {
        let count = self.area.len();
        let turn = |i: usize| {
            let [a, b, c] = [0, 1, 2].map(|k| self.area[(i + k) % count]);
            (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])
        };
        let convex = (0..count).all(|i| turn(i) >= 0.0) || (0..count).all(|i| turn(i) <= 0.0);
        convex && self.lines.len() == count && self.map.is_none()
    }

    /// Area of the ground, walls included (m^2).
    pub fn size(&self) -> f64 {
        area(&self.area)
    }

    /// A raster of the ground for a search from cell to cell. On a map its cells are those of the map, or squares of them on
    /// a map of more than a million.
    pub fn raster(&self) -> Raster<'_> {
        if let Some(map) = &self.map {
            let mut joined = 1;
            while map.columns.div_ceil(joined) * map.rows.div_ceil(joined) > MOST_MAP_CELLS {
                joined += 1;
            }
            let (columns, rows) = (map.columns.div_ceil(joined), map.rows.div_ceil(joined));
            return Raster { ground: self, cell: joined as f64 * map.resolution, joined, columns, rows };
        }
        let size = [self.corners[1][0] - self.corners[0][0], self.corners[1][1] - self.corners[0][1]];
        let cell = (size[0] * size[1] / MOST_CELLS).sqrt().max(CELL);
        let count = |length: f64| ((length / cell).ceil() as usize).max(1);
        Raster { ground: self, cell, joined: 1, columns: count(size[0]), rows: count(size[1]) }
    }
}

/// The ground in square cells.
#[derive(Clone, Debug)]
pub struct Raster<'g> {
    ground: &'g Ground,
    /// Width of a cell (m).
    pub cell: f64,
    /// Number of cells of the map on a side of a cell.
    joined: usize,
    columns: usize,
    rows: usize,
}

impl Raster<'_> {
    fn middle(&self, cell: usize) -> Point {
        let [column, row] = [cell % self.columns, cell / self.columns].map(|i| i as f64 + 0.5);
        if let Some(map) = &self.ground.map {
            let joined = self.joined as f64;
            return map.to_ground([column * joined, row * joined]);
        }
        let [x, y] = self.ground.corners[0];
        [x + column * self.cell, y + row * self.cell]
    }

    /// Column and row of a point, which may be outside the raster.
    fn place(&self, p: Point) -> [f64; 2] {
        match &self.ground.map {
            Some(map) => map.to_cells(p).map(|x| (x / self.joined as f64).floor()),
            None => [0, 1].map(|axis| ((p[axis] - self.ground.corners[0][axis]) / self.cell).floor()),
        }
    }

    /// Cells around a point whose middles the body reaches straight from it.
    fn around(&self, p: Point) -> Vec<usize> {
        let [column, row] = self.place(p);
        let index = |x: f64, count: usize| (x as isize).clamp(0, count as isize - 1);
        let (column, row) = (index(column, self.columns), index(row, self.rows));
        let mut found = Vec::new();
        for (dc, dr) in (-2..=2).flat_map(|dr| (-2..=2).map(move |dc| (dc, dr))) {
            let (c, r) = (column + dc, row + dr);
            if (0..self.columns as isize).contains(&c) && (0..self.rows as isize).contains(&r) {
                let cell = r as usize * self.columns + c as usize;
                let middle = self.middle(cell);
                if self.ground.fits(middle) && self.ground.clear(p, middle) {
                    found.push(cell);
                }
            }
        }
        found
    }

    fn neighbours(&self, cell: usize) -> impl Iterator<Item = usize> + '_ {
        let (column, row) = ((cell % self.columns) as isize, (cell / self.columns) as isize);
        let steps = [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)];
        let valid = move |(c, r): &(isize, isize)| {
            (0..self.columns as isize).contains(c) && (0..self.rows as isize).contains(r)
        };
        let next = steps.into_iter().map(move |(dc, dr)| (column + dc, row + dr)).filter(valid);
        next.map(|(c, r)| r as usize * self.columns + c as usize)
    }

    /// Cells that the body reaches from a point.
    pub fn reached(&self, from: Point) -> Reached<'_> {
        let mut before = vec![u32::MAX; self.columns * self.rows];
        let mut queue: std::collections::VecDeque<usize> = self.around(from).into();
        queue.iter().for_each(|cell| before[*cell] = *cell as u32);
        while let Some(cell) = queue.pop_front() {
            let here = self.middle(cell);
            for next in self.neighbours(cell) {
                if before[next] == u32::MAX && self.ground.clear(here, self.middle(next)) {
                    before[next] = cell as u32;
                    queue.push_back(next);
                }
            }
        }
        Reached { raster: self, from, before }
    }
}

/// Cells that a body reaches from a point.
#[derive(Clone, Debug)]
pub struct Reached<'r> {
    raster: &'r Raster<'r>,
    from: Point,
    before: Vec<u32>,
}

impl Reached<'_> {
    /// Returns true if the body reaches a point where it fits.
    pub fn reaches(&self, to: Point) -> bool {
        self.raster.ground.clear(self.from, to)
            || self.raster.around(to).iter().any(|cell| self.before[*cell] != u32::MAX)
    }

    /// Returns true if the body reaches the cell of a point or its middle.
    pub fn middles(&self) -> impl Iterator<Item = Point> + '_ {
        let reached = self.before.iter().enumerate().filter(|(_, before)| **before != u32::MAX);
        reached.map(|(cell, _)| self.raster.middle(cell))
    }

    /// A way to a point, from cell to cell; none: the body does not reach it.
    pub fn way(&self, to: Point) -> Option<Vec<Point>> {
        if self.raster.ground.clear(self.from, to) {
            return Some(vec![self.from, to]);
        }
        let reached = self.raster.around(to).into_iter().filter(|cell| self.before[*cell] != u32::MAX);
        let near = |a: &usize, b: &usize| {
            let far = |cell: &usize| distance(self.raster.middle(*cell), to);
            far(a).total_cmp(&far(b))
        };
        let mut cell = reached.min_by(near)?;
        let mut way = vec![to, self.raster.middle(cell)];
        while self.before[cell] as usize != cell {
            cell = self.before[cell] as usize;
            way.push(self.raster.middle(cell));
        }
        way.push(self.from);
        way.reverse();
        Some(way)
    }
}
