//! Start of a parameter's trajectory: the value after `from` when the stack is entered, or the task's own value at that
//! moment, with its rate of change.

use dsl::tree::Value;
use dsl::{Diagnostic, Span};
use runtime::program::{CaptureSource, Op};
use stdlib_tasks::task::CurrentValueType;

use super::scope::TaskScope;
use crate::expr::{Graph, Kind, Lowering, Start, needs_from};

impl TaskScope<'_> {
    /// See [`crate::expr::Scope::start`].
    pub(super) fn started(
        &mut self,
        graph: &mut Graph,
        from: Option<&Value>,
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Start> {
        if self.capturing || !self.moving {
            let text = match self.capturing {
                true => "a trajectory is not allowed in `initial(..)`: it begins when the stack is entered",
                false => "this parameter must not move, and a trajectory does",
            };
            let help = if self.capturing { "name its start" } else { "write a constant" };
            diagnostics.push(Diagnostic::error("HQ0307", span, text).help(help));
            return None;
        }
        let Some(from) = from else { return self.own_start(graph, span, diagnostics) };
        let mut inside = self.inside(false);
        // Kept back: if it depends on the robot's state, `captured` lowers it again and reports the same mistakes.
        let mut found = Vec::new();
        let typed = Lowering { graph, scope: &mut inside, diagnostics: &mut found }.value(from);
        match typed {
            Ok(typed) if typed.nodes.iter().any(|&n| graph.is_state(n)) => {
                Some(Start::At(self.captured(graph, from, from.span, diagnostics)?, Vec::new()))
            }
            Ok(typed) => {
                diagnostics.extend(found);
                Some(Start::At(typed, Vec::new()))
            }
            Err(_) => {
                diagnostics.extend(found);
                None
            }
        }
    }

    /// Start from the task's own value and its rate of change.
    fn own_start(&mut self, graph: &mut Graph, span: Span, diagnostics: &mut Vec<Diagnostic>) -> Option<Start> {
        let known = self.owner.filter(|_| self.whole == Some(span)).and_then(|owner| {
            let own = format!("{}{}", owner.prefix, owner.param);
            // A tracked value moves to its target.
            let all = [own.as_str(), "value"].into_iter();
            all.filter(|name| *name != "value" || own == "target")
                .find_map(|name| owner.kind.current_values.iter().find(|a| a.name == name))
                .map(|actual| (owner.task, actual.name.to_string(), actual.ty))
        });
        let Some((task, path, ty)) = known else {
            diagnostics.push(needs_from(span));
            return None;
        };
        let value = self.own_value(graph, path.clone(), ty, span, span);
        let value = value.map_err(|d| diagnostics.extend(d.map(|d| *d))).ok()?;
        let width = value.nodes.len();
        let len = match value.kind {
            Kind::Rotation => 3,
            Kind::Pose => 6,
            _ => CurrentValueType::len(ty).min(width),
        };
        let first = self.table.capture(CaptureSource::Velocity(task, path, width), len);
        let velocity = (first..first + len).map(|k| graph.push(Op::Input(k))).collect();
        Some(Start::At(value, velocity))
    }
}
