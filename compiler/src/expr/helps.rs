//! Helps for operands that do not match.

use dsl::tree::{BinaryOp, Value, ValueKind};
use names::list;
use stdlib_tasks::dimension::{ANGLE, NONE};

use super::{FUNCTIONS, Family, Kind, PRESENT, TRAJECTORIES, Typed};
use crate::units;

/// `one argument`, `2 to 16 arguments`.
pub(super) fn count(arity: &std::ops::RangeInclusive<usize>) -> String {
    match (arity.start(), arity.end()) {
        (1, 1) => "one argument".to_string(),
        (a, b) if a == b => format!("{a} arguments"),
        (a, b) => format!("{a} to {b} arguments"),
    }
}

/// Translates a function of other languages.
pub(super) fn elsewhere(name: &str) -> Option<&'static str> {
    let known: &[(&[&str], &'static str)] = &[
        (&["arcsin"], "asin(number)"),
        (&["arccos"], "acos(number)"),
        (&["arctan", "atan", "arctan2"], "atan2(y, x)"),
        (&["angle"], "angle_between(vector, vector)` or `atan2(y, x)"),
        (&["ln", "log10", "log2"], "log(number)"),
        (&["pow", "power", "square", "sqr"], "x^2"),
        (&["length", "magnitude", "len", "norm2"], "norm(vector)"),
        (&["unit", "normalise", "normalized", "direction"], "normalize(vector)"),
        (&["saturate", "limit", "bound", "sat"], "clamp(x, low, high)"),
        (&["mix", "interpolate", "lin"], "lerp(from, to, share)"),
        (&["minimum"], "min(x, y, ..)"),
        (&["maximum"], "max(x, y, ..)"),
        (&["sign", "sgn", "step", "heaviside"], "if(x > 0, 1, -1)"),
        (&["where", "select", "ifelse", "iff"], "if(condition, value, other value)"),
        (&["fabs"], "abs(x)"),
        (&["euler", "rotation", "rotate", "rot"], "rpy(roll, pitch, yaw)"),
        (&["quat"], "quaternion(w, x, y, z)"),
        (&["conjugate", "transpose", "inv"], "inverse(orientation)"),
        (&["position", "pos", "pose", "link"], "frame(LINK).position"),
        (&["orientation"], "frame(LINK).orientation"),
        (&["vector", "vec", "vec3"], "[x, y, z]"),
        (&["radians", "deg2rad", "degrees"], "(x) deg"),
        (&["dist", "gap"], "distance(a, b)"),
        (&["vangle", "vector_angle", "anglebetween"], "angle_between(vector, vector)"),
        (&["trapezoidal", "profile", "lspb", "move", "moveto", "go"], TRAJECTORIES[0].form),
        (&["scurve", "jerk_limited", "quintic", "min_jerk"], TRAJECTORIES[1].form),
        (&["via", "points", "route", "polyline", "path", "waypoint"], TRAJECTORIES[2].form),
    ];
    let lower = name.to_lowercase();
    known.iter().find(|(names, _)| names.contains(&lower.as_str())).map(|(_, form)| *form)
}

/// Lists all functions by family.
pub(super) fn families() -> String {
    let of = |family: Family| FUNCTIONS.iter().filter(move |f| f.family == family).map(|f| f.name);
    format!(
        "of numbers there are {}; of vectors {}; of orientations {}; of motion {}; of the robot {}, and `initial`",
        list(of(Family::Numbers), 32),
        list(of(Family::Vectors), 8),
        list(of(Family::Orientations), 8),
        list(TRAJECTORIES.iter().map(|t| t.name), 8),
        list(PRESENT.iter().copied(), 8)
    )
}

pub(super) fn help_for_kinds(op: BinaryOp, a: Kind, b: Kind) -> &'static str {
    match (op, a, b) {
        (BinaryOp::Mul, Kind::Vector, Kind::Vector) => "write `dot(a, b)` or `cross(a, b)`",
        (BinaryOp::Add | BinaryOp::Sub, Kind::Rotation, Kind::Rotation) => "one turn after another is a product: `a*b`",
        (BinaryOp::Mul, Kind::Vector, Kind::Rotation) => "the orientation comes first: `rpy(..)*[x, y, z]`",
        (BinaryOp::Add | BinaryOp::Sub, Kind::Pose, _) | (BinaryOp::Add | BinaryOp::Sub, _, Kind::Pose) => {
            "one pose after another is a product: `a*b`; sums are of `.position`"
        }
        (BinaryOp::Mul, Kind::Pose, _) => {
            "a pose moves poses and points, vectors in m; for other vectors and orientations write `.orientation*..`"
        }
        (BinaryOp::Mul, Kind::Rotation, Kind::Pose) => "for a turn about the origin write `pose([0, 0, 0] m, r)*..`",
        (BinaryOp::Mul, _, Kind::Pose) => "the pose comes first: `frame(F).pose*[x, y, z] m`",
        (BinaryOp::Mul, ..) => "a number scales numbers and vectors; an orientation turns vectors and orientations",
        (BinaryOp::Div, ..) => "divide by a number",
        _ => "both sides are numbers, or both are vectors",
    }
}

pub(super) fn help_for_sum(a: &Typed, b: &Typed) -> String {
    let (bare, other) = if a.dimension == NONE { (a, b) } else { (b, a) };
    if bare.dimension == NONE && bare.bare {
        format!("give the bare number a unit, such as `{}`", units::written(other.dimension))
    } else if a.dimension == ANGLE || b.dimension == ANGLE {
        "an angle times a radius is a length".to_string()
    } else {
        "check the units of both".to_string()
    }
}

/// Help for a list that is no vector. Four numbers without a unit are a quaternion, in either order.
pub(super) fn for_list(items: &[Value]) -> String {
    let numbers: Vec<String> = items.iter().filter_map(number).collect();
    match numbers.as_slice() {
        [a, b, c, d] if items.len() == 4 => format!(
            "a quaternion is written `quaternion(w, x, y, z)`: `quaternion({a}, {b}, {c}, {d})` if this list begins with the \
             real part, `quaternion({d}, {a}, {b}, {c})` if it ends with it, as in ROS and Pinocchio"
        ),
        _ => "write `[x, y, z]`".to_string(),
    }
}

/// Text of a bare number, with its sign.
fn number(value: &Value) -> Option<String> {
    match &value.kind {
        ValueKind::Number(n) => Some(n.text.to_string()),
        ValueKind::Negate(inner) => Some(format!("-{}", number(inner)?)),
        _ => None,
    }
}

/// Puts the value of `1/2 m`, `pi/2 rad` or `2^2 m` in brackets, so that the unit applies to the whole: `(1/2) m`.
pub fn bracketed(op: BinaryOp, left: &Value, right: &Value) -> Option<String> {
    let sign = match op {
        BinaryOp::Div => '/',
        BinaryOp::Pow => '^',
        _ => return None,
    };
    let ValueKind::Unit(right, unit) = &right.kind else { return None };
    if units::is_assumed(unit) {
        return None;
    }
    let ValueKind::Number(b) = &right.kind else { return None };
    Some(format!("({}{sign}{}) {unit}", factors(left)?, b.text))
}

/// The text of a number, a name, or a product of them.
fn factors(value: &Value) -> Option<String> {
    match &value.kind {
        ValueKind::Number(number) => Some(number.text.clone()),
        ValueKind::Name(name) => Some(name.clone()),
        ValueKind::Binary(op, left, right) if op.value == BinaryOp::Mul => {
            Some(format!("{}*{}", factors(left)?, factors(right)?))
        }
        _ => None,
    }
}
