//! Facts of the meshes of a robot: how far the shapes that can stand for them exceed them.

use robot::{Excess, LinkMesh, PlacedShape, ShapeKind, Surface};

/// Gap that a bound of an excess may leave (m), and relative to the size of the mesh.
const PRECISION: f64 = 1e-4;
const RELATIVE: f64 = 5e-4;

/// Facts of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshFacts {
    /// Name of the link.
    pub link: String,
    /// Path of the file.
    pub file: String,
    /// Kind of the shapes that the link has.
    pub kind: ShapeKind,
    /// Volume (m³); `None` for an open mesh.
    pub volume: Option<f64>,
    /// Each kind of shapes; the reason why there are none.
    pub shapes: Result<Vec<ShapeFacts>, String>,
}

/// Facts of the shapes that stand for a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeFacts {
    /// Their kind.
    pub kind: ShapeKind,
    /// Their number.
    pub count: usize,
    /// Excess over the mesh.
    pub excess: Excess,
}

/// Collects the facts of meshes, in their order.
pub fn mesh_facts(meshes: &[LinkMesh]) -> Vec<MeshFacts> {
    let one = |mesh: &LinkMesh| {
        let surface = mesh.surface();
        MeshFacts {
            link: mesh.link.clone(),
            file: mesh.path.display().to_string(),
            kind: mesh.kind,
            volume: surface.as_ref().ok().and_then(Surface::volume),
            shapes: surface.and_then(|surface| shapes(mesh, &surface)),
        }
    };
    meshes.iter().map(one).collect()
}

fn shapes(mesh: &LinkMesh, surface: &Surface) -> Result<Vec<ShapeFacts>, String> {
    let of = |kind, shapes: &[PlacedShape]| ShapeFacts {
        kind,
        count: shapes.len(),
        excess: Excess::of(shapes, surface, PRECISION.max(RELATIVE * surface.extent())),
    };
    let hull = PlacedShape::hull(&surface.points()).map_err(|e| e.to_string())?;
    let capsule = surface.capsule().into_iter().map(|c| of(ShapeKind::Capsules, &[c]));
    let others = [of(ShapeKind::Hulls, &[hull]), of(ShapeKind::Pieces, &mesh.pieces()?.shapes())];
    Ok(capsule.chain(others).collect())
}
