//! Scalars with expressions or task definitions in the native grammar.

use super::Reader;
use super::events::{NodeId, Style};
use crate::calls;
use crate::diagnostic::Topic;
use crate::explain::{self, After};
use crate::expr::{Place, missing};
use crate::grammar::{Grammar, Pair, Rule};
use crate::limits::{MAX_DEPTH, too_deep};
use crate::tree::{Block, Entry, TaskDefinition, Value, ValueKind};
use crate::words::is_glob;
use crate::{Diagnostic, Spanned};
use pest::Parser;

impl Reader<'_> {
    /// Returns the text of a scalar and its place: byte-exact if the source spells it the same.
    pub(super) fn spelled(&self, id: NodeId) -> (String, Place) {
        let span = self.span(id);
        let Some((value, style)) = self.scalar(id) else { return (String::new(), Place::Whole(span)) };
        let range = span.range();
        let inset = usize::from(style == Style::Quoted);
        let (start, end) = (range.start + inset, range.end.saturating_sub(inset));
        let raw = self.text.get(start..end.max(start)).unwrap_or("");
        let place = if raw.starts_with(value) && style != Style::Block {
            Place::Exact(self.source, start)
        } else {
            Place::Whole(span)
        };
        (value.to_owned(), place)
    }

    /// Reports text that must not reach the grammar: brackets nested too deeply, comments of the other syntax.
    pub(super) fn unfit(&self, text: &str, place: Place) -> Option<Diagnostic> {
        let bytes = text.as_bytes();
        let (mut depth, mut at) = (0usize, 0usize);
        while let Some(&byte) = bytes.get(at) {
            match byte {
                b'"' => {
                    if let Some(end) = crate::limits::text_end(text, at) {
                        at = end;
                        continue;
                    }
                }
                b'(' | b'[' | b'{' => {
                    depth += 1;
                    if depth > MAX_DEPTH {
                        return Some(too_deep(place.span(at, at + 1)));
                    }
                }
                b')' | b']' | b'}' => depth = depth.saturating_sub(1),
                b'/' if bytes.get(at + 1) == Some(&b'/') => {
                    let diagnostic =
                        Diagnostic::unreadable("HQ0113", place.span(at, at + 2), "`//` is unexpected here");
                    return Some(
                        diagnostic.help("comments in YAML begin with ` #`; a text needs quotes of its own: `'\"..\"'`"),
                    );
                }
                _ => {}
            }
            at += 1;
        }
        None
    }

    /// Parses a scalar as an expression.
    pub(super) fn expression(&mut self, id: NodeId, key: Option<&Spanned<String>>) -> Value {
        let span = self.span(id);
        let (text, place) = self.spelled(id);
        if is_glob(&text) && self.scalar(id).is_some_and(|s| s.1 != Style::Block) {
            return Value { kind: ValueKind::Text(text), span };
        }
        if let Some(diagnostic) = self.unfit(&text, place) {
            self.diags.push(diagnostic);
            return missing(span);
        }
        let parsed = Grammar::parse(Rule::scalar_expr, &text).ok().and_then(|mut p| p.next());
        let Some(parsed) = parsed else {
            self.diags.push(too_deep(span));
            return missing(span);
        };
        let (mut value, mut rest) = (None, None);
        for part in parsed.into_inner() {
            if part.as_rule() == Rule::within {
                value = Some(self.flat(part, place));
            } else {
                rest = Some(part.as_span().start());
            }
        }
        let start = rest.unwrap_or(text.len());
        if text[start..].trim().is_empty()
            && let Some(value) = value
        {
            return value;
        }
        let name = key.map_or("this item", |k| k.value.as_str());
        if text.trim().is_empty() {
            self.diags.push(explain::no_value(name, span).help("write the value between the quotes"));
            return missing(span);
        }
        let after = value.as_ref().map_or(After::Key(name), After::Value);
        let diagnostic = explain::junk(&text, start, text.len(), place, after, true);
        let unit = diagnostic.topic == Topic::UnknownUnit;
        self.diags.push(diagnostic);
        match value {
            Some(value) if !unit => value,
            _ => missing(span),
        }
    }

    /// Parses a scalar as `kind` or `kind(args)`, with the given `body`. The flag is true if there were parentheses.
    pub(super) fn task_head(&mut self, id: NodeId, body: Block) -> Option<(TaskDefinition, bool)> {
        let span = self.span(id);
        let (text, place) = self.spelled(id);
        if let Some(diagnostic) = self.unfit(&text, place) {
            self.diags.push(diagnostic);
            return None;
        }
        let parsed = Grammar::parse(Rule::scalar_task, &text).ok().and_then(|mut p| p.next())?;
        let (mut kind, mut args, mut rest) = (None, None, text.len());
        for part in parsed.into_inner() {
            match part.as_rule() {
                Rule::name => kind = Some(place.spanned(&part)),
                Rule::actuals => args = Some(part),
                _ => rest = part.as_span().start(),
            }
        }
        let called = args.is_some();
        let (args, named) = args.map(|args| self.args(args, place)).unwrap_or_default();
        if !text[rest..].trim().is_empty() || kind.is_none() {
            let start = if kind.is_some() && !called { 0 } else { rest };
            let diagnostic = if text.trim().is_empty() {
                Diagnostic::incomplete("HQ0116", span, "a task is missing here")
                    .help("write the name of a task or `KIND(..)`")
            } else {
                explain::junk(&text, start, text.len(), place, After::Start("a task, such as `hold(left)`,"), false)
            };
            self.diags.push(diagnostic);
        }
        let kind = kind?;
        let span = span.to(body.span);
        Some((TaskDefinition { kind, args, named, body, span }, called))
    }

    fn args(&mut self, args: Pair<'_>, place: Place) -> (Vec<Value>, Vec<Entry>) {
        let mut diags = Vec::new();
        let out = calls::arguments(args, place, &mut |part| self.flat(part, place), &mut diags);
        self.diags.extend(diags);
        out
    }
}
