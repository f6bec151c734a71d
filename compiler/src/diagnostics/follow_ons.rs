//! What only follows from a mistake of form is not told beside it.
//!
//! The reader goes on behind text that it could not read, and what is missing then is missing for that reason alone:
//! the stack whose line was not understood, the task that stood in it. Such messages would send the reader of a
//! report to places where nothing is wrong. They come back with the next check, if they were about more than that.

use std::collections::BTreeSet;

use dsl::tree::Spec;
use dsl::{Diagnostic, Severity, Sources, Span};

/// Removes those diagnostics behind the first `form` ones (of the reader, about form) that follow from them.
/// A header that is missing or new costs nothing else. That nothing uses a name is not said where a key is unknown, and
/// so what stands behind it was not read.
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
    // A word of text that was not read may be the name or the key that is missing elsewhere.
    let unread: BTreeSet<&str> = spec.unread.iter().flat_map(|s| words(sources.snippet(*s))).collect();
    // `sin(2 pi t)`: the name of a call whose arguments could not be read stands alone in the tree.
    let called = |at: Span| {
        let behind = Span { start: at.end, end: at.end.saturating_add(1), ..at };
        sources.snippet(behind) == "("
    };
    let follows = |d: &Diagnostic| {
        let at = d.primary.span;
        // A value in which something could not be read.
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

/// The words of a text.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|w| !w.is_empty())
}

/// What stands between backticks in a message.
fn quoted(message: &str) -> impl Iterator<Item = &str> {
    message.split('`').skip(1).step_by(2)
}
