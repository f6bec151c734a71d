//! Reader of collision and visual elements: shapes, meshes, colours.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use nalgebra::{Isometry3, Vector3};
use roxmltree::Node;

use super::cx::{Cx, attribute, child, parse_numbers};
use super::{LinkMesh, Options, ShapeKind, Shapes, UrdfCode, UrdfMessage, locate};
use crate::mesh;
use crate::{FilePieces, MeshFile, PlacedShape, Shape, Visual, VisualGeometry};

/// Extent of a mesh from which on its numbers are probably millimetres \[m\].
const LARGE: f64 = 50.0;

/// Context of the shapes: options, named colours and the meshes read so far.
pub(super) struct Solids<'o> {
    options: &'o Options,
    colors: BTreeMap<String, [f64; 4]>,
    meshes: BTreeMap<PathBuf, Result<Vec<Vector3<f64>>, String>>,
    unread: usize,
    /// Meshes that were not found, by what would make them findable: the first message, its address and their number.
    missing: BTreeMap<String, (UrdfMessage, String, usize)>,
    found: Vec<LinkMesh>,
    pieces: BTreeMap<(PathBuf, [u64; 3]), Result<FilePieces, String>>,
}

impl<'o> Solids<'o> {
    /// Collects the named colours of the whole file; the first definition of a name is used.
    pub(super) fn new(cx: &mut Cx, root: Node, options: &'o Options) -> Solids<'o> {
        let mut colors = BTreeMap::new();
        for node in root.descendants().filter(|n| n.tag_name().name() == "material") {
            if let (Some(name), Some(rgba)) = (attribute(node, "name"), color(cx, node)) {
                colors.entry(name.value.to_owned()).or_insert(rgba);
            }
        }
        // Each visual parses its own colour again, and reports errors then.
        cx.warnings.clear();
        Solids {
            options,
            colors,
            meshes: BTreeMap::new(),
            unread: 0,
            missing: BTreeMap::new(),
            found: Vec::new(),
            pieces: BTreeMap::new(),
        }
    }

    /// Meshes that were found.
    pub(super) fn into_meshes(self) -> Vec<LinkMesh> {
        self.found
    }

    /// Warns of the meshes that were not found: once for all meshes of a package, since one path makes all of them findable.
    pub(super) fn report_missing(&mut self, cx: &mut Cx) {
        for (mut message, address, number) in std::mem::take(&mut self.missing).into_values() {
            message.text = match number {
                1 => format!("mesh `{address}` not found; the link has no shape there"),
                2 => format!("mesh `{address}` and another one not found; their links have no shapes there"),
                n => format!("mesh `{address}` and {} others not found; their links have no shapes there", n - 1),
            };
            cx.warn(message);
        }
    }
}

fn color(cx: &mut Cx, material: Node) -> Option<[f64; 4]> {
    let rgba = attribute(child(material, "color")?, "rgba")?;
    match parse_numbers::<4>(rgba.value) {
        Ok(values) => Some(values.map(|x| x.clamp(0.0, 1.0))),
        Err(what) => {
            let text = format!("`rgba` {what}; the colour is left out");
            cx.warn(UrdfMessage::new(UrdfCode::Ignored, rgba.span, text));
            None
        }
    }
}

/// Reads the geometry of an element. Invalid sizes are reported through `complain`.
fn geometry(cx: &mut Cx, element: Node, complain: fn(&mut Cx, UrdfMessage)) -> Option<(VisualGeometry, Range<usize>)> {
    let what = element.tag_name().name();
    let Some(node) = child(element, "geometry").and_then(|g| g.children().find(Node::is_element)) else {
        let span = cx.tag(element);
        let text = format!("the `<{what}>` has no geometry and is left out");
        cx.warn(UrdfMessage::new(UrdfCode::Ignored, span, text));
        return None;
    };
    let mut span = cx.tag(node);
    let sizes = |cx: &mut Cx, names: &[&str]| -> Option<Vec<f64>> {
        let mut found = Some(Vec::new());
        for name in names {
            let value = if cx.need(node, name).is_some() { cx.number(node, name) } else { None };
            found = found.zip(value).map(|(mut all, x)| {
                all.push(x);
                all
            });
        }
        found
    };
    let (shape, sizes) = match node.tag_name().name() {
        "sphere" => {
            let sizes = sizes(cx, &["radius"])?;
            (VisualGeometry::Sphere { radius: sizes[0] }, sizes)
        }
        "cylinder" => {
            let sizes = sizes(cx, &["radius", "length"])?;
            (VisualGeometry::Cylinder { radius: sizes[0], length: sizes[1] }, sizes)
        }
        "capsule" => {
            let sizes = sizes(cx, &["radius", "length"])?;
            (VisualGeometry::Capsule { radius: sizes[0], length: sizes[1] }, sizes)
        }
        "box" => {
            cx.need(node, "size")?;
            let size = cx.numbers::<3>(node, "size")?;
            (VisualGeometry::Box { size }, size.to_vec())
        }
        "mesh" => {
            let file = cx.need(node, "filename")?;
            let scale = match attribute(node, "scale") {
                Some(_) => cx.numbers::<3>(node, "scale")?,
                None => [1.0; 3],
            };
            let sizes = scale.iter().map(|s| s.abs()).collect();
            span = file.span;
            (VisualGeometry::Mesh { path: file.value.trim().to_owned(), scale }, sizes)
        }
        other => {
            let text = format!("the shape `{other}` is not known; the `<{what}>` is left out");
            cx.warn(UrdfMessage::new(UrdfCode::Ignored, span, text));
            return None;
        }
    };
    if sizes.iter().any(|x| *x <= 0.0) {
        let text = match node.tag_name().name() {
            "mesh" => "the scale of a mesh must not be zero".to_owned(),
            name => format!("the sizes of a {name} must be greater than zero"),
        };
        complain(cx, UrdfMessage::new(UrdfCode::BadSize, cx.tag(node), text));
        return None;
    }
    Some((shape, span))
}

/// Reads a visual. A geometry that cannot be drawn is a warning.
pub(super) fn visual(cx: &mut Cx, element: Node, solids: &Solids) -> Option<Visual> {
    let origin = cx.origin(element);
    let material = child(element, "material");
    let color = material.and_then(|m| color(cx, m)).or_else(|| {
        let name = attribute(material?, "name")?;
        solids.colors.get(name.value).copied()
    });
    let (geometry, _) = geometry(cx, element, |cx, m| cx.warn(m))?;
    Some(Visual { origin, geometry, color })
}

/// Reads a collision shape of a link, with those around a mesh.
pub(super) fn collision(cx: &mut Cx, element: Node, link: &str, solids: &mut Solids) -> Vec<PlacedShape> {
    let kind = solids.options.shapes.kind(link);
    let origin = cx.origin(element);
    let Some((geometry, span)) = geometry(cx, element, |cx, m| cx.error(m)) else { return Vec::new() };
    let shape = match geometry {
        VisualGeometry::Sphere { radius } => Shape::Sphere { radius },
        VisualGeometry::Cylinder { radius, length } if kind != ShapeKind::Capsules => {
            Shape::Cylinder { radius, half_length: 0.5 * length }
        }
        VisualGeometry::Cylinder { radius, length } | VisualGeometry::Capsule { radius, length } => {
            Shape::Capsule { radius, half_length: 0.5 * length }
        }
        VisualGeometry::Box { size } => Shape::Box { half: size.map(|x| 0.5 * x) },
        VisualGeometry::Mesh { path, scale } => {
            let of = MeshOf { link, address: &path, scale, span, origin };
            let shapes = around_mesh(cx, solids, of, kind);
            return shapes.into_iter().map(|s| PlacedShape { origin: origin * s.origin, shape: s.shape }).collect();
        }
    };
    vec![PlacedShape { origin, shape }]
}

/// A mesh of a link.
struct MeshOf<'a> {
    link: &'a str,
    address: &'a str,
    scale: [f64; 3],
    span: Range<usize>,
    origin: Isometry3<f64>,
}

