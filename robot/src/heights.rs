//! Heights over a grid, from a text file: a line for each row, its numbers separated by commas, semicolons or spaces.
//!
//! Rows are as one sees them from above with x to the right and y up: the first line has the largest y. The middle of the
//! grid is the origin.

use std::path::Path;

use nalgebra::Vector3;

/// Maximum size of a file \[bytes\].
const MAX_BYTES: u64 = 64 << 20;

/// Largest number of heights in a row, and of rows.
const MOST: usize = 10_000;

/// Heights over a grid, in the units of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Heights {
    rows: Vec<Vec<f64>>,
}

impl Heights {
    /// Reads a `.csv` or `.txt` file.
    ///
    /// # Errors
    /// The reason why it cannot be used.
    pub fn read(path: &Path) -> Result<Heights, String> {
        let kind = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        if !["csv", "txt", "asc"].contains(&kind.as_str()) {
            return Err(format!("files of kind `{kind}` are not read, only csv and txt"));
        }
        let bytes = files::read(path, MAX_BYTES).map_err(|e| e.to_string())?;
        Heights::parse(&String::from_utf8_lossy(&bytes))
    }

    fn parse(text: &str) -> Result<Heights, String> {
        let mut rows: Vec<Vec<f64>> = Vec::new();
        for (i, line) in text.lines().enumerate() {
            let line = line.trim();
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let words = line.split(|c: char| c.is_whitespace() || c == ',' || c == ';').filter(|w| !w.is_empty());
            let mut row = Vec::new();
            for word in words {
                let height: f64 = word.parse().map_err(|_| format!("`{word}` in line {} of it is no number", i + 1))?;
                if !height.is_finite() {
                    return Err(format!("a height in line {} of it is {word}: the ground is unknown there", i + 1));
                }
                row.push(height);
            }
            if let Some(first) = rows.first().filter(|first| first.len() != row.len()) {
                return Err(format!("line {} of it has {} heights, and others {}", i + 1, row.len(), first.len()));
            }
            if row.len() > MOST || rows.len() >= MOST {
                return Err(format!("it has more than {MOST} heights in a row, or rows"));
            }
            rows.push(row);
        }
        match (rows.len(), rows.first().map_or(0, Vec::len)) {
            (0, _) => Err("it has no height".into()),
            (1, _) | (_, ..=1) => Err("it has a single row or column, which is no surface".into()),
            _ => Ok(Heights { rows }),
        }
    }

    /// Number of triangles of the surface.
    pub fn count(&self) -> usize {
        2 * (self.rows.len() - 1) * (self.rows[0].len() - 1)
    }

    /// Triangles of the surface, two for each cell of this width \[m\]; one unit of the file is `scale` metres.
    pub fn triangles(&self, cell: f64, scale: f64) -> Vec<[Vector3<f64>; 3]> {
        let (rows, columns) = (self.rows.len(), self.rows[0].len());
        let middle = |n: usize| 0.5 * (n - 1) as f64;
        let at = |r: usize, c: usize| {
            let (x, y) = (c as f64 - middle(columns), middle(rows) - r as f64);
            Vector3::new(cell * x, cell * y, scale * self.rows[r][c])
        };
        let mut all = Vec::with_capacity(self.count());
        for r in 0..rows - 1 {
            for c in 0..columns - 1 {
                let [a, b, d, e] = [at(r, c), at(r, c + 1), at(r + 1, c), at(r + 1, c + 1)];
                all.extend([[a, d, b], [b, d, e]]);
            }
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_as_seen_from_above() {
        let heights = Heights::parse("# a step\n0, 1, 2\n\n3;4 5\n").unwrap();
        let triangles = heights.triangles(0.5, 0.1);
        assert_eq!(triangles.len(), heights.count());
        let corners: Vec<Vector3<f64>> = triangles.iter().flatten().copied().collect();
        for expected in [[-0.5, 0.25, 0.0], [0.5, 0.25, 0.2], [-0.5, -0.25, 0.3], [0.0, -0.25, 0.4]] {
            assert!(corners.iter().any(|p| (p - Vector3::from(expected)).norm() < 1e-12), "{expected:?} {corners:?}");
        }
        // All face up, and cover the grid.
        let up = triangles.iter().map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a)).z);
        assert!(up.clone().all(|area| area > 0.0));
        assert!((up.sum::<f64>() - 0.5).abs() < 1e-12);
    }

    #[test]
    fn broken_files_say_what_is_wrong() {
        for (text, word) in [
            ("", "no height"),
            ("1 2 3\n", "single row"),
            ("1\n2\n", "single row or column"),
            ("1 2\n1 2 3\n", "line 2"),
            ("1 2\n1 x\n", "`x`"),
            ("1 2\n1 nan\n", "unknown"),
            ("1 2\n1 inf\n", "line 2"),
        ] {
            let why = Heights::parse(text).unwrap_err();
            assert!(why.contains(word), "{why}");
        }
    }
}
