//! Types of arguments: a value given for a parameter of a task or stack must have the parameter's kind and dimension.

use dsl::tree::Value;
use dsl::{Diagnostic, Span, Spanned};

use super::Lowerer;
use crate::expand::{Given, quantity};
use crate::expr::constants::{Params, check_dimension};
use crate::expr::{Frame, Graph, Lowering, Meaning, RobotStateTerm, Scope, Typed};

/// Scope of arguments. Names that only a task knows are left to the task.
struct Outside<'s>(&'s mut Params);

impl Scope for Outside<'_> {
    fn name(&mut self, name: &str) -> Meaning {
        self.0.meaning(name)
    }

    fn names(&self) -> Vec<String> {
        self.0.names()
    }

    fn presence(&mut self, name: &str) -> Option<usize> {
        self.0.presence(name)
    }

    fn initial(&mut self, _: &mut Graph, _: &Value, _: Span, _: &mut Vec<Diagnostic>) -> Option<Typed> {
        None
    }

    fn frame(&mut self, _: &Spanned<String>, _: &mut Vec<Diagnostic>) -> Option<Frame> {
        None
    }

    fn now(&mut self, _: &mut Graph, _: &RobotStateTerm, _: Span, _: &mut Vec<Diagnostic>) -> Option<Typed> {
        None
    }
}

impl Lowerer<'_> {
    /// Checks arguments; returns the spans of the rejected ones.
    pub(super) fn given(&mut self, given: &[Given]) -> Vec<Span> {
        let mut refused = Vec::new();
        for g in given {
            let Some((kind, dimension)) = quantity(&g.ty.value) else { continue };
            // Other mistakes are reported at the use.
            let mut found = Vec::new();
            let mut scope = Outside(&mut self.params);
            let typed = Lowering { graph: &mut self.graph, scope: &mut scope, diagnostics: &mut found }.value(&g.value);
            let Ok(typed) = typed else { continue };
            let wrong = if typed.kind != kind {
                let (is, needed) = (typed.kind.describe(), kind.describe());
                let d = Diagnostic::error("HQ0215", g.value.span, format!("{} is {needed}, and this is {is}", g.what));
                Some(d.here(is).help(format!("give {needed}")))
            } else {
                dimension.and_then(|d| check_dimension(&self.graph, &typed, d, &g.what))
            };
            if let Some(d) = wrong {
                // From here on, a bare number is in SI, so the warning for a bare angle has to come here.
                if d.severity == dsl::Severity::Error {
                    refused.push(g.value.span);
                }
                self.push(d.label(g.ty.span, "declared here"));
            }
        }
        refused
    }
}
