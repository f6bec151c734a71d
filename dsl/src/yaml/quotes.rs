//! Values that need quotes in YAML: `[up(tool, 3 /s)]`, which YAML splits at the comma, and `[0.5, 0, 0.4] m`, which it
//! parses as a sequence followed by text. Each gets one diagnostic, and is read as if the quotes were there.

use std::ops::Range;

use pest::Parser;

use super::events::{Kind, Node, NodeId, Style};
use super::syntax::line_of;
use crate::diagnostic::clip;
use crate::fix::Fix;
use crate::grammar::{Grammar, Rule};
use crate::limits::MAX_DEPTH;
use crate::{Diagnostic, SourceId, Span};

/// Maximum length of a value that is examined, in bytes.
const MAX_LENGTH: usize = 2000;

/// Quotes a value.
fn quoted(value: &str) -> String {
    if value.contains(['"', '\\']) { format!("'{}'", value.replace('\'', "''")) } else { format!("\"{value}\"") }
}

/// Returns the diagnostic for a value without the quotes that it needs.
fn diagnostic(source: SourceId, place: Range<usize>, value: &str, why: &str) -> Diagnostic {
    let text = format!("`{}` needs quotes", clip(value));
    let (span, quoted) = (Span::new(source, place.start, place.end), quoted(value));
    Diagnostic::error("HQ0137", span, text)
        .note(why)
        .help(format!("put quotes around it: `{quoted}`"))
        .fix(Fix::edit("Put it in quotes", span, quoted).certain())
}

/// Returns the diagnostic for a mapping in place of a text: an unquoted `The middle: of the table` is a mapping too.
pub(super) fn no_text(key: &str, text: &str, span: Span) -> Diagnostic {
    let raw = text.get(span.range()).unwrap_or("").trim_end();
    let diagnostic = Diagnostic::error("HQ0119", span, format!("`{}` takes a text, not a mapping", clip(key)));
    if raw.starts_with('{') || raw.contains('\n') {
        return diagnostic.help("write the text in quotes");
    }
    let why = "without quotes YAML reads the text before `: ` as a key";
    let raw = quoted(raw);
    diagnostic.note(why).help(format!("put quotes around it: `{raw}`")).fix(Fix::edit("Put it in quotes", span, raw))
}

/// Returns true if a text is a complete value or task.
fn reads(text: &str) -> bool {
    let deep = text.bytes().filter(|b| matches!(b, b'(' | b'[' | b'{')).count() > MAX_DEPTH;
    let whole = |rule: Rule| {
        let Some(parsed) = Grammar::parse(rule, text).ok().and_then(|mut p| p.next()) else { return false };
        let known = |rule: Rule| matches!(rule, Rule::within | Rule::name | Rule::actuals);
        let read: usize =
            parsed.into_inner().take_while(|p| known(p.as_rule())).map(|p| p.as_span().end()).last().unwrap_or(0);
        read > 0 && text[read..].trim().is_empty()
    };
    text.len() <= MAX_LENGTH && !deep && (whole(Rule::scalar_expr) || whole(Rule::scalar_task))
}

/// Returns the number of `(` minus the number of `)` in a text.
fn open(text: &str) -> i64 {
    text.bytes().map(|b| i64::from(b == b'(') - i64::from(b == b')')).sum()
}

