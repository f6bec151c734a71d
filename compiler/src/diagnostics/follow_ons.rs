//! Removes diagnostics that only follow from a syntax error.
//!
//! The parser continues behind text that it cannot read. Declarations that are missing afterwards are missing for that
//! reason alone: the stack whose line was not understood, the task inside it. Such messages would send the reader to
//! places where nothing is wrong. Those with another cause return at the next check.

use std::collections::BTreeSet;

use dsl::tree::Spec;
use dsl::{Diagnostic, Severity, Sources, Span};

/// Removes the diagnostics that follow from the first `form` ones, which are the parser's syntax errors. A missing or
/// outdated header has no consequences. Unused names are not reported if a key is unknown, because the block of that
/// key was not read.
pub(crate) fn remove(diagnostics: &mut Vec<Diagnostic>, form: usize, spec: &Spec, sources: &Sources) {
    let slip = |d: &Diagnostic| matches!(d.code, "HQ0132" | "HQ0145" | "HQ0205");
    if diagnostics.iter().any(slip) {
        diagnostics.retain(|d| d.code != "HQ0203");
    }
    let errors: Vec<Span> = diagnostics
        .iter()
        .take(form)
        .filter(|d| d.severity == Severity::Error && !matches!(d.code, "HQ0101" | "HQ0102"))
        .map(|d| d.primary.span)
        .collect();
    if errors.is_empty() {
        return;
    }
    let inside =
        |outer: Span, inner: Span| outer.source == inner.source && outer.start <= inner.start && inner.end <= outer.end;
    let lost = errors.iter().any(|e| !spec.items.iter().any(|i| inside(i.span, *e)));
    // A word in unread text may be the name or the key that is missing elsewhere.
    let unread: BTreeSet<&str> = spec.unread.iter().flat_map(|s| words(sources.snippet(*s))).collect();
    // `sin(2 pi t)`: if the arguments of a call cannot be read, its bare name is left in the tree.
    let called = |at: Span| {
        let behind = Span { start: at.end, end: at.end.saturating_add(1), ..at };
        sources.snippet(behind) == "("
    };
    let follows = |d: &Diagnostic| {
        let at = d.primary.span;
        // A value with an unreadable part.
        let broken = !at.is_empty() && errors.iter().any(|e| inside(at, *e));
        let own = spec.items.iter().find(|i| inside(i.span, at));
        let damaged = own.is_some_and(|i| errors.iter().any(|e| inside(i.span, *e)));
        match d.code {
            "HQ0203" => true,
            "HQ0201" | "HQ0206" if called(at) => true,
            "HQ0201" => broken || unread.contains(sources.snippet(at)),
            "HQ0206" => broken || (lost && at.is_empty()) || quoted(&d.message).any(|key| unread.contains(key)),
            "HQ0601" | "HQ0603" | "HQ0901" => lost || damaged,
            _ => broken,
        }
    };
    let mut index = 0;
    diagnostics.retain(|d| {
        index += 1;
        index <= form || !follows(d)
    });
}

/// Splits a text into words.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|w| !w.is_empty())
}

/// Parts of a message between backticks.
fn quoted(message: &str) -> impl Iterator<Item = &str> {
    message.split('`').skip(1).step_by(2)
}
