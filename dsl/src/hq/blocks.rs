//! Reader of blocks and their entries, in `*.hq` texts.

use super::Reader;
use crate::explain::{self, After};
use crate::expr::{Place, missing};
use crate::fix::Fix;
use crate::grammar::{Pair, Rule};
use crate::tree::{Block, Comments, Entry, Value, ValueKind};
use crate::words::is_text_key;
use crate::{Diagnostic, Spanned, checks};

impl Reader<'_> {
    /// Converts a node `tagged`, `block` or `expr` to a value. A comment after the opening brace is stored in `behind`.
    pub(super) fn value(&mut self, pair: Pair<'_>, behind: &mut Option<String>) -> Value {
        let span = self.of(&pair);
        match pair.as_rule() {
            Rule::block => Value { kind: ValueKind::Block(self.block(pair, behind)), span },
            Rule::tagged => {
                let mut parts = pair.into_inner();
                let (Some(tag), Some(body)) = (parts.next(), parts.next()) else { return missing(span) };
                let key = self.place().spanned(&tag);
                let inner = self.of(&body);
                let block = self.block(body, behind);
                let value = Value { kind: ValueKind::Block(block), span: inner };
                let entries = vec![Entry { key, value, comments: Comments::default() }];
                let outer = Block { entries, span, tagged: true, closing_comments: Comments::default() };
                Value { kind: ValueKind::Block(outer), span }
            }
            Rule::single => {
                let said = pair.as_str().trim_matches('\'').to_owned();
                self.diags
                    .push(Diagnostic::error("HQ0109", span, "a text needs double quotes").write(format!("\"{said}\"")));
                Value { kind: ValueKind::Text(said), span }
            }
            _ => self.expr(pair),
        }
    }

    /// Converts a node `block`.
    pub(super) fn block(&mut self, pair: Pair<'_>, behind: &mut Option<String>) -> Block {
        let span = self.of(&pair);
        let (start, end) = (span.start as usize, span.end as usize);
        self.pool.behind(start + 1, &[], behind);
        let mut block = Block { span, ..Block::default() };
        let mut open = false;
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::entry => self.entry(part, &mut block.entries),
                _ => open = true,
            }
        }
        if open {
            self.unclosed(start, end);
        } else {
            self.pool.before(end - 1, &mut block.closing_comments.before);
        }
        checks::duplicates(&block.entries, &mut self.diags);
        block
    }

    /// Converts a node `entry`, and adds the entry to `entries`.
    pub(super) fn entry(&mut self, pair: Pair<'_>, entries: &mut Vec<Entry>) {
        let whole = self.of(&pair);
        let (start, end) = (whole.start as usize, whole.end as usize);
        if start < self.read {
            return;
        }
        let mut parts = pair.into_inner().peekable();
        if let Some(allow) = parts.next_if(|part| part.as_rule() == Rule::allow) {
            return self.allow(allow, entries);
        }
        let mut comments = Comments::default();
        self.pool.before(start, &mut comments.before);
        let (mut key, mut mark, mut value, mut junk) = (None, None, None, None);
        for part in parts {
            match part.as_rule() {
                Rule::name => key = Some(self.place().spanned(&part)),
                Rule::pattern => key = Some(Spanned::new(part.as_str().trim_matches('"').to_owned(), self.of(&part))),
                Rule::mark => mark = Some(self.of(&part)),
                Rule::junk => junk = Some(self.of(&part)),
                _ => value = Some(part),
            }
        }
        let Some(key) = key else {
            if let Some(junk) = junk {
                self.unread.push(junk);
                let place = Place::Exact(self.source, 0);
                let diagnostic =
                    explain::junk(self.text, junk.range().start, junk.range().end, place, After::Start("a key"), false);
                self.diags.push(diagnostic);
            }
            return;
        };
        // `finger_* 0.3 rad`: a name, followed by a character that is not allowed there.
        if let Some(junk) = junk.filter(|j| value.is_none() && mark.is_none() && j.start == key.span.end)
            && let Some(range) = explain::unquoted_pattern(self.text, junk.range().start, After::Key(&key.value))
        {
            let span = self.span(range.start, range.end);
            self.diags.push(explain::needs_quotes(&self.text[range], span));
            return;
        }
        let lone_name = value
            .as_ref()
            .filter(|v| v.as_rule() == Rule::expr && crate::words::is_name(v.as_str()))
            .map(|v| self.of(v));
        // `d_min 0.5 mtr` is parsed as two entries: the second has no value, or the next key as its value. If a number
        // follows, even an invalid one, the word is a key.
        let behind = self.text[key.span.range().end..end].trim_start();
        let number_behind = behind.starts_with(|c: char| c.is_ascii_digit() || c == '.');
        // The next key is on a line of its own: `rate 100 Hxz`, and below it `home { .. }`.
        let below = value.as_ref().filter(|v| v.as_rule() != Rule::block).map(|v| self.of(v)).filter(|v| {
            self.text[v.range()].starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
                && self.text[key.span.range().end..v.range().start].contains('\n')
        });
        if mark.is_none()
            && !number_behind
            && (junk.is_some() || value.is_none() || below.is_some())
            && self.follows_bare_number(entries, start)
        {
            self.diags.push(explain::unknown_unit(&key.value, key.span));
            if let Some(last) = entries.last_mut() {
                last.value.kind = ValueKind::Missing;
            }
            if let Some(next) = below.or(lone_name) {
                // The value of the next key may follow the text that was parsed as the value of this one.
                let line = line_end(self.text, end);
                let until = if lone_name.is_some() && below.is_some() { line } else { end };
                self.again(Rule::entry, next.range().start, until, |reader, pair| {
                    let behind = reader.of(&pair).range().end;
                    reader.entry(pair, entries);
                    reader.read = reader.read.max(behind);
                });
            }
            return;
        }
        if mark.is_none()
            && let Some(unit) = self.unit_behind_expression(entries, start)
        {
            self.diags.push(explain::unit_behind_expression(&self.text[start..unit], self.span(start, unit)));
            if let Some(last) = entries.last_mut() {
                last.value.kind = ValueKind::Missing;
            }
            self.read = self.read.max(unit);
            // The next entry on the line was parsed as the value of the unit.
            let next = unit + self.text[unit..].len() - self.text[unit..].trim_start().len();
            if next < end {
                self.again(Rule::entry, next, line_end(self.text, next), |reader, pair| {
                    let behind = reader.of(&pair).range().end;
                    reader.entry(pair, entries);
                    reader.read = reader.read.max(behind);
                });
            }
            return;
        }
        // A key without a value, for which the next key on the following line was taken.
        if let (Some(next), Some(_)) = (lone_name, junk)
            && self.text[key.span.range().end..next.range().start].contains('\n')
        {
            self.diags.push(explain::no_value(&key.value, key.span));
            entries.push(Entry { value: missing(key.span), key, comments });
            self.again(Rule::entry, next.range().start, end, |reader, pair| reader.entry(pair, entries));
            return;
        }
        if let Some(mark) = mark {
            let sign = &self.text[mark.range()];
            let said = value.as_ref().map_or("0.5 m", |v| v.as_str());
            let said = if said.contains('\n') || said.len() > 40 { ".." } else { said };
            self.diags.push(
                Diagnostic::error("HQ0108", mark, format!("unexpected `{sign}` between a key and its value"))
                    .help(format!("write `{} {said}`", key.value))
                    .fix(Fix::delete(mark, sign).certain()),
            );
        }
        let value = self.entry_value(&key, value, junk, &mut comments);
        self.pool.behind(end, &[',', ';'], &mut comments.behind);
        entries.push(Entry { key, value, comments });
    }

    /// Converts the value of an entry, and reports unreadable text after the key or after the value.
    fn entry_value(
        &mut self,
        key: &Spanned<String>,
        value: Option<Pair<'_>>,
        junk: Option<crate::Span>,
        comments: &mut Comments,
    ) -> Value {
        if let (Some(junk), true) = (junk, is_text_key(&key.value)) {
            let start = value.as_ref().map_or(junk, |v| self.of(v)).range().start;
            let mut end = junk.range().end;
            if self.text[end..].starts_with("//") && self.text[..end].ends_with(':') {
                // `package://..` without quotes: the rest was parsed as a comment.
                end += self.text[end..].find(char::is_whitespace).unwrap_or(self.text.len() - end);
            }
            let raw = self.text[start..end].trim_end();
            let span = self.span(start, start + raw.len());
            if !raw.contains(['"', '\'', '\n']) && raw.starts_with('[') && raw.ends_with(']') {
                self.diags.push(checks::unquoted_texts(&key.value, raw, span));
                return missing(span);
            }
            if !raw.contains(['"', '\'', '\n']) {
                let mut value = Value { kind: ValueKind::Name(raw.to_owned()), span };
                checks::text_value(&key.value, &mut value, self.text, &mut self.diags);
                return value;
            }
        }
        let mut value = match (value, junk) {
            (Some(pair), junk) => {
                let is_expr = pair.as_rule() == Rule::expr;
                let value = self.value(pair, &mut comments.behind);
                if is_expr {
                    self.pool.before(value.span.range().end, &mut comments.before);
                }
                if let Some(junk) = junk {
                    self.unread.push(junk);
                    self.junk(junk, After::Value(&value));
                }
                value
            }
            (None, Some(junk)) => {
                self.unread.push(junk);
                self.junk(junk, After::Key(&key.value));
                missing(junk)
            }
            (None, None) => {
                self.diags.push(explain::no_value(&key.value, key.span));
                missing(key.span)
            }
        };
        checks::text_value(&key.value, &mut value, self.text, &mut self.diags);
        value
    }

    /// Returns the end of the unit at `start` if it follows an expression on its line, as in `0.4*pi rad/s`, and is no key: there
    /// is no value behind it.
    fn unit_behind_expression(&self, entries: &[Entry], start: usize) -> Option<usize> {
        let last = &entries.last()?.value;
        let gap = self.text.get(last.span.range().end..start)?;
        let unit = explain::unit_end(self.text, start)?;
        let mut words = self.text[unit..].lines().next().unwrap_or("").split_whitespace();
        let (next, behind) = (words.next().unwrap_or(""), words.next().unwrap_or(""));
        let ends = next.is_empty() || next.starts_with(['}', ',', ';', '/']);
        // `joint_2 0.1 rad` behind it: a key with its value.
        let key =
            crate::words::is_name(next) && behind.starts_with(|c: char| c.is_ascii_digit() || "[(-\"".contains(c));
        (explain::is_expression(last) && gap.chars().all(|c| c == ' ' || c == '\t') && (ends || key)).then_some(unit)
    }

    /// Returns true if the entry at `start` follows, on the same line, an entry whose value is a number without a unit.
    pub(super) fn follows_bare_number(&self, entries: &[Entry], start: usize) -> bool {
        entries.last().is_some_and(|last| {
            let end = last.value.span.range().end;
            matches!(last.value.kind, ValueKind::Number(_) | ValueKind::List(_))
                && self.text.get(end..start).is_some_and(|gap| gap.chars().all(|c| c == ' ' || c == '\t'))
        })
    }
}

