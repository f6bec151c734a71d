//! Moves errors that a value from the command line causes from the place of use to that value.

use std::collections::BTreeSet;

use dsl::{Diagnostic, Severity, Sources, Span};

use crate::input::{Compiled, Input};

/// Moves errors that occur only with the values of `--set` to the value that causes them, if it is unique. The text of
/// the former place becomes a label. Returns true if an error was moved.
pub(crate) fn attribute_errors(
    compile: fn(&Input) -> Compiled,
    input: &Input,
    diagnostics: &mut [Diagnostic],
    sources: &Sources,
) -> bool {
    let is_error = |d: &Diagnostic| d.severity == Severity::Error;
    if input.set.is_empty() || !diagnostics.iter().any(is_error) {
        return false;
    }
    let mut moved = false;
    let given: Vec<(&str, Span)> =
        input.set.iter().filter_map(|(n, text)| Some((&**n, place(n, text, sources)?))).collect();
    let own = compile(&Input { set: &[], ..input.clone() }).report;
    let key = |d: &Diagnostic, sources: &Sources| {
        let Span { source, start, end } = d.primary.span;
        (d.code, sources.get(source).map_or_else(String::new, |s| s.name.clone()), start, end)
    };
    let known: BTreeSet<_> = own.diagnostics.iter().map(|d| key(d, &own.sources)).collect();
    for d in diagnostics.iter_mut().filter(|d| is_error(d)) {
        let at = d.primary.span;
        if known.contains(&key(d, sources)) || given.iter().any(|(_, g)| g.source == at.source) {
            continue;
        }
        let used: BTreeSet<&str> = words(sources.snippet(at)).collect();
        let mut named = given.iter().filter(|(name, _)| used.contains(name)).map(|(_, span)| *span);
        let only = match given.as_slice() {
            [(_, span)] => Some(*span),
            _ => None,
        };
        let Some(value) = named.next().filter(|_| named.next().is_none()).or(only) else { continue };
        let used = std::mem::take(&mut d.primary.text);
        let used = if used.is_empty() { "used here".to_string() } else { format!("used here: {used}") };
        // They would change the text of the spec.
        d.fixes.clear();
        d.labels.push(dsl::Label { span: at, text: used });
        d.primary = dsl::Label { span: value, text: "given on the command line".to_string() };
        moved = true;
    }
    moved
}

/// Span of the value of a `--set`.
fn place(name: &str, text: &str, sources: &Sources) -> Option<Span> {
    let title = format!("--set {name}={text}");
    let (id, source) = sources.iter().find(|(_, s)| s.name == title)?;
    let end = source.text.trim_end().len();
    Some(Span::new(id, (source.text.len() - 1).checked_sub(text.len())?, end))
}

/// Splits a text into words.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|w| !w.is_empty())
}
