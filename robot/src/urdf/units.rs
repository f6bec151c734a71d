//! Numbers of a URDF that were probably written in another unit: limits in degrees, masses in grams. Nothing is converted; these are
//! warnings.

use std::f64::consts::PI;

use roxmltree::Node;

use super::cx::{Cx, attribute, child};
use super::read::RawJoint;
use super::{UrdfCode, UrdfMessage};
use crate::{JointKind, PlacedShape, Shape};

/// Limit above which the position of a revolute joint is suspected \[rad\]: four turns.
const FOUR_TURNS: f64 = 25.2;
/// Largest limit that is written in degrees: two turns.
const MOST_DEGREES: f64 = 720.0;
/// Mass from which a link is suspected \[kg\]: in grams, a tenth of a kilogram.
const SUSPECT: f64 = 100.0;
/// Density that no material has \[kg/m^3\]: four times that of osmium. Shapes are simplified, and may be smaller than their link.
const DENSEST: f64 = 1e5;
/// Radius of gyration that no link of such a mass has \[m\].
const SMALLEST: f64 = 5e-3;

/// Warns of limits of a revolute joint that look like degrees.
pub(super) fn degrees(cx: &mut Cx, joint: &RawJoint) {
    let Some(limit) = joint.limit.as_ref().filter(|_| joint.kind == JointKind::Revolute) else { return };
    let (lower, upper) = (limit.lower.unwrap_or(0.0), limit.upper.unwrap_or(0.0));
    let most = lower.abs().max(upper.abs());
    // Powers of ten stand for "no limit" in many files.
    let endless = lower == -upper && most.log10().fract() == 0.0;
    let whole = |x: f64| x.fract() == 0.0;
    if most <= FOUR_TURNS || most > MOST_DEGREES || endless || !whole(lower) || !whole(upper) {
        return;
    }
    let text =
        format!("joint `{}` turns from {lower} to {upper} rad; these limits look like degrees", joint.name.value);
    let (l, u) = (lower.to_radians(), upper.to_radians());
    let help = format!("limits are in radians: write `lower=\"{l:.4}\" upper=\"{u:.4}\"`");
    cx.warn(UrdfMessage::new(UrdfCode::Unit, limit.span.clone(), text).help(help));
}

/// Warns of a mass that looks like grams: the link would be denser than any material, or its inertia that of a point.
pub(super) fn grams(cx: &mut Cx, name: &str, inertial: Node, mass: f64, shapes: &[PlacedShape]) {
    if mass < SUSPECT {
        return;
    }
    let volume: f64 = shapes.iter().map(|s| volume(&s.shape)).sum();
    let dense = volume > 0.0 && mass / volume > DENSEST;
    let moment = child(inertial, "inertia").map_or(0.0, |inertia| {
        let of = |axis| attribute(inertia, axis).and_then(|a| a.value.trim().parse::<f64>().ok()).unwrap_or(0.0);
        of("ixx") + of("iyy") + of("izz")
    });
    let point = moment > 0.0 && (moment / (2.0 * mass)).sqrt() < SMALLEST;
    if !dense && !point {
        return;
    }
    let span = child(inertial, "mass").and_then(|m| attribute(m, "value")).map_or_else(|| cx.tag(inertial), |a| a.span);
    let why = if dense { "its shapes are too small for it" } else { "its inertia is too small for it" };
    let text = format!("link `{name}` has a mass of {mass} kg, and {why}; this looks like grams");
    let help = format!("masses are in kilograms: write `value=\"{}\"`", mass / 1e3);
    cx.warn(UrdfMessage::new(UrdfCode::Unit, span, text).help(help));
}

/// Volume of a shape \[m^3\].
fn volume(shape: &Shape) -> f64 {
    let ball = |radius: f64| 4.0 / 3.0 * PI * radius.powi(3);
    match shape {
        Shape::Sphere { radius } => ball(*radius),
        Shape::Capsule { radius, half_length } => ball(*radius) + PI * radius.powi(2) * 2.0 * half_length,
        Shape::Box { half: [x, y, z] } => 8.0 * x * y * z,
        Shape::Cylinder { radius, half_length } => PI * radius.powi(2) * 2.0 * half_length,
        // Of the box around it: enough for a judgement of orders of magnitude.
        Shape::Hull(hull) => {
            let [x, y, z] = [0, 1, 2].map(|i| hull.corners().iter().map(|p| p[i].abs()).fold(0.0, f64::max));
            8.0 * x * y * z
        }
    }
}
