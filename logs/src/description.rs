//! The URDF of a model: what `/robot_description` holds. It is written from the model and not copied, so that its links are the
//! frames of `/tf` also for several robots in one model, and so that a compiled program is enough.
//!
//! A link without visuals is drawn by its collision shapes. URDF knows no capsule, which becomes a cylinder and two balls, and
//! no hull of points, which is left out.

use std::fmt::Write;

use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use robot::{Drive, Joint, JointKind, Link, Model, Shape, Visual, VisualGeometry};

/// Writes the URDF.
pub fn urdf(model: &Model) -> String {
    let mut out = format!("<?xml version=\"1.0\"?>\n<robot name=\"{}\">\n", escaped(&model.name));
    model.links.iter().for_each(|l| link(l, &mut out));
    model.joints.iter().for_each(|j| joint(model, j, &mut out));
    out + "</robot>\n"
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Motion of a joint that is held at a position.
fn held(joint: &Joint, position: f64) -> Isometry3<f64> {
    let along = joint.axis * position;
    match joint.kind {
        JointKind::Fixed => Isometry3::identity(),
        JointKind::Prismatic => Isometry3::from_parts(Translation3::from(along), UnitQuaternion::identity()),
        JointKind::Revolute | JointKind::Continuous => {
            Isometry3::from_parts(Translation3::identity(), UnitQuaternion::from_scaled_axis(along))
        }
    }
}

fn origin(pose: &Isometry3<f64>) -> String {
    let (p, (roll, pitch, yaw)) = (pose.translation.vector, pose.rotation.euler_angles());
    format!("<origin xyz=\"{} {} {}\" rpy=\"{roll} {pitch} {yaw}\"/>", p.x, p.y, p.z)
}

fn link(link: &Link, out: &mut String) {
    let _ = writeln!(out, "  <link name=\"{}\">", escaped(&link.name));
    let solids: Vec<(Isometry3<f64>, String)> =
        link.collision.iter().flat_map(|c| shapes(&c.shape, &c.origin)).collect();
    for (pose, geometry) in &solids {
        element("collision", pose, geometry, None, out);
    }
    match link.visual.is_empty() {
        true => solids.iter().for_each(|(pose, geometry)| element("visual", pose, geometry, None, out)),
        false => link.visual.iter().for_each(|v| visual(v, out)),
    }
    out.push_str("  </link>\n");
}

fn element(name: &str, pose: &Isometry3<f64>, geometry: &str, color: Option<[f64; 4]>, out: &mut String) {
    let _ = write!(out, "    <{name}>{}<geometry>{geometry}</geometry>", origin(pose));
    if let Some([r, g, b, a]) = color {
        let _ = write!(out, "<material name=\"{r}_{g}_{b}_{a}\"><color rgba=\"{r} {g} {b} {a}\"/></material>");
    }
    let _ = writeln!(out, "</{name}>");
}

fn capsule(radius: f64, length: f64, pose: &Isometry3<f64>) -> Vec<(Isometry3<f64>, String)> {
    let ball = |z: f64| (pose * Translation3::new(0.0, 0.0, z), format!("<sphere radius=\"{radius}\"/>"));
    let middle = format!("<cylinder radius=\"{radius}\" length=\"{length}\"/>");
    vec![(*pose, middle), ball(-length / 2.0), ball(length / 2.0)]
}

fn shapes(shape: &Shape, pose: &Isometry3<f64>) -> Vec<(Isometry3<f64>, String)> {
    let one = |text: String| vec![(*pose, text)];
    match shape {
        Shape::Sphere { radius } => one(format!("<sphere radius=\"{radius}\"/>")),
        Shape::Capsule { radius, half_length } => capsule(*radius, 2.0 * half_length, pose),
        Shape::Box { half: [x, y, z] } => one(format!("<box size=\"{} {} {}\"/>", 2.0 * x, 2.0 * y, 2.0 * z)),
        Shape::Cylinder { radius, half_length } => {
            one(format!("<cylinder radius=\"{radius}\" length=\"{}\"/>", 2.0 * half_length))
        }
        Shape::Hull(_) => Vec::new(),
    }
}

fn visual(visual: &Visual, out: &mut String) {
    let one = |text: String| vec![(visual.origin, text)];
    let all = match &visual.geometry {
        VisualGeometry::Box { size: [x, y, z] } => one(format!("<box size=\"{x} {y} {z}\"/>")),
        VisualGeometry::Cylinder { radius, length } => {
            one(format!("<cylinder radius=\"{radius}\" length=\"{length}\"/>"))
        }
        VisualGeometry::Capsule { radius, length } => capsule(*radius, *length, &visual.origin),
        VisualGeometry::Sphere { radius } => one(format!("<sphere radius=\"{radius}\"/>")),
        VisualGeometry::Mesh { path, scale: [x, y, z] } => {
            one(format!("<mesh filename=\"{}\" scale=\"{x} {y} {z}\"/>", escaped(path)))
        }
    };
    for (pose, geometry) in all {
        element("visual", &pose, &geometry, visual.color, out);
    }
}

fn joint(model: &Model, joint: &Joint, out: &mut String) {
    let name = |link| escaped(&model.link_ref(link).name);
    let (kind, pose, follows) = match joint.drive {
        Drive::Fixed if model.base_at(joint.child).is_some() => ("floating", joint.origin, None),
        Drive::Fixed => ("fixed", joint.origin, None),
        Drive::Locked(position) => ("fixed", joint.origin * held(joint, position), None),
        Drive::Dof(_) => (moving(joint.kind), joint.origin, None),
        Drive::Mimic { dof, multiplier, offset } => (moving(joint.kind), joint.origin, Some((dof, multiplier, offset))),
    };
    let _ = writeln!(out, "  <joint name=\"{}\" type=\"{kind}\">", escaped(&joint.name));
    let _ = writeln!(out, "    {}", origin(&pose));
    let _ = writeln!(out, "    <parent link=\"{}\"/><child link=\"{}\"/>", name(joint.parent), name(joint.child));
    if kind != "fixed" {
        let a = joint.axis;
        let _ = writeln!(out, "    <axis xyz=\"{} {} {}\"/>", a.x, a.y, a.z);
        // URDF demands all four where a joint has limits, and has no word for none.
        let or = |x: f64, most: f64| if x.is_finite() { x } else { most };
        let (lower, upper) = (or(joint.lower, -1e9), or(joint.upper, 1e9));
        let (effort, velocity) = (or(joint.effort, 1e9), or(joint.velocity, 1e9));
        let range = if joint.kind == JointKind::Continuous {
            String::new()
        } else {
            format!(" lower=\"{lower}\" upper=\"{upper}\"")
        };
        let _ = writeln!(out, "    <limit{range} effort=\"{effort}\" velocity=\"{velocity}\"/>");
    }
    if let Some((dof, multiplier, offset)) = follows
        && let Some(leader) = model.dofs.get(dof)
    {
        let leader = escaped(&leader.name);
        let _ = writeln!(out, "    <mimic joint=\"{leader}\" multiplier=\"{multiplier}\" offset=\"{offset}\"/>");
    }
    out.push_str("  </joint>\n");
}

fn moving(kind: JointKind) -> &'static str {
    match kind {
        JointKind::Fixed => "fixed",
        JointKind::Revolute => "revolute",
        JointKind::Continuous => "continuous",
        JointKind::Prismatic => "prismatic",
    }
}
