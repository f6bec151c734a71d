//! Blocks whose opening brace was left out: the lines up to the brace that closes them are read as if it stood there.

use pest::Parser;

use super::Reader;
use super::items::KEYWORDS;
use crate::grammar::{Grammar, Pair, Rule};
use crate::limits::text_end;
use crate::{Diagnostic, Span};

/// A block without its opening brace.
pub(super) struct Headless {
    /// The blank where the brace belongs.
    pub open: usize,
    /// One past its closing brace.
    pub end: usize,
    /// Its text, with the brace in the place of that blank.
    text: String,
}

impl Headless {
    /// The block as a node of `rule`; its bytes count from [`Headless::open`].
    pub fn pair(&self, rule: Rule) -> Option<Pair<'_>> {
        Grammar::parse(rule, &self.text).ok().and_then(|mut pairs| pairs.next())
    }
}

impl Reader<'_> {
    /// The block that the lines below byte `end` make, where a brace closes it before the next declaration begins.
    pub(super) fn headless(&self, end: usize) -> Option<Headless> {
        let bytes = self.text.as_bytes();
        let line = self.text[end..].find('\n')?;
        if !self.text[end..end + line].trim().is_empty() {
            return None;
        }
        let mut open: Vec<u8> = Vec::new();
        let mut empty = true;
        let mut at = end;
        loop {
            match *bytes.get(at)? {
                b'\n' if begins_declaration(&self.text[at + 1..]) => return None,
                b'"' => {
                    if let Some(close) = text_end(self.text, at) {
                        at = close;
                        continue;
                    }
                }
                b'/' if bytes.get(at + 1) == Some(&b'/') => {
                    at += self.text[at..].find('\n')?;
                    continue;
                }
                b'}' if open.is_empty() => break,
                bracket @ (b'{' | b'[' | b'(') => open.push(bracket),
                b'}' | b']' | b')' => {
                    open.pop()?;
                }
                byte => empty &= byte.is_ascii_whitespace(),
            }
            at += 1;
        }
        let inside = self.text.get(end + 1..=at)?;
        (!empty).then(|| Headless { open: end, end: at + 1, text: format!("{{{inside}") })
    }

    /// Reports the brace that a declaration lacks.
    pub(super) fn no_brace(&mut self, what: &str, at: Span, block: &Headless) {
        let close = self.span(block.end - 1, block.end);
        self.diags.push(
            Diagnostic::error("HQ0117", at, format!("the `{{` of this {what} is missing"))
                .label(close, "this brace closes it")
                .help("write `{` at the end of the line"),
        );
    }
}

/// True for a line that begins with a word for declarations.
fn begins_declaration(line: &str) -> bool {
    let word = line.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).next().unwrap_or("");
    KEYWORDS.contains(&word)
}
