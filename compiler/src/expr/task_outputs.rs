//! Outputs of a running task: `guard.scaling` of a safety planner, `separation.room`.

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Span, Spanned};
use stdlib_tasks::KINDS;

use super::scope::{Failed, Meaning};
use super::{Lowering, Typed};
use crate::forms::{target, written};

/// Name of the symbol for a task's output. Users cannot write it.
pub(crate) fn output_symbol(task: &str, output: &str) -> String {
    format!("{task}.#{output}")
}

impl Lowering<'_> {
    /// Lowers `guard.scaling`, if the first name is that of a task with outputs.
    pub(super) fn task_output(
        &mut self,
        inner: &Value,
        field: &Spanned<String>,
        span: Span,
    ) -> Option<Result<Typed, Failed>> {
        let ValueKind::Name(name) = &inner.kind else { return None };
        if let Meaning::Value(symbol) = self.scope.name(&output_symbol(target(name), &field.value)) {
            return Some(Ok(Typed { span, ..symbol.value }));
        }
        // A value hides a task of the same name.
        if !matches!(self.scope.name(name), Meaning::Unknown) {
            return None;
        }
        let mut has = |output: &str| matches!(self.scope.name(&output_symbol(target(name), output)), Meaning::Value(_));
        let kind = KINDS.iter().find(|k| !k.outputs.is_empty() && k.outputs.iter().all(|t| has(t.name)))?;
        let text = format!("`{}`, a `{}`, has no output `{}`", written(name), kind.name, field.value);
        let d = Diagnostic::unknown_name(field.span, text);
        let names = || kind.outputs.iter().map(|t| t.name);
        Some(self.fail(d.one_of("its outputs are", &field.value, names())))
    }
}
