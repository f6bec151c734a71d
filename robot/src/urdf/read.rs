//! Reader of links and joints from XML; each value is checked on its own.

use std::collections::BTreeMap;
use std::ops::Range;

use nalgebra::{Isometry3, Matrix3, Rotation3, Vector3};
use roxmltree::Node;

use super::cx::{Cx, Spanned, attribute, child, children};
use super::solid::{self, Solids};
use super::{UrdfCode, UrdfMessage, units, xml};
use crate::{JointKind, PlacedShape, Visual};

/// Maximum number of links of a robot.
const MAX_LINKS: usize = 100_000;

/// A link as written.
pub(super) struct RawLink {
    pub name: Spanned<String>,
    pub mass: f64,
    pub center_of_mass: Vector3<f64>,
    pub inertia: [f64; 6],
    pub collision: Vec<PlacedShape>,
    pub visual: Vec<Visual>,
}

/// The `<limit>` of a joint as written.
pub(super) struct RawLimit {
    pub span: Range<usize>,
    pub lower: Option<f64>,
    pub upper: Option<f64>,
    pub velocity: Option<f64>,
    pub effort: f64,
    pub acceleration: f64,
}

/// The `<mimic>` of a joint as written.
pub(super) struct RawMimic {
    pub joint: Spanned<String>,
    pub multiplier: f64,
    pub offset: f64,
}

/// A joint as written.
pub(super) struct RawJoint {
    pub name: Spanned<String>,
    pub tag: Range<usize>,
    pub kind: JointKind,
    /// `planar` or `floating` with its location; these types are not supported inside a tree.
    pub free: Option<Spanned<String>>,
    pub parent: Spanned<String>,
    pub child: Spanned<String>,
    pub origin: Isometry3<f64>,
    pub axis: Vector3<f64>,
    pub limit: Option<RawLimit>,
    pub mimic: Option<RawMimic>,
}

/// A robot as written.
pub(super) struct RawRobot {
    pub name: String,
    pub tag: Range<usize>,
    pub links: Vec<RawLink>,
    pub joints: Vec<RawJoint>,
}

/// Reads all links and joints. `None` if the file is not usable as a robot.
pub(super) fn robot(cx: &mut Cx, root: Node, solids: &mut Solids) -> Option<RawRobot> {
    let tag = xml::first_line(cx.text, cx.tag(root));
    if root.tag_name().name() != "robot" {
        let text = format!("`<robot>` expected, `<{}>` found", root.tag_name().name());
        cx.error(UrdfMessage::new(UrdfCode::NoRobot, tag, text));
        return None;
    }
    if let Some(macro_) =
        root.descendants().find(|n| n.is_element() && n.tag_name().namespace().is_some_and(|ns| ns.contains("xacro")))
    {
        let span = cx.tag(macro_);
        let text = "this is a xacro file, not a URDF";
        cx.error(
            UrdfMessage::new(UrdfCode::Xacro, span, text)
                .help("expand it first: `xacro robot.urdf.xacro > robot.urdf`"),
        );
        return None;
    }
    for element in ["link", "joint"] {
        let count = children(root, element).count();
        if count > MAX_LINKS {
            let text = format!("{count} {element}s, at most {MAX_LINKS} are read");
            cx.error(UrdfMessage::new(UrdfCode::TooLarge, tag, text));
            return None;
        }
    }
    let name = attribute(root, "name").map(|a| a.value.trim().to_owned()).unwrap_or_default();
    let links: Vec<RawLink> = children(root, "link").filter_map(|node| link(cx, node, solids)).collect();
    let joints: Vec<RawJoint> = children(root, "joint").filter_map(|node| joint(cx, node)).collect();
    if children(root, "link").next().is_none() {
        let (code, text) = match srdf_element(root) {
            Some(_) => (UrdfCode::Srdf, "this is an SRDF, which describes groups and postures of a robot, not a URDF"),
            None => (UrdfCode::NoLinks, "the robot has no link"),
        };
        let mut message = UrdfMessage::new(code, tag.clone(), text);
        if code == UrdfCode::Srdf {
            message = message.help("name the URDF behind `urdf`, and this file behind `srdf`");
        } else if root.namespaces().any(|ns| ns.uri().contains("xacro")) {
            message = message.help("a xacro file that only defines macros gives this; expand the file that calls them");
        }
        cx.error(message);
    }
    unique(cx, "link", links.iter().map(|l| &l.name));
    unique(cx, "joint", joints.iter().map(|j| &j.name));
    Some(RawRobot { name, tag, links, joints })
}

