//! Arguments of `initial(..)`: a value of the task itself, or any expression of the robot's state.
//!
//! An expression is lowered as in `keep` and `track`, and becomes a capture of its own, which is evaluated once, when
//! the stack becomes active. Time is zero at that moment, so it must stay outside of `initial(..)`.

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Fix, Span};
use names::{list, suggest};
use runtime::program::{CaptureSource, Op};
use stdlib_tasks::dimension::NONE;
use stdlib_tasks::expression::Leaf;
use stdlib_tasks::task::CurrentValueType;

use super::partition::partition;
use super::scope::TaskScope;
use crate::diagnostics::refused::Refused;
use crate::expr::constants::is_word;
use crate::expr::{Graph, Kind, Lowering, Typed, root};
use crate::forms::path_of;

/// Help for an argument that cannot be captured.
const USE: &str = "name a quantity of the robot's state, such as `initial(frame(LINK).position)`, `initial(joint(NAME))` or `initial(distance(a, b))`, or a value of the task itself";

impl TaskScope<'_> {
    /// Lowers `initial(ARGUMENT)`.
    pub(super) fn captured(
        &mut self,
        graph: &mut Graph,
        argument: &Value,
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Typed> {
        if self.capturing {
            let d = Diagnostic::error("HQ0311", span, "an `initial(..)` inside another");
            diagnostics.push(d.help("remove it: everything inside the outer one is captured at the same time"));
            return None;
        }
        let found = match self.own(argument) {
            Some((path, ty)) => self.own_value(graph, path, ty, argument.span, span),
            None => self.expression(graph, argument, span, diagnostics),
        };
        found.map_err(|d| diagnostics.extend(d.map(|d| *d))).ok()
    }

    /// Name and type of the task's own value that the argument names.
    fn own(&self, value: &Value) -> Option<(String, CurrentValueType)> {
        let path = path_of(value)?;
        let arm = |name: &str| self.robot.arms.iter().any(|arm| name == format!("angle.{}", arm.name));
        let owner = self.owner?;
        [format!("{}{path}", owner.prefix), path].into_iter().find_map(|name| {
            let actual = owner.kind.current_values.iter().find(|a| a.name == name || (a.name == "*" && arm(&name)))?;
            Some((name, actual.ty))
        })
    }

    /// Captures a value of the task itself.
    pub(super) fn own_value(
        &mut self,
        graph: &mut Graph,
        path: String,
        ty: CurrentValueType,
        at: Span,
        span: Span,
    ) -> Result<Typed, Refused> {
        let ty = match ty {
            CurrentValueType::Of(name) => self.type_of(name, at)?,
            ty => ty,
        };
        self.must_move(span)?;
        let axes = self.axes.get(path.as_str()).cloned().unwrap_or_default();
        let task = self.owner.map_or(0, |o| o.task);
        let first = self.table.capture(CaptureSource::Task(task, path), ty.len());
        let nodes = (first..first + ty.len()).map(|k| graph.push(Op::Input(k))).collect();
        let (kind, dimension) = match ty {
            CurrentValueType::Scalar(d) => (Kind::Scalar, d),
            CurrentValueType::Vector(d) => (Kind::Vector, d),
            CurrentValueType::Rotation | CurrentValueType::Of(_) => (Kind::Rotation, NONE),
            CurrentValueType::Pose => (Kind::Pose, NONE),
        };
        Ok(Typed { kind, dimension, nodes, bare: false, axes, span })
    }

    /// Type of a parameter that was bound before. A parameter that failed to bind was reported there.
    fn type_of(&self, name: &str, span: Span) -> Result<CurrentValueType, Refused> {
        match self.forms.get(name) {
            Some((Kind::Scalar | Kind::Truth, d)) => Ok(CurrentValueType::Scalar(*d)),
            Some((Kind::Vector, d)) => Ok(CurrentValueType::Vector(*d)),
            Some((Kind::Rotation, _)) => Ok(CurrentValueType::Rotation),
            Some((Kind::Pose, _)) => Ok(CurrentValueType::Pose),
            None if self.owner.is_none_or(|o| o.param != name) => Err(None),
            None => {
                let d = Diagnostic::error("HQ0311", span, format!("`{name}` cannot be captured inside itself"));
                let help =
                    "name a quantity of the robot's state, such as `initial(frame(F).position)` or `initial(joint(J))`";
                Err(Some(Box::new(d.help(help))))
            }
        }
    }

    /// Captures an expression of the robot's state.
    fn expression(
        &mut self,
        graph: &mut Graph,
        argument: &Value,
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Result<Typed, Refused> {
        if let Some(d) = self.no_value(argument).or_else(|| self.own_inside(argument)) {
            return Err(Some(Box::new(d)));
        }
        let mut inside = self.inside(true);
        let typed = Lowering { graph, scope: &mut inside, diagnostics }.value(argument);
        let asked = inside.asked;
        self.state(graph, typed.map_err(|_| None)?, asked, argument, span)
    }

    /// Captures a typed expression; `asked` is true if it names a part of the robot's state.
    fn state(
        &mut self,
        graph: &mut Graph,
        typed: Typed,
        asked: bool,
        argument: &Value,
        span: Span,
    ) -> Result<Typed, Refused> {
        if typed.nodes.iter().all(|&n| graph.constant(n).is_some()) {
            // The state of a link that does not move is constant.
            let d = Diagnostic::error("HQ0311", argument.span, "nothing can be captured from this");
            return if asked { Ok(Typed { span, ..typed }) } else { Err(Some(Box::new(d.help(USE)))) };
        }
        let e = partition(graph, self.table, &typed);
        let people = e.leaves.iter().find_map(|l| match l {
            Leaf::Field(_) => Some(("a safety field", "field")),
            Leaf::PointDistance(_) => Some(("the distance to a person", "distance")),
            _ => None,
        });
        if let Some((what, function)) = people {
            let d = Diagnostic::error("HQ0311", argument.span, format!("{what} cannot be captured"))
                .note("`initial(..)` reads the robot alone, and people go on moving");
            return Err(Some(Box::new(d.help(format!("write `{function}(..)` without `initial`, or a number")))));
        }
        if !e.inputs.is_empty() {
            let d = Diagnostic::error("HQ0311", argument.span, "the time cannot be captured")
                .note("`initial(..)` is the value when the stack becomes active, and `t` is zero then");
            return Err(Some(Box::new(d.help("leave `t` and `time` out, or write them outside of `initial(..)`"))));
        }
        self.must_move(span)?;
        let first = self.table.capture_nodes(&typed.nodes, e);
        let nodes = (first..first + typed.nodes.len()).map(|k| graph.push(Op::Input(k))).collect();
        Ok(Typed { nodes, bare: false, span, ..typed })
    }

    /// Rejects captures in a parameter that is needed before anything is captured.
    fn must_move(&self, span: Span) -> Result<(), Refused> {
        if self.moving {
            return Ok(());
        }
        let d = Diagnostic::error("HQ0307", span, "this parameter is needed before anything is captured")
            .note("`initial(..)` has its value when the stack becomes active, and the task is built before");
        Err(Some(Box::new(d.help("write a constant"))))
    }

    /// Diagnostic for a name that neither the task nor the spec declares.
    fn no_value(&self, argument: &Value) -> Option<Diagnostic> {
        let path = path_of(argument)?;
        if root(argument).is_some_and(|name| self.params.knows(name)) || is_word(&path) {
            return None;
        }
        let own: Vec<&str> = self.owner.iter().flat_map(|o| o.kind.current_values).map(|a| a.name).collect();
        let text = match self.owner {
            Some(owner) => format!("`{}` has no value `{path}` that could be captured", owner.kind.name),
            None => format!("a `let` belongs to no task, so there is no `{path}` that could be captured"),
        };
        let d = Diagnostic::error("HQ0311", argument.span, text);
        Some(if let Some(near) = suggest(&path, own.iter().copied()) {
            d.help(format!("did you mean `initial({near})`?")).fix(Fix::name(argument.span, near))
        } else if own.is_empty() {
            d.help("name a quantity of the robot's state, such as `initial(frame(LINK).position)` or `initial(joint(NAME))`")
        } else {
            d.help(format!("it has {}", list(own.iter().copied(), 8).replace("`*`", "`angle.ARM`")))
        })
    }

    /// Diagnostic for a value of the task itself inside a captured expression: it is not a part of the robot's state.
    fn own_inside(&self, value: &Value) -> Option<Diagnostic> {
        let names = |v: &&Value| matches!(&v.kind, ValueKind::Name(n) if self.params.knows(n));
        if let Some((path, _)) = Some(value).filter(|v| !names(v)).and_then(|v| self.own(v)) {
            let d = Diagnostic::error("HQ0311", value.span, format!("`{path}` must be alone in `initial(..)`")).note(
                "it is a value of the task itself; only expressions of the robot's state can be captured as a whole",
            );
            return Some(d.help(format!("capture it by itself, and write the rest outside: `initial({path})`")));
        }
        match &value.kind {
            // The arguments of these calls are names of frames, joints, parts and fields, not values.
            ValueKind::Call(function, _)
                if ["frame", "joint", "distance", "manipulability", "field"].contains(&function.value.as_str()) =>
            {
                None
            }
            ValueKind::Call(_, args) | ValueKind::List(args) => args.iter().find_map(|a| self.own_inside(a)),
            ValueKind::Field(inner, _)
            | ValueKind::Unit(inner, _)
            | ValueKind::In(inner, _)
            | ValueKind::Named(_, inner)
            | ValueKind::Negate(inner)
            | ValueKind::Not(inner) => self.own_inside(inner),
            ValueKind::Binary(_, a, b) => self.own_inside(a).or_else(|| self.own_inside(b)),
            ValueKind::Missing
            | ValueKind::Number(_)
            | ValueKind::Text(_)
            | ValueKind::Name(_)
            | ValueKind::Block(_) => None,
        }
    }
}
