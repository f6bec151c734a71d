//! The observability graph of srs 5.1: cells of the ground, and which of them are in sight of one another.
//!
//! The ground is cut into square cells. A cell counts if its middle is in the area, outside solid walls and in a free cell of the
//! map. Two cells see one another if no wall, edge of the area or blocked cell is between their middles. An agent sees from the
//! nearest cell whose middle is in its sight, so that a thin wall never puts it on the wrong side. Sight has no direction.

use std::sync::{Arc, OnceLock};

use super::geometry::{Point, bounds, distance, edges, inside, segments};
use super::problem::{Problem, Wall};
use crate::occupancy::OccupancyGrid;

/// The most cells of a belief.
pub const MAX_CELLS: usize = 4096;

/// Difference of two distances below which they are the same (m).
const TIE: f64 = 1e-6;

/// The parts of a problem that sight depends on.
#[derive(Clone, Debug, PartialEq)]
struct Opaque {
    area: Vec<Point>,
    walls: Vec<Wall>,
    map: Option<OccupancyGrid>,
    cell: f64,
    within: f64,
}

/// Cells that see one another.
#[derive(Clone, Debug)]
pub struct Sight {
    of: Opaque,
    /// Lines that block the sight.
    lines: Vec<[Point; 2]>,
    low: Point,
    columns: usize,
    rows: usize,
    /// Number of the cell at each place of the raster, row by row.
    numbers: Vec<Option<u32>>,
    middles: Vec<Point>,
    /// For each cell those that it sees, the nearest first, with their distances (m).
    seen: Vec<Vec<(f64, u32)>>,
}

/// Returns the number of columns and rows of cells of this width (m) over a ground.
pub fn raster_of(area: &[Point], cell: f64) -> [usize; 2] {
    let [low, high] = bounds(area.iter().copied());
    // Rounding does not add a row.
    [0, 1].map(|axis| (((high[axis] - low[axis]) / cell - 1e-9).ceil()).max(1.0) as usize)
}

impl Sight {
    fn new(of: Opaque) -> Sight {
        let [low, _] = bounds(of.area.iter().copied());
        let [columns, rows] = raster_of(&of.area, of.cell);
        let mut lines: Vec<[Point; 2]> = edges(&of.area).collect();
        for wall in of.walls.iter().filter(|wall| !wall.transparent) {
            match wall.solid {
                true => lines.extend(edges(&wall.points)),
                false => lines.extend(wall.points.windows(2).map(|two| [two[0], two[1]])),
            }
        }
        let mut sight = Sight {
            of,
            lines,
            low,
            columns,
            rows,
            numbers: vec![None; columns.saturating_mul(rows)],
            middles: Vec::new(),
            seen: Vec::new(),
        };
        for place in 0..sight.numbers.len() {
            let at = sight.middle_of(place % columns, place / columns);
            if sight.is_searchable(at) && sight.middles.len() < MAX_CELLS {
                sight.numbers[place] = Some(sight.middles.len() as u32);
                sight.middles.push(at);
            }
        }
        let count = sight.middles.len();
        let mut seen: Vec<Vec<(f64, u32)>> = (0..count).map(|cell| vec![(0.0, cell as u32)]).collect();
        for one in 0..count {
            for other in one + 1..count {
                let (a, b) = (sight.middles[one], sight.middles[other]);
                let far = distance(a, b);
                if far <= sight.of.within && sight.is_clear(a, b) {
                    seen[one].push((far, other as u32));
                    seen[other].push((far, one as u32));
                }
            }
        }
        for row in &mut seen {
            row.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        }
        sight.seen = seen;
        sight
    }

    fn middle_of(&self, column: usize, row: usize) -> Point {
        let at = |low: f64, number: usize| low + (number as f64 + 0.5) * self.of.cell;
        [at(self.low[0], column), at(self.low[1], row)]
    }

    fn is_searchable(&self, at: Point) -> bool {
        inside(at, &self.of.area)
            && !self.of.walls.iter().any(|wall| wall.solid && inside(at, &wall.points))
            && self.of.map.as_ref().is_none_or(|map| !map.is_blocked(map.index(at)))
    }

    /// Returns true if nothing blocks the sight between two points.
    pub fn is_clear(&self, a: Point, b: Point) -> bool {
        // Lines whose boxes are apart do not meet.
        let [low, high] =
            [0, 1].map(|side| [0, 1].map(|axis| if side == 0 { a[axis].min(b[axis]) } else { a[axis].max(b[axis]) }));
        let is_apart = |c: &Point, d: &Point| {
            (0..2).any(|axis| c[axis].max(d[axis]) < low[axis] || c[axis].min(d[axis]) > high[axis])
        };
        // A line that passes the end of a wall touches it.
        let blocks = |[c, d]: &[Point; 2]| !is_apart(c, d) && segments(a, b, *c, *d) <= 0.0;
        !self.lines.iter().any(blocks) && self.of.map.as_ref().is_none_or(|map| !map.crosses(a, b))
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.middles.len()
    }