/// Shapes around a mesh, in its frame; none if it cannot be read, which is reported.
fn around_mesh(cx: &mut Cx, solids: &mut Solids, mesh: MeshOf, kind: ShapeKind) -> Vec<PlacedShape> {
    let MeshOf { link, address, scale, span, origin } = mesh;
    if !solids.options.read_meshes {
        solids.unread += 1;
        if solids.unread == 1 {
            let text = "collision meshes are not read; the links have no shape there";
            cx.warn(
                UrdfMessage::new(UrdfCode::MeshNotRead, span, text)
                    .help("ask for meshes to be read, or give the links simple shapes"),
            );
        }
        return Vec::new();
    }
    let path = match locate::find(address, solids.options) {
        Ok(path) => path,
        Err(help) => {
            let message = UrdfMessage::new(UrdfCode::MeshMissing, span, "").help(help.as_str());
            let first = || (message, address.to_owned(), 0);
            solids.missing.entry(help).or_insert_with(first).2 += 1;
            return Vec::new();
        }
    };
    let Options { shapes: Shapes { pieces_within, .. }, cache, .. } = solids.options;
    let (link, cache) = (link.to_owned(), cache.clone());
    let found = LinkMesh { link, path: path.clone(), scale, origin, kind, pieces_within: *pieces_within, cache };
    solids.found.push(found);
    let shapes = match kind {
        ShapeKind::Pieces => solids.pieces(&path, scale).map(|found| {
            let within = solids.options.shapes.pieces_within;
            if let Some(text) = found.pieces.shortfall(within) {
                let text = format!("mesh `{address}`: {text}");
                let help = "allow more with `pieces_within`, or give the link a simpler mesh";
                cx.warn(UrdfMessage::new(UrdfCode::MeshPieces, span.clone(), text).help(help));
            }
            if let Some(entry) = &found.damaged {
                let text = format!("`{}` is damaged; the pieces of `{address}` were computed again", entry.display());
                cx.warn(UrdfMessage::new(UrdfCode::MeshEntry, span.clone(), text));
            }
            found.pieces.shapes()
        }),
        ShapeKind::Capsules | ShapeKind::Hulls => {
            let vertices = solids.meshes.entry(path).or_insert_with_key(|path| mesh::vertices(path));
            vertices.as_ref().map_err(String::clone).and_then(|vertices| {
                let scale = Vector3::from(scale);
                let scaled: Vec<_> = vertices.iter().map(|v| v.component_mul(&scale)).collect();
                around_points(&scaled, kind).map(|shape| vec![shape])
            })
        }
    };
    if let Ok(shapes) = &shapes {
        warn_of_size(cx, address, &span, shapes);
    }
    shapes.unwrap_or_else(|what| {
        let text = format!("mesh `{address}` cannot be used: {what}");
        cx.warn(UrdfMessage::new(UrdfCode::MeshUnreadable, span, text));
        Vec::new()
    })
}

