//! Conditions of a machine: truth values of signals, of the time in a state, and of the state and motion of the robot.

use dsl::tree::Value;
use dsl::{Diagnostic, Help, Snippet};
use runtime::program::Op;
use stdlib_tasks::dimension::Dimension;
use stdlib_tasks::expression::Expression;

use super::motion::MeasuredState;
use super::partition::partition;
use super::{Binder, Known, TaskScope};
use crate::expr::{Frame, Graph, Kind, Lowering};

/// A condition, with the properties that are known before the run.
pub(crate) struct Condition {
    /// The condition.
    pub expression: Expression,
    /// Its node in the graph.
    pub node: usize,
    /// Its value, if it never changes.
    pub constant: Option<bool>,
    /// Signals that must be present: the condition is false if one of them is absent.
    pub demands: Vec<usize>,
}

impl Binder<'_> {
    /// Binds a condition; `None` if it is invalid, with diagnostics.
    pub(crate) fn condition(&mut self, value: &Value, state: &mut MeasuredState) -> Option<Condition> {
        let known = Known { forms: &self.forms, axes: &self.axes };
        let targets = state.targets;
        let mut numbers =
            |graph: &mut Graph, text: &str, measure, dimension| state.number(graph, text, measure, dimension);
        let free = TaskScope::free(self.robot, self.params, self.table, known);
        let mut scope = TaskScope { numbers: Some(&mut numbers), targets, ..free };
        let mut lowering = Lowering { graph: self.graph, scope: &mut scope, diagnostics: self.diagnostics };
        let typed = lowering.value(value).ok()?;
        if typed.kind != Kind::Truth {
            let is = typed.kind.describe();
            let d = Diagnostic::error("HQ0304", value.span, format!("a condition is true or false, and this is {is}"));
            self.diagnostics.push(d.here(is).help("compare it with something: `norm(right_ft.force) < 3 N`"));
            return None;
        }
        let (ops, _) = self.graph.extract(&typed.nodes);
        if self.graph.moves_along(&typed.nodes) {
            let d = Diagnostic::error("HQ0312", value.span, "a trajectory is not allowed in a condition");
            let note = "it begins when a stack is entered, and a condition belongs to no stack";
            self.diagnostics.push(
                d.note(note).help(Help::with(
                    "wait for the task that it moves: {}",
                    [Snippet::entry("on", "reached(TASK, ..)")],
                )),
            );
            return None;
        }
        if ops.iter().any(|op| matches!(op, Op::Input(_))) {
            let d = Diagnostic::error("HQ0311", value.span, "`initial(..)` is not allowed in a condition");
            self.diagnostics.push(
                d.note("it captures a value when a stack becomes active, and a condition belongs to no stack").help(
                    "compare with a value that is known, or let the task `track` it and wait for `reached(TASK, ..)`",
                ),
            );
            return None;
        }
        let constant = self.graph.constant(typed.nodes[0]).map(|x| x >= 0.0);
        let mut demands = Vec::new();
        self.demanded(typed.nodes[0], &mut demands);
        let mut expression = partition(self.graph, self.table, &typed);
        for input in &mut expression.inputs {
            *input = self.table.place(&[*input]).at;
        }
        Some(Condition { expression, node: typed.nodes[0], constant, demands })
    }

    /// Binds the value that an action assigns to a variable of the machine; `None` if it is invalid, with diagnostics.
    pub(crate) fn assigned(&mut self, value: &Value, wanted: (Kind, Dimension), what: &str) -> Option<Expression> {
        let typed = self.present(value)?;
        self.check_type(&typed, value, wanted, what)?;
        if wanted.0 != Kind::Scalar && wanted.0 != Kind::Truth {
            self.expressed(&typed, &Frame::World, true, what)?;
        }
        let (ops, _) = self.graph.extract(&typed.nodes);
        if ops.iter().any(|op| matches!(op, Op::Input(_))) {
            let d = Diagnostic::error("HQ0311", value.span, "`initial(..)` is not allowed in an action");
            self.diagnostics.push(
                d.note("it captures a value when a stack becomes active, and an action belongs to no stack")
                    .help("write the value itself: an action works it out once, at its tick"),
            );
            return None;
        }
        let mut expression = partition(self.graph, self.table, &typed);
        for input in &mut expression.inputs {
            *input = self.table.place(&[*input]).at;
        }
        Some(expression)
    }

    /// Collects the signals without which a truth value cannot hold: those of operands joined by `and`, which is
    /// `if a then b else a`.
    fn demanded(&self, node: usize, out: &mut Vec<usize>) {
        match self.graph.ops()[node] {
            Op::Signal(at) => out.push(at),
            Op::Select(a, b, c) if c == a => {
                self.demanded(a, out);
                self.demanded(b, out);
            }
            _ => {}
        }
    }
}
