//! Poses: where something is and how it is turned, together. Seven numbers, the position `x y z` in m and the unit
//! quaternion `w x y z`.
//!
//! ```text
//! (p, q) (p', q') = (p + q p', q q')        (p, q) v = p + q v        (p, q)⁻¹ = (-q⁻¹ p, q⁻¹)
//! ```

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Span, Spanned};
use runtime::program::Op;
use stdlib_tasks::dimension::{LENGTH, NONE};

use super::functions::{CallError, number, vector};
use super::ops::{Mismatch, conjugate, is_zero, quaternion_product, rotate};
use super::present::Now;
use super::scope::Failed;
use super::{Axes, Frame, Graph, Kind, Lowering, Meaning, Typed, rotations};

/// How many numbers of a pose are its position.
const POSITION: usize = 3;

fn typed(nodes: Vec<usize>, axes: Axes, span: Span) -> Typed {
    // Its position is a point.
    let axes = Axes { origins: Some(1.0), ..axes };
    Typed { kind: Kind::Pose, dimension: NONE, nodes, bare: false, axes, span }
}

/// `pose(position, orientation)`
pub(super) fn make(g: &Graph, args: &[Typed], span: Span) -> Result<Typed, CallError> {
    let position = vector(args, 0)?;
    if !(position.bare || is_zero(g, position) || LENGTH.accepts(position.dimension)) {
        return Err(CallError::Argument { index: 0, wanted: "a position in m".into() });
    }
    let orientation = rotations::rotation(args, 1)?;
    let to = position.axes.to.joined(&args[1].axes.to).ok_or(CallError::Axes { first: 0, second: 1 })?;
    let nodes = [&position.nodes[..], orientation].concat();
    Ok(typed(nodes, Axes::orientation(args[1].axes.from.clone(), to), span))
}

/// `lerp` of two poses: the positions along a straight line, the orientations the shorter way at a steady rate.
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
    nodes.extend(rotations::slerp(g, q, turned, share));
    Ok(typed(nodes, axes, span))
}

/// The pose of the second in the first.
pub(super) fn inverse(g: &mut Graph, pose: &Typed, span: Span) -> Typed {
    let axes = Axes::orientation(pose.axes.to.clone(), pose.axes.from.clone());
    typed(inverted(g, &pose.nodes), axes, span)
}

/// A pose times a pose, or times a vector in m: the place of a point.
pub(super) fn product(g: &mut Graph, a: &Typed, b: &Typed, span: Span) -> Result<Typed, Mismatch> {
    let mut axes = a.axes.product(&b.axes).ok_or(Mismatch::Axes)?;
    if b.kind == Kind::Pose {
        return Ok(typed(composed(g, &a.nodes, &b.nodes), axes, span));
    }
    if b.kind != Kind::Vector || !(is_zero(g, b) || LENGTH.accepts(b.dimension)) {
        return Err(Mismatch::Kinds);
    }
    // A written vector, or a way within the frame, leads from its origin; a point is there already.
    axes.origins = b.axes.origins.filter(|o| *o == 0.0 || *o == 1.0).map(|_| 1.0);
    let nodes = placed(g, &a.nodes, &b.nodes);
    Ok(Typed { kind: Kind::Vector, dimension: LENGTH, nodes, bare: false, axes, span })
}

/// Where a point of a pose's frame is: `p + q v`.
fn placed(g: &mut Graph, pose: &[usize], v: &[usize]) -> Vec<usize> {
    let (p, q) = pose.split_at(POSITION);
    let turned = rotate(g, q, v);
    p.iter().zip(turned).map(|(&p, v)| g.push(Op::Add(p, v))).collect()
}

/// The numbers of one pose after another.
pub(super) fn composed(g: &mut Graph, a: &[usize], b: &[usize]) -> Vec<usize> {
    let mut nodes = placed(g, a, &b[..POSITION]);
    nodes.extend(quaternion_product(g, &a[POSITION..], &b[POSITION..]));
    nodes
}

/// The numbers of the pose that leads back.
pub(super) fn inverted(g: &mut Graph, pose: &[usize]) -> Vec<usize> {
    let (p, q) = pose.split_at(POSITION);
    let back = conjugate(g, q);
    let p: Vec<usize> = rotate(g, &back, p).into_iter().map(|n| g.push(Op::Neg(n))).collect();
    [p, back].concat()
}

/// The name that a value with fields begins with: `goal` of `goal.position.x`.
pub(crate) fn root(value: &Value) -> Option<&str> {
    match &value.kind {
        ValueKind::Name(name) => Some(name),
        ValueKind::Field(inner, _) => root(inner),
        _ => None,
    }
}

impl Lowering<'_> {
    /// `frame(F).pose`: both parts of it.
    pub(super) fn frame_pose(&mut self, frame: &Value, at: Span, span: Span) -> Result<Typed, Failed> {
        let part = |name: &str| Spanned::new(name.to_string(), at);
        let position = self.now(&Now::Frame(frame, &part("position")), span)?;
        let orientation = self.now(&Now::Frame(frame, &part("orientation")), span)?;
        Ok(typed([position.nodes, orientation.nodes].concat(), orientation.axes, span))
    }

    /// `.position` or `.orientation` of a value. `None` where the value is no expression, but the name of a value of a
    /// task.
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
            // Without axes of its own it is like a written vector, which leads from the origin of what it meets.
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
