//! Types of arguments: a value given for a parameter of a task or stack must have the parameter's kind and dimension.

use dsl::{Diagnostic, Span};

use super::Lowerer;
use crate::expand::{Given, quantity};
use crate::expr::constants::{Constants, check_dimension};

impl Lowerer<'_> {
    /// Checks arguments; returns the spans of the rejected ones.
    pub(super) fn given(&mut self, given: &[Given]) -> Vec<Span> {
        let mut refused = Vec::new();
        for g in given {
            let Some((kind, dimension)) = quantity(&g.ty.value) else { continue };
            let mut constants = Constants { graph: &mut self.graph, params: &mut self.params };
            let Some(typed) = constants.argument(&g.value) else { continue };
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
