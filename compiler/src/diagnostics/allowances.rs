//! Warnings that a spec allows, `allow HQ0606 "the tray is soft on purpose"`: they leave the report, which lists them with
//! the reasons.

use dsl::{Diagnostic, Fix, Severity, Span};

use super::report::Report;

/// An allowance of a spec.
#[derive(Clone, Debug)]
pub(crate) struct Allowance {
    /// The code.
    pub code: &'static str,
    /// The reason.
    pub reason: String,
    /// The code and the reason in the text.
    pub span: Span,
    /// The declaration in which the warning is allowed.
    pub scope: Span,
    /// The text to remove without it, if nothing else stands there.
    pub removable: Option<Span>,
}

/// A warning that is allowed.
#[derive(Clone, Debug, PartialEq)]
pub struct Allowed {
    /// The code.
    pub code: &'static str,
    /// Its message.
    pub message: String,
    /// The place that it points at.
    pub place: Span,
    /// The reason for which it is allowed.
    pub reason: String,
    /// The code and the reason in the text.
    pub by: Span,
}

impl Report {
    /// Moves the warnings that are allowed to [`Report::allowed`]. `is_spec` tells the texts of specs from that of the URDF, which specs
    /// name at `urdf`. Returns a warning for each allowance that allows nothing.
    pub(crate) fn allow(
        &mut self,
        allowances: &[Allowance],
        is_spec: impl Fn(Span) -> bool,
        is_known: impl Fn(&str) -> bool,
        urdf: &[Span],
    ) -> Vec<Diagnostic> {
        let sources = &self.sources;
        let scopes: Vec<Span> = allowances.iter().map(|a| sources.real(a.scope)).collect();
        let mut used = vec![false; allowances.len()];
        let allowed = &mut self.allowed;
        self.diagnostics.retain(|d| {
            let own = sources.real(d.primary.span);
            let named = urdf.iter().map(|span| sources.real(*span));
            let places: Vec<Span> = if is_spec(own) { vec![own] } else { named.collect() };
            let allows =
                |i: &usize| allowances[*i].code == d.code && places.iter().any(|place| contains(scopes[*i], *place));
            // The innermost one has the reason for this place.
            let by = (0..allowances.len()).filter(allows).min_by_key(|i| scopes[*i].len());
            let Some(i) = by.filter(|_| d.severity == Severity::Warning) else { return true };
            used[i] = true;
            let Allowance { code, ref reason, span, .. } = allowances[i];
            let new = Allowed {
                code,
                message: d.message.clone(),
                place: own,
                reason: reason.clone(),
                by: sources.real(span),
            };
            if !allowed.contains(&new) {
                allowed.push(new);
            }
            false
        });
        self.allowed.sort_by_key(|a| (a.place.source, a.place.start, a.code));
        let unused = allowances.iter().zip(used).filter(|(a, used)| !used && is_known(a.code));
        unused.map(|(allowance, _)| without_effect(allowance)).collect()
    }
}

fn contains(scope: Span, place: Span) -> bool {
    scope.source == place.source && scope.start <= place.start && place.end <= scope.end
}

fn without_effect(allowance: &Allowance) -> Diagnostic {
    let code = allowance.code;
    let d = Diagnostic::warning("HQ0223", allowance.span, format!("`{code}` is allowed, and nothing here causes it"))
        .note("an allowance that outlives its warning would hide the next one")
        .help("delete it, or move it to the declaration that causes the warning");
    match allowance.removable {
        Some(span) => d.fix(Fix::remove(&format!("allow {code}"), span)),
        None => d,
    }
}
