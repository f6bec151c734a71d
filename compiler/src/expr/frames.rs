//! Axes in which the numbers of a vector or orientation are expressed, and the operator `v in F` that sets or changes
//! them.
//!
//! A literal vector has no axes of its own and takes those of its context. Positions count origins: a point has one
//! origin, a difference of two points none, and their mean one again. `p in F` therefore distinguishes a point, which
//! moves with the origin of F, from a direction, which only rotates.

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Span, Spanned};
use runtime::program::Op;

use super::ops::{conjugate, quaternion_product, rotate};
use super::poses::{composed, inverted};
use super::robot_state::RobotStateTerm;
use super::scope::Failed;
use super::{Kind, Lowering, Typed, VectorBound};

/// A set of axes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Frame {
    /// Those of the context.
    #[default]
    Any,
    /// The world's.
    World,
    /// A link's, by its name.
    Link(String),
}

impl Frame {
    /// Description in messages.
    pub fn describe(&self) -> String {
        match self {
            Frame::Any => "no axes of its own".to_string(),
            Frame::World => "the axes of the world".to_string(),
            Frame::Link(name) => format!("the axes of `{name}`"),
        }
    }

    /// Name to write behind `in`.
    pub fn written(&self) -> &str {
        match self {
            Frame::Any | Frame::World => "world",
            Frame::Link(name) => name,
        }
    }

    /// Common axes of two values, if they are compatible.
    pub fn joined(&self, other: &Frame) -> Option<Frame> {
        match (self, other) {
            (Frame::Any, f) | (f, Frame::Any) => Some(f.clone()),
            (a, b) => (a == b).then(|| a.clone()),
        }
    }
}

/// The axes of a typed value.
#[derive(Clone, Debug, PartialEq)]
pub struct Axes {
    /// Axes in which the numbers are expressed. An orientation maps vectors to them.
    pub to: Frame,
    /// For an orientation: axes of the vectors that it maps.
    pub from: Frame,
    /// For a vector: number of origins, 1 for a point and 0 for a direction. `None` if the number is not constant.
    pub origins: Option<f64>,
}

impl Default for Axes {
    fn default() -> Self {
        Axes { to: Frame::Any, from: Frame::Any, origins: Some(0.0) }
    }
}

impl Axes {
    /// Axes of a point.
    pub fn point(to: Frame) -> Self {
        Axes { to, origins: Some(1.0), ..Axes::default() }
    }

    /// Axes of a direction.
    pub fn direction(to: Frame) -> Self {
        Axes { to, ..Axes::default() }
    }

    /// Axes of the orientation of `from` in `to`.
    pub fn orientation(from: Frame, to: Frame) -> Self {
        Axes { to, from, ..Axes::default() }
    }

    /// Axes of a value that is one of two, or lies between them: both must be expressed in the same axes. The result
    /// has `from` only if both orientations agree in it.
    pub fn joined(&self, other: &Axes) -> Option<Axes> {
        let origins = self.origins.filter(|o| other.origins == Some(*o));
        let from = self.from.joined(&other.from).unwrap_or_default();
        Some(Axes { to: self.to.joined(&other.to)?, from, origins })
    }

    /// Axes of a sum, or with `sign` -1 of a difference.
    pub fn sum(&self, other: &Axes, sign: f64) -> Option<Axes> {
        let origins = self.origins.zip(other.origins).map(|(a, b)| a + sign * b);
        Some(Axes { origins, ..self.joined(other)? })
    }

    /// Axes of a vector times a number; `factor` is `None` if the number is not constant.
    pub fn scaled(&self, factor: Option<f64>) -> Axes {
        let origins = match self.origins {
            Some(0.0) => Some(0.0),
            some => some.zip(factor).map(|(o, f)| o * f),
        };
        Axes { origins, ..self.clone() }
    }

    /// Axes of a value computed from a vector, which is a direction only if the vector is one.
    pub fn derived(&self) -> Axes {
        self.scaled(None)
    }

    /// Axes of an orientation times a vector or orientation. An orientation without axes rotates within those of the
    /// other operand.
    pub fn product(&self, other: &Axes) -> Option<Axes> {
        let within = |a: &Axes| a.to == Frame::Any && a.from == Frame::Any;
        let origins = other.derived().origins;
        if within(self) {
            return Some(Axes { origins, ..other.clone() });
        }
        if within(other) && other.from == Frame::Any && other.to == Frame::Any {
            return Some(Axes { to: self.to.clone(), from: self.from.clone(), origins });
        }
        self.from.joined(&other.to)?;
        Some(Axes { to: self.to.clone(), from: other.from.clone(), origins })
    }
}

