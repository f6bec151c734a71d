//! What the robot does now, as an expression names it: frames, points of frames, joints, distances.

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Span, Spanned};
use stdlib_tasks::dimension::LENGTH;

use super::lower::Failed;
use super::{Frame, Kind, Lowering, Typed, frames};
use crate::constants::fits;

/// The functions that give what the robot does now.
pub(crate) const PRESENT: &[&str] = &["frame", "point", "joint", "distance"];

/// Something that the robot does now, with the values that name it.
#[derive(Clone, Debug)]
pub enum Now<'v> {
    /// `frame(F).position`, `frame(F).orientation`: the frame, and what of it.
    Frame(&'v Value, &'v Spanned<String>),
    /// `point(F, OFFSET)`: the frame, and the offset in its axes in m.
    Point(&'v Value, [f64; 3]),
    /// `joint(J)`.
    Joint(&'v Value),
    /// `distance(A, B)`.
    Distance(&'v Value, &'v Value),
}

impl Lowering<'_> {
    fn now(&mut self, what: &Now, span: Span) -> Result<Typed, Failed> {
        self.scope.now(self.graph, what, span, self.diagnostics).ok_or(Failed)
    }

    /// `frame(F).position` and the like; other fields are values of tasks.
    pub(super) fn field(&mut self, inner: &Value, field: &Spanned<String>, span: Span) -> Result<Typed, Failed> {
        if let ValueKind::Call(function, args) = &inner.kind
            && function.value == "frame"
        {
            let [frame] = args.as_slice() else {
                let d = Diagnostic::error("HQ0310", inner.span, "`frame` takes the name of one link or arm");
                return self.fail(d.help("write for instance `frame(left_tool).position`"));
            };
            return self.now(&Now::Frame(frame, field), span);
        }
        self.fail(
            Diagnostic::error("HQ0201", span, "the value of a task stands only inside `initial(..)`")
                .note("of what the robot does now there is `frame(F).position`, `frame(F).orientation`, `point(F, ..)`, `joint(J)`, `distance(a, b)`")
                .help("write `initial(..)` around it for its value at the moment the stack becomes active"),
        )
    }

    /// A call of one of [`PRESENT`].
    pub(super) fn present(&mut self, function: &Spanned<String>, args: &[Value], span: Span) -> Result<Typed, Failed> {
        let form = match (function.value.as_str(), args) {
            ("frame", _) => {
                return self.fail(
                    Diagnostic::error("HQ0304", span, "a frame by itself is no value")
                        .help("write `frame(F).position` or `frame(F).orientation`"),
                );
            }
            ("joint", [joint]) => return self.now(&Now::Joint(joint), span),
            ("distance", [a, b]) => return self.now(&Now::Distance(a, b), span),
            ("point", [frame, offset]) => {
                let name = Spanned::new(crate::forms::text_of(frame).unwrap_or_default().to_string(), frame.span);
                let offset = self.offset(offset, &name)?;
                return self.now(&Now::Point(frame, offset), span);
            }
            ("joint", _) => "joint(NAME)",
            ("distance", _) => "distance(PART, PART)",
            _ => "point(FRAME, [x, y, z] m)",
        };
        let count = if args.len() == 1 { "one argument".to_string() } else { format!("{} arguments", args.len()) };
        let text = format!("`{}` does not take {count}", function.value);
        self.fail(Diagnostic::error("HQ0310", span, text).help(format!("the form is `{form}`")))
    }

    /// The constant offset of a point in its frame.
    fn offset(&mut self, value: &Value, frame: &Spanned<String>) -> Result<[f64; 3], Failed> {
        let typed = self.value(value)?;
        if typed.axes.to != Frame::Any {
            let axes = self.scope.frame(frame, self.diagnostics).ok_or(Failed)?;
            if let Some(d) = frames::wanted(&typed, &axes, "the place of a point in its frame", true) {
                return self.fail(d);
            }
        }
        if typed.kind != Kind::Vector {
            let is = typed.kind.describe();
            let text = format!("the place of a point in its frame is a vector, and this is {is}");
            return self.fail(Diagnostic::error("HQ0304", value.span, text).here(is).help("write `[x, y, z] m`"));
        }
        if let Some(d) = fits(self.graph, &typed, LENGTH, "the place of a point in its frame") {
            return self.fail(d);
        }
        let mut offset = [0.0; 3];
        for (x, &node) in offset.iter_mut().zip(&typed.nodes) {
            match self.graph.constant(node) {
                Some(c) if c.is_finite() => *x = c,
                _ => {
                    let d =
                        Diagnostic::error("HQ0307", value.span, "a point is fixed in its frame, and this place is not");
                    return self.fail(d.help(
                        "write a constant; for a place that moves in the frame write `frame(F).position + frame(F).orientation*[..] m`",
                    ));
                }
            }
        }
        Ok(offset)
    }
}
