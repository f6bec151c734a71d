//! Code actions: fixes for the mistakes at the cursor. Each fix is tested on the text before it is offered.

use compiler::{Input, Report};
use dsl::{Diagnostic, Fix, Severity};
use lsp_types::{CodeAction, CodeActionContext, CodeActionKind, CodeActionOrCommand, Range, TextEdit, WorkspaceEdit};

use super::document::Document;
use super::{allowances, diagnostics};

/// Maximum number of fixes tested per request.
const MOST: usize = 16;

/// Quick fixes for a range of a document.
pub(super) fn of(document: &Document, range: Range, context: &CodeActionContext) -> Option<Vec<CodeActionOrCommand>> {
    let wanted = |kind: &CodeActionKind| kind.as_str().is_empty() || *kind == CodeActionKind::QUICKFIX;
    if context.only.as_ref().is_some_and(|only| !only.iter().any(wanted)) {
        return Some(Vec::new());
    }
    let syntax = document.syntax()?;
    let report = compiled(document, document.text.as_str())?;
    let (from, to) = (document.text.byte(range.start), document.text.byte(range.end));
    let mut actions = Vec::new();
    let here = report.diagnostics.iter().filter(|d| {
        let at = d.primary.span.range();
        d.primary.span.source.0 == 0 && at.start <= to && from <= at.end
    });
    let mut tried = 0;
    for d in here {
        let mut preferred = true;
        let allow = allowances::fix(document.text.as_str(), syntax, d);
        let fixes = d.fixes.iter().chain(&allow);
        for fix in fixes.filter(|fix| fix.edits().iter().all(|edit| edit.span.source.0 == 0)) {
            tried += 1;
            if tried > MOST || !mends(document, &report, d, fix) {
                continue;
            }
            let edits = fix.edits().iter().map(|e| TextEdit::new(document.text.range(e.span.range()), e.new.clone()));
            actions.push(CodeActionOrCommand::CodeAction(CodeAction {
                title: fix.title().into_owned(),
                kind: Some(CodeActionKind::QUICKFIX),
                diagnostics: Some(vec![diagnostics::one(document, &report, d)]),
                edit: Some(WorkspaceEdit::new([(document.uri.clone(), edits.collect())].into_iter().collect())),
                is_preferred: Some(preferred && !d.fixes.is_empty()),
                ..CodeAction::default()
            }));
            preferred = false;
        }
    }
    Some(actions)
}

/// Report for a text in place of the document's text.
fn compiled(document: &Document, text: &str) -> Option<Report> {
    let syntax = document.syntax()?;
    let folder = document.folder();
    let input = Input { name: "", text, syntax, folder, set: &[], package_paths: &[] };
    Some(compiler::compile_among(&input, &document.library().texts()).report)
}

/// True if a fix removes its mistake and adds no syntax error.
fn mends(document: &Document, before: &Report, d: &Diagnostic, fix: &Fix) -> bool {
    let (text, _) = dsl::fix::apply(document.text.as_str(), [fix]);
    let Some(after) = compiled(document, &text) else { return false };
    let same =
        |report: &Report| report.diagnostics.iter().filter(|o| o.code == d.code && o.message == d.message).count();
    let of_form = |report: &Report| {
        let is_form = |o: &&Diagnostic| o.severity == Severity::Error && dsl::codes::explain(o.code).is_some();
        report.diagnostics.iter().filter(is_form).count()
    };
    same(&after) < same(before) && of_form(&after) <= of_form(before)
}
