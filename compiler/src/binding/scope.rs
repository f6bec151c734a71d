//! What names and `initial(..)` mean inside the parameters of a task.

use std::collections::BTreeMap;

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Span, Spanned};
use runtime::program::{CaptureSource, Op};
use stdlib_tasks::dimension::{Dimension, LENGTH, NONE};
use stdlib_tasks::task::ActualType;

use super::{Owner, Table};
use crate::constants::{Params, joint_dimension};
use crate::expr::{Axes, Frame, Graph, Kind, Meaning, Now, Scope, Typed};
use crate::forms::{path_of, text_of};
use crate::names::{list, suggest};
use crate::robot_binding::{BoundRobot, unknown_joint, unknown_link};

/// The scope of a task's parameters: declared parameters, and what `initial(..)` can capture.
pub(super) struct TaskScope<'s> {
    pub robot: &'s BoundRobot,
    pub params: &'s mut Params,
    pub table: &'s mut Table,
    /// The task; none for a named expression that all tasks may use.
    pub owner: Option<Owner<'s>>,
    pub moving: bool,
    /// Whether what the robot does now may stand in it.
    pub state: bool,
    /// Kind and dimension of parameters that were bound before and are expressions.
    pub forms: &'s BTreeMap<&'static str, (Kind, Dimension)>,
}

impl Scope for TaskScope<'_> {
    fn name(&mut self, name: &str) -> Meaning {
        self.params.meaning(name)
    }

    fn names(&self) -> Vec<String> {
        self.params.names()
    }

    fn initial(&mut self, graph: &mut Graph, argument: &Value, span: Span) -> Result<Typed, Box<Diagnostic>> {
        let (source, ty, axes) = self.source(argument)?;
        if !self.moving {
            return Err(Box::new(
                Diagnostic::error("HQ0307", span, "this parameter is needed before anything is captured")
                    .note("`initial(..)` has its value when the stack becomes active, and the task is built before")
                    .help("write a constant"),
            ));
        }
        let len = ty.len();
        let at = self.table.capture(source, len);
        let nodes = (at..at + len).map(|k| graph.push(Op::Input(k))).collect();
        let (kind, dimension) = match ty {
            ActualType::Scalar(d) => (Kind::Scalar, d),
            ActualType::Vector(d) => (Kind::Vector, d),
            ActualType::Rotation | ActualType::Of(_) => (Kind::Rotation, NONE),
        };
        Ok(Typed { kind, dimension, nodes, bare: false, axes, span })
    }

    fn frame(&mut self, name: &Spanned<String>, diagnostics: &mut Vec<Diagnostic>) -> Option<Frame> {
        self.axes_named(name, diagnostics)
    }

    fn now(&mut self, graph: &mut Graph, what: &Now, span: Span, diagnostics: &mut Vec<Diagnostic>) -> Option<Typed> {
        self.present(graph, what, span, diagnostics)
    }
}

impl TaskScope<'_> {
    /// The type of a parameter that was bound before.
    fn type_of(&self, name: &str, span: Span) -> Result<ActualType, Box<Diagnostic>> {
        match self.forms.get(name) {
            Some((Kind::Scalar | Kind::Truth, d)) => Ok(ActualType::Scalar(*d)),
            Some((Kind::Vector, d)) => Ok(ActualType::Vector(*d)),
            Some((Kind::Rotation, _)) => Ok(ActualType::Rotation),
            None => Err(Box::new(
                Diagnostic::error("HQ0311", span, format!("`{name}` cannot be captured inside itself"))
                    .help("use `initial(frame(F).position)`, `initial(frame(F).orientation)` or `initial(joint(J))`"),
            )),
        }
    }

    fn source(&self, argument: &Value) -> Result<(CaptureSource, ActualType, Axes), Box<Diagnostic>> {
        let model = &self.robot.model;
        if let ValueKind::Field(inner, field) = &argument.kind
            && let ValueKind::Call(function, args) = &inner.kind
            && function.value == "frame"
        {
            let link = match args.as_slice() {
                [one] => text_of(one).map(|n| (n, one.span)),
                _ => None,
            };
            let Some((name, at)) = link else {
                return Err(Box::new(Diagnostic::error("HQ0310", inner.span, "`frame` takes the name of a link")));
            };
            let arm = self.robot.arms.iter().find(|a| a.name == name).map(|a| a.tip);
            let Some(link) = model.link(name).or(arm) else {
                return Err(Box::new(unknown_link(model, name, at, &self.robot.arms)));
            };
            return match field.value.as_str() {
                "position" => {
                    Ok((CaptureSource::FramePosition(link), ActualType::Vector(LENGTH), Axes::point(Frame::World)))
                }
                "orientation" => {
                    let axes = Axes::orientation(self.axes_of(link), Frame::World);
                    Ok((CaptureSource::FrameOrientation(link), ActualType::Rotation, axes))
                }
                other => Err(Box::new(
                    Diagnostic::error("HQ0201", field.span, format!("a frame has no `{other}`"))
                        .help("it has `position` and `orientation`"),
                )),
            };
        }
        if let ValueKind::Call(function, args) = &argument.kind
            && function.value == "joint"
            && let [one] = args.as_slice()
            && let Some(name) = text_of(one)
        {
            let dof = model.dof(name).filter(|&d| model.dofs[d].q_index.is_some());
            let Some(dof) = dof else {
                return Err(Box::new(unknown_joint(model, name, one.span, &[], &self.robot.joint_groups.locked)));
            };
            let q = model.dofs[dof].q_index.unwrap_or(0);
            return Ok((CaptureSource::Joint(q), ActualType::Scalar(joint_dimension(model, dof)), Axes::default()));
        }
        let actuals = self.owner.map_or(&[][..], |o| o.kind.actuals);
        let own: Vec<&str> = actuals.iter().map(|a| a.name).collect();
        let Some(path) = path_of(argument) else {
            return Err(Box::new(
                Diagnostic::error("HQ0311", argument.span, "nothing can be captured from this")
                    .help("name `frame(LINK).position`, `frame(LINK).orientation`, `joint(NAME)` or a value of the task itself"),
            ));
        };
        let candidates = self.owner.iter().flat_map(|o| [(o, format!("{}{path}", o.prefix)), (o, path.clone())]);
        for (owner, candidate) in candidates {
            let found = actuals.iter().find(|a| {
                a.name == candidate
                    || (a.name == "*" && self.robot.arms.iter().any(|arm| candidate == format!("angle.{}", arm.name)))
            });
            if let Some(actual) = found {
                let ty = match actual.ty {
                    ActualType::Of(name) => self.type_of(name, argument.span)?,
                    ty => ty,
                };
                return Ok((CaptureSource::Task(owner.task, candidate), ty, Axes::default()));
            }
        }
        let mut d = Diagnostic::error(
            "HQ0311",
            argument.span,
            match self.owner {
                Some(owner) => format!("`{}` has no value `{path}` that could be captured", owner.kind.name),
                None => format!("a `let` belongs to no task, so there is no `{path}` that could be captured"),
            },
        );
        if let Some(near) = suggest(&path, own.iter().copied()) {
            d = d.help(format!("did you mean `initial({near})`?"));
        } else if own.is_empty() {
            d = d.help(
                "use `initial(frame(LINK).position)`, `initial(frame(LINK).orientation)` or `initial(joint(NAME))`",
            );
        } else {
            d = d.help(format!("it has {}", list(own.iter().copied(), 8).replace("`*`", "`angle.ARM`")));
        }
        Err(Box::new(d))
    }
}