/// Returns the end of the line of byte `at`, or the closing brace before it. A block that opens on the line belongs to
/// the line.
fn line_end(text: &str, at: usize) -> usize {
    let mut open = 0usize;
    let end = text.as_bytes()[at..].iter().position(|byte| {
        match byte {
            b'{' => open += 1,
            b'}' if open > 0 => open -= 1,
            b'}' => return true,
            b'\n' => return open == 0,
            _ => {}
        }
        false
    });
    end.map_or(text.len(), |n| at + n)
}

/// Returns the first pair of braces between two bytes whose closing brace begins a line with another indentation than
/// the line of the opening one: a hint at the forgotten brace.
pub(super) fn misaligned(text: &str, start: usize, end: usize) -> Option<(usize, usize)> {
    let indent = |at: usize| {
        let line = text[..at].rfind('\n').map_or(0, |n| n + 1);
        let rest = &text[line..];
        (rest.len() - rest.trim_start_matches([' ', '\t']).len(), line)
    };
    let bytes = text.as_bytes();
    let mut open = Vec::new();
    let mut at = start;
    while at < end {
        match *bytes.get(at)? {
            b'"' => {
                if let Some(close) = crate::limits::text_end(text, at) {
                    at = close;
                    continue;
                }
            }
            b'/' if bytes.get(at + 1) == Some(&b'/') => {
                at = text[at..].find('\n').map_or(end, |n| at + n);
                continue;
            }
            b'{' => open.push(at),
            b'}' => {
                let from = open.pop()?;
                let ((inner, line), (outer, first)) = (indent(at), indent(from));
                if line != first && inner + line == at && inner != outer {
                    return Some((from, at));
                }
            }
            _ => {}
        }
        at += 1;
    }
    None
}
