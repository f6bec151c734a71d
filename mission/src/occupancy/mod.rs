//! Occupancy grid maps as ROS stores them: a YAML file of `map_server` that names an image (PGM or PNG), and the grid of
//! free, occupied and unknown cells that both describe.
//!
//! [`MapFile`] reads the YAML, [`Image`] the image, [`OccupancyGrid::read`] makes the grid. Cells that are not known to be
//! free, and everything outside the map, are blocked. [`OccupancyGrid::crosses`] walks a straight line cell by cell, for
//! motions of a point and for lines of sight; [`OccupancyGrid::clear`] keeps a distance from all blocked cells.
//! The crate reads no files: the compiler does, and a program contains the grid as data.

mod clearance;
mod grid;
mod image;
mod pgm;
mod rectangles;
mod runs;
mod traversal;
mod yaml;

pub use grid::{Cell, CellIndex, MAX_CELLS, OccupancyGrid};
pub use image::{Image, MAX_IMAGE_BYTES};
pub use yaml::{MapFile, Mode, image_path};

/// A mistake in a map file or in its image.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// It is in the image; else in the YAML.
    pub in_image: bool,
    /// Number of the line of the YAML, from 1.
    pub line: Option<usize>,
    /// The mistake, in a sentence.
    pub text: String,
    /// A way out.
    pub help: String,
}

impl Fault {
    fn of_image(text: impl Into<String>, help: impl Into<String>) -> Fault {
        Fault { in_image: true, line: None, text: text.into(), help: help.into() }
    }

    fn of_yaml(line: Option<usize>, text: impl Into<String>, help: impl Into<String>) -> Fault {
        Fault { in_image: false, line, text: text.into(), help: help.into() }
    }
}