/// Returns an element that only an SRDF has.
fn srdf_element<'a, 'i: 'a>(root: Node<'a, 'i>) -> Option<Node<'a, 'i>> {
    ["group", "group_state", "end_effector", "virtual_joint", "passive_joint", "disable_collisions"]
        .into_iter()
        .find_map(|element| children(root, element).next())
}

fn unique<'n>(cx: &mut Cx, what: &str, names: impl Iterator<Item = &'n Spanned<String>>) {
    let mut seen: BTreeMap<&str, &Range<usize>> = BTreeMap::new();
    for name in names {
        if let Some(first) = seen.get(name.value.as_str()) {
            let text = format!("there is already a {what} `{}`", name.value);
            let help = format!("the first one is on line {}", cx.line(first));
            let message = UrdfMessage::new(UrdfCode::DuplicateName, name.span.clone(), text);
            cx.error(message.help(help));
        } else {
            seen.insert(&name.value, &name.span);
        }
    }
}

fn owned(found: Spanned<&str>) -> Spanned<String> {
    Spanned { value: found.value.to_owned(), span: found.span }
}

fn link(cx: &mut Cx, node: Node, solids: &mut Solids) -> Option<RawLink> {
    let name = cx.need(node, "name");
    let (mut mass, mut center_of_mass) = (0.0, Vector3::zeros());
    let inertial = child(node, "inertial");
    if let Some(origin) = inertial.and_then(|i| child(i, "origin")) {
        center_of_mass = cx.numbers(origin, "xyz").map_or(center_of_mass, Vector3::from);
    }
    if let Some(element) = inertial.and_then(|i| child(i, "mass")) {
        mass = cx.number(element, "value").unwrap_or(0.0);
        if mass < 0.0 {
            let span = attribute(element, "value").map_or_else(|| cx.tag(element), |a| a.span);
            cx.error(UrdfMessage::new(UrdfCode::BadSize, span, "the mass is negative"));
        }
    }
    let of = name.as_ref().map_or("", |name| name.value);
    let collision: Vec<PlacedShape> =
        children(node, "collision").flat_map(|element| solid::collision(cx, element, of, solids)).collect();
    let visual = children(node, "visual").filter_map(|element| solid::visual(cx, element, solids)).collect();
    let name = name?;
    if let Some(inertial) = inertial {
        units::grams(cx, name.value, inertial, mass, &collision);
    }
    let inertia = inertial.map_or([0.0; 6], inertia);
    Some(RawLink { name: owned(name), mass, center_of_mass, inertia, collision, visual })
}

/// Inertia of a link along the axes of its frame. Numbers that cannot be read are zero: only a simulation with physics needs them,
/// and says what it lacks.
fn inertia(inertial: Node) -> [f64; 6] {
    let Some(element) = child(inertial, "inertia") else { return [0.0; 6] };
    let of = |name| attribute(element, name).and_then(|a| a.value.trim().parse().ok()).filter(|x: &f64| x.is_finite());
    let [xx, yy, zz, xy, xz, yz] = ["ixx", "iyy", "izz", "ixy", "ixz", "iyz"].map(|name| of(name).unwrap_or(0.0));
    let own = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    let origin = child(inertial, "origin").and_then(|origin| attribute(origin, "rpy"));
    let angles = |text: &str| -> Vec<f64> { text.split_whitespace().filter_map(|x| x.parse().ok()).collect() };
    let turned = match origin.map(|rpy| angles(rpy.value)).as_deref() {
        Some([roll, pitch, yaw]) => {
            let r = Rotation3::from_euler_angles(*roll, *pitch, *yaw);
            r * own * r.transpose()
        }
        _ => own,
    };
    [turned.m11, turned.m22, turned.m33, turned.m12, turned.m13, turned.m23]
}

