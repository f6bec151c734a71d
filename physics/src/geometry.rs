//! Shapes as geometries of MuJoCo: primitives, hulls as meshes, and the elements of clouds and surfaces one by one.

use std::fmt::Write;

use nalgebra::{Isometry3, Vector3};
use robot::{Shape, Soup};
use stdlib_tasks::obstacle::Form;

/// Least half of an edge or of a height \[m\]: MuJoCo has no body without one.
const LEAST_HALF: f64 = 1e-3;

/// Depth of a triangle behind its surface \[m\]: a body without one would be passed through between two time steps.
const DEPTH: f64 = 0.01;

/// Radius of a point of a cloud that has none \[m\].
const LEAST_RADIUS: f64 = 1e-3;

/// Half of an edge of the block that stands for a half-space that moves \[m\].
const VAST: f64 = 50.0;

/// Groups that touch each other: the bits of a geometry, and those of the geometries that it touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// Links of the robot.
    Links {
        /// True if they touch each other.
        each_other: bool,
    },
    /// Obstacles in the room, and people.
    Room,
    /// Obstacles that a link carries.
    Carried,
}

impl Group {
    fn attributes(self) -> &'static str {
        match self {
            Group::Links { each_other: false } => "contype=\"1\" conaffinity=\"2\"",
            Group::Links { each_other: true } => "contype=\"1\" conaffinity=\"3\"",
            Group::Room => "contype=\"2\" conaffinity=\"1\"",
            Group::Carried => "contype=\"4\" conaffinity=\"3\"",
        }
    }
}

/// Geometries of a body, and the meshes that they use, as XML.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Geometries {
    /// Elements `geom`.
    pub geoms: String,
    /// Elements `mesh`.
    pub meshes: String,
    /// Number of meshes, which numbers their names.
    count: usize,
}

impl Geometries {
    /// Adds a shape at a pose in the frame of the body. Names of meshes begin with `name`.
    pub fn shape(&mut self, name: &str, pose: &Isometry3<f64>, shape: &Shape, group: Group) {
        let form = match shape {
            Shape::Sphere { radius } => format!("type=\"sphere\" size=\"{radius}\""),
            Shape::Capsule { radius, half_length } => {
                format!("type=\"capsule\" size=\"{radius} {}\"", half_length.max(1e-6))
            }
            Shape::Cylinder { radius, half_length } => {
                format!("type=\"cylinder\" size=\"{radius} {}\"", half_length.max(LEAST_HALF))
            }
            Shape::Box { half } => {
                let [x, y, z] = half.map(|x: f64| x.max(LEAST_HALF));
                format!("type=\"box\" size=\"{x} {y} {z}\"")
            }
            Shape::Hull(hull) => self.mesh(name, hull.corners().iter().copied()),
        };
        self.geom(&form, pose, group);
    }

    /// Adds the form of an obstacle at a pose in the frame of the body. A half-space in a body that does not move is a
    /// plane, in one that moves a large block.
    pub fn form(&mut self, name: &str, pose: &Isometry3<f64>, form: &Form, group: Group, moves: bool) {
        match form {
            Form::Shape(origin, shape) => self.shape(name, &(pose * origin), shape, group),
            Form::HalfSpace(turn) if !moves => {
                let pose = pose * Isometry3::from_parts(Vector3::zeros().into(), *turn);
                self.geom("type=\"plane\" size=\"0 0 1\"", &pose, group);
            }
            Form::HalfSpace(turn) => {
                let below = Isometry3::translation(0.0, 0.0, -VAST);
                let pose = pose * Isometry3::from_parts(Vector3::zeros().into(), *turn) * below;
                self.geom(&format!("type=\"box\" size=\"{VAST} {VAST} {VAST}\""), &pose, group);
            }
            Form::Soup(soup) => (0..soup.len()).for_each(|k| self.element(name, pose, soup, k, group)),
        }
    }

    /// Adds a point as a ball, a triangle as a wedge behind its surface, a piece as its hull.
    fn element(&mut self, name: &str, pose: &Isometry3<f64>, soup: &Soup, k: usize, group: Group) {
        match soup.corners(k) {
            [] => (),
            [p] => {
                let at = pose * Isometry3::translation(p.x, p.y, p.z);
                let radius = soup.radius().max(LEAST_RADIUS);
                self.geom(&format!("type=\"sphere\" size=\"{radius}\""), &at, group);
            }
            &[a, b, c] => {
                // A triangle without an area is the edge of its neighbours.
                if let Some(normal) = (b - a).cross(&(c - a)).try_normalize(1e-12) {
                    let behind = normal * DEPTH;
                    let form = self.mesh(name, [a, b, c, a - behind, b - behind, c - behind].into_iter());
                    self.geom(&form, pose, group);
                }
            }
            corners => {
                let form = self.mesh(name, corners.iter().copied());
                self.geom(&form, pose, group);
            }
        }
    }

    /// Declares the hull of points, and returns the attributes of a geometry that has its form.
    fn mesh(&mut self, name: &str, points: impl Iterator<Item = Vector3<f64>>) -> String {
        let name = format!("{name}_{}", self.count);
        self.count += 1;
        let points: Vec<String> = points.map(|p| format!("{} {} {}", p.x, p.y, p.z)).collect();
        let _ = writeln!(self.meshes, "<mesh name=\"{name}\" vertex=\"{}\"/>", points.join(" "));
        format!("type=\"mesh\" mesh=\"{name}\"")
    }

    fn geom(&mut self, form: &str, pose: &Isometry3<f64>, group: Group) {
        let _ = writeln!(self.geoms, "<geom {form} {} {}/>", placed(pose), group.attributes());
    }
}

/// Attributes of a pose.
pub fn placed(pose: &Isometry3<f64>) -> String {
    let (p, r) = (&pose.translation, &pose.rotation);
    format!("pos=\"{} {} {}\" quat=\"{} {} {} {}\"", p.x, p.y, p.z, r.w, r.i, r.j, r.k)
}