/// Description of a value's axes in messages.
fn said(typed: &Typed) -> String {
    match typed.kind {
        Kind::Pose if typed.axes.from != Frame::Any => {
            format!("of {} in {}", typed.axes.from.describe(), typed.axes.to.describe())
        }
        Kind::Rotation => format!("turns {} into {}", typed.axes.from.describe(), typed.axes.to.describe()),
        _ => format!("in {}", typed.axes.to.describe()),
    }
}

/// Expression that transforms a value to the axes `name`: with the current pose, or if that is not permitted, with the
/// pose at the start.
fn brought(name: &str, follows: bool) -> String {
    if follows { format!("`(..) in {name}`") } else { format!("`initial((..) in {name})`") }
}

/// Diagnostic for two values in different axes. `follows` is true if the robot's current state is permitted.
pub fn different(a: &Typed, b: &Typed, span: Span, follows: bool) -> Diagnostic {
    let help = match (&a.axes.to, &b.axes.to) {
        _ if matches!(a.kind, Kind::Rotation | Kind::Pose) => {
            "write `inverse(..)` for the way back, or bring one with `in` to the axes of the other".to_string()
        }
        (first, Frame::World) => format!(
            "bring the first to the axes of the second with {}, or the second with {}",
            brought("world", follows),
            brought(first.written(), follows)
        ),
        (first, _) => format!("bring the second to the axes of the first: {}", brought(first.written(), follows)),
    };
    mismatch("these are expressed in different axes", a, b, span).help(help)
}

/// Diagnostic for an orientation that maps vectors of other axes than those of its factor.
pub fn turned(a: &Typed, b: &Typed, span: Span, follows: bool) -> Diagnostic {
    let wanted = a.axes.from.written();
    let (text, other) = match a.kind {
        Kind::Pose => ("this pose applies to vectors in other axes", "leave the pose out"),
        _ => ("this orientation applies to vectors in other axes", "leave the orientation out"),
    };
    mismatch(text, a, b, span)
        .help(format!("bring the second to the axes of its frame: {}; or {other}", brought(wanted, follows)))
}

fn mismatch(text: &str, a: &Typed, b: &Typed, span: Span) -> Diagnostic {
    Diagnostic::error("HQ0314", span, text)
        .label(a.span, said(a))
        .label(b.span, said(b))
        .note("numbers that count along different axes do not go together, however alike their units are")
}

/// Diagnostic for a value in other axes than required. `follows` is true if the value can be transformed to them: if
/// the parameter may depend on the pose of a link, or if neither frame moves.
pub fn wanted(typed: &Typed, frame: &Frame, what: &str, follows: bool) -> Option<Diagnostic> {
    if typed.axes.to.joined(frame).is_some() || matches!(typed.kind, Kind::Scalar | Kind::Truth) {
        return None;
    }
    let is = typed.axes.to.describe();
    let text = format!("{what} is wanted in {}, and this is in {is}", frame.describe());
    Some(Diagnostic::error("HQ0314", typed.span, text).help(if follows {
        format!("bring it there: `(..) in {}`", frame.written())
    } else if *frame != Frame::World {
        format!("write its numbers along {}", frame.describe())
    } else {
        format!(
            "a target that moves with a link is an expression: `track(frame(F).position in {}) {{ target .. }}`",
            typed.axes.to.written()
        )
    }))
}

