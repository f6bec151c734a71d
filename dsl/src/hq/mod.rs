//! Reader of `*.hq` texts: converts pest nodes to the tree, declaration by declaration.

mod allowances;
mod blocks;
mod headless;
mod items;
mod levels;
mod machines;
mod missions;
mod parts;
mod reuse;
mod scenarios;
mod states;

pub(crate) use items::{KEYWORDS, bad_version, no_header};

use crate::comments::Pool;
use crate::expr::{self, Place};
use crate::grammar::{Grammar, Pair, Rule};
use crate::tree::{BlockKind, Spec, Value, ValueKind};
use crate::{Diagnostic, SourceId, Span, limits};
use pest::Parser;

/// Reads a text.
pub(crate) fn parse(source: SourceId, text: &str) -> (Spec, Vec<Diagnostic>) {
    if let Some(refusal) = limits::check_size(source, text) {
        return (Spec::default(), vec![refusal]);
    }
    let begin = if text.starts_with('\u{feff}') { 3 } else { 0 };
    let scan = limits::scan(source, text, begin);
    if let Some(refusal) = scan.refused {
        return (Spec::default(), vec![refusal]);
    }
    let pool = Pool::new(text, scan.comments);
    let mut reader = Reader {
        source,
        text,
        base: begin,
        pool,
        diags: scan.diagnostics,
        unread: Vec::new(),
        read: 0,
        nested: false,
        meant: None,
        states: 0,
        closers: None,
    };
    let mut spec = reader.spec(begin);
    spec.unread = reader.unread;
    (spec, crate::checks::finish(reader.diags))
}

/// State while reading one text.
struct Reader<'t> {
    source: SourceId,
    text: &'t str,
    /// Start of the piece that pest parsed last.
    base: usize,
    pool: Pool<'t>,
    diags: Vec<Diagnostic>,
    /// Text that could not be interpreted.
    unread: Vec<Span>,
    /// The text before this byte has been read already.
    read: usize,
    /// True inside a repetition.
    nested: bool,
    /// The declaration that a misspelt keyword, which is read next, was taken for.
    meant: Option<BlockKind>,
    /// Number of nested states.
    states: usize,
    /// The closing brackets; set once a block lacks its opening brace.
    closers: Option<headless::Closers>,
}

impl<'t> Reader<'t> {
    fn spec(&mut self, begin: usize) -> Spec {
        let mut spec = Spec::default();
        let mut at = begin;
        let mut header: Option<Span> = None;
        loop {
            self.base = at;
            let chunk = match Grammar::parse(Rule::chunk, &self.text[at..]) {
                Ok(mut pairs) => pairs.next(),
                Err(_) => {
                    // The rule `chunk` fails only if pest refuses to recurse further.
                    self.diags.push(limits::too_deep(self.span(at, at)));
                    break;
                }
            };
            let Some(chunk) = chunk else { break };
            let end = at + chunk.as_span().end();
            let Some(item) = chunk.into_inner().next() else { break };
            if item.as_rule() == Rule::header {
                self.header(item, &mut spec, &mut header);
            } else {
                if header.is_none() && spec.items.is_empty() {
                    let start = at + item.as_span().start();
                    header = Some(self.span(start, start));
                    self.diags.push(items::no_header(self.span(start, start), "hierarq 1"));
                }
                self.item(item, &mut spec.items);
            }
            if end <= at {
                break;
            }
            at = end.max(self.read);
        }
        if header.is_none() {
            self.diags.push(items::no_header(self.span(begin, begin), "hierarq 1"));
        }
        self.pool.before(usize::MAX, &mut spec.closing_comments.before);
        spec
    }

    fn place(&self) -> Place {
        Place::Exact(self.source, self.base)
    }

    fn span(&self, start: usize, end: usize) -> Span {
        Span::new(self.source, start, end)
    }

    fn of(&self, pair: &Pair<'_>) -> Span {
        self.place().of(pair)
    }

    /// Converts a node `expr`.
    fn expr(&mut self, pair: Pair<'_>) -> Value {
        let place = self.place();
        let mut diags = std::mem::take(&mut self.diags);
        let value = expr::value(pair, place, &mut diags, &mut |part, diags| {
            std::mem::swap(&mut self.diags, diags);
            // A list cannot store a comment after an inner brace; a filled slot leaves the comment to the first key.
            let mut value = self.value(part, &mut Some(String::new()));
            if let ValueKind::Block(block) = &mut value.kind {
                self.pool.behind(value.span.range().end, &[','], &mut block.closing_comments.behind);
            }
            std::mem::swap(&mut self.diags, diags);
            value
        });
        self.diags = diags;
        value
    }

    /// Parses the bytes `start..end` again with another rule and passes the node to `f`.
    fn again(&mut self, rule: Rule, start: usize, end: usize, f: impl FnOnce(&mut Self, Pair<'_>)) {
        let text = self.text;
        if let Some(pair) = text.get(start..end).and_then(|t| Grammar::parse(rule, t).ok()).and_then(|mut p| p.next()) {
            let base = std::mem::replace(&mut self.base, start);
            f(self, pair);
            self.base = base;
        }
    }

    /// Reports the brace at byte `open` as not closed before byte `end`.
    fn unclosed(&mut self, open: usize, end: usize) {
        let mut diagnostic = crate::explain::unclosed(Place::Exact(self.source, 0), open, '{');
        if let Some((from, to)) = blocks::misaligned(self.text, open + 1, end) {
            diagnostic = diagnostic
                .label(self.span(from, from + 1), "this one may be closed too late")
                .label(self.span(to, to + 1), "its closing brace is in another column");
        }
        self.diags.push(diagnostic);
    }
}
