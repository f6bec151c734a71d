//! Poses: position and orientation as one value of seven numbers, the position `x y z` in m and the unit quaternion
//! `w x y z`.
//!
//! ```text
//! (p, q) (p', q') = (p + q p', q q')        (p, q) v = p + q v        (p, q)⁻¹ = (-q⁻¹ p, q⁻¹)
//! ```

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Span, Spanned};
use runtime::program::Op;
use stdlib_tasks::dimension::{LENGTH, NONE};

use super::arguments::{CallError, number, orientation, vector};
use super::functions::slerp;
use super::ops::{Mismatch, conjugate, is_zero, quaternion_product, rotate};
use super::robot_state::RobotStateTerm;
use super::scope::Failed;
use super::{Axes, Frame, Graph, Kind, Lowering, Meaning, Typed};

/// Number of position components of a pose.
const POSITION: usize = 3;

fn typed(nodes: Vec<usize>, axes: Axes, span: Span) -> Typed {
    // The position of a pose is a point.
    let axes = Axes { origins: Some(1.0), ..axes };
    Typed { kind: Kind::Pose, dimension: NONE, nodes, bare: false, axes, span }
}

/// Lowers `pose(position, orientation)`.
pub(super) fn make(g: &Graph, args: &[Typed], span: Span) -> Result<Typed, CallError> {
    let position = vector(args, 0)?;
    if !(position.bare || is_zero(g, position) || LENGTH.accepts(position.dimension)) {
        return Err(CallError::Argument { index: 0, wanted: "a position in m".into() });
    }
    let turned = orientation(args, 1)?;
    let to = position.axes.to.joined(&args[1].axes.to).ok_or(CallError::Axes { first: 0, second: 1 })?;
    let nodes = [&position.nodes[..], turned].concat();
    Ok(typed(nodes, Axes::orientation(args[1].axes.from.clone(), to), span))
}

/// Lowers `lerp` of two poses: positions along a straight line, orientations along the shorter arc at a constant rate.
pub(super) fn between(g: &mut Graph, args: &[Typed], span: Span) -> Result<Typed, CallError> {
    if let Some(index) = (0..2).find(|&i| args[i].kind != Kind::Pose) {
        return Err(CallError::Argument { index, wanted: "a pose like the other".into() });
    }
    let share = number(args, 2)?;
    let axes = args[0].axes.joined(&args[1].axes).ok_or(CallError::Axes { first: 0, second: 1 })?;
    let ((p, q), (to, turned)) = (args[0].nodes.split_at(POSITION), args[1].nodes.split_at(POSITION));
    let mut nodes: Vec<usize> = Vec::with_capacity(7);
    for (&from, &to) in p.iter().zip(to) {
        let step = g.push(Op::Sub(to, from));
        let part = g.push(Op::Mul(step, share));
        nodes.push(g.push(Op::Add(from, part)));
    }
    nodes.extend(slerp(g, q, turned, share));
    Ok(typed(nodes, axes, span))
}

/// Lowers the inverse of a pose.
pub(super) fn inverse(g: &mut Graph, pose: &Typed, span: Span) -> Typed {
    let axes = Axes::orientation(pose.axes.to.clone(), pose.axes.from.clone());
    typed(inverted(g, &pose.nodes), axes, span)
}

/// Lowers a pose times a pose, or times a vector in m; the latter product is the position of a point.
pub(super) fn product(g: &mut Graph, a: &Typed, b: &Typed, span: Span) -> Result<Typed, Mismatch> {
    let mut axes = a.axes.product(&b.axes).ok_or(Mismatch::Axes)?;
    if b.kind == Kind::Pose {
        return Ok(typed(composed(g, &a.nodes, &b.nodes), axes, span));
    }
    if b.kind != Kind::Vector || !(is_zero(g, b) || LENGTH.accepts(b.dimension)) {
        return Err(Mismatch::Kinds);
    }
    // The result is a point, whether the vector is a literal, a displacement within the frame, or a point.
    axes.origins = b.axes.origins.filter(|o| *o == 0.0 || *o == 1.0).map(|_| 1.0);
    let nodes = transformed_point(g, &a.nodes, &b.nodes);
    Ok(Typed { kind: Kind::Vector, dimension: LENGTH, nodes, bare: false, axes, span })
}

