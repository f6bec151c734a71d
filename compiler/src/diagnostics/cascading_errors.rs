//! Removes diagnostics that only follow from a syntax error.
//!
//! The parser continues behind text that it cannot read. Declarations that are missing afterwards are missing for that
//! reason alone: the stack whose line was not understood, the task inside it. Such messages would send the reader to
//! places where nothing is wrong. Those with another cause return at the next check.

use std::collections::BTreeSet;

use dsl::tree::Spec;
use dsl::{Diagnostic, Severity, Sources, Span, Topic};

/// Removes the diagnostics that follow from the first `form` ones, which are the parser's syntax errors. A missing or
/// outdated header has no consequences. Unused names are not reported if a key is unknown, because the block of that
/// key was not read.
pub(crate) fn remove(diagnostics: &mut Vec<Diagnostic>, form: usize, spec: &Spec, sources: &Sources) {
    if diagnostics.iter().any(|d| d.topic == Topic::UnknownKey) {
        diagnostics.retain(|d| d.topic != Topic::Unused);
    }
    merge_unusual(diagnostics);
    let errors: Vec<Span> = diagnostics
        .iter()
        .take(form)
        .filter(|d| d.severity == Severity::Error && d.topic != Topic::Header)
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
        match &d.topic {
            Topic::Unused => true,
            Topic::UnknownName | Topic::MissingKeys(_) if called(at) => true,
            Topic::UnknownName => broken || unread.contains(sources.snippet(at)),
            Topic::MissingKeys(keys) => broken || keys.iter().any(|key| unread.contains(key.as_str())),
            Topic::MissingRobot => lost,
            Topic::MissingStack | Topic::MissingDeclaration => {
                let own = spec.items.iter().find(|i| inside(i.span, at));
                lost || own.is_some_and(|i| errors.iter().any(|e| inside(i.span, *e)))
            }
            _ => broken,
        }
    };
    let mut index = 0;
    diagnostics.retain(|d| {
        index += 1;
        index <= form || !follows(d)
    });
}

/// Removes the remarks on the size of a number about which another diagnostic speaks, which takes over their fixes.
fn merge_unusual(diagnostics: &mut Vec<Diagnostic>) {
    let unusual = |d: &Diagnostic| d.topic == Topic::UnusualSize;
    let others: BTreeSet<Span> = diagnostics.iter().filter(|d| !unusual(d)).map(|d| d.primary.span).collect();
    let merged: Vec<Diagnostic> =
        diagnostics.extract_if(.., |d| unusual(d) && others.contains(&d.primary.span)).collect();
    for Diagnostic { primary, fixes, .. } in merged {
        if let Some(other) = diagnostics.iter_mut().find(|d| d.primary.span == primary.span) {
            other.fixes.extend(fixes);
        }
    }
}

/// Splits a text into words.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|w| !w.is_empty())
}
