//! Wavefront OBJ: reads the lines that start with `v`, and those with `f` for triangles.

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

/// Returns all triangles; polygons are split about their first corner.
pub(super) fn triangles(text: &str) -> Result<Vec<[Vector3<f64>; 3]>, String> {
    let vertices = vertices(text)?;
    let (mut found, mut known) = (Vec::new(), 0usize);
    for (i, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        match words.next() {
            // A negative index counts back from the vertices so far.
            Some("v") => known += 1,
            Some("f") => {
                let corner = |word: &str| {
                    let index: i64 = word.split('/').next()?.parse().ok()?;
                    let at = if index < 0 { known as i64 + index } else { index - 1 };
                    vertices.get(usize::try_from(at).ok()?).copied()
                };
                let corners: Option<Vec<Vector3<f64>>> = words.map(corner).collect();
                let corners =
                    corners.ok_or_else(|| format!("the face in line {} has a vertex that is not there", i + 1))?;
                let [first, rest @ ..] = corners.as_slice() else {
                    return Err(format!("the face in line {} has no vertex", i + 1));
                };
                found.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
            }
            _ => {}
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

    #[test]
    fn faces_by_any_index() {
        let [a, b, c, d] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]].map(Vector3::from);
        let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1/1/1 2//2 3 4/4\nf -4 -3 -2\n";
        assert_eq!(triangles(text).unwrap(), [[a, b, c], [a, c, d], [a, b, c]]);
        for broken in ["f 1 2 5\n", "f 0 1 2\n", "f -5 1 2\n", "f a 1 2\n", "f\n"] {
            assert!(triangles(&text.replace("f -4 -3 -2\n", broken)).unwrap_err().contains("line 6"), "{broken}");
        }
    }
}