impl Lowering<'_> {
    /// Lowers `v in F`: sets the axes of literal numbers, or transforms a value to other axes.
    pub(super) fn in_frame(&mut self, inner: &Value, name: &Spanned<String>, span: Span) -> Result<Typed, Failed> {
        let typed = self.value(inner);
        let frame = self.scope.frame(name, self.diagnostics).ok_or(Failed);
        let (typed, frame) = (typed?, frame?);
        if matches!(typed.kind, Kind::Scalar | Kind::Truth) {
            let text = format!("{} has no axes", typed.kind.describe());
            return self.fail(Diagnostic::error("HQ0304", span, text).help(
                "`in` follows a vector, orientation or pose and applies to the value directly before it: use brackets",
            ));
        }
        if typed.axes.to == Frame::Any {
            let axes = Axes { to: frame, ..typed.axes };
            return Ok(Typed { axes, span, ..typed });
        }
        if typed.axes.to == frame {
            return Ok(Typed { span, ..typed });
        }
        let world = self.seen_from_world(typed, name, span)?;
        self.seen_from_frame(world, frame, name, span)
    }

    /// Nodes of `frame(F).position` or `frame(F).orientation`.
    fn pose_of(&mut self, frame: &Frame, field: &str, at: Span) -> Result<Vec<usize>, Failed> {
        let link = Value { kind: ValueKind::Name(frame.written().to_string()), span: at };
        let field = Spanned::new(field.to_string(), at);
        let what = RobotStateTerm::Frame(&link, &field);
        Ok(self.scope.now(self.graph, &what, at, self.diagnostics).ok_or(Failed)?.nodes)
    }

    /// Number of origins of a vector, which must be known to transform it from one frame to another.
    fn origins(&mut self, typed: &Typed) -> Result<f64, Failed> {
        match typed.axes.origins {
            Some(o) => Ok(o),
            None => self.fail(
                Diagnostic::error("HQ0314", typed.span, "this is neither a point nor a direction")
                    .note("a point moves with the origin of its axes, a direction does not; a vector that was scaled by a moving number or rotated is neither")
                    .help("bring the points to these axes first, one by one"),
            ),
        }
    }

    fn seen_from_world(&mut self, typed: Typed, name: &Spanned<String>, span: Span) -> Result<Typed, Failed> {
        if typed.axes.to == Frame::World {
            return Ok(typed);
        }
        let q = self.pose_of(&typed.axes.to, "orientation", name.span)?;
        let axes = Axes { to: Frame::World, ..typed.axes.clone() };
        if typed.kind == Kind::Rotation {
            let nodes = quaternion_product(self.graph, &q, &typed.nodes);
            return Ok(Typed { nodes, axes, span, ..typed });
        }
        if typed.kind == Kind::Pose {
            let p = self.pose_of(&typed.axes.to, "position", name.span)?;
            let nodes = composed(self.graph, &[p, q].concat(), &typed.nodes);
            return Ok(Typed { nodes, axes, span, ..typed });
        }
        let origins = self.origins(&typed)?;
        let mut nodes = rotate(self.graph, &q, &typed.nodes);
        if origins != 0.0 {
            let p = self.pose_of(&typed.axes.to, "position", name.span)?;
            self.add(&mut nodes, &p, origins);
        }
        Ok(Typed { nodes, axes, span, ..typed })
    }

    fn seen_from_frame(
        &mut self,
        typed: Typed,
        frame: Frame,
        name: &Spanned<String>,
        span: Span,
    ) -> Result<Typed, Failed> {
        if frame == Frame::World {
            return Ok(Typed { span, ..typed });
        }
        let q = self.pose_of(&frame, "orientation", name.span)?;
        let axes = Axes { to: frame.clone(), ..typed.axes.clone() };
        if typed.kind == Kind::Pose {
            let p = self.pose_of(&frame, "position", name.span)?;
            let back = inverted(self.graph, &[p, q].concat());
            let nodes = composed(self.graph, &back, &typed.nodes);
            return Ok(Typed { nodes, axes, span, ..typed });
        }
        let back = conjugate(self.graph, &q);
        if typed.kind == Kind::Rotation {
            let nodes = quaternion_product(self.graph, &back, &typed.nodes);
            return Ok(Typed { nodes, axes, span, ..typed });
        }
        let origins = self.origins(&typed)?;
        let mut nodes = typed.nodes.clone();
        if origins != 0.0 {
            let p = self.pose_of(&frame, "position", name.span)?;
            self.add(&mut nodes, &p, -origins);
        }
        let nodes = rotate(self.graph, &back, &nodes);
        Ok(Typed { nodes, axes, span, ..typed })
    }

    /// Computes `nodes += factor p`.
    fn add(&mut self, nodes: &mut [usize], p: &[usize], factor: f64) {
        let before = nodes.to_vec();
        let times = self.graph.number(factor);
        for (x, &p) in nodes.iter_mut().zip(p) {
            let part = self.graph.push(Op::Mul(times, p));
            *x = self.graph.push(Op::Add(*x, part));
        }
        self.graph.note(nodes, VectorBound::Sum(before, p.to_vec(), factor));
    }
}
