//! Converts the compiler's diagnostics to those of the editor.

use compiler::{Input, Report};
use dsl::tree::{Item, ItemKind};
use dsl::{Diagnostic, Label, Severity, SourceId, Span, Topic};
use lsp_types::{
    Diagnostic as Shown, DiagnosticRelatedInformation, DiagnosticSeverity, Location, NumberOrString, Range, Uri,
};

use super::document::Document;
use super::text::Text;
use super::uri;

/// Compiles a document and returns its diagnostics; none if it is not a spec.
pub(super) fn of(document: &Document) -> Vec<Shown> {
    let Some(syntax) = document.syntax() else { return Vec::new() };
    let name = document.path.as_ref().map_or_else(|| document.uri.to_string(), |p| p.display().to_string());
    let input = Input {
        name: &name,
        text: document.text.as_str(),
        syntax,
        folder: document.folder(),
        set: &[],
        package_paths: &[],
    };
    let compiled = compiler::compile_among(&input, &document.library().texts());
    let report = &compiled.report;
    let others = others(document, report);
    report.diagnostics.iter().map(|d| shown(document, report, &others, d)).collect()
}

/// Converts one diagnostic of a document's report.
pub(super) fn one(document: &Document, report: &Report, d: &Diagnostic) -> Shown {
    shown(document, report, &others(document, report), d)
}

/// Texts of a report, by source; `None` for the document itself, and for texts without a file.
fn others(document: &Document, report: &Report) -> Vec<Option<(Uri, Text)>> {
    report.sources.iter().map(|(id, s)| other(document, id, &s.name, &s.text)).collect()
}

/// Address and text of another file with diagnostics.
fn other(document: &Document, id: SourceId, name: &str, text: &str) -> Option<(Uri, Text)> {
    let path = document.folder().join(name);
    if id.0 == 0 || !path.is_file() {
        return None;
    }
    Some((uri::of(&path)?, Text::new(text.to_string())))
}

fn shown(document: &Document, report: &Report, others: &[Option<(Uri, Text)>], d: &Diagnostic) -> Shown {
    let own = |span: Span| (span.source.0 == 0).then(|| document.text.range(span.range()));
    let location = |span: Span| match own(span) {
        Some(range) => Some(Location::new(document.uri.clone(), range)),
        None => {
            let (uri, text) = others.get(span.source.0 as usize)?.as_ref()?;
            Some(Location::new(uri.clone(), text.range(span.range())))
        }
    };
    let mut message = d.message.clone();
    if !d.primary.text.is_empty() {
        message.push_str(&format!("\nhere: {}", d.primary.text));
    }
    for note in &d.notes {
        message.push_str(&format!("\nnote: {note}"));
    }
    if let Some(help) = &d.help {
        message.push_str(&format!("\nhelp: {help}"));
    }
    let related = |label: &Label, text: &str| {
        Some(DiagnosticRelatedInformation { location: location(label.span)?, message: text.to_string() })
    };
    let mut places: Vec<DiagnosticRelatedInformation> = Vec::new();
    let range = match own(d.primary.span) {
        Some(range) => range,
        // A mistake in another file is shown where this document refers to it, with a link to the place itself.
        None => {
            places.extend(related(&d.primary, &d.message));
            let (line, column) = report.sources.line_column(d.primary.span.source, d.primary.span.start);
            if let Some(source) = report.sources.get(d.primary.span.source).filter(|_| !places.is_empty()) {
                message.push_str(&format!("\nin {}:{line}:{column}", source.name));
            }
            let label = d.labels.iter().find_map(|l| own(l.span));
            label.or_else(|| urdf_value(document)).unwrap_or_default()
        }
    };
    let severity = match d.severity {
        Severity::Error if lacks_only_what_others_have(document, d) => {
            message.push_str("\nnote: a file that others import from needs none");
            DiagnosticSeverity::INFORMATION
        }
        Severity::Error => DiagnosticSeverity::ERROR,
        Severity::Warning => DiagnosticSeverity::WARNING,
    };
    places.extend(d.labels.iter().filter_map(|l| related(l, if l.text.is_empty() { "here" } else { &l.text })));
    Shown {
        range,
        severity: Some(severity),
        code: Some(NumberOrString::String(d.code.to_string())),
        source: Some("hierarq".to_string()),
        message,
        related_information: (!places.is_empty()).then_some(places),
        ..Shown::default()
    }
}

/// True if a stack or robot is missing in a file with declarations, but no stack and no run: others may import it.
fn lacks_only_what_others_have(document: &Document, d: &Diagnostic) -> bool {
    let lacks = matches!(d.topic, Topic::MissingRobot | Topic::MissingStack);
    lacks && document.spec().is_some_and(|spec| !spec.items.is_empty() && !spec.items.iter().any(runs))
}

/// True for a stack or a run, and for a repetition of these.
fn runs(item: &Item) -> bool {
    match &item.kind {
        ItemKind::Stack(_) | ItemKind::Run(_) => true,
        ItemKind::For(repeat) => repeat.body.iter().any(runs),
        _ => false,
    }
}

/// Range of the spec's URDF path.
fn urdf_value(document: &Document) -> Option<Range> {
    let robots = document.spec()?.items.iter().filter_map(|item| match &item.kind {
        ItemKind::Robot(robot) => robot.body.get("urdf"),
        _ => None,
    });
    let path = robots.map(|e| e.value.span).next()?;
    Some(document.text.range(path.range()))
}
