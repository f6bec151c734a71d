//! Wavefront OBJ: reads the lines that start with `v`.

use nalgebra::Vector3;

/// Returns all vertices of the file.
pub(super) fn vertices(text: &str) -> Result<Vec<Vector3<f64>>, String> {
    let mut found = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        if words.next() == Some("v") {
            let vertex = super::point(words).ok_or_else(|| format!("line {} is broken", i + 1))?;
            found.push(vertex);
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_vertices_are_read() {
        let text = "# cube\nvn 0 0 1\nv 1 2 3\nv -1e-1 0 0.5 1.0\nvt 0 0\nf 1 2 3\n";
        let expected = vec![Vector3::new(1.0, 2.0, 3.0), Vector3::new(-0.1, 0.0, 0.5)];
        assert_eq!(vertices(text).unwrap(), expected);
        assert!(vertices("v 1 2 x\n").is_err());
    }
}