/// Joins values that YAML split at commas inside brackets, in a sequence or mapping of flow style. Returns the
/// diagnostics.
pub(super) fn mend(source: SourceId, text: &str, nodes: &mut Vec<Node>, id: NodeId) -> Vec<Diagnostic> {
    let std::ops::Range { start, end } = nodes[id].span.range();
    // `f(x, min: 3)` as an item: for YAML, the text before the colon is a key.
    if let Kind::Mapping(entries) = &nodes[id].kind
        && let [(key, value)] = *entries.as_slice()
        && is_open(text, nodes, key, start)
        && let Some(found) = divided(text, nodes, key, end).filter(|f| nodes[value].span.range().start < f.end)
        && let whole = text[found.clone()].split_whitespace().collect::<Vec<_>>().join(" ")
        && reads(&whole)
    {
        let diag = diagnostic(source, found.clone(), &whole, "without quotes YAML reads the text before `: ` as a key");
        let span = Span::new(source, found.start, found.end);
        nodes[id] = Node { kind: Kind::Scalar(whole, Style::Plain), span, flow: false };
        return vec![diag];
    }
    if !nodes[id].flow {
        return Vec::new();
    }
    let mut diags = Vec::new();
    let kind = nodes[id].kind.clone();
    // Joins a split value that begins with a scalar: returns the node of the whole value and the number of parts that
    // follow.
    let mut join = |nodes: &mut Vec<Node>, first: NodeId, rest: &mut dyn Iterator<Item = NodeId>| {
        let found =
            Some(first).filter(|f| is_open(text, nodes, *f, start)).and_then(|f| divided(text, nodes, f, end))?;
        // Nodes that begin inside the value are parts of it.
        let taken = rest.take_while(|n| nodes[*n].span.range().start < found.end).count();
        let value = text[found.clone()].split_whitespace().collect::<Vec<_>>().join(" ");
        if taken == 0 || !reads(&value) {
            return None;
        }
        let why = "in `[..]` and `{..}` YAML splits unquoted text at each comma";
        diags.push(diagnostic(source, found.clone(), &value, why));
        let span = Span::new(source, found.start, found.end);
        nodes.push(Node { kind: Kind::Scalar(value, Style::Plain), span, flow: false });
        Some((nodes.len() - 1, taken))
    };
    match kind {
        Kind::Sequence(items) => {
            let (mut out, mut i) = (Vec::with_capacity(items.len()), 0);
            while let Some(&item) = items.get(i) {
                let joined = join(nodes, item, &mut items[i + 1..].iter().copied());
                out.push(joined.map_or(item, |j| j.0));
                i += 1 + joined.map_or(0, |j| j.1);
            }
            nodes[id].kind = Kind::Sequence(out);
        }
        Kind::Mapping(entries) => {
            let (mut out, mut i) = (Vec::with_capacity(entries.len()), 0);
            while let Some(&(key, value)) = entries.get(i) {
                let mut first =
                    |nodes: &mut Vec<Node>, id: NodeId| join(nodes, id, &mut entries[i + 1..].iter().map(|e| e.0));
                if let Some((whole, taken)) = first(nodes, value) {
                    out.push((key, whole));
                    i += taken;
                } else if let Some((whole, taken)) = first(nodes, key) {
                    // If a key was split, its value is the one after the last part.
                    let last = entries[i + taken].1;
                    let (end, behind) = (nodes[whole].span.range().end, nodes[last].span.range().start);
                    if behind >= end && !nodes[last].span.is_empty() {
                        out.push((whole, last));
                    } else {
                        let span = Span::new(source, end, end);
                        nodes.push(Node { kind: Kind::Broken, span, flow: false });
                        out.push((whole, nodes.len() - 1));
                    }
                    i += taken;
                } else {
                    out.push((key, value));
                }
                i += 1;
            }
            nodes[id].kind = Kind::Mapping(out);
        }
        _ => {}
    }
    diags
}

/// Returns true for an unquoted value with an unclosed `(`, in a collection that begins at byte `from`. An alias, which
/// refers to text elsewhere, does not count.
fn is_open(text: &str, nodes: &[Node], id: NodeId, from: usize) -> bool {
    let node = &nodes[id];
    let plain = matches!(&node.kind, Kind::Scalar(_, Style::Plain));
    plain
        && node.span.range().start >= from
        && node.span.len() <= MAX_LENGTH
        && text.get(node.span.range()).is_some_and(|t| open(t) > 0)
}

/// Returns the range of the value that begins with a scalar. It extends over the closed brackets to the next comma or
/// the end of the collection.
fn divided(text: &str, nodes: &[Node], first: NodeId, end: usize) -> Option<Range<usize>> {
    let start = nodes[first].span.range().start;
    let limit = end.min(start + MAX_LENGTH);
    let (mut parens, mut closed) = (0i64, false);
    for (i, byte) in text.as_bytes().get(start..limit)?.iter().enumerate() {
        match byte {
            b'(' => parens += 1,
            b')' => {
                parens -= 1;
                closed |= parens == 0;
            }
            b',' | b']' | b'}' | b':' if closed && parens == 0 => {
                let value = text.get(start..start + i)?.trim_end();
                return Some(start..start + value.len());
            }
            _ => {}
        }
        if parens < 0 {
            return None;
        }
    }
    let value = text.get(start..limit)?.trim_end();
    (closed && parens == 0 && limit == end).then(|| start..start + value.len())
}