    /// Returns true if there is no cell.
    pub fn is_empty(&self) -> bool {
        self.middles.is_empty()
    }

    /// Middles of the cells (m).
    pub fn middles(&self) -> &[Point] {
        &self.middles
    }

    /// Corners of a cell (m).
    pub fn corners(&self, cell: usize) -> [Point; 4] {
        let ([x, y], half) = (self.middles[cell], 0.5 * self.of.cell);
        [[x - half, y - half], [x + half, y - half], [x + half, y + half], [x - half, y + half]]
    }

    /// Returns the cell from which an agent at a point sees: the nearest one whose middle is in its sight.
    pub fn seat(&self, at: Point) -> Option<u32> {
        let index = |axis: usize| ((at[axis] - self.low[axis]) / self.of.cell).floor() as i64;
        let (column, row) = (index(0), index(1));
        // Cells row by row, those that do not count infinitely far.
        let mut near = [(f64::INFINITY, 0_u32); 9];
        for (place, entry) in near.iter_mut().enumerate() {
            let (c, r) = (column + place as i64 % 3 - 1, row + place as i64 / 3 - 1);
            if (0..self.columns as i64).contains(&c)
                && (0..self.rows as i64).contains(&r)
                && let Some(cell) = self.numbers[r as usize * self.columns + c as usize]
            {
                *entry = (distance(at, self.middles[cell as usize]), cell);
            }
        }
        let is_seen = |(far, cell): &(f64, u32)| *far <= 1e-9 || self.is_clear(at, self.middles[*cell as usize]);
        for _ in 0..near.len() {
            // Of those that are as near the first one counts, whatever rounding says.
            let least = near.iter().map(|(far, _)| *far).fold(f64::INFINITY, f64::min);
            let nearest = near.iter_mut().find(|(far, _)| *far <= least + TIE && far.is_finite())?;
            if is_seen(nearest) {
                return Some(nearest.1);
            }
            nearest.0 = f64::INFINITY;
        }
        None
    }

    /// Cells whose middles are at most this far (m) from a point, whether or not they are in sight.
    pub fn around(&self, at: Point, far: f64) -> impl Iterator<Item = u32> + '_ {
        let index = |axis: usize| ((at[axis] - self.low[axis]) / self.of.cell).floor();
        let (column, row, reach) = (index(0), index(1), (far / self.of.cell).ceil() as i32);
        let places = (-reach..=reach).flat_map(move |dr| (-reach..=reach).map(move |dc| (dc, dr)));
        places.filter_map(move |(dc, dr)| {
            let (c, r) = (column + f64::from(dc), row + f64::from(dr));
            if c < 0.0 || r < 0.0 || c >= self.columns as f64 || r >= self.rows as f64 {
                return None;
            }
            let cell = self.numbers[r as usize * self.columns + c as usize]?;
            (distance(at, self.middles[cell as usize]) <= far).then_some(cell)
        })
    }

    /// Cells in sight from a cell, up to a distance (m).
    pub fn seen(&self, from: u32, within: f64) -> &[(f64, u32)] {
        let row = &self.seen[from as usize];
        &row[..row.partition_point(|(far, _)| *far <= within)]
    }
}

/// The sight of a problem, computed when it is first asked for. Copies of the problem share it.
#[derive(Clone, Debug, Default)]
pub struct SightCache(OnceLock<Arc<Sight>>);

impl PartialEq for SightCache {
    /// The sight follows from the rest of a problem.
    fn eq(&self, _: &SightCache) -> bool {
        true
    }
}

impl SightCache {
    pub(super) fn of(&self, problem: &Problem) -> Arc<Sight> {
        let within = problem.agents.iter().filter_map(|agent| agent.sees).map(|sees| sees.within).fold(0.0, f64::max);
        let is_same = |known: &&Arc<Sight>| {
            let of = &known.of;
            of.within == within
                && of.cell == problem.cell
                && of.area == problem.area
                && of.walls == problem.walls
                && of.map == problem.occupancy
        };
        // Walls may have changed since a copy of the problem asked.
        if let Some(known) = self.0.get().filter(is_same) {
            return known.clone();
        }
        let of = Opaque {
            area: problem.area.clone(),
            walls: problem.walls.clone(),
            map: problem.occupancy.clone(),
            cell: problem.cell,
            within,
        };
        let sight = Arc::new(Sight::new(of));
        let _ = self.0.set(sight.clone());
        sight
    }
}
