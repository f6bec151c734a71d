//! STL, binary and ASCII.

use nalgebra::Vector3;

/// Sizes in a binary file: header with the count, and one triangle \[bytes\].
const HEAD: usize = 84;
const TRIANGLE: usize = 50;

/// Returns the corners of all triangles. A file is binary if its length matches its count, independent of its
/// beginning: many binary files start with `solid` too.
pub(super) fn vertices(bytes: &[u8]) -> Result<Vec<Vector3<f64>>, String> {
    let count = bytes
        .get(HEAD - 4..HEAD)
        .and_then(|b| <[u8; 4]>::try_from(b).ok())
        .map_or(0, |b| u32::from_le_bytes(b) as usize);
    let whole = count.checked_mul(TRIANGLE).and_then(|n| n.checked_add(HEAD));
    if bytes.len() >= HEAD && whole == Some(bytes.len()) {
        return Ok(binary(&bytes[HEAD..]));
    }
    if bytes.trim_ascii_start().starts_with(b"solid") {
        return ascii(&String::from_utf8_lossy(bytes));
    }
    if bytes.len() >= HEAD && whole.is_some_and(|n| n < bytes.len()) {
        // Some programs append data to the file.
        return Ok(binary(&bytes[HEAD..HEAD + count * TRIANGLE]));
    }
    Err("it is cut off, or no STL file".into())
}

/// Returns all triangles.
pub(super) fn triangles(bytes: &[u8]) -> Result<Vec<[Vector3<f64>; 3]>, String> {
    let corners = vertices(bytes)?;
    let (triangles, rest) = corners.as_chunks::<3>();
    if rest.is_empty() { Ok(triangles.to_vec()) } else { Err("its last triangle is cut off".into()) }
}

fn binary(triangles: &[u8]) -> Vec<Vector3<f64>> {
    let number = |b: &[u8]| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let corners =
        |t: &[u8]| [12, 24, 36].map(|at| Vector3::new(number(&t[at..]), number(&t[at + 4..]), number(&t[at + 8..])));
    triangles.chunks_exact(TRIANGLE).flat_map(corners).collect()
}

fn ascii(text: &str) -> Result<Vec<Vector3<f64>>, String> {
    let mut found = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        if words.next() == Some("vertex") {
            let vertex = super::point(words).ok_or_else(|| format!("line {} is broken", i + 1))?;
            found.push(vertex);
        }
    }
    if found.is_empty() { Err("it has no vertex, or is cut off".into()) } else { Ok(found) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn binary_and_ascii_give_the_same_corners() {
        let corners = [[0.0f32, 1.0, 2.0], [3.5, -4.0, 5.0], [6.0, 7.0, -8.25]];
        let mut file = b"solid but binary".to_vec();
        file.resize(80, 0);
        file.extend(1u32.to_le_bytes());
        for number in [0.0f32; 3].iter().chain(corners.iter().flatten()) {
            file.extend(number.to_le_bytes());
        }
        file.extend([0; 2]);
        let text = "solid x\n facet normal 0 0 1\n outer loop\n vertex 0 1 2\n vertex 3.5 -4 5\n\
                    vertex 6 7e0 -8.25\n endloop\n endfacet\nendsolid x\n";
        let expected: Vec<_> = corners.iter().map(|c| Vector3::from(c.map(f64::from))).collect();
        assert_eq!(vertices(&file).unwrap(), expected);
        assert_eq!(vertices(text.as_bytes()).unwrap(), expected);
        assert!(vertices(&file[..file.len() - 3]).is_err());
        file[3] = b'X';
        file.truncate(100);
        assert!(vertices(&file).is_err());
    }

    #[test]
    fn triangles_have_three_corners() {
        let text = "solid x\n vertex 0 1 2\n vertex 3.5 -4 5\n vertex 6 7e0 -8.25\n";
        assert_eq!(triangles(text.as_bytes()).unwrap().len(), 1);
        assert!(triangles(format!("{text} vertex 1 2 3\n").as_bytes()).unwrap_err().contains("cut off"));
    }

    #[test]
    fn a_broken_line_is_named() {
        let error = vertices(b"solid\nvertex 1 2\n").unwrap_err();
        assert!(error.contains("line 2"), "{error}");
    }
}
