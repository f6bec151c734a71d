//! Scope of a task's parameters: the meaning of names and of `initial(..)` in them.

use std::collections::BTreeMap;

use dsl::tree::Value;
use dsl::{Diagnostic, Help, Span, Spanned};
use stdlib_tasks::dimension::Dimension;

use super::motion::{Numbers, TargetFlag};
use super::{Owner, Table};
use crate::expr::constants::Params;
use crate::expr::{Axes, Frame, Graph, Kind, Meaning, RobotStateTerm, Scope, Start, Typed};
use crate::robot_binding::BoundRobot;

/// Scope of a task's parameters: declared parameters, and the values that `initial(..)` can capture.
pub(crate) struct TaskScope<'s> {
    pub robot: &'s BoundRobot,
    pub params: &'s mut Params,
    pub table: &'s mut Table,
    /// The task; `None` for a named expression that all tasks may use.
    pub(super) owner: Option<Owner<'s>>,
    pub moving: bool,
    /// True if the expression may depend on the robot's current state.
    pub state: bool,
    /// Span of the parameter's whole value, inside a parameter.
    pub whole: Option<Span>,
    /// True inside `initial(..)`.
    pub capturing: bool,
    /// True if a part of the robot's current state was named.
    pub asked: bool,
    /// Kind and dimension of the parameters bound before that are expressions.
    pub forms: &'s BTreeMap<&'static str, (Kind, Dimension)>,
    /// Known axes of the task's own values.
    pub axes: &'s BTreeMap<&'static str, Axes>,
    /// Adds a measure of the motion, in a condition of a machine.
    pub numbers: Option<&'s mut Numbers<'s>>,
    /// Targets that a condition of a machine asks to be reached.
    pub targets: &'s [TargetFlag],
}

/// Properties of a task that follow from its bound parameters.
#[derive(Clone, Copy)]
pub(crate) struct Known<'s> {
    /// Kind and dimension of the parameters that are expressions.
    pub forms: &'s BTreeMap<&'static str, (Kind, Dimension)>,
    /// Axes of the task's own values.
    pub axes: &'s BTreeMap<&'static str, Axes>,
}

impl<'s> TaskScope<'s> {
    /// Scope of an expression that belongs to no task: of the robot's current state, and of time.
    pub fn free(
        robot: &'s BoundRobot,
        params: &'s mut Params,
        table: &'s mut Table,
        Known { forms, axes }: Known<'s>,
    ) -> Self {
        TaskScope {
            robot,
            params,
            table,
            owner: None,
            moving: true,
            state: true,
            whole: None,
            capturing: false,
            asked: false,
            forms,
            axes,
            numbers: None,
            targets: &[],
        }
    }

    /// Scope of an expression inside the parameter that may depend on the robot's state when the stack is entered.
    pub(super) fn inside(&mut self, capturing: bool) -> TaskScope<'_> {
        let known = Known { forms: self.forms, axes: self.axes };
        let free = TaskScope::free(self.robot, self.params, self.table, known);
        TaskScope { owner: self.owner, moving: self.moving, capturing, ..free }
    }
}

impl Scope for TaskScope<'_> {
    fn name(&mut self, name: &str) -> Meaning {
        self.params.meaning(name)
    }

    fn names(&self) -> Vec<String> {
        self.params.names()
    }

    fn presence(&mut self, name: &str) -> Option<usize> {
        self.params.presence(name)
    }

    fn age(&mut self, name: &str) -> Option<usize> {
        self.params.age(name)
    }

    fn follows(&self) -> bool {
        self.state
    }

    fn instead(&self, name: &str) -> Option<Help> {
        let model = &self.robot.model;
        if let Some(owner) = self.owner.filter(|o| o.kind.name == "keep" && ["min", "max"].contains(&o.param))
            && ["_", "none", "inf", "infinity", "free", "any", "nan"].contains(&name.to_lowercase().as_str())
        {
            let text =
                format!("a number of a vector without a limit is `none`; a number alone needs no `{}`", owner.param);
            return Some(text.into());
        }
        if model.dof(name).is_some_and(|d| model.dofs[d].q_index.is_some()) {
            return Some(format!("for the position of the joint write `joint({name})`").into());
        }
        if model.link(name).is_some() || self.robot.arms.iter().any(|a| a.name == name) {
            return Some(
                format!("write `frame({name}).position` for its position, `.orientation` for its orientation").into(),
            );
        }
        let part = self.robot.groups.contains_key(name) || self.robot.geometries.iter().any(|g| g.name == name);
        part.then(|| {
            format!(
                "it is a part of the robot, not a value: write `distance({name}, OTHER)` for how far it is from another"
            )
            .into()
        })
    }

    fn initial(
        &mut self,
        graph: &mut Graph,
        argument: &Value,
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Typed> {
        self.captured(graph, argument, span, diagnostics)
    }

    fn start(
        &mut self,
        graph: &mut Graph,
        from: Option<&Value>,
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Start> {
        self.started(graph, from, span, diagnostics)
    }

    fn frame(&mut self, name: &Spanned<String>, diagnostics: &mut Vec<Diagnostic>) -> Option<Frame> {
        self.axes_named(name, diagnostics)
    }

    fn now(
        &mut self,
        graph: &mut Graph,
        what: &RobotStateTerm,
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Typed> {
        self.present(graph, what, span, diagnostics)
    }

    fn measured(
        &mut self,
        graph: &mut Graph,
        function: &Spanned<String>,
        args: &[Value],
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Typed> {
        self.measure(graph, function, args, span, diagnostics).map_err(|d| diagnostics.extend(d.map(|d| *d))).ok()
    }
}
