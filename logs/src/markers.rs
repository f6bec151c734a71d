//! Markers: bodies and lines as messages of the type `visualization_msgs/Marker`.

use nalgebra::{Isometry3, Translation3, Vector3};
use robot::Shape;

use crate::cdr::Cdr;

/// Red, green, blue, alpha in 0..1.
pub type Color = [f32; 4];

/// Colour of walls and of volumes that are kept clear.
pub const WALL: Color = [0.25, 0.45, 0.85, 0.25];
/// Colour of obstacles.
pub const OBSTACLE: Color = [0.55, 0.5, 0.45, 0.8];
/// Colour of people.
pub const PERSON: Color = [0.95, 0.55, 0.1, 0.9];
/// Colour of a margin that is not known.
pub const UNKNOWN: Color = [0.5, 0.5, 0.5, 1.0];

/// Margin from which on a line is green, in m.
const WIDE: f64 = 0.2;

/// Colour of a margin in m: red at zero and below, over yellow to green at 0.2 m.
pub fn of_margin(h: f64) -> Color {
    if h.is_nan() {
        return UNKNOWN;
    }
    let share = (h / WIDE).clamp(0.0, 1.0) as f32;
    [(2.0 - 2.0 * share).min(1.0), (2.0 * share).min(1.0), 0.0, 1.0]
}

/// Body or lines of a marker.
#[derive(Clone, Debug, PartialEq)]
pub enum Drawn {
    /// A box with these edge lengths in m.
    Cube(Vector3<f64>),
    /// An ellipsoid with these diameters in m.
    Sphere(Vector3<f64>),
    /// A cylinder about z with this radius and length in m.
    Cylinder(f64, f64),
    /// Segments: two points each, in m, and the width in m.
    Lines(Vec<Vector3<f64>>, f64),
    /// Balls: their centres and their diameter in m.
    Balls(Vec<Vector3<f64>>, f64),
    /// Triangles: three corners each, in m.
    Triangles(Vec<Vector3<f64>>),
    /// Nothing: what was drawn under this name and number is removed.
    Nothing,
}

/// A marker.
#[derive(Clone, Debug, PartialEq)]
pub struct Marker {
    /// Frame of its pose.
    pub frame: String,
    /// Name; with the number it tells markers apart.
    pub name: String,
    /// Number.
    pub id: i32,
    /// Content.
    pub drawn: Drawn,
    /// Its pose in the frame.
    pub pose: Isometry3<f64>,
    /// Colour.
    pub color: Color,
    /// Colours of the points; empty for one colour.
    pub colors: Vec<Color>,
}

impl Marker {
    /// A marker in one colour.
    pub fn new(frame: &str, name: &str, id: usize, drawn: Drawn, pose: Isometry3<f64>, color: Color) -> Marker {
        let id = i32::try_from(id).unwrap_or(i32::MAX);
        Marker { frame: frame.to_string(), name: name.to_string(), id, drawn, pose, color, colors: Vec::new() }
    }

    /// Appends the marker to a message at a time in ns.
    fn write(&self, time: u64, out: &mut Cdr) {
        header(time, &self.frame, out);
        out.text(&self.name);
        out.i32(self.id);
        let none = Vector3::zeros();
        let (kind, scale, points): (i32, Vector3<f64>, &[Vector3<f64>]) = match &self.drawn {
            Drawn::Cube(size) => (1, *size, &[]),
            Drawn::Sphere(size) => (2, *size, &[]),
            Drawn::Cylinder(radius, length) => (3, Vector3::new(2.0 * radius, 2.0 * radius, *length), &[]),
            Drawn::Lines(points, width) => (5, Vector3::new(*width, 0.0, 0.0), points),
            Drawn::Balls(points, size) => (7, Vector3::repeat(*size), points),
            Drawn::Triangles(points) => (11, Vector3::repeat(1.0), points),
            Drawn::Nothing => (1, none, &[]),
        };
        let removed = matches!(self.drawn, Drawn::Nothing);
        out.i32(kind);
        out.i32(if removed { 2 } else { 0 });
        let pose = if removed { &Isometry3::identity() } else { &self.pose };
        vector(&pose.translation.vector, out);
        quaternion(pose, out);
        vector(&scale, out);
        self.color.iter().for_each(|x| out.f32(*x));
        // Lifetime: for ever.
        out.i32(0);
        out.u32(0);
        // The marker moves with its frame.
        out.bool(true);
        out.count(points.len());
        points.iter().for_each(|p| vector(p, out));
        out.count(self.colors.len());
        self.colors.iter().flatten().for_each(|x| out.f32(*x));
        // No texture: name, header, format and data of the image, coordinates.
        out.text("");
        header(0, "", out);
        out.text("");
        out.count(0);
        out.count(0);
        // No text and no mesh: address, name and data of the file.
        out.text("");
        out.text("");
        out.text("");
        out.count(0);
        out.bool(false);
    }
}

/// Appends an array of markers to a message that was begun.
pub fn write(markers: &[Marker], time: u64, out: &mut Cdr) {
    out.count(markers.len());
    markers.iter().for_each(|m| m.write(time, out));
}

/// Appends a time in ns.
pub fn stamp(time: u64, out: &mut Cdr) {
    const SECOND: u64 = 1_000_000_000;
    out.i32(i32::try_from(time / SECOND).unwrap_or(i32::MAX));
    out.u32((time % SECOND) as u32);
}

/// Appends a header: a time in ns, and a frame.
pub fn header(time: u64, frame: &str, out: &mut Cdr) {
    stamp(time, out);
    out.text(frame);
}

/// Appends a vector.
pub fn vector(v: &Vector3<f64>, out: &mut Cdr) {
    v.iter().for_each(|x| out.f64(*x));
}

/// Appends the orientation of a pose, `x y z w`.
pub fn quaternion(pose: &Isometry3<f64>, out: &mut Cdr) {
    let r = &pose.rotation;
    [r.i, r.j, r.k, r.w].into_iter().for_each(|x| out.f64(x));
}

/// A shape at a pose of a frame, expanded by a distance in m. A capsule needs three markers, numbered from `id`.
pub fn of_shape(
    shape: &Shape,
    by: f64,
    pose: &Isometry3<f64>,
    place: impl Fn(usize, Drawn, Isometry3<f64>) -> Marker,
) -> Vec<Marker> {
    let ball = |id, radius: f64, z: f64| {
        place(id, Drawn::Sphere(Vector3::repeat(2.0 * (radius + by))), pose * Translation3::new(0.0, 0.0, z))
    };
    match shape {
        Shape::Sphere { radius } => vec![ball(0, *radius, 0.0)],
        Shape::Capsule { radius, half_length } => vec![
            place(0, Drawn::Cylinder(radius + by, 2.0 * half_length), *pose),
            ball(1, *radius, -half_length),
            ball(2, *radius, *half_length),
        ],
        Shape::Box { half } => {
            vec![place(0, Drawn::Cube(Vector3::from(half.map(|h| 2.0 * (h + by)))), *pose)]
        }
        Shape::Cylinder { radius, half_length } => {
            vec![place(0, Drawn::Cylinder(radius + by, 2.0 * (half_length + by)), *pose)]
        }
        Shape::Hull(hull) => {
            let corner = |i: &u32| hull.corners().get(*i as usize).copied().unwrap_or_default();
            let corners = hull.triangles().iter().flatten().map(corner).collect();
            vec![place(0, Drawn::Triangles(corners), *pose)]
        }
    }
}
