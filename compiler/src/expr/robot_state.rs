//! The robot's current state in expressions: frames, points, joints, distances, the centre of mass, safety fields.

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Span, Spanned};
use stdlib_tasks::dimension::{Dimension, LENGTH};
use stdlib_tasks::expression::MotionPart;

use super::scope::Failed;
use super::{Axes, Frame, Kind, Lowering, Typed, frames};
use crate::expr::constants::check_dimension;

/// Functions of the robot's current state.
pub(crate) const PRESENT: &[&str] = &["frame", "point", "joint", "distance", "plane", "com", "manipulability", "field"];

/// A part of the robot's current state, with the values that name it.
#[derive(Clone, Debug)]
pub enum RobotStateTerm<'v> {
    /// `frame(F).position`, `frame(F).orientation`: the frame, and the field.
    Frame(&'v Value, &'v Spanned<String>),
    /// `point(F, OFFSET)`: the frame, and the offset in its axes (m).
    Point(&'v Value, [f64; 3]),
    /// `joint(J)`.
    Joint(&'v Value),
    /// `distance(A, B)`.
    Distance(&'v Value, &'v Value),
    /// `distance(A, plane(POINT, NORMAL))`: the part, and the plane.
    Above(&'v Value, Plane),
    /// `com`.
    Com,
    /// `manipulability(F, linear, JOINTS)`: the frame, its velocities that count, and the joints, if they are named.
    Manipulability(&'v Value, MotionPart, Option<&'v [Value]>),
    /// `field(F)`.
    Field(&'v Value),
}

/// A plane: a point of it (m), its unit normal, and the axes in which both are expressed.
#[derive(Clone, Debug)]
pub struct Plane {
    /// A point of the plane (m).
    pub point: [f64; 3],
    /// Unit normal.
    pub normal: [f64; 3],
    /// Axes that carry the plane: those of the world, or of a link.
    pub axes: Frame,
    /// Source span.
    pub span: Span,
}

/// Velocities that count, and the names of joints behind them.
fn velocities(args: &[Value]) -> (MotionPart, Option<&[Value]>) {
    let part = match args.first().and_then(crate::forms::text_of) {
        Some("linear") => MotionPart::Linear,
        Some("angular") => MotionPart::Angular,
        _ => MotionPart::Whole,
    };
    let joints = if part == MotionPart::Whole { args } else { args.get(1..).unwrap_or_default() };
    let joints = match joints {
        [one] => one.items(),
        several => several,
    };
    (part, (!joints.is_empty()).then_some(joints))
}

/// Arguments of `plane(..)`, if the value is such a call.
fn plane_of(value: &Value) -> Option<(&[Value], Span)> {
    match &value.kind {
        ValueKind::Call(function, args) if function.value == "plane" => Some((args, value.span)),
        _ => None,
    }
}

/// Frame of `plane(..) in F`.
fn carried(value: &Value) -> Option<&Spanned<String>> {
    match &value.kind {
        ValueKind::In(inner, frame) => plane_of(inner).map(|_| frame),
        _ => None,
    }
}

impl Lowering<'_> {
    pub(super) fn now(&mut self, what: &RobotStateTerm, span: Span) -> Result<Typed, Failed> {
        self.scope.now(self.graph, what, span, self.diagnostics).ok_or(Failed)
    }

    /// Lowers `frame(F).position` and the like; other fields are values of tasks.
    pub(super) fn field(&mut self, inner: &Value, field: &Spanned<String>, span: Span) -> Result<Typed, Failed> {
        if let ValueKind::Call(function, args) = &inner.kind
            && function.value == "frame"
        {
            let [frame] = args.as_slice() else {
                let d = Diagnostic::error("HQ0310", inner.span, "`frame` takes the name of one link or arm");
                return self.fail(d.help("write for instance `frame(left_tool).position`"));
            };
            if field.value == "pose" {
                return self.frame_pose(frame, field.span, span);
            }
            return self.now(&RobotStateTerm::Frame(frame, field), span);
        }
        if let ValueKind::Name(name) = &inner.kind
            && let Some(part) = self.scope.part(self.graph, (name, inner.span), field, self.diagnostics)
        {
            return part.map(|part| Typed { span, ..part }).ok_or(Failed);
        }
        if let Some(part) = self.part_of_wrench(inner, field, span) {
            return part;
        }
        if let Some(point) = self.tracked(inner, field, span) {
            return point;
        }
        if let Some(velocity) = self.velocity_of_signal(inner, field, span) {
            return velocity;
        }
        if let Some(output) = self.task_output(inner, field, span) {
            return output;
        }
        if let Some(k) = ["x", "y", "z"].iter().position(|n| *n == field.value) {
            let of = self.value(inner)?;
            if of.kind == Kind::Vector {
                let nodes = vec![of.nodes[k]];
                return Ok(Typed { kind: Kind::Scalar, nodes, axes: Axes::default(), span, ..of });
            }
            let text = format!("only a vector has an `{}`, and this is {}", field.value, of.kind.describe());
            let help = match of.kind {
                Kind::Pose => format!("write `.position.{}`", field.value),
                _ => "leave it out".to_string(),
            };
            return self.fail(Diagnostic::error("HQ0304", inner.span, text).help(help));
        }
        if let Some(part) = self.pose_field(inner, field, span) {
            return part;
        }
        if let Some(misspelt) = self.misspelt(inner) {
            return self.fail(misspelt);
        }
        self.fail(
            Diagnostic::unknown_name(span, "the value of a task can be used only inside `initial(..)`")
                .note("the robot's state is read by `frame(F).position`, `.orientation`, `.pose`, `point(F, ..)`, `joint(J)`, `distance(a, b)`, `com`, `manipulability(F)`, `field(F)`")
                .help("write `initial(..)` around it for its value at the moment the stack becomes active"),
        )
    }

    /// Lowers a call of one of [`PRESENT`].
    pub(super) fn present(&mut self, function: &Spanned<String>, args: &[Value], span: Span) -> Result<Typed, Failed> {
        let form = match (function.value.as_str(), args) {
            ("frame", _) => {
                return self.fail(
                    Diagnostic::error("HQ0304", span, "a frame by itself is no value")
                        .help("write `frame(F).position`, `frame(F).orientation` or `frame(F).pose`"),
                );
            }
            ("field", [field]) => return self.now(&RobotStateTerm::Field(field), span),
            ("manipulability", [frame, rest @ ..]) => {
                let (part, by) = velocities(rest);
                return self.now(&RobotStateTerm::Manipulability(frame, part, by), span);
            }
            ("joint", [joint]) => return self.now(&RobotStateTerm::Joint(joint), span),
            ("plane", _) => {
                return self.fail(
                    Diagnostic::error("HQ0304", span, "a plane by itself is no value")
                        .help("write how far a part is above it: `distance(PART, plane([x, y, z] m, [0, 0, 1]))`"),
                );
            }
            ("com", _) => {
                let d = Diagnostic::error("HQ0310", span, "`com` is the centre of mass of the whole robot");
                return self.fail(d.help("write `com`, without brackets"));
            }
            ("distance", [a, b]) if let Some(frame) = carried(a).or(carried(b)) => {
                let d = Diagnostic::error(
                    "HQ0304",
                    frame.span,
                    "a plane counts along the axes of its point and its normal",
                );
                return self.fail(d.help(format!("write `plane([x, y, z] m in {0}, [0, 0, 1] in {0})`", frame.value)));
            }
            ("distance", [a, b]) if plane_of(a).is_some() || plane_of(b).is_some() => return self.above(a, b, span),
            ("distance", [a, b]) => return self.now(&RobotStateTerm::Distance(a, b), span),
            ("point", [frame, offset]) => {
                let name = Spanned::new(crate::forms::text_of(frame).unwrap_or_default().to_string(), frame.span);
                let axes = |s: &mut Self| s.scope.frame(&name, s.diagnostics).ok_or(Failed);
                let what = Fixed {
                    what: "the place of a point in its frame",
                    form: "[x, y, z] m",
                    moves: "a point is fixed in its frame, and this place is not",
                    help: "write a constant; for a place that moves in the frame write `frame(F).position + frame(F).orientation*[..] m`",
                };
                let typed = self.vector(offset, &what)?;
                if typed.axes.to != Frame::Any {
                    let axes = axes(self)?;
                    if let Some(d) = frames::wanted(&typed, &axes, what.what, true) {
                        return self.fail(d);
                    }
                }
                let offset = self.fixed(&typed, Some(LENGTH), &what)?;
                return self.now(&RobotStateTerm::Point(frame, offset), span);
            }
            ("field", _) => "field(NAME)",
            ("manipulability", _) => {
                "manipulability(FRAME)`, `manipulability(FRAME, linear)` or `manipulability(FRAME, angular, JOINTS)"
            }
            ("joint", _) => "joint(NAME)",
            ("distance", _) => "distance(PART, PART)` or `distance(PART, plane(POINT, NORMAL))",
            _ => "point(FRAME, [x, y, z] m)",
        };
        let count = if args.len() == 1 { "one argument".to_string() } else { format!("{} arguments", args.len()) };
        let text = format!("`{}` does not take {count}", function.value);
        self.fail(Diagnostic::error("HQ0310", span, text).help(format!("the form is `{form}`")))
    }

    /// Lowers `distance(A, plane(POINT, NORMAL))`, with the arguments in either order.
    fn above(&mut self, a: &Value, b: &Value, span: Span) -> Result<Typed, Failed> {
        let (part, args, at) = match (plane_of(a), plane_of(b)) {
            (Some((args, at)), None) => (b, args, at),
            (None, Some((args, at))) => (a, args, at),
            _ => {
                let d = Diagnostic::error("HQ0304", span, "a distance between two planes does not depend on the robot");
                return self.fail(d.help("name a part of the robot on one side"));
            }
        };
        let [point, normal] = args else {
            let d = Diagnostic::error("HQ0310", at, format!("`plane` takes a point and a normal, not {}", args.len()));
            return self.fail(d.help("the form is `plane([x, y, z] m, [0, 0, 1])`"));
        };
        let help = "write constants; a plane that a link carries along counts in its axes: `plane([x, y, z] m in F, [0, 0, 1] in F)`";
        let moves = "this plane moves, and a distance is to one that is fixed in the world or in a link";
        let of_point = Fixed { what: "the point of a plane", form: "[x, y, z] m", moves, help };
        let of_normal = Fixed { what: "the normal of a plane", form: "[x, y, z]", moves, help };
        let (p, n) = (self.vector(point, &of_point), self.vector(normal, &of_normal));
        let (p, n) = (p?, n?);
        let Some(axes) = p.axes.to.joined(&n.axes.to) else { return self.fail(frames::different(&p, &n, at, true)) };
        let point = self.fixed(&p, Some(LENGTH), &of_point)?;
        let normal = nalgebra::Vector3::from(self.fixed(&n, None, &of_normal)?);
        // Scaled first, because the square of a huge number overflows.
        let Some(normal) = (normal / normal.amax()).try_normalize(0.0).filter(|_| normal.amax() > 0.0) else {
            let d = Diagnostic::error("HQ0309", n.span, "the normal of a plane needs a direction");
            return self.fail(d.help("write the direction that leads away from the plane, such as `[0, 0, 1]`"));
        };
        let axes = if axes == Frame::Any { Frame::World } else { axes };
        self.now(&RobotStateTerm::Above(part, Plane { point, normal: normal.into(), axes, span: at }), span)
    }

    /// Lowers a vector of any dimension and in any axes.
    fn vector(&mut self, value: &Value, what: &Fixed) -> Result<Typed, Failed> {
        let typed = self.value(value)?;
        if typed.kind == Kind::Vector {
            return Ok(typed);
        }
        let is = typed.kind.describe();
        let text = format!("{} is a vector, and this is {is}", what.what);
        self.fail(Diagnostic::error("HQ0304", value.span, text).here(is).help(format!("write `{}`", what.form)))
    }

    /// Evaluates a constant vector, in SI.
    fn fixed(&mut self, typed: &Typed, dimension: Option<Dimension>, what: &Fixed) -> Result<[f64; 3], Failed> {
        if let Some(d) = dimension.and_then(|wanted| check_dimension(self.graph, typed, wanted, what.what)) {
            return self.fail(d);
        }
        let mut numbers = [0.0; 3];
        for (x, &node) in numbers.iter_mut().zip(&typed.nodes) {
            match self.graph.constant(node) {
                Some(c) if c.is_finite() => *x = c,
                _ => return self.fail(Diagnostic::error("HQ0307", typed.span, what.moves).help(what.help)),
            }
        }
        Ok(numbers)
    }
}

/// Messages for a vector that must be constant.
struct Fixed {
    /// Name of the vector.
    what: &'static str,
    /// Syntax of the vector.
    form: &'static str,
    /// Reason why it must be constant.
    moves: &'static str,
    /// Help if it is not.
    help: &'static str,
}
