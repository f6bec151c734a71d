//! The grid of an occupancy map: square cells in a frame that may be turned, row by row from the bottom of the image.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::Fault;
use super::image::Image;
use super::runs;
use super::yaml::{MapFile, Mode};
use crate::numbers::MAX_NUMBER;

/// The most cells of a grid.
pub const MAX_CELLS: usize = 1 << 24;

/// State of a cell, as far as it is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cell {
    /// Nothing stands in it.
    Free,
    /// Something stands in it.
    Occupied,
    /// Nothing is known of it, or it is neither free nor occupied with certainty.
    Unknown,
}

impl Cell {
    /// Name, as in messages.
    pub fn name(self) -> &'static str {
        match self {
            Cell::Free => "free",
            Cell::Occupied => "occupied",
            Cell::Unknown => "unknown",
        }
    }
}

/// Column from the left and row from the bottom, in the frame of the map; outside the map they are negative or too large.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct CellIndex {
    /// Column.
    pub column: i64,
    /// Row.
    pub row: i64,
}

/// An occupancy grid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Data", into = "Data")]
pub struct OccupancyGrid {
    /// Path of the image, for messages.
    pub image: String,
    /// Number of columns.
    pub columns: usize,
    /// Number of rows.
    pub rows: usize,
    /// Width of a cell (m).
    pub resolution: f64,
    /// Position of the lower left corner of the lower left cell (m).
    pub origin: [f64; 2],
    /// Direction of the rows (rad), from the x axis.
    pub yaw: f64,
    cells: Arc<[Cell]>,
    /// A bit for each blocked cell; each row begins a word.
    blocked: Arc<[u64]>,
}

/// The grid as it is stored, with its cells as run lengths.
#[derive(Clone, Serialize, Deserialize)]
struct Data {
    image: String,
    columns: usize,
    rows: usize,
    resolution: f64,
    origin: [f64; 2],
    yaw: f64,
    cells: String,
}

impl From<OccupancyGrid> for Data {
    fn from(grid: OccupancyGrid) -> Data {
        let cells = runs::written(&grid.cells);
        let OccupancyGrid { image, columns, rows, resolution, origin, yaw, .. } = grid;
        Data { image, columns, rows, resolution, origin, yaw, cells }
    }
}

impl TryFrom<Data> for OccupancyGrid {
    type Error = String;

    fn try_from(data: Data) -> Result<OccupancyGrid, String> {
        let Data { image, columns, rows, resolution, origin, yaw, cells } = data;
        let count = columns.checked_mul(rows).filter(|count| (1..=MAX_CELLS).contains(count));
        let count = count.ok_or("a map has no cell, or too many")?;
        let cells = runs::read(&cells, count).ok_or("the cells of a map are wrong")?;
        OccupancyGrid::new(image, [columns, rows], resolution, origin, yaw, cells)
            .ok_or_else(|| "a map has a resolution or an origin that is not possible".into())
    }
}

impl OccupancyGrid {
    /// Creates a grid of `size` columns and rows. None: a number is out of its range.
    pub fn new(
        image: String,
        size: [usize; 2],
        resolution: f64,
        origin: [f64; 2],
        yaw: f64,
        cells: Vec<Cell>,
    ) -> Option<OccupancyGrid> {
        let [columns, rows] = size;
        let small = |x: f64| x.is_finite() && x.abs() <= MAX_NUMBER;
        let sound = resolution > 0.0
            && [resolution, yaw, origin[0], origin[1]].into_iter().all(small)
            && small(resolution * columns.max(rows) as f64)
            && columns.checked_mul(rows).is_some_and(|count| count == cells.len() && count > 0);
        if !sound {
            return None;
        }
        let words = columns.div_ceil(64);
        let mut blocked = vec![0_u64; words * rows];
        for (index, _) in cells.iter().enumerate().filter(|(_, cell)| **cell != Cell::Free) {
            let (column, row) = (index % columns, index / columns);
            blocked[row * words + column / 64] |= 1 << (column % 64);
        }
        let (cells, blocked) = (cells.into(), blocked.into());
        Some(OccupancyGrid { image, columns, rows, resolution, origin, yaw, cells, blocked })
    }

    /// Makes the grid of a map file and its image.
    ///
    /// # Errors
    /// The image has too many cells.
    pub fn read(file: &MapFile, image: &Image) -> Result<OccupancyGrid, Fault> {
        let count = image.width * image.height;
        if count > MAX_CELLS {
            let text = format!("it has {count} pixels, more than the {MAX_CELLS} that a map may have");
            return Err(Fault::of_image(text, "crop it, or save the map with a larger `resolution`"));
        }
        // The first row of an image is the uppermost.
        let places = (0..image.height).rev().flat_map(|y| (0..image.width).map(move |x| [x, y]));
        let cells = places.map(|[x, y]| cell(file, image, x, y)).collect();
        let size = [image.width, image.height];
        OccupancyGrid::new(file.image.clone(), size, file.resolution, file.origin, file.yaw, cells).ok_or_else(|| {
            let text = format!("{} by {} cells of {} m are too far apart", size[0], size[1], file.resolution);
            Fault::of_yaml(None, text, "check `resolution` and `origin`, which are in metres")
        })
    }

