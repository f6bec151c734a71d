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

/// The bytes of a mesh file, and its kind.
pub(crate) struct MeshBytes {
    pub bytes: Vec<u8>,
    /// Its extension in lower case.
    kind: String,
}

impl MeshBytes {
    pub fn read(path: &Path) -> Result<MeshBytes, String> {
        let bytes = files::read(path, MAX_BYTES).map_err(|e| e.to_string())?;
        let kind = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        Ok(MeshBytes { bytes, kind })
    }

    pub fn vertices(&self) -> Result<Vec<Vector3<f64>>, String> {
        match self.kind.as_str() {
            "stl" => stl::vertices(&self.bytes),
            "obj" => obj::vertices(&String::from_utf8_lossy(&self.bytes)),
            "dae" => dae::vertices(&String::from_utf8_lossy(&self.bytes)),
            kind => Err(format!("files of kind `{kind}` are not read, only stl, obj and dae")),
        }
    }

    pub fn triangles(&self) -> Result<Vec<[Vector3<f64>; 3]>, String> {
        match self.kind.as_str() {
            "stl" => stl::triangles(&self.bytes),
            "obj" => obj::triangles(&String::from_utf8_lossy(&self.bytes)),
            kind => Err(format!("triangles of files of kind `{kind}` are not read, only those of stl and obj")),
        }
    }
}

/// Reads the vertices of a `.stl`, `.obj` or `.dae` file, in the units of the file.
///
/// # Errors
/// The reason why it cannot be used.
pub fn vertices(path: &Path) -> Result<Vec<Vector3<f64>>, String> {
    MeshBytes::read(path)?.vertices()
}

/// Reads the triangles of a `.stl` or `.obj` file, in the units of the file. Polygons are split into triangles about their
/// first corner. The mesh may be open.
///
/// # Errors
/// The reason why it cannot be used.
pub fn triangles(path: &Path) -> Result<Vec<[Vector3<f64>; 3]>, String> {
    MeshBytes::read(path)?.triangles()
}

/// Triangles that are scaled along each axis, with their outer sides outside: a mirror turns them.
pub(crate) fn scaled(triangles: Vec<[Vector3<f64>; 3]>, scale: [f64; 3]) -> Vec<[Vector3<f64>; 3]> {
    let is_mirrored = scale.iter().filter(|x| **x < 0.0).count() % 2 == 1;
    let scale = Vector3::from(scale);
    let one = |t: [Vector3<f64>; 3]| {
        let [a, b, c] = t.map(|p| p.component_mul(&scale));
        if is_mirrored { [a, c, b] } else { [a, b, c] }
    };
    triangles.into_iter().map(one).collect()
}

/// Parses the first three of `words` as coordinates.
fn point<'w>(mut words: impl Iterator<Item = &'w str>) -> Option<Vector3<f64>> {
    let mut next = || words.next()?.parse::<f64>().ok();
    Some(Vector3::new(next()?, next()?, next()?))
}