fn joint(cx: &mut Cx, node: Node) -> Option<RawJoint> {
    let name = cx.need(node, "name").map(owned);
    let tag = cx.tag(node);
    let mut free = None;
    let mut kind = JointKind::Fixed;
    if let Some(written) = cx.need(node, "type") {
        kind = match written.value.trim() {
            "fixed" => JointKind::Fixed,
            "revolute" => JointKind::Revolute,
            "continuous" => JointKind::Continuous,
            "prismatic" => JointKind::Prismatic,
            "planar" | "floating" => {
                free = Some(owned(written));
                JointKind::Fixed
            }
            other => {
                let text = format!("there is no joint type `{other}`");
                cx.error(
                    UrdfMessage::new(UrdfCode::UnknownJointType, written.span, text)
                        .help("use `fixed`, `revolute`, `continuous` or `prismatic`"),
                );
                JointKind::Fixed
            }
        };
    }
    let end = |cx: &mut Cx, element: &'static str| match child(node, element) {
        Some(found) => cx.need(found, "link").map(owned),
        None => {
            let text = format!("the joint has no `<{element}>`");
            cx.error(UrdfMessage::new(UrdfCode::Missing, tag.clone(), text));
            None
        }
    };
    let parent = end(cx, "parent");
    let child_link = end(cx, "child");
    let origin = cx.origin(node);
    let axis = if kind == JointKind::Fixed { Vector3::x() } else { axis(cx, node) };
    let limit = child(node, "limit").map(|element| limit(cx, element));
    let mimic = child(node, "mimic").and_then(|element| {
        let multiplier = cx.number(element, "multiplier").unwrap_or(1.0);
        let offset = cx.number(element, "offset").unwrap_or(0.0);
        let joint = owned(cx.need(element, "joint")?);
        Some(RawMimic { joint, multiplier, offset })
    });
    let (name, parent, child) = (name?, parent?, child_link?);
    Some(RawJoint { name, tag, kind, free, parent, child, origin, axis, limit, mimic })
}

/// Returns the unit axis; the x axis if none is written, as URDF defines.
fn axis(cx: &mut Cx, node: Node) -> Vector3<f64> {
    let Some(element) = child(node, "axis") else { return Vector3::x() };
    let Some(axis) = cx.numbers::<3>(element, "xyz").map(Vector3::from) else {
        return Vector3::x();
    };
    // Scaled first, because the square of a huge number is not finite.
    let size = axis.amax();
    if size > 1e-9 {
        (axis / size).normalize()
    } else {
        let span = attribute(element, "xyz").map_or_else(|| cx.tag(element), |a| a.span);
        let text = "the axis of a moving joint needs a direction";
        cx.error(UrdfMessage::new(UrdfCode::ZeroAxis, span, text));
        Vector3::x()
    }
}

fn limit(cx: &mut Cx, element: Node) -> RawLimit {
    let velocity = speed(cx, element, "velocity");
    let effort = speed(cx, element, "effort").filter(|x| *x > 0.0).unwrap_or(f64::INFINITY);
    RawLimit {
        span: cx.tag(element),
        lower: cx.number(element, "lower"),
        upper: cx.number(element, "upper"),
        velocity,
        effort,
        acceleration: acceleration(cx, element),
    }
}

/// Returns the lower of `acceleration` and `deceleration` (URDF 1.2). A jerk limit is not read.
fn acceleration(cx: &mut Cx, element: Node) -> f64 {
    let [up, down] = ["acceleration", "deceleration"]
        .map(|name| speed(cx, element, name).filter(|x| *x > 0.0).unwrap_or(f64::INFINITY));
    up.min(down)
}

/// Reads a number; infinity and NaN mean that there is no limit.
fn speed(cx: &mut Cx, element: Node, name: &str) -> Option<f64> {
    match attribute(element, name)?.value.trim().parse::<f64>() {
        Ok(value) if !value.is_finite() => Some(f64::INFINITY),
        _ => cx.number(element, name),
    }
}