/// Returns the diagnostic for a syntax error at byte `at` that stems from an unquoted value, and the text with quotes,
/// in which the bytes after the value keep their positions. No text if the quotes do not fit.
pub(super) fn missing(source: SourceId, text: &str, at: usize) -> Option<(Diagnostic, Option<String>)> {
    // YAML may report a sequence that is followed by text only on the next line.
    let above = |text: &str| {
        let found = value_around(text, text[..at].trim_end().len())?;
        let value = &text[found.0.clone()];
        (value.starts_with('[') && !value.ends_with(']')).then_some(found)
    };
    let (place, flow) = value_around(text, at).or_else(|| above(text))?;
    let value = &text[place.clone()];
    let needed = value.starts_with('[') || value.contains(": ") || (flow && value.contains([',', '[']));
    if !needed || value.starts_with(['"', '\'', '{']) || !reads(value) {
        return None;
    }
    let why = "without quotes a `[` begins a sequence of YAML, and `, ` or `: ` begins the next entry";
    Some((diagnostic(source, place.clone(), value, why), with_quotes(text, place)))
}

/// Returns the text with a value in quotes; they replace two spaces of the value.
fn with_quotes(text: &str, place: Range<usize>) -> Option<String> {
    let value = &text[place.clone()];
    if value.contains(['"', '\\', '\'']) {
        return None;
    }
    let bytes = value.as_bytes();
    let word = |b: Option<&u8>| b.is_some_and(|b| b.is_ascii_alphanumeric() || *b == b'_');
    let needless = |i: usize| bytes[i] == b' ' && !(word(bytes.get(i.wrapping_sub(1))) && word(bytes.get(i + 1)));
    let gone: Vec<usize> = (1..bytes.len()).filter(|&i| needless(i)).take(2).collect();
    let [first, second] = gone.as_slice() else { return None };
    let inner = [&value[..*first], &value[first + 1..*second], &value[second + 1..]].concat();
    Some([&text[..place.start], "\"", &inner, "\"", &text[place.end..]].concat())
}

/// Returns the range of the value that contains or precedes byte `at`, on one line; true if it is inside a flow
/// collection on that line.
fn value_around(text: &str, at: usize) -> Option<(Range<usize>, bool)> {
    let line = line_of(text, at);
    if line.len() > MAX_LENGTH {
        return None;
    }
    let bytes = &text.as_bytes()[..line.end];
    let indent = text[line.clone()].len() - text[line.clone()].trim_start_matches([' ', '-']).len();
    let mut i = line.start + indent;
    // Start of the value, no part of the value seen yet, depth of the brackets inside it, and start of each collection.
    let (mut start, mut fresh, mut inner, mut flows): (_, _, usize, Vec<usize>) = (i, true, 0, Vec::new());
    let mut parens = 0usize;
    let done = |start: usize, end: usize, flow: bool| {
        let value = text.get(start..end)?.trim_end();
        (end >= at && !value.is_empty()).then_some((start..start + value.len(), flow))
    };
    while let Some(&byte) = bytes.get(i) {
        let blank = bytes.get(i + 1).is_none_or(|b| *b == b' ');
        let outside = parens == 0 && inner == 0;
        match byte {
            b' ' => {}
            b'#' if i > line.start && bytes[i - 1] == b' ' => break,
            quote @ (b'"' | b'\'') if fresh => {
                i += 1 + text.get(i + 1..line.end)?.find(quote as char)?;
                fresh = false;
            }
            b'[' | b'{' if fresh => flows.push(i),
            b'[' | b'{' => inner += 1,
            b']' | b'}' if inner > 0 => inner -= 1,
            b']' | b'}' if parens == 0 => {
                if let Some(value) = done(start, i, !flows.is_empty()).filter(|_| !fresh) {
                    return Some(value);
                }
                let flow = flows.pop()?;
                (start, fresh) = (flow, false);
            }
            b',' | b':' if outside && (byte == b',' || blank) => {
                if let Some(value) = done(start, i, !flows.is_empty()).filter(|_| !fresh) {
                    return Some(value);
                }
                fresh = true;
            }
            _ => {
                if fresh {
                    (start, fresh) = (i, false);
                }
                match byte {
                    b'(' => parens += 1,
                    b')' => parens = parens.checked_sub(1)?,
                    _ => {}
                }
            }
        }
        i += 1;
    }
    done(start, i.min(line.end), !flows.is_empty()).filter(|_| !fresh && parens == 0 && inner == 0)
}