/// Position in the outer frame of a point in a pose's frame: `p + q v`.
fn transformed_point(g: &mut Graph, pose: &[usize], v: &[usize]) -> Vec<usize> {
    let (p, q) = pose.split_at(POSITION);
    let turned = rotate(g, q, v);
    p.iter().zip(turned).map(|(&p, v)| g.push(Op::Add(p, v))).collect()
}

/// Numbers of the composition of two poses.
pub(super) fn composed(g: &mut Graph, a: &[usize], b: &[usize]) -> Vec<usize> {
    let mut nodes = transformed_point(g, a, &b[..POSITION]);
    nodes.extend(quaternion_product(g, &a[POSITION..], &b[POSITION..]));
    nodes
}

/// Numbers of the inverse pose.
pub(super) fn inverted(g: &mut Graph, pose: &[usize]) -> Vec<usize> {
    let (p, q) = pose.split_at(POSITION);
    let back = conjugate(g, q);
    let p: Vec<usize> = rotate(g, &back, p).into_iter().map(|n| g.push(Op::Neg(n))).collect();
    [p, back].concat()
}

/// First name of a value with fields: `goal` of `goal.position.x`.
pub(crate) fn root(value: &Value) -> Option<&str> {
    match &value.kind {
        ValueKind::Name(name) => Some(name),
        ValueKind::Field(inner, _) => root(inner),
        _ => None,
    }
}

impl Lowering<'_> {
    /// Lowers `frame(F).pose` from position and orientation.
    pub(super) fn frame_pose(&mut self, frame: &Value, at: Span, span: Span) -> Result<Typed, Failed> {
        let part = |name: &str| Spanned::new(name.to_string(), at);
        let position = self.now(&RobotStateTerm::Frame(frame, &part("position")), span)?;
        let orientation = self.now(&RobotStateTerm::Frame(frame, &part("orientation")), span)?;
        Ok(typed([position.nodes, orientation.nodes].concat(), orientation.axes, span))
    }

    /// Lowers `.position` or `.orientation` of a value. Returns `None` if the value is not an expression, but the name
    /// of a task's value.
    pub(super) fn pose_field(
        &mut self,
        inner: &Value,
        field: &Spanned<String>,
        span: Span,
    ) -> Option<Result<Typed, Failed>> {
        if !matches!(field.value.as_str(), "position" | "orientation") {
            return None;
        }
        if root(inner).is_some_and(|name| name != "com" && matches!(self.scope.name(name), Meaning::Unknown)) {
            return None;
        }
        let of = match self.value(inner) {
            Ok(of) => of,
            Err(failed) => return Some(Err(failed)),
        };
        if of.kind != Kind::Pose {
            let is = of.kind.describe();
            let text = format!("only a pose has {} `{}`, and this is {is}", article(&field.value), field.value);
            let d = Diagnostic::error("HQ0304", inner.span, text).here(is);
            return Some(self.fail(d.help("leave it out; the pose of a frame is `frame(F).pose`")));
        }
        let (position, orientation) = of.nodes.split_at(POSITION);
        Some(Ok(if field.value == "position" {
            // Without axes of its own, the position counts as a literal vector, relative to the origin of the context.
            let origins = if of.axes.to == Frame::Any { 0.0 } else { 1.0 };
            let axes = Axes { to: of.axes.to.clone(), origins: Some(origins), ..Axes::default() };
            Typed { kind: Kind::Vector, dimension: LENGTH, nodes: position.to_vec(), axes, span, ..of }
        } else {
            let axes = Axes::orientation(of.axes.from.clone(), of.axes.to.clone());
            Typed { kind: Kind::Rotation, nodes: orientation.to_vec(), axes, span, ..of }
        }))
    }
}

fn article(word: &str) -> &'static str {
    if word.starts_with('o') { "an" } else { "a" }
}