    /// Returns a point (m) in the frame of the map, in cells.
    pub fn to_cells(&self, p: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.yaw.sin_cos();
        let [x, y] = [p[0] - self.origin[0], p[1] - self.origin[1]];
        [(cos * x + sin * y) / self.resolution, (cos * y - sin * x) / self.resolution]
    }

    /// Returns the point (m) at a place in the frame of the map, in cells.
    pub fn to_ground(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.yaw.sin_cos();
        let (x, y) = (x * self.resolution, y * self.resolution);
        [self.origin[0] + cos * x - sin * y, self.origin[1] + sin * x + cos * y]
    }

    /// Returns the index of the cell that a point (m) is in.
    pub fn index(&self, p: [f64; 2]) -> CellIndex {
        let [x, y] = self.to_cells(p);
        CellIndex { column: x.floor() as i64, row: y.floor() as i64 }
    }

    /// Returns a cell; none: it is outside the map.
    pub fn cell(&self, CellIndex { column, row }: CellIndex) -> Option<Cell> {
        let (column, row) = (usize::try_from(column).ok()?, usize::try_from(row).ok()?);
        if column >= self.columns { None } else { self.cells.get(row * self.columns + column).copied() }
    }

    /// Returns true if a cell is not known to be free, or is outside the map.
    pub fn is_blocked(&self, index: CellIndex) -> bool {
        self.cell(index) != Some(Cell::Free)
    }

    /// Corners of the map (m), counterclockwise.
    pub fn corners(&self) -> [[f64; 2]; 4] {
        let (w, h) = (self.columns as f64, self.rows as f64);
        [[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]].map(|corner| self.to_ground(corner))
    }

    /// Middle of a cell (m).
    pub fn middle(&self, CellIndex { column, row }: CellIndex) -> [f64; 2] {
        self.to_ground([column as f64 + 0.5, row as f64 + 0.5])
    }

    /// Share of the cells that are in a state.
    pub fn share(&self, of: Cell) -> f64 {
        self.cells.iter().filter(|cell| **cell == of).count() as f64 / self.cells.len() as f64
    }

    /// The state of the cell of a point (m), and its pixel in the image, for messages.
    pub fn describe(&self, p: [f64; 2]) -> String {
        let index = self.index(p);
        match self.cell(index) {
            None => format!(
                "`{}` has {} by {} pixels of {} m, and this point is outside it",
                self.image, self.columns, self.rows, self.resolution
            ),
            Some(cell) => format!("{} is {}", self.pixel(index), cell.name()),
        }
    }

    /// The pixel of a cell inside the map, as image editors count: from 0 at the upper left.
    pub fn pixel(&self, CellIndex { column, row }: CellIndex) -> String {
        let from_top = self.rows as i64 - 1 - row;
        format!("pixel ({column}, {from_top}) of `{}`, counted from its upper left,", self.image)
    }

    /// Calls `each` with the blocked cells of a row between two columns, the last one included, until it returns false. Returns
    /// true if it never did.
    pub(super) fn blocked_in_row(
        &self,
        row: usize,
        from: usize,
        to: usize,
        mut each: impl FnMut(usize) -> bool,
    ) -> bool {
        let words = self.columns.div_ceil(64);
        for word in from / 64..=to / 64 {
            let mut bits = self.blocked[row * words + word];
            if word == from / 64 {
                bits &= u64::MAX << (from % 64);
            }
            if word == to / 64 {
                bits &= u64::MAX >> (63 - to % 64);
            }
            while bits != 0 {
                if !each(word * 64 + bits.trailing_zeros() as usize) {
                    return false;
                }
                bits &= bits - 1;
            }
        }
        true
    }

    /// Cells, row by row from the bottom.
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }
}

/// The cell of a pixel, by the rules of `map_server` of ROS 2.
fn cell(file: &MapFile, image: &Image, x: usize, y: usize) -> Cell {
    let pixel = image.pixel(x, y);
    // In this mode `map_server` takes the alpha channel as one more colour.
    let shade = match pixel.alpha {
        Some(alpha) if file.mode == Mode::Trinary => (3.0 * pixel.shade + alpha) / 4.0,
        _ => pixel.shade,
    };
    let occupancy = match file.mode {
        Mode::Trinary | Mode::Scale if file.negate => shade,
        Mode::Trinary | Mode::Scale => 1.0 - shade,
        // The value of the pixel is the occupancy in percent.
        Mode::Raw => match (255.0 * shade).round() {
            percent if percent <= 100.0 => percent / 100.0,
            _ => return Cell::Unknown,
        },
    };
    if file.mode == Mode::Scale && pixel.alpha.is_some_and(|alpha| alpha < 1.0) {
        return Cell::Unknown;
    }
    match occupancy {
        p if p > file.occupied_thresh => Cell::Occupied,
        p if p < file.free_thresh => Cell::Free,
        _ => Cell::Unknown,
    }
}
