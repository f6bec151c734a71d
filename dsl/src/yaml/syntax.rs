//! Diagnostics for YAML syntax errors in the terms of this project, and recovery by blanking lines.

use crate::diagnostic::Topic;
use crate::{Diagnostic, SourceId, Span};
use std::ops::Range;

/// Returns the range of the line that contains byte `at`, without its line break.
pub(super) fn line_of(text: &str, at: usize) -> Range<usize> {
    let start = text[..at].rfind('\n').map_or(0, |n| n + 1);
    let end = text[at..].find('\n').map_or(text.len(), |n| at + n);
    start..end
}

/// Returns the diagnostic for an error at byte `at`, and a byte of the line to blank for the next attempt. `text` is
/// the file, `current` the file in which the lines of earlier errors are blank.
pub(super) fn explain(source: SourceId, text: &str, current: &str, at: usize, message: &str) -> (Diagnostic, usize) {
    let mut at = at.min(current.len());
    while !current.is_char_boundary(at) {
        at -= 1;
    }
    let error = |span: Range<usize>, message: &str| {
        Diagnostic::error("HQ0130", Span::new(source, span.start, span.end), message)
    };
    let said = format!("the YAML reader says: {message}");
    if let Some(tab) = tab_in_indentation(current, at) {
        let diagnostic = error(tab..tab + 1, "a tab in the indentation")
            .here("a tab")
            .note("YAML allows only spaces there")
            .help("replace it by two spaces");
        return (diagnostic, tab);
    }
    if let Some(open) = open_quote(current, at, message) {
        let line = line_of(current, open);
        let diagnostic = error(open..line.end, "this quote is not closed")
            .here("opened here")
            .help("write the closing quote at the end of the text");
        return (diagnostic, open);
    }
    if let Some((open, bracket)) = open_bracket(current, at) {
        let closer = if bracket == '[' { ']' } else { '}' };
        let diagnostic = error(open..open + 1, &format!("this `{bracket}` is not closed"))
            .here("opened here")
            .note(said)
            .help(format!("write the missing `{closer}`, or put quotes around the value"));
        return (Diagnostic { code: "HQ0105", ..diagnostic }.about(Topic::OpenBracket), open);
    }
    let place = visible(current, at);
    let mut line = line_of(current, place.start);
    if message.contains("mapping values")
        && second_colon(current, &line).is_none()
        && let Some(previous) = previous_line(current, line.start)
        && missing_colon(current[previous.clone()].trim())
    {
        line = previous;
    }
    let content = text[line.clone()].trim();
    let diagnostic = if let Some(second) = second_colon(current, &line) {
        error(second..second + 1, "a second `:` on this line")
            .note("an unquoted value cannot contain `: `")
            .help("put the value in quotes, or begin a new line")
    } else if missing_colon(content) {
        let start = line.start + text[line.clone()].len() - text[line.clone()].trim_start().len();
        error(start..start + content.len(), "this line is neither `key: value` nor `- value`")
            .help("write a `:` and a space after the key")
    } else if let Some((own, left, right)) = odd_indentation(current, &line) {
        error(line.start..line.start + own, "the indentation fits no line above")
            .here(format!("{own} spaces"))
            .note("keys of one mapping begin in the same column")
            .help(format!("indent this line by {right} spaces, or by {left}, like the lines above that it belongs to"))
    } else {
        error(place.clone(), "this is not YAML at this place")
            .note(said)
            .help("check the indentation and the quotes around here")
    };
    (diagnostic, line.start)
}

/// Returns the range of the first visible text at or before byte `at`.
fn visible(text: &str, at: usize) -> Range<usize> {
    let mut at = at;
    if text[at..].trim_start().is_empty() {
        at = text.trim_end().len();
        at = text[..at].char_indices().next_back().map_or(0, |c| c.0);
    }
    let line = line_of(text, at);
    let skipped = text[at..line.end].len() - text[at..line.end].trim_start().len();
    let start = if skipped < line.end - at { at + skipped } else { at };
    let word =
        text[start..line.end].find(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).map_or(line.end, |n| start + n);
    let end = text[start..line.end].chars().next().map_or(start, |c| start + c.len_utf8());
    start..end.max(word)
}

/// Returns the position of a tab in the indentation of the line at `at`, or of the line before it.
fn tab_in_indentation(text: &str, at: usize) -> Option<usize> {
    let line = line_of(text, at);
    let previous = line.start.checked_sub(1).map(|end| line_of(text, end));
    [Some(line), previous].into_iter().flatten().find_map(|line| {
        let indent = text[line.clone()].len() - text[line.clone()].trim_start_matches([' ', '\t']).len();
        let blank_line = line.start + indent == line.end;
        text[line.start..line.start + indent].find('\t').filter(|_| !blank_line).map(|n| line.start + n)
    })
}

/// Returns the opening quote of a quoted scalar whose end the YAML library did not find.
fn open_quote(text: &str, at: usize, message: &str) -> Option<usize> {
    if !message.contains("quote") {
        return None;
    }
    let mut line = line_of(text, at);
    for _ in 0..30 {
        let content = &text[line.clone()];
        let value = content.find(": ").map_or(0, |n| n + 2);
        let quote = content[value..].find(['"', '\'']).map(|n| value + n);
        if let Some(quote) = quote {
            let mark = &content[quote..=quote];
            if content.matches(mark).count() % 2 == 1 {
                return Some(line.start + quote);
            }
        }
        line = previous_line(text, line.start)?;
    }
    None
}

