//! What names and `initial(..)` mean inside the parameters of a task.

use std::collections::BTreeMap;

use dsl::tree::Value;
use dsl::{Diagnostic, Span, Spanned};
use stdlib_tasks::dimension::Dimension;

use super::{Owner, Table};
use crate::constants::Params;
use crate::expr::{Frame, Graph, Kind, Meaning, Now, Scope, Typed};
use crate::robot_binding::BoundRobot;

/// The scope of a task's parameters: declared parameters, and what `initial(..)` can capture.
pub(crate) struct TaskScope<'s> {
    pub robot: &'s BoundRobot,
    pub params: &'s mut Params,
    pub table: &'s mut Table,
    /// The task; none for a named expression that all tasks may use.
    pub(super) owner: Option<Owner<'s>>,
    pub moving: bool,
    /// Whether what the robot does now may stand in it.
    pub state: bool,
    /// Inside `initial(..)`.
    pub capturing: bool,
    /// Whether something that the robot does now was named.
    pub asked: bool,
    /// Kind and dimension of parameters that were bound before and are expressions.
    pub forms: &'s BTreeMap<&'static str, (Kind, Dimension)>,
}

impl<'s> TaskScope<'s> {
    /// That of an expression that belongs to no task: of what the robot does now, and of time.
    pub fn free(
        robot: &'s BoundRobot,
        params: &'s mut Params,
        table: &'s mut Table,
        forms: &'s BTreeMap<&'static str, (Kind, Dimension)>,
    ) -> Self {
        TaskScope {
            robot,
            params,
            table,
            owner: None,
            moving: true,
            state: true,
            capturing: false,
            asked: false,
            forms,
        }
    }
}

impl Scope for TaskScope<'_> {
    fn name(&mut self, name: &str) -> Meaning {
        self.params.meaning(name)
    }

    fn names(&self) -> Vec<String> {
        self.params.names()
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

    fn frame(&mut self, name: &Spanned<String>, diagnostics: &mut Vec<Diagnostic>) -> Option<Frame> {
        self.axes_named(name, diagnostics)
    }

    fn now(&mut self, graph: &mut Graph, what: &Now, span: Span, diagnostics: &mut Vec<Diagnostic>) -> Option<Typed> {
        self.present(graph, what, span, diagnostics)
    }
}
