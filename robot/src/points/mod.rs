//! Points of files: point clouds as `.ply`, `.pcd` and `.xyz`. Everything but the coordinates is passed over.
//!
//! Points of which a coordinate is NaN are left out, as scanners and ROS write them in place of a missing return; one that is
//! infinite is no point, and refused.

mod pcd;
mod ply;
mod table;
mod xyz;

use std::path::Path;

use nalgebra::Vector3;

/// Maximum size of a file \[bytes\].
const MAX_BYTES: u64 = 256 << 20;

/// Points of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Points {
    /// In the units of the file.
    pub points: Vec<Vector3<f64>>,
    /// Number of points that were left out, because a coordinate was NaN.
    pub missing: usize,
}

/// Reads the points of a `.ply`, `.pcd` or `.xyz` file, in the units of the file.
///
/// # Errors
/// The reason why it cannot be used.
pub fn points(path: &Path) -> Result<Points, String> {
    let bytes = files::read(path, MAX_BYTES).map_err(|e| e.to_string())?;
    let kind = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    let all = match kind.as_str() {
        "ply" => ply::points(&bytes)?,
        "pcd" => pcd::points(&bytes)?,
        "xyz" | "txt" | "csv" => xyz::points(&String::from_utf8_lossy(&bytes))?,
        _ => return Err(format!("files of kind `{kind}` are not read, only ply, pcd and xyz")),
    };
    let count = all.len();
    let points: Vec<Vector3<f64>> = all.into_iter().filter(|p| !p.iter().any(|x| x.is_nan())).collect();
    if let Some(p) = points.iter().find(|p| p.iter().any(|x| x.is_infinite())) {
        return Err(format!("a point is infinite: {} {} {}", p.x, p.y, p.z));
    }
    match (count, points.len()) {
        (0, _) => Err("it has no point".into()),
        (_, 0) => Err("all of its points are NaN".into()),
        (all, left) => Ok(Points { points, missing: all - left }),
    }
}

/// The lines of a header up to the one that ends it, and what follows.
struct Header<'b> {
    lines: Vec<String>,
    rest: &'b [u8],
}

/// Largest number of lines of a header.
const MOST_LINES: usize = 1000;

/// Splits a file after the line for which `last` is true.
fn header(bytes: &[u8], last: impl Fn(&str) -> bool) -> Option<Header<'_>> {
    let (mut lines, mut rest) = (Vec::new(), bytes);
    while lines.len() < MOST_LINES {
        let end = rest.iter().position(|b| *b == b'\n')?;
        let line = String::from_utf8_lossy(&rest[..end]).trim().to_string();
        rest = &rest[end + 1..];
        let is_last = last(&line);
        lines.push(line);
        if is_last {
            return Some(Header { lines, rest });
        }
    }
    None
}

#[cfg(test)]
mod tests;
