//! Splits comma-separated text into lines and cells, each with its span.
//!
//! A quoted cell may contain commas, line breaks, and doubled quotes. Spaces around cells and blank lines are ignored.

use std::borrow::Cow;

use dsl::{Diagnostic, SourceId, Span};

/// Text of a cell, with its span.
pub(super) type Cell<'t> = (Cow<'t, str>, Span);

/// Reader of a text, line by line.
pub(super) struct Lines<'t> {
    text: &'t str,
    at: usize,
    source: SourceId,
}

impl<'t> Lines<'t> {
    pub(super) fn new(text: &'t str, source: SourceId) -> Lines<'t> {
        Lines { text, at: text.len() - text.trim_start_matches('\u{feff}').len(), source }
    }

    /// Replaces `row` with the cells of the next line and returns the span of the line; `None` at the end of the text.
    pub(super) fn next(&mut self, row: &mut Vec<Cell<'t>>) -> Result<Option<Span>, Box<Diagnostic>> {
        row.clear();
        // Skip blank lines.
        loop {
            let rest = &self.text[self.at..];
            let end = rest.find('\n').unwrap_or(rest.len());
            if !rest[..end].trim().is_empty() {
                break;
            }
            if end == rest.len() {
                return Ok(None);
            }
            self.at += end + 1;
        }
        let start = self.at;
        loop {
            let cell = self.cell()?;
            row.push(cell);
            let last = row.last().map_or(start, |cell| cell.1.range().end);
            match self.text.as_bytes().get(self.at) {
                Some(b',') => self.at += 1,
                end => {
                    self.at += usize::from(end.is_some());
                    return Ok(Some(Span::new(self.source, start, last)));
                }
            }
        }
    }

    /// Parses the cell at the current position, up to a comma, the end of the line or the end of the text.
    fn cell(&mut self) -> Result<Cell<'t>, Box<Diagnostic>> {
        let rest = &self.text[self.at..];
        let inner = rest.trim_start_matches(|c: char| c.is_whitespace() && c != '\n');
        if inner.starts_with('"') {
            self.at += rest.len() - inner.len();
            return self.quoted();
        }
        let end = rest.find([',', '\n']).unwrap_or(rest.len());
        let cell = rest[..end].trim();
        // The span of a blank cell is at its end.
        let from = self.at + (end - rest[..end].trim_start().len());
        self.at += end;
        Ok((cell.into(), Span::new(self.source, from, from + cell.len())))
    }

    fn quoted(&mut self) -> Result<Cell<'t>, Box<Diagnostic>> {
        let open = self.at;
        let mut at = open + 1;
        let inside = loop {
            let Some(n) = self.text[at..].find('"') else {
                let d = Diagnostic::error("HQ0805", Span::new(self.source, open, open + 1), "this quote does not end");
                return Err(Box::new(d.help("close it; a quote inside is written twice, `\"\"`")));
            };
            at += n + 1;
            if self.text.as_bytes().get(at) != Some(&b'"') {
                break &self.text[open + 1..at - 1];
            }
            at += 1;
        };
        let rest = &self.text[at..];
        let behind = rest.trim_start_matches(|c: char| c.is_whitespace() && c != '\n');
        if !(behind.is_empty() || behind.starts_with([',', '\n'])) {
            let d = Diagnostic::error("HQ0805", Span::new(self.source, open, at), "unexpected text after the quotes");
            return Err(Box::new(d.help("put all of the cell into the quotes; one inside is written twice, `\"\"`")));
        }
        self.at = at + (rest.len() - behind.len());
        let cell = if inside.contains('"') { inside.replace("\"\"", "\"").into() } else { Cow::Borrowed(inside) };
        Ok((cell, Span::new(self.source, open, at)))
    }
}
