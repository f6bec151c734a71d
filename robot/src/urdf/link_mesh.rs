//! Mesh files of collision shapes, with the shapes that stand for them.

use std::path::PathBuf;

use nalgebra::Isometry3;

use super::ShapeKind;
use crate::mesh;
use crate::{MeshFile, Pieces, Surface};

/// A mesh file of a collision shape.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkMesh {
    /// Name of the link.
    pub link: String,
    /// The file.
    pub path: PathBuf,
    /// Metres of one unit of the file along each axis.
    pub scale: [f64; 3],
    /// Pose of the file's frame in the link's frame.
    pub origin: Isometry3<f64>,
    /// Kind of shapes that the link has.
    pub kind: ShapeKind,
    /// Distance by which pieces may exceed the mesh \[m\].
    pub pieces_within: f64,
    /// Folder in which the cache of pieces is.
    pub cache: Option<PathBuf>,
}

impl LinkMesh {
    /// Reads its triangles, in the frame of the file \[m\].
    ///
    /// # Errors
    /// The reason why it cannot be used.
    pub fn surface(&self) -> Result<Surface, String> {
        Surface::new(&mesh::scaled(mesh::triangles(&self.path)?, self.scale)).map_err(|e| e.to_string())
    }

    /// Reads or computes its pieces, in the frame of the file.
    ///
    /// # Errors
    /// The reason why it cannot be used.
    pub fn pieces(&self) -> Result<Pieces, String> {
        let (within, beside) = (self.pieces_within, self.cache.as_deref());
        MeshFile { path: &self.path, scale: self.scale, within, beside }.pieces().map(|found| found.pieces)
    }
}
