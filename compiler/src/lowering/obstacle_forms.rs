//! Forms of obstacles: shapes, half-spaces, and bodies that files hold.

use std::path::PathBuf;

use blocks::{Located, Origin};
use dsl::tree::NamedBlock;
use dsl::{Diagnostic, Help, Snippet};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use robot::{FilePieces, Heights, Hull, MOST_ELEMENTS, MeshFile, Shape, Soup, SoupError};
use stdlib_tasks::dimension::LENGTH;
use stdlib_tasks::obstacle::Form;

use super::Lowerer;
use crate::paths::instead_of;
use crate::sections::{ObstacleBlock, RoundBlock};
use crate::units;

/// The keys of forms.
const FORMS: [&str; 8] = ["box", "sphere", "cylinder", "capsule", "plane", "mesh", "cloud", "heightfield"];

/// Keys of some forms alone.
const KEYS_OF: [(&str, &[&str]); 5] = [
    ("scale", &["mesh", "cloud", "heightfield"]),
    ("radius", &["cloud"]),
    ("cell", &["heightfield"]),
    ("shape", &["mesh"]),
    ("pieces_within", &["mesh"]),
];

/// Extent of a mesh from which on its numbers are probably millimetres (m).
const LARGE: f64 = 50.0;

/// The same of a cloud, which may be a hall (m).
const VAST: f64 = 200.0;

/// Extent of a mesh below which its numbers were probably scaled twice (m).
const SMALL: f64 = 1e-3;

