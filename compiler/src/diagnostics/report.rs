//! All diagnostics of a compilation, as text for people and as JSON for programs.

use std::collections::BTreeMap;

use dsl::{Applicability, Diagnostic, Label, Severity, Sources, Span};
use miette::{GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteDiagnostic, Report as Miette};
use serde_json::{Value as Json, json};

use crate::diagnostics::allowances::Allowed;
use crate::diagnostics::window::Window;

/// Maximum number of uses shown with a diagnostic.
const USES: usize = 4;

/// Diagnostics, with the sources that their spans refer to.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Errors and warnings in source order.
    pub diagnostics: Vec<Diagnostic>,
    /// Warnings that the spec allows, in source order.
    pub allowed: Vec<Allowed>,
    /// Sources.
    pub sources: Sources,
}

/// Maximum number of diagnostics in a report; one more reports the number left out.
pub const MOST_SHOWN: usize = 200;

/// Maximum length of a line that is drawn.
const LONGEST_LINE: usize = 2_000;

/// Labels at most this many lines above the primary place are drawn in the same picture.
const LINES_ABOVE: usize = 1;

/// Style of the text output.
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

    /// Maps spans inside instances to the original text, with labels for the uses that led there; sorts diagnostics by
    /// place, errors first; and removes duplicates, including those from several uses.
    pub fn finish(&mut self) {
        self.settle();
        self.diagnostics.sort_by_key(|d| (d.primary.span.source, d.primary.span.start, d.severity, d.code));
        self.diagnostics.dedup();
        if self.diagnostics.len() > MOST_SHOWN {
            self.shorten();
        }
    }

    /// Keeps the first [`MOST_SHOWN`] diagnostics, errors before warnings, and reports the number left out.
    fn shorten(&mut self) {
        let warnings = MOST_SHOWN.saturating_sub(self.errors());
        let (mut errors, mut kept) = (0, 0);
        let all = self.diagnostics.len();
        let mut last = None;
        self.diagnostics.retain(|d| {
            let (count, most) = match d.severity {
                Severity::Error => (&mut errors, MOST_SHOWN),
                Severity::Warning => (&mut kept, warnings),
            };
            *count += 1;
            let keep = *count <= most;
            if keep {
                last = Some((d.primary.span, d.severity));
            }
            keep
        });
        let left = all - self.diagnostics.len();
        if let Some((span, severity)) = last {
            let more = Diagnostic::error("HQ0192", span, format!("{left} more are not shown"))
                .help("fix the first errors; the others may be consequences");
            self.diagnostics.push(Diagnostic { severity, ..more });
        }
    }

    /// Maps spans and merges duplicates, see [`Report::finish`].
    fn settle(&mut self) {
        let mut settled: Vec<(Diagnostic, Vec<Vec<Label>>)> = Vec::new();
        let mut known: BTreeMap<(Span, &'static str, String), Vec<usize>> = BTreeMap::new();
        for mut d in std::mem::take(&mut self.diagnostics) {
            let spans: Vec<Span> = std::iter::once(d.primary.span).chain(d.labels.iter().map(|l| l.span)).collect();
            d.primary.span = self.sources.real(d.primary.span);
            for l in &mut d.labels {
                l.span = self.sources.real(l.span);
            }
            let mut uses: Vec<Label> = Vec::new();
            for (span, what) in spans.iter().flat_map(|s| self.sources.uses(s.source, USES)) {
                let known = d.primary.span == span || d.labels.iter().chain(&uses).any(|l| l.span == span);
                if !known {
                    uses.push(Label { span, text: what.to_string() });
                }
            }
            let alike = known.entry((d.primary.span, d.code, d.message.clone())).or_default();
            match alike.iter().copied().find(|&i| settled[i].0 == d) {
                Some(i) => {
                    // Keep only minimal sets of uses: a use that was added to a failing set is not the cause.
                    let among = |few: &[Label], many: &[Label]| few.iter().all(|l| many.contains(l));
                    let others = &mut settled[i].1;
                    if !others.iter().any(|o| among(o, &uses)) {
                        others.retain(|o| !among(&uses, o));
                        others.push(uses);
                    }
                }
                None => {
                    alike.push(settled.len());
                    settled.push((d, vec![uses]));
                }
            }
        }
        self.diagnostics = settled
            .into_iter()
            .map(|(mut d, all)| {
                let mut uses: Vec<Label> = Vec::new();
                for label in all.into_iter().flatten() {
                    if !uses.contains(&label) {
                        uses.push(label);
                    }
                }
                if uses.len() > USES {
                    d.notes.push(format!("the same applies to {} more uses", uses.len() - USES));
                    uses.truncate(USES);
                }
                d.labels.extend(uses);
                d
            })
            .collect();
    }

    /// Renders all diagnostics as text.
    ///
    /// Colours come only from the style: in quoted text, ASCII SUBSTITUTE replaces each ESCAPE.
    pub fn render(&self, style: Style, width: usize) -> String {
        let mut out = String::new();
        for d in &self.diagnostics {
            out.push_str(&self.render_one(d, style, width));
            out.push('\n');
        }
        out
    }

    /// Renders the warnings that are allowed, each with its place and the reason: `SPEC:12:5: HQ0606, this ..`.
    pub fn render_allowed(&self) -> String {
        let line = |a: &Allowed| {
            let (line, column) = self.sources.line_column(a.place.source, a.place.start);
            let name = self.sources.get(a.place.source).map_or("?", |s| s.name.as_str());
            let text = format!("{name}:{line}:{column}: allowed {}, {}\n  {}\n", a.code, a.message, a.reason);
            colourless(&text)
        };
        self.allowed.iter().map(line).collect()
    }

    /// Returns true if a label is drawn in the picture of the primary place. A picture starts at its topmost label, so
    /// a label far above would push the primary place out of sight. Such labels follow in pictures of their own.
    fn beside(&self, primary: Span, label: &Label) -> bool {
        let line = |byte: u32| self.sources.line_column(primary.source, byte).0;
        label.span.source == primary.source && line(label.span.end) + LINES_ABOVE >= line(primary.start)
    }

    /// Renders the message with its place, then labels in other files and far above, then notes, then the help.
    fn render_one(&self, d: &Diagnostic, style: Style, width: usize) -> String {
        let theme = match style {
            Style::Terminal => GraphicalTheme::unicode(),
            Style::Plain => GraphicalTheme::unicode_nocolor(),
        };
        let head = theme.styles.help;
        let handler = GraphicalReportHandler::new_themed(theme).with_width(width).with_links(false);
        let severity = match d.severity {
            Severity::Error => miette::Severity::Error,
            Severity::Warning => miette::Severity::Warning,
        };
        let (here, elsewhere): (Vec<&Label>, Vec<&Label>) =
            d.labels.iter().partition(|l| self.beside(d.primary.span, l));
        let mut out =
            self.snippet(&handler, Some(d.code), severity, &colourless(&clipped(&d.message)), &d.primary, &here);
        for l in elsewhere {
            let place = Label { span: l.span, text: String::new() };
            out.push_str(&self.snippet(&handler, None, miette::Severity::Advice, &colourless(&l.text), &place, &[]));
        }
        let help = d.help.as_deref().map(|help| ("help", help));
        let notes = d.notes.iter().map(|note| ("note", note.as_str())).chain(help);
        for (word, text) in notes {
            let first = format!("  {}: ", head.style(word));
            let lines = wrapped(&colourless(&clipped(text)), width.saturating_sub(word.len() + 4));
            out.push_str(&first);
            out.push_str(&lines.join(&format!("\n{}", " ".repeat(word.len() + 4))));
            out.push('\n');
        }
        out
    }

    /// Renders a message with the source text that it refers to.
    fn snippet(
        &self,
        handler: &GraphicalReportHandler,
        code: Option<&str>,
        severity: miette::Severity,
        message: &str,
        primary: &Label,
        others: &[&Label],
    ) -> String {
        // An empty text has no line to show; the message names the file.
        let source = self.sources.get(primary.span.source).filter(|s| !s.text.trim().is_empty());
        let length = source.map_or(0, |s| s.text.len());
        let label = |l: &Label, new: fn(Option<String>, std::ops::Range<usize>) -> LabeledSpan| {
            let start = (l.span.start as usize).min(length);
            let text = (!l.text.is_empty()).then(|| colourless(&l.text));
            new(text, start..(l.span.end as usize).clamp(start, length))
        };
        // If labelled parts cover the primary span, its underline without a text would only run through them.
        let parts = |l: &&Label| primary.span.start <= l.span.start && l.span.end <= primary.span.end;
        let bare = primary.text.is_empty() && others.iter().any(parts);
        let labels = (!bare && source.is_some())
            .then(|| label(primary, LabeledSpan::new_primary_with_span))
            .into_iter()
            .chain(others.iter().filter(|_| source.is_some()).map(|l| label(l, LabeledSpan::new_with_span)));
        let mut shown = MietteDiagnostic::new(message).with_labels(labels).with_severity(severity);
        if let Some(code) = code {
            shown = shown.with_code(code);
        }
        let mut report = Miette::new(shown);
        let mut drawn = true;
        if let Some(s) = source {
            let spans = others.iter().map(|l| l.span.range()).chain([primary.span.range()]);
            let window = Window::around(s, spans);
            drawn = window.text.lines().all(|l| l.len() <= LONGEST_LINE);
            if drawn {
                report = report.with_source_code(window);
            }
        }
        let mut out = String::new();
        if !drawn || handler.render_report(&mut out, report.as_ref()).is_err() {
            // A place that cannot be drawn, in an empty text or in a very long line, is still named.
            let (line, column) = self.sources.line_column(primary.span.source, primary.span.start);
            let name = colourless(source.map_or("?", |s| s.name.as_str()));
            out = format!("{}\n\n  {message}\n   {name}:{line}:{column}\n", code.unwrap_or(""));
        }
        let empty = self.sources.get(primary.span.source).filter(|s| source.is_none() && !message.contains(&s.name));
        if let Some(s) = empty {
            out.push_str(&format!("   {}\n", colourless(&s.name)));
        }
        out
    }

    /// Returns all diagnostics as data: `{"version":1,"errors":n,"warnings":n,"diagnostics":[..],"allowed":[..]}`.
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
                "help": d.help.as_deref(),
                "fixes": d.fixes.iter().map(|fix| json!({
                    "title": fix.title(),
                    "certain": fix.applicability == Applicability::Certain,
                    "edits": fix.edits().iter().map(|e| json!({"place": place(e.span), "new": e.new})).collect::<Vec<_>>(),
                })).collect::<Vec<_>>(),
            })
        };
        json!({
            "version": 1,
            "errors": self.errors(),
            "warnings": self.warnings(),
            "diagnostics": self.diagnostics.iter().map(one).collect::<Vec<_>>(),
            "allowed": self.allowed.iter().map(|a| json!({
                "code": a.code, "message": a.message, "place": place(a.place), "reason": a.reason, "by": place(a.by),
            })).collect::<Vec<_>>(),
        })
    }
}

/// Clips a text to a readable length; names can be extremely long.
fn clipped(text: &str) -> std::borrow::Cow<'_, str> {
    match text.char_indices().nth(LONGEST_LINE) {
        Some((end, _)) => format!("{}..", &text[..end]).into(),
        None => text.into(),
    }
}

/// Replaces ESCAPE, so that a text cannot start a colour. The substitute has the same length, so offsets stay valid.
pub(crate) fn colourless(text: &str) -> String {
    text.replace('\u{1b}', "\u{1a}")
}

fn severity(s: Severity) -> &'static str {
    match s {
        Severity::Error => "error",
        Severity::Warning => "warning",
    }
}

/// Wraps a text to lines of at most `width` characters; line breaks of the text are kept.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for paragraph in text.lines() {
        let mut line = String::new();
        for word in paragraph.split(' ') {
            if !line.is_empty() && line.chars().count() + 1 + word.chars().count() > width {
                lines.push(std::mem::take(&mut line));
            }
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
        lines.push(line);
    }
    lines
}
