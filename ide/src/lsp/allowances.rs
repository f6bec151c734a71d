//! Allowed warnings in the editor: codes after `allow`, their pages on hover, and the quick fix that allows a warning. Later stages of
//! the compiler do not see allowances, so that these read the text.

use std::ops::Range;

use compiler::codes::{self, Page};
use compiler::sections::ALLOW;
use dsl::{Diagnostic, Fix, Severity, Span, Syntax};
use lsp_types::{Hover, HoverContents, MarkupContent, MarkupKind};

use super::document::Document;

/// Codes that can follow the text before a byte; `None` if no code belongs there.
pub(super) fn codes(document: &Document, start: usize) -> Option<impl Iterator<Item = &'static Page>> {
    let before = &document.text.as_str()[..start];
    let line = &before[before.rfind('\n').map_or(0, |n| n + 1)..];
    let expected = match document.syntax()? {
        Syntax::Native => last_word(line) == ALLOW.name && line.ends_with([' ', '\t']),
        Syntax::Yaml if line.trim().is_empty() => owner(before, line.len()) == Some("allow:"),
        Syntax::Yaml => {
            let open = line.rfind('{').map(|at| line[..at].trim_end());
            let inside = open.filter(|head| !line[head.len()..].contains('}') && head.ends_with("allow:"));
            inside.is_some() && line.trim_end().ends_with(['{', ','])
        }
    };
    expected.then(|| codes::all().filter(|page| page.warning))
}

fn last_word(line: &str) -> &str {
    let line = line.trim_end();
    &line[line.trim_end_matches(|c: char| c.is_ascii_alphanumeric() || c == '_').len()..]
}

/// The nearest line above with less indentation, without it.
fn owner(before: &str, indent: usize) -> Option<&str> {
    let mut filled = before.lines().rev().filter(|line| !line.trim().is_empty());
    let outer = |line: &&str| line.len() - line.trim_start().len() < indent;
    filled.find(|line| outer(line)).map(str::trim)
}

/// The page of the code at a byte.
pub(super) fn hover(document: &Document, byte: usize) -> Option<Hover> {
    let text = document.text.as_str();
    let part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let start = text.get(..byte)?.trim_end_matches(part).len();
    let end = text.len() - text[byte..].trim_start_matches(part).len();
    let word = &text[start..end];
    let value = match word {
        "allow" => super::hover::key(&ALLOW),
        code if code.starts_with("HQ") => {
            let page = codes::all().find(|page| page.code == code)?;
            let kind = if page.warning { "warning" } else { "error" };
            format!("**{}** ({kind}): {}\n\n{}", page.code, page.title, first_part(page))
        }
        _ => return None,
    };
    let contents = HoverContents::Markup(MarkupContent { kind: MarkupKind::Markdown, value });
    Some(Hover { contents, range: Some(document.text.range(start..end)) })
}

/// The text of a page up to its first example.
fn first_part(page: &Page) -> &'static str {
    page.text.split("```").next().unwrap_or("").trim_end()
}

/// The fix that allows a warning in the smallest block that it points at. Its reason is empty, which is an error until it is
/// written.
pub(super) fn fix(text: &str, syntax: Syntax, d: &Diagnostic) -> Option<Fix> {
    let page = codes::explain(d.code).filter(|page| page.warning && d.severity == Severity::Warning)?;
    let at = d.primary.span.range();
    text.get(at.clone())?;
    let (place, new) = match syntax {
        Syntax::Native => native(text, at, page.code)?,
        Syntax::Yaml => yaml(text, at, page.code)?,
    };
    Some(Fix::edit(format!("Allow {} with a reason", page.code), Span::new(d.primary.span.source, place, place), new))
}

/// After the brace behind the place on its line, or the innermost one around it; else above the line.
fn native(text: &str, at: Range<usize>, code: &str) -> Option<(usize, String)> {
    let allow = format!("allow {code} \"\"");
    let line_end = text[at.end..].find('\n').map_or(text.len(), |n| at.end + n);
    let behind = text[at.end..line_end].find(['{', '}']).map(|n| at.end + n);
    let behind = behind.filter(|n| text.as_bytes()[*n] == b'{');
    let open = behind.or_else(|| innermost(text, at.start));
    let Some(open) = open else {
        let line = text[..at.start].rfind('\n').map_or(0, |n| n + 1);
        return Some((line, format!("{allow}\n\n")));
    };
    // In a block of several lines, it has a line of its own.
    let next = &text[open + 1..];
    let first = next.lines().next().unwrap_or("");
    if first.trim().is_empty() && next.contains('\n') {
        let below = next.lines().nth(1).unwrap_or("");
        let indent = &below[..below.len() - below.trim_start().len()];
        return Some((open + 1 + first.len() + 1, format!("{indent}{allow}\n")));
    }
    Some((open + 1, format!(" {allow} ")))
}

/// The last brace before a byte that is open there. Braces in texts and comments are rare, and the fix is tried before it is offered.
fn innermost(text: &str, at: usize) -> Option<usize> {
    let mut open = 0usize;
    for (i, byte) in text.as_bytes()[..at].iter().enumerate().rev() {
        match byte {
            b'}' => open += 1,
            b'{' if open == 0 => return Some(i),
            b'{' => open -= 1,
            _ => {}
        }
    }
    None
}

/// After the flow brace around the place on its line, or as a line of the mapping that it stands in.
fn yaml(text: &str, at: Range<usize>, code: &str) -> Option<(usize, String)> {
    let line = text[..at.start].rfind('\n').map_or(0, |n| n + 1);
    if let Some(open) = innermost(&text[line..], at.start - line) {
        return Some((line + open + 1, format!(" allow: {{ {code}: \"\" }},")));
    }
    let whole = text[line..].lines().next()?;
    let column = whole.len() - whole.trim_start_matches([' ', '-']).len();
    let end = line + whole.len() + 1;
    let indent = " ".repeat(column);
    let new = format!("{indent}allow: {{ {code}: \"\" }}\n");
    if whole.trim_start().starts_with('-') {
        return Some((end.min(text.len()), new));
    }
    // Below `arm:`, the block of the name.
    let below = text.get(end..).and_then(|rest| rest.lines().next()).unwrap_or("");
    let deeper = below.len() - below.trim_start_matches(' ').len();
    if whole.trim_end().ends_with(':') && deeper > column && !below.trim_start().starts_with('-') {
        return Some((end, format!("{}allow: {{ {code}: \"\" }}\n", " ".repeat(deeper))));
    }
    Some((line, new))
}