impl Lowerer<'_> {
    /// The form; `None` if there is not exactly one, or if it is wrong.
    pub(super) fn form(&mut self, b: &NamedBlock, block: &ObstacleBlock) -> Option<Form> {
        let written: Vec<_> = b.body.entries.iter().filter(|e| FORMS.contains(&e.key.value.as_str())).collect();
        let shape = |shape| Some(Form::Shape(Isometry3::identity(), shape));
        match written.as_slice() {
            [] => {
                // A misspelt key was reported.
                let known =
                    ["scale", "radius", "cell", "shape", "pieces_within", "position", "orientation", "on", "present"];
                if b.body.entries.iter().all(|e| known.contains(&e.key.value.as_str())) {
                    let text = format!("obstacle `{}` has no form", b.name.value);
                    let d = Diagnostic::error("HQ0580", b.name.span, text);
                    self.push(d.help(Help::with(
                        "write one of {}, {}, {}, {}, {}, {}, {} and {}",
                        [
                            Snippet::entry("box", "[1.2, 0.8, 0.04] m"),
                            Snippet::entry("sphere", "0.2 m"),
                            Snippet::block(
                                "cylinder",
                                [Snippet::entry("radius", "0.1 m"), Snippet::entry("length", "1 m")],
                            ),
                            Snippet::block(
                                "capsule",
                                [Snippet::entry("radius", "0.1 m"), Snippet::entry("length", "1 m")],
                            ),
                            Snippet::entry("plane", "[0, 0, 1]"),
                            Snippet::entry("mesh", "\"shelf.stl\""),
                            Snippet::entry("cloud", "\"scan.ply\""),
                            Snippet::entry("heightfield", "\"ground.csv\""),
                        ],
                    )));
                }
                return None;
            }
            [_] => {}
            [first, second, ..] => {
                let text = format!("obstacle `{}` has two forms", b.name.value);
                let d = Diagnostic::error("HQ0580", second.key.span, text).label(first.key.span, "the other one");
                self.push(d.help("keep one of them, and declare another obstacle for the other"));
                return None;
            }
        }
        let form = written[0].key.value.as_str();
        for (key, of) in KEYS_OF {
            if let Some(entry) = b.body.get(key).filter(|_| !of.contains(&form)) {
                let text = format!("`{key}` goes with {}, and this is a {form}", names::list(of.iter().copied(), 8));
                let help = if key == "scale" { "write the size itself" } else { "remove it" };
                self.push(Diagnostic::unknown_key("HQ0205", entry.key.span, text).help(help));
            }
        }
        if let Some(entry) = b.body.get("pieces_within").filter(|_| form == "mesh" && block.shape != "pieces") {
            let text = format!("`pieces_within` goes with pieces, and the shape of this mesh is `{}`", block.shape);
            let d = Diagnostic::unknown_key("HQ0205", entry.key.span, text);
            self.push(d.help(Help::with("write {}, or remove it", [Snippet::entry("shape", "pieces")])));
        }
        let round = |round: &RoundBlock| Some((round.radius.as_ref()?.value, 0.5 * round.length.as_ref()?.value));
        match form {
            "box" => {
                let Located { at, value } = block.r#box.as_ref()?;
                if value.iter().filter(|x| **x == 0.0).count() > 1 {
                    let d = Diagnostic::error("HQ0308", self.origins.span(*at), "two edges of this box have no length");
                    self.push(d.help("a wall has one edge of zero; a rod is a `capsule`"));
                    return None;
                }
                shape(Shape::Box { half: value.map(|x| 0.5 * x) })
            }
            "sphere" => shape(Shape::Sphere { radius: block.sphere.as_ref()?.value }),
            "cylinder" => {
                let (radius, half_length) = round(block.cylinder.as_ref()?)?;
                shape(Shape::Cylinder { radius, half_length })
            }
            "capsule" => {
                let (radius, half_length) = round(block.capsule.as_ref()?)?;
                shape(Shape::Capsule { radius, half_length })
            }
            "plane" => {
                let Located { at, value } = block.plane.as_ref()?;
                self.half_space(*at, Vector3::from(*value))
            }
            "cloud" => self.cloud(block.cloud.as_ref()?, block.scale.value, block.radius.value),
            "heightfield" => {
                let path = block.heightfield.as_ref()?;
                let Some(cell) = &block.cell else {
                    // One that is wrong was reported.
                    if b.body.get("cell").is_none() {
                        let d =
                            Diagnostic::error("HQ0206", self.origins.span(path.at), "this heightfield has no `cell`");
                        let d = d.note("it is the distance between two heights of a row, and between two rows");
                        self.push(d.help(Help::with("add {}", [Snippet::entry("cell", "5 cm")])));
                    }
                    return None;
                };
                self.heightfield(path, cell.value, block.scale.value)
            }
            _ if block.shape == "pieces" => self.pieces(block.mesh.as_ref()?, block),
            _ if block.shape == "triangles" => self.triangles(block.mesh.as_ref()?, block.scale.value),
            _ => self.hull(block.mesh.as_ref()?, block.scale.value),
        }
    }

    /// A half-space whose free side a vector points to: the shape's frame is turned so that its z axis is the normal.
    fn half_space(&mut self, at: Origin, normal: Vector3<f64>) -> Option<Form> {
        let Some(normal) = normal.try_normalize(1e-9) else {
            let d = Diagnostic::error("HQ0308", self.origins.span(at), "this vector has no direction");
            self.push(d.help(Help::with("write where the free side is: {}", [Snippet::entry("plane", "[0, 0, 1]")])));
            return None;
        };
        let turn = UnitQuaternion::rotation_between(&Vector3::z(), &normal)
            .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
        Some(Form::HalfSpace(turn))
    }

    /// The path of the file of a form; `None` if it is not there.
    fn file_of(&mut self, path: &Located<String>) -> Option<PathBuf> {
        let on_disk = self.input.folder.join(&path.value);
        if on_disk.is_file() {
            return Some(on_disk);
        }
        let text = format!("cannot read `{}`: there is no such file", path.value);
        let d = Diagnostic::error("HQ0581", self.origins.span(path.at), text);
        let d = d.note("paths are relative to the file that names them");
        self.push(instead_of(d, &path.value, &on_disk));
        None
    }

    /// Refuses a file.
    fn refuse(&mut self, what: &str, path: &Located<String>, why: &str, help: &str) {
        let text = format!("{what} `{}` cannot be used: {why}", path.value);
        self.push(Diagnostic::error("HQ0581", self.origins.span(path.at), text).help(help));
    }

    /// Warns of a body whose unit is probably another one.
    fn warn_of_size(&mut self, what: &str, path: &Located<String>, extent: f64, largest: f64) {
        if (SMALL..=largest).contains(&extent) {
            return;
        }
        let text = format!("{what} `{}` is {extent:.3} m across", path.value);
        let help = match extent > largest {
            true => Help::with("if its numbers are millimetres, write {}", [Snippet::entry("scale", "0.001")]),
            false => Help::with("if its numbers are metres, write {}", [Snippet::entry("scale", "1")]),
        };
        self.push(Diagnostic::warning("HQ0582", self.origins.span(path.at), text).help(help));
    }

    /// The convex hull of a mesh file.
    fn hull(&mut self, path: &Located<String>, scale: f64) -> Option<Form> {
        let file = self.file_of(path)?;
        let hull = robot::mesh_vertices(&file).and_then(|vertices| {
            let scaled: Vec<Vector3<f64>> = vertices.iter().map(|v| v * scale).collect();
            Hull::around(&scaled).map_err(|e| e.to_string())
        });
        match hull {
            Ok((middle, hull)) => {
                self.warn_of_size("mesh", path, 2.0 * hull.radius(), LARGE);
                Some(Form::Shape(Isometry3::translation(middle.x, middle.y, middle.z), Shape::Hull(hull)))
            }
            Err(why) => {
                self.refuse("mesh", path, &why, "export it again as STL or OBJ");
                None
            }
        }
    }

    /// Convex pieces of a mesh file.
    fn pieces(&mut self, path: &Located<String>, block: &ObstacleBlock) -> Option<Form> {
        let file = self.file_of(path)?;
        let within = block.pieces_within.value;
        let beside = Some(self.input.folder);
        let mesh = MeshFile { path: &file, scale: [block.scale.value; 3], within, beside };
        match mesh.pieces() {
            Ok(FilePieces { pieces, damaged }) => {
                if let Some(text) = pieces.shortfall(within) {
                    let text = format!("mesh `{}`: {text}", path.value);
                    let d = Diagnostic::warning("HQ0584", self.origins.span(path.at), text);
                    self.push(d.help(Help::with(
                        "allow more, such as {}, or take the triangles, {}",
                        [
                            Snippet::entry("pieces_within", units::shown(1.2 * pieces.excess, LENGTH)),
                            Snippet::entry("shape", "triangles"),
                        ],
                    )));
                }
                if let Some(entry) = damaged {
                    let (entry, mesh) = (entry.display(), &path.value);
                    let text = format!("`{entry}` is damaged; the pieces of `{mesh}` were computed again");
                    self.push(Diagnostic::warning("HQ0585", self.origins.span(path.at), text));
                }
                self.soup("mesh", path, &pieces.corners, 0.0, LARGE)
            }
            Err(why) => {
                self.refuse("mesh", path, &why, "export it again as STL or OBJ");
                None
            }
        }
    }

    /// The triangles of a mesh file.
    fn triangles(&mut self, path: &Located<String>, scale: f64) -> Option<Form> {
        let file = self.file_of(path)?;
        match robot::mesh_triangles(&file) {
            Ok(triangles) => {
                let scaled: Vec<[Vector3<f64>; 3]> = triangles.into_iter().map(|t| t.map(|p| p * scale)).collect();
                self.soup("mesh", path, &scaled, 0.0, LARGE)
            }
            Err(why) => {
                self.refuse("mesh", path, &why, "export it again as STL or OBJ");
                None
            }
        }
    }

    /// The surface over a grid of heights.
    fn heightfield(&mut self, path: &Located<String>, cell: f64, scale: f64) -> Option<Form> {
        let file = self.file_of(path)?;
        match Heights::read(&file) {
            Ok(heights) if heights.count() <= MOST_ELEMENTS => {
                // Its width is that of its cells, which the spec gives.
                self.soup("heightfield", path, &heights.triangles(cell, scale), 0.0, f64::INFINITY)
            }
            Ok(heights) => {
                let why = format!("it has {} triangles, and {MOST_ELEMENTS} are the most", heights.count());
                self.refuse("heightfield", path, &why, "keep the part in which the robot is, or larger cells");
                None
            }
            Err(why) => {
                self.refuse("heightfield", path, &why, "write a line of numbers for each row of the grid");
                None
            }
        }
    }

    /// The points of a cloud, with a radius around each.
    fn cloud(&mut self, path: &Located<String>, scale: f64, radius: f64) -> Option<Form> {
        let file = self.file_of(path)?;
        let points = match robot::points(&file) {
            Ok(found) => found.points,
            Err(why) => {
                self.refuse("cloud", path, &why, "export it again as PLY, as PCD that is not compressed, or as XYZ");
                return None;
            }
        };
        let elements: Vec<[Vector3<f64>; 1]> = points.into_iter().map(|p| [p * scale]).collect();
        self.soup("cloud", path, &elements, radius, VAST)
    }

    /// A body of elements.
    fn soup<E: AsRef<[Vector3<f64>]>>(
        &mut self,
        what: &str,
        path: &Located<String>,
        elements: &[E],
        radius: f64,
        largest: f64,
    ) -> Option<Form> {
        match Soup::new(elements, radius) {
            Ok(soup) => {
                self.warn_of_size(what, path, soup.extent(), largest);
                Some(Form::Soup(soup))
            }
            Err(why) => {
                let help = match why {
                    SoupError::TooMany(_) => "thin it out: keep one point of each few centimetres, or fewer triangles",
                    _ => "check its numbers, and `scale`",
                };
                self.refuse(what, path, &why.to_string(), help);
                None
            }
        }
    }
}
