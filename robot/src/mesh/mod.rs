//! Vertices and triangles of mesh files, and the bounding capsule of vertices. Without a need for triangles, faces are not
//! read: a capsule and a hull are convex, and contain the mesh if they contain the vertices.

use std::path::Path;

use nalgebra::Vector3;

mod bound;
mod dae;
mod obj;
mod stl;

pub(crate) use bound::bounding_capsule;

/// Maximum size of a mesh file \[bytes\].
const MAX_BYTES: u64 = 256 << 20;

/// Reads the vertices of a `.stl`, `.obj` or `.dae` file, in the units of the file.
///
/// # Errors
/// The reason why it cannot be used.
pub fn vertices(path: &Path) -> Result<Vec<Vector3<f64>>, String> {
    let bytes = files::read(path, MAX_BYTES).map_err(|e| e.to_string())?;
    let kind = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    match kind.as_str() {
        "stl" => stl::vertices(&bytes),
        "obj" => obj::vertices(&String::from_utf8_lossy(&bytes)),
        "dae" => dae::vertices(&String::from_utf8_lossy(&bytes)),
        _ => Err(format!("files of kind `{kind}` are not read, only stl, obj and dae")),
    }
}

/// Reads the triangles of a `.stl` or `.obj` file, in the units of the file. Polygons are split into triangles about their
/// first corner. The mesh may be open.
///
/// # Errors
/// The reason why it cannot be used.
pub fn triangles(path: &Path) -> Result<Vec<[Vector3<f64>; 3]>, String> {
    let bytes = files::read(path, MAX_BYTES).map_err(|e| e.to_string())?;
    let kind = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    match kind.as_str() {
        "stl" => stl::triangles(&bytes),
        "obj" => obj::triangles(&String::from_utf8_lossy(&bytes)),
        _ => Err(format!("triangles of files of kind `{kind}` are not read, only those of stl and obj")),
    }
}

/// Parses the first three of `words` as coordinates.
fn point<'w>(mut words: impl Iterator<Item = &'w str>) -> Option<Vector3<f64>> {
    let mut next = || words.next()?.parse::<f64>().ok();
    Some(Vector3::new(next()?, next()?, next()?))
}