/// Returns the line above the one that begins at `start`; skips empty ones.
fn previous_line(text: &str, start: usize) -> Option<Range<usize>> {
    let end = text[..start].trim_end().len();
    (end > 0).then(|| line_of(text, end))
}

/// Returns the line above the one that begins at `start`; skips empty ones and comments.
fn content_above(text: &str, start: usize) -> Option<Range<usize>> {
    let mut line = previous_line(text, start)?;
    while text[line.clone()].trim_start().starts_with('#') {
        line = previous_line(text, line.start)?;
    }
    Some(line)
}

/// Returns the innermost `[` or `{` of flow style that is open at byte `at`.
fn open_bracket(text: &str, at: usize) -> Option<(usize, char)> {
    let bytes = text.as_bytes();
    let mut open: Vec<(usize, char)> = Vec::new();
    let mut previous = b'\n';
    let mut i = 0;
    let mut value_begins = true;
    while i < at {
        let byte = bytes[i];
        let in_flow = !open.is_empty();
        match byte {
            b'#' if matches!(previous, b' ' | b'\t' | b'\n') => {
                i = text[i..].find('\n').map_or(at, |n| i + n);
                continue;
            }
            b'"' | b'\'' if value_begins => {
                let mut end = i + 1;
                while end < at && bytes[end] != byte {
                    end += if byte == b'"' && bytes[end] == b'\\' { 2 } else { 1 };
                }
                i = end;
            }
            b'[' | b'{' if value_begins || in_flow => open.push((i, byte as char)),
            b']' | b'}' if in_flow => {
                let top = open.pop()?;
                if (top.1 == '[') != (byte == b']') {
                    return Some(top);
                }
            }
            _ => {}
        }
        previous = bytes.get(i).copied().unwrap_or(b' ');
        value_begins = match previous {
            b' ' | b'\t' => value_begins,
            b'\n' | b':' | b'-' | b',' | b'[' | b'{' => true,
            _ => false,
        };
        i += 1;
    }
    let (from, bracket) = open.pop()?;
    (!closed_later(text, from, at)).then_some((from, bracket))
}

/// Returns true if the brackets opened at byte `from` balance after byte `at`, and before the lines return to the
/// indentation of the first one.
fn closed_later(text: &str, from: usize, at: usize) -> bool {
    let indent = |line: &str| line.len() - line.trim_start().len();
    let own = indent(&text[line_of(text, from)]);
    let mut depth = 0i32;
    let mut i = from;
    for line in text[from..].split_inclusive('\n') {
        if i > from && !line.trim().is_empty() && indent(line) <= own && !line.trim_start().starts_with([']', '}']) {
            return false;
        }
        for c in line.bytes() {
            depth += i32::from(matches!(c, b'[' | b'{')) - i32::from(matches!(c, b']' | b'}'));
            i += 1;
            if depth == 0 {
                return i > at;
            }
        }
    }
    false
}

/// Returns the indentation of a line that matches no column of the lines above it, and the nearest columns to its left
/// and right. The text after a `- ` begins a column of its own. `None` if the line matches a column.
fn odd_indentation(text: &str, line: &Range<usize>) -> Option<(usize, usize, usize)> {
    let indent = |line: Range<usize>| text[line.clone()].len() - text[line].trim_start_matches(' ').len();
    let own = indent(line.clone());
    let (mut left, mut right, mut shallowest) = (None, None, usize::MAX);
    let mut start = line.start;
    while let Some(previous) = content_above(text, start) {
        start = previous.start;
        let first = indent(previous.clone());
        if first >= shallowest {
            continue;
        }
        let mut column = first;
        loop {
            match column {
                n if n >= shallowest => break,
                n if n == own => return None,
                n if n > own => right = Some(right.map_or(n, |r: usize| r.min(n))),
                n => left = Some(left.map_or(n, |l: usize| l.max(n))),
            }
            let rest = &text[previous.start + column..previous.end];
            let Some(item) = rest.strip_prefix("- ") else { break };
            column += 2 + item.len() - item.trim_start_matches(' ').len();
        }
        shallowest = first;
        if first == 0 {
            break;
        }
    }
    Some((own, left?, right?))
}

/// Returns the position of a second `: ` on a line of block style.
fn second_colon(text: &str, line: &Range<usize>) -> Option<usize> {
    let content = &text[line.clone()];
    if content.contains(['"', '\'', '{', '[', '#']) {
        return None;
    }
    let first = content.find(": ")?;
    content[first + 2..].find(": ").map(|n| line.start + first + 2 + n)
}

fn missing_colon(content: &str) -> bool {
    !content.is_empty()
        && !content.contains(':')
        && !content.starts_with(['-', '[', '{', '}', ']', '"', '\'', '&', '*', '%'])
}

/// Returns the text with the line of byte `at`, and the lines below it that are indented more, replaced by spaces.
pub(super) fn blank(text: &str, at: usize) -> Option<(String, Range<usize>)> {
    let first = line_of(text, at.min(text.len()));
    let indent = |line: &str| line.len() - line.trim_start_matches([' ', '\t']).len();
    let depth = indent(&text[first.clone()]);
    let mut end = first.end;
    while end < text.len() {
        let next = line_of(text, end + 1);
        let content = &text[next.clone()];
        if !content.trim().is_empty() && indent(content) <= depth {
            break;
        }
        end = next.end;
    }
    if text[first.start..end].trim().is_empty() {
        return None;
    }
    let mut bytes = text.as_bytes().to_vec();
    for byte in &mut bytes[first.start..end] {
        if *byte != b'\n' && *byte != b'\r' {
            *byte = b' ';
        }
    }
    String::from_utf8(bytes).ok().map(|text| (text, first.start..end))
}
