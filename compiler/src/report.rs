//! All diagnostics of a compilation, as text for people and as JSON for programs.

use dsl::{Diagnostic, Severity, Sources, Span};
use miette::{GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteDiagnostic, NamedSource, Report as Miette};
use serde_json::{Value as Json, json};

/// Diagnostics with the texts that they point into.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Errors and warnings in the order of the text.
    pub diagnostics: Vec<Diagnostic>,
    /// The texts.
    pub sources: Sources,
}

/// How text output looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Colours and box-drawing characters.
    Terminal,
    /// Box-drawing characters, no colours: files, CI.
    Plain,
}

impl Report {
    /// Number of errors.
    pub fn errors(&self) -> usize {
        self.diagnostics.iter().filter(|d| d.severity == Severity::Error).count()
    }

    /// Number of warnings.
    pub fn warnings(&self) -> usize {
        self.diagnostics.len() - self.errors()
    }

    /// Sorts diagnostics by place, errors of one place first, and drops exact repetitions.
    pub fn finish(&mut self) {
        self.diagnostics.sort_by_key(|d| (d.primary.span.source, d.primary.span.start, d.severity, d.code));
        self.diagnostics.dedup();
    }

    /// All diagnostics as text.
    pub fn render(&self, style: Style, width: usize) -> String {
        let mut out = String::new();
        for d in &self.diagnostics {
            out.push_str(&self.render_one(d, style, width));
            out.push('\n');
        }
        out
    }

    fn render_one(&self, d: &Diagnostic, style: Style, width: usize) -> String {
        let theme = match style {
            Style::Terminal => GraphicalTheme::unicode(),
            Style::Plain => GraphicalTheme::unicode_nocolor(),
        };
        let handler = GraphicalReportHandler::new_themed(theme).with_width(width).with_links(false);
        let mut out = String::new();
        let shown = miette_of(d, &self.sources);
        // Writing to a String does not fail.
        let _ = handler.render_report(&mut out, shown.as_ref());
        let other: Vec<&dsl::Label> = d.labels.iter().filter(|l| l.span.source != d.primary.span.source).collect();
        for label in other {
            let (line, column) = self.sources.line_column(label.span.source, label.span.start);
            let name = self.sources.get(label.span.source).map_or("?", |s| s.name.as_str());
            out.push_str(&format!("   see {name}:{line}:{column}: {}\n", label.text));
        }
        for note in &d.notes {
            out.push_str(&format!("  why: {note}\n"));
        }
        out
    }

    /// All diagnostics as data: `{"version":1,"errors":n,"warnings":n,"diagnostics":[..]}`.
    pub fn to_json(&self) -> Json {
        let place = |span: Span| {
            let (line, column) = self.sources.line_column(span.source, span.start);
            let (end_line, end_column) = self.sources.line_column(span.source, span.end);
            json!({
                "file": self.sources.get(span.source).map(|s| s.name.clone()),
                "start": span.start, "end": span.end,
                "line": line, "column": column, "end_line": end_line, "end_column": end_column,
            })
        };
        let one = |d: &Diagnostic| {
            json!({
                "code": d.code,
                "severity": severity(d.severity),
                "message": d.message,
                "place": place(d.primary.span),
                "label": d.primary.text,
                "labels": d.labels.iter().map(|l| json!({"place": place(l.span), "text": l.text})).collect::<Vec<_>>(),
                "notes": d.notes,
                "help": d.help,
            })
        };
        json!({
            "version": 1,
            "errors": self.errors(),
            "warnings": self.warnings(),
            "diagnostics": self.diagnostics.iter().map(one).collect::<Vec<_>>(),
        })
    }
}

fn severity(s: Severity) -> &'static str {
    match s {
        Severity::Error => "error",
        Severity::Warning => "warning",
    }
}

fn miette_of(d: &Diagnostic, sources: &Sources) -> Miette {
    let range = |span: Span| {
        let length = sources.get(span.source).map_or(0, |s| s.text.len());
        let start = (span.start as usize).min(length);
        start..(span.end as usize).clamp(start, length)
    };
    let primary = LabeledSpan::new_primary_with_span(
        (!d.primary.text.is_empty()).then(|| d.primary.text.clone()),
        range(d.primary.span),
    );
    let others = d.labels.iter().filter(|l| l.span.source == d.primary.span.source);
    let labels =
        std::iter::once(primary).chain(others.map(|l| LabeledSpan::new_with_span(Some(l.text.clone()), range(l.span))));
    let mut shown = MietteDiagnostic::new(d.message.clone()).with_code(d.code).with_labels(labels).with_severity(
        match d.severity {
            Severity::Error => miette::Severity::Error,
            Severity::Warning => miette::Severity::Warning,
        },
    );
    if let Some(help) = &d.help {
        shown = shown.with_help(help.clone());
    }
    let report = Miette::new(shown);
    match sources.get(d.primary.span.source) {
        Some(s) => report.with_source_code(NamedSource::new(s.name.clone(), s.text.clone())),
        None => report,
    }
}
