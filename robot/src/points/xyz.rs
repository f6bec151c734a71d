//! XYZ: a point a line, its coordinates first, separated by spaces, tabs, commas or semicolons; no header.

use nalgebra::Vector3;

pub(super) fn points(text: &str) -> Result<Vec<Vector3<f64>>, String> {
    let mut found = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with(['#', '/']) {
            continue;
        }
        let mut words = line.split(|c: char| c.is_whitespace() || c == ',' || c == ';').filter(|w| !w.is_empty());
        let mut p = Vector3::zeros();
        for x in p.iter_mut() {
            let word = words.next().ok_or_else(|| format!("line {} of it has fewer than three numbers", i + 1))?;
            *x = word.parse().map_err(|_| format!("`{word}` in line {} of it is no number", i + 1))?;
        }
        found.push(p);
    }
    Ok(found)
}
