//! Helpers of the tests: rendering of diagnostics, the example spec in both syntaxes.

pub mod trees;

use hierarq_dsl::tree::Spec;
use hierarq_dsl::{Diagnostic, SourceId, Sources, Syntax, parse};

/// Every feature of the language once.
pub const HQ: &str = include_str!("example.hq");
/// The same spec.
pub const YAML: &str = include_str!("example.yaml");

/// Reads a text that must be free of mistakes.
pub fn good(text: &str, syntax: Syntax) -> Spec {
    let (spec, diags) = parse(SourceId(0), text, syntax);
    assert!(diags.is_empty(), "{}\n---\n{text}", render(text, &diags));
    spec
}

/// Diagnostics as text: code, place, the underlined source, labels, notes, help.
pub fn render(text: &str, diags: &[Diagnostic]) -> String {
    let mut sources = Sources::default();
    let id = sources.add("spec", text);
    let mut out = String::new();
    for d in diags {
        let (line, column) = sources.line_column(id, d.primary.span.start);
        out.push_str(&format!("{} at {line}:{column}: {}\n", d.code, d.message));
        out.push_str(&underlined(text, d.primary.span.range(), line, &d.primary.text));
        for label in &d.labels {
            let (line, column) = sources.line_column(id, label.span.start);
            out.push_str(&format!("  and {line}:{column}: {}\n", label.text));
            out.push_str(&underlined(text, label.span.range(), line, ""));
        }
        for note in &d.notes {
            out.push_str(&format!("  note: {note}\n"));
        }
        if let Some(help) = &d.help {
            out.push_str(&format!("  help: {help}\n"));
        }
    }
    out
}

fn underlined(text: &str, range: std::ops::Range<usize>, line: usize, label: &str) -> String {
    let source = text.lines().nth(line - 1).unwrap_or("");
    let start = text[..range.start].rfind('\n').map_or(0, |n| n + 1);
    let before = text[start..range.start].chars().count();
    let marked = text[range.clone()].lines().next().unwrap_or("").chars().count().max(1);
    let more = if text[range].trim_end().contains('\n') { " .." } else { "" };
    format!("  | {source}\n  | {}{}{more} {label}\n", " ".repeat(before), "^".repeat(marked))
        .lines()
        .map(|l| format!("{}\n", l.trim_end()))
        .collect()
}