/// Warns of a mesh whose unit is probably another one.
fn warn_of_size(cx: &mut Cx, address: &str, span: &Range<usize>, shapes: &[PlacedShape]) {
    let extent = shapes.iter().map(|s| 2.0 * s.shape.bounding_radius()).fold(0.0, f64::max);
    if extent <= LARGE {
        return;
    }
    let text = format!("mesh `{address}` is about {extent:.0} m across; this looks like millimetres");
    let help = "meshes are in metres: write `scale=\"0.001 0.001 0.001\"`";
    cx.warn(UrdfMessage::new(UrdfCode::Unit, span.clone(), text).help(help));
}

impl Solids<'_> {
    /// Pieces of a mesh file; those of the same mesh of several links are computed once.
    fn pieces(&mut self, path: &Path, scale: [f64; 3]) -> Result<FilePieces, String> {
        let within = self.options.shapes.pieces_within;
        let beside = self.options.cache.as_deref();
        let known = self.pieces.entry((path.to_path_buf(), scale.map(f64::to_bits)));
        known.or_insert_with(|| MeshFile { path, scale, within, beside }.pieces()).clone()
    }
}

/// The hull of points, or the capsule around them.
fn around_points(points: &[Vector3<f64>], kind: ShapeKind) -> Result<PlacedShape, String> {
    if kind == ShapeKind::Hulls {
        return PlacedShape::hull(points).map_err(|e| e.to_string());
    }
    mesh::bounding_capsule(points)
        .map(|(origin, shape)| PlacedShape { origin, shape })
        .ok_or_else(|| "it has no vertex, or one that is not finite".to_string())
}
