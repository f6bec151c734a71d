//! Blocks with a missing opening brace: the lines up to the closing brace are read as if it were there.
//!
//! Many declarations may lack one, and the closing brace may be far away: [`Closers`] finds all of them in one pass.

use pest::Parser;

use super::KEYWORDS;
use super::Reader;
use crate::fix::Fix;
use crate::grammar::{Grammar, Pair, Rule};
use crate::limits::text_end;
use crate::{Diagnostic, Span};

/// A block with a missing opening brace.
pub(super) struct Headless {
    /// Position where the brace belongs.
    pub open: usize,
    /// Position after its closing brace.
    pub end: usize,
    /// Its text, with the brace inserted at [`Headless::open`].
    text: String,
}

impl Headless {
    /// Parses the block as a node of `rule`; its byte positions count from [`Headless::open`].
    pub fn pair(&self, rule: Rule) -> Option<Pair<'_>> {
        Grammar::parse(rule, &self.text).ok().and_then(|mut pairs| pairs.next())
    }
}

impl Reader<'_> {
    /// Returns the block of the lines below byte `end`, if a brace closes it before the next declaration begins.
    pub(super) fn headless(&mut self, end: usize) -> Option<Headless> {
        let text = self.text;
        let behind = text.get(end..)?;
        let blank = behind.len() - behind.trim_start_matches(|c: char| c.is_whitespace() && c != '\n').len();
        if !behind[blank..].starts_with('\n') {
            return None;
        }
        let closers = self.closers.get_or_insert_with(|| Closers::of(text));
        let close = closers.around(end)?;
        if text.as_bytes()[close] != b'}' || closers.declared(end, close) {
            return None;
        }
        let inside = text.get(end + 1..close + 1)?;
        says_something(&text[end..close]).then(|| Headless { open: end, end: close + 1, text: format!("{{{inside}") })
    }

    /// Reports the missing brace of a declaration.
    pub(super) fn no_brace(&mut self, what: &str, at: Span, block: &Headless) {
        let close = self.span(block.end - 1, block.end);
        self.diags.push(
            Diagnostic::incomplete("HQ0117", at, format!("the `{{` of this {what} is missing"))
                .label(close, "this brace closes it")
                .help("write `{` at the end of the line")
                .fix(Fix::edit("Write the missing `{`", self.span(block.open, block.open), " {").certain()),
        );
    }
}

/// The brackets of a text outside texts and comments, and the closing bracket for any position.
pub(super) struct Closers {
    /// Positions of the brackets, in the order of the text.
    brackets: Vec<usize>,
    /// For each bracket, and for the end of the text, the first closing bracket from there on that has no opening one
    /// after that position; `usize::MAX` if there is none.
    next: Vec<usize>,
    /// The line breaks before the lines that begin a declaration.
    declarations: Vec<usize>,
}

impl Closers {
    fn of(text: &str) -> Closers {
        let (mut brackets, mut declarations) = (Vec::new(), Vec::new());
        let bytes = text.as_bytes();
        let mut at = 0;
        while let Some(&byte) = bytes.get(at) {
            match byte {
                b'\n' if begins_declaration(&text[at + 1..]) => declarations.push(at),
                b'"' => {
                    if let Some(close) = text_end(text, at) {
                        at = close;
                        continue;
                    }
                }
                b'/' if bytes.get(at + 1) == Some(&b'/') => {
                    at += text[at..].find('\n').unwrap_or(text.len() - at);
                    continue;
                }
                b'{' | b'[' | b'(' | b'}' | b']' | b')' => brackets.push(at),
                _ => {}
            }
            at += 1;
        }
        // From the end: the closing brackets that are still unmatched, the nearest last.
        let mut next = vec![usize::MAX; brackets.len() + 1];
        let mut closing: Vec<usize> = Vec::new();
        for (i, &at) in brackets.iter().enumerate().rev() {
            if matches!(bytes[at], b'{' | b'[' | b'(') {
                closing.pop();
            } else {
                closing.push(at);
            }
            next[i] = closing.last().copied().unwrap_or(usize::MAX);
        }
        Closers { brackets, next, declarations }
    }

    /// Returns the bracket, of any kind, that closes the innermost pair around byte `at`.
    fn around(&self, at: usize) -> Option<usize> {
        let first = self.brackets.partition_point(|&b| b < at);
        self.next.get(first).copied().filter(|&close| close != usize::MAX)
    }

    /// Returns true if a line between two bytes begins a declaration.
    fn declared(&self, start: usize, end: usize) -> bool {
        let first = self.declarations.partition_point(|&d| d < start);
        self.declarations.get(first).is_some_and(|&d| d < end)
    }
}

/// Returns true for a text with more than brackets, texts and comments.
fn says_something(text: &str) -> bool {
    let bytes = text.as_bytes();
    let mut at = 0;
    while let Some(&byte) = bytes.get(at) {
        match byte {
            b'"' => {
                if let Some(close) = text_end(text, at) {
                    at = close;
                    continue;
                }
            }
            b'/' if bytes.get(at + 1) == Some(&b'/') => {
                at += text[at..].find('\n').unwrap_or(text.len() - at);
                continue;
            }
            b'{' | b'[' | b'(' | b'}' | b']' | b')' => {}
            byte if byte.is_ascii_whitespace() => {}
            _ => return true,
        }
        at += 1;
    }
    false
}

/// Returns true for a line that begins with the keyword of a declaration.
fn begins_declaration(line: &str) -> bool {
    let word = line.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).next().unwrap_or("");
    KEYWORDS.contains(&word)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Computes the result of `around` by scanning the text from byte `end` on.
    fn looked_for(text: &str, end: usize) -> Option<usize> {
        let bytes = text.as_bytes();
        let (mut open, mut at) = (0, end);
        loop {
            match *bytes.get(at)? {
                b'\n' if begins_declaration(&text[at + 1..]) => return None,
                b'"' if text_end(text, at).is_some() => {
                    at = text_end(text, at)?;
                    continue;
                }
                b'/' if bytes.get(at + 1) == Some(&b'/') => {
                    at += text[at..].find('\n')?;
                    continue;
                }
                b'}' if open == 0 => return Some(at),
                b'{' | b'[' | b'(' => open += 1,
                b'}' | b']' | b')' if open == 0 => return None,
                b'}' | b']' | b')' => open -= 1,
                _ => {}
            }
            at += 1;
        }
    }

    proptest! {
        #[test]
        fn the_closing_bracket_is_that_which_a_look_at_the_text_finds(
            words in prop::collection::vec(
                prop::sample::select(vec!["{", "}", "(", ")", "[", "]", "\n", "\nrobot a", "\nruns", "x", "\"", "//", "\\", "é"]),
                0..40,
            ),
        ) {
            let text = words.concat();
            let closers = Closers::of(&text);
            for (end, _) in text.match_indices('\n') {
                let close = closers.around(end).filter(|&c| text.as_bytes()[c] == b'}' && !closers.declared(end, c));
                prop_assert_eq!(close, looked_for(&text, end), "{:?} from byte {}", text, end);
            }
        }
    }
}
