//! What a safety planner tells of itself: `guard.scaling`, `guard.deviation`, `guard.slack`, `guard.withheld`, `guard.field`.

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Span, Spanned};
use runtime::PLANNER_OUTPUTS;

use super::scope::{Failed, Meaning};
use super::{Lowering, Typed};
use crate::forms::{target, written};
use crate::names::list;

/// The name under which something that a planner tells stands among the values. Nobody can write it.
pub(crate) fn told(task: &str, output: &str) -> String {
    format!("{task}.#{output}")
}

impl Lowering<'_> {
    /// `guard.scaling`, where the first name is that of a safety planner.
    pub(super) fn told_by_planner(
        &mut self,
        inner: &Value,
        field: &Spanned<String>,
        span: Span,
    ) -> Option<Result<Typed, Failed>> {
        let ValueKind::Name(name) = &inner.kind else { return None };
        let said = match self.scope.name(&told(target(name), &field.value)) {
            Meaning::Value(symbol) => return Some(Ok(Typed { span, ..symbol.value })),
            _ => written(name),
        };
        // A value of that name is meant before a task.
        if !matches!(self.scope.name(name), Meaning::Unknown) {
            return None;
        }
        let known = matches!(self.scope.name(&told(target(name), PLANNER_OUTPUTS[0])), Meaning::Value(_));
        known.then(|| {
            let d =
                Diagnostic::error("HQ0201", field.span, format!("safety planner `{said}` tells no `{}`", field.value));
            self.fail(d.help(format!("it tells {}", list(PLANNER_OUTPUTS, 8))))
        })
    }
}
