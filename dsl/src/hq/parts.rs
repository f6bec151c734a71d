//! The parts of a declaration after its keyword (name, sign, value and block), and the diagnostics for missing ones.

use super::Reader;
use crate::diagnostic::Topic;
use crate::explain::{self, After};
use crate::expr::{Place, missing};
use crate::fix::Fix;
use crate::grammar::{Pair, Rule};
use crate::tree::{Block, Comments, Param, Stack, Task, TaskDefinition, Value};
use crate::{Diagnostic, Span, Spanned, checks};

/// The parts of a declaration, by kind.
#[derive(Default)]
pub(super) struct Parts<'p> {
    pub(super) name: Option<Spanned<String>>,
    pub(super) mark: Option<Span>,
    pub(super) formals: Option<Pair<'p>>,
    pub(super) from: Option<Pair<'p>>,
    pub(super) body: Option<Pair<'p>>,
    /// The range of a `param`.
    pub(super) range: Option<Pair<'p>>,
    pub(super) junk: Option<Span>,
}

impl Reader<'_> {
    pub(super) fn name(&mut self, parts: &Parts<'_>, keyword: Span) -> Option<Spanned<String>> {
        if parts.name.is_none() {
            let word = self.text.get(keyword.range()).unwrap_or("").to_owned();
            self.diags.push(
                Diagnostic::incomplete("HQ0116", keyword, format!("this `{word}` has no name"))
                    .help(format!("write the name after `{word}`: letters, digits and `_`")),
            );
        }
        parts.name.clone()
    }

    /// Reports text that cannot be read, which another reader does not report.
    pub(super) fn junk(&mut self, junk: Span, after: After<'_>) {
        let range = junk.range();
        let place = Place::Exact(self.source, 0);
        self.diags.push(explain::junk(self.text, range.start, range.end, place, after, false));
    }

    /// Reports text that cannot be read. Returns true if it is a word in place of a unit.
    pub(super) fn explain(&mut self, junk: Span, after: After<'_>, unit_only: bool) -> bool {
        let range = junk.range();
        let place = Place::Exact(self.source, 0);
        self.unread.push(junk);
        let diagnostic = explain::junk(self.text, range.start, range.end, place, after, unit_only);
        let topic = diagnostic.topic.clone();
        // A second error for the brace that closes a block on this line: its declaration lost a bracket before it,
        // which is reported already.
        let lost = |d: &Diagnostic| {
            let from = d.primary.span.range().start;
            d.topic == Topic::OpenBracket && self.text.get(from..range.start).is_some_and(|t| !t.contains('\n'))
        };
        if topic != Topic::LooseBracket || !self.diags.last().is_some_and(lost) {
            self.diags.push(diagnostic);
        }
        topic == Topic::UnknownUnit
    }

    /// Reports a missing or wrong `=` after a name.
    fn equals(&mut self, parts: &Parts<'_>, what: &str) {
        let Some(name) = &parts.name else { return };
        match parts.mark {
            Some(mark) if &self.text[mark.range()] == "=" => {}
            Some(mark) => self.diags.push(
                Diagnostic::error("HQ0104", mark, format!("expected `=` after the name of a {what}, found `:`"))
                    .help(format!("write `{what} {} = ..`", name.value))
                    .fix(Fix::sign(name.span, mark, "=").certain()),
            ),
            None if parts.body.is_some() || parts.junk.is_some() => {
                let at = name.span.range().end;
                self.diags.push(
                    Diagnostic::error("HQ0104", self.span(at, at), format!("`=` is missing after `{}`", name.value))
                        .label(name.span, format!("the name of the {what}"))
                        .help(format!("write `{what} {} = ..`", name.value))
                        .fix(Fix::insert("Write `=`", name.span, " =").certain()),
                );
            }
            None => {}
        }
    }

    pub(super) fn no_mark(&mut self, parts: &Parts<'_>, what: &str) {
        if let Some(mark) = parts.mark {
            let sign = &self.text[mark.range()];
            let diagnostic =
                Diagnostic::error("HQ0104", mark, format!("unexpected `{sign}` after the name of a {what}"));
            self.diags
                .push(diagnostic.help("delete it; the block follows the name").fix(Fix::delete(mark, sign).certain()));
        }
    }

    pub(super) fn param(&mut self, mut parts: Parts<'_>, keyword: Span, comments: &mut Comments) -> Option<Param> {
        let range = parts.range.take();
        let (name, value) = self.named_value(parts, keyword, "param", comments);
        let at = value.span.range().end;
        let mut range = match range {
            Some(pair) => self.block(pair, &mut comments.behind),
            None => Block { span: self.span(at, at), ..Block::default() },
        };
        checks::range(&mut range, &mut self.diags);
        name.map(|name| Param { name, value, range })
    }

    /// Reads `NAME = VALUE`; does not use the range of a `param`.
    pub(super) fn named_value(
        &mut self,
        parts: Parts<'_>,
        keyword: Span,
        what: &str,
        comments: &mut Comments,
    ) -> (Option<Spanned<String>>, Value) {
        let name = self.name(&parts, keyword);
        self.equals(&parts, what);
        let shown = name.as_ref().map_or(what, |n| n.value.as_str());
        let at = name.as_ref().map_or(keyword, |n| n.span);
        let value = match (parts.body, parts.junk) {
            (Some(body), junk) => {
                let mut value = self.expr(body);
                self.pool.before(value.span.range().end, &mut comments.before);
                if let Some(junk) = junk
                    && self.explain(junk, After::Value(&value), true)
                {
                    value = missing(value.span);
                }
                value
            }
            (None, Some(junk)) => {
                self.explain(junk, After::Key(shown), true);
                missing(junk)
            }
            (None, None) => {
                if name.is_some() {
                    self.diags.push(
                        Diagnostic::incomplete("HQ0107", at, format!("`{shown}` has no value"))
                            .help(format!("write `{what} {shown} = 0.5 m`, with the value you mean")),
                    );
                }
                missing(at)
            }
        };
        (name, value)
    }

    pub(super) fn task(&mut self, mut parts: Parts<'_>, keyword: Span, comments: &mut Comments) -> Option<Task> {
        let name = self.name(&parts, keyword);
        let parameters = parts.formals.take().map(|pair| self.parameters(pair)).unwrap_or_default();
        self.equals(&parts, "task");
        let junk = parts.junk;
        let definition = parts.body.map(|body| self.definition(body, &mut comments.behind));
        let at = junk.or(name.as_ref().map(|n| n.span)).unwrap_or(keyword);
        match (&definition, junk) {
            (Some(_), Some(junk)) => {
                self.explain(junk, After::Start("a new line"), false);
            }
            (None, Some(junk)) => {
                self.explain(junk, After::Start("a task type"), false);
            }
            (None, None) => {
                if let Some(name) = &name {
                    self.diags.push(
                        Diagnostic::incomplete(
                            "HQ0107",
                            name.span,
                            format!("the task `{}` is not defined", name.value),
                        )
                        .help(format!("write `task {} = KIND {{ .. }}`", name.value)),
                    );
                }
            }
            (Some(_), None) => {}
        }
        let definition = definition.unwrap_or_else(|| TaskDefinition::unread(at));
        Some(Task { name: name?, parameters, definition })
    }

    /// Converts a node `definition`: `kind(args) { .. }`.
    pub(super) fn definition(&mut self, pair: Pair<'_>, behind: &mut Option<String>) -> TaskDefinition {
        let span = self.of(&pair);
        let mut kind = Spanned::new(String::new(), span);
        let (mut args, mut named) = (Vec::new(), Vec::new());
        let mut body = Block { span: self.span(span.range().end, span.range().end), ..Block::default() };
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::name => kind = self.place().spanned(&part),
                Rule::actuals => (args, named) = self.arguments(part),
                _ => body = self.block(part, behind),
            }
        }
        TaskDefinition { kind, args, named, body, span }
    }

    /// Reads the block of a robot, a human, a safety field, a coverage or a run.
    pub(super) fn body(&mut self, parts: Parts<'_>, keyword: Span, what: &str, comments: &mut Comments) -> Block {
        match (parts.body, parts.junk) {
            (Some(body), _) => return self.block(body, &mut comments.behind),
            (None, Some(junk)) => {
                let example = match what {
                    "run" => Some("run { stack NAME  duration 10 s }"),
                    "coverage" => Some("coverage { velocity hard }"),
                    _ => None,
                };
                if let Some(example) = example
                    && self.text[junk.range()].starts_with(|c: char| c.is_ascii_alphabetic())
                {
                    self.diags.push(
                        Diagnostic::unreadable("HQ0113", junk, format!("`{what}` takes no name"))
                            .help(format!("write `{example}`")),
                    );
                } else {
                    self.explain(junk, After::Start("a block in braces"), false);
                }
            }
            (None, None) => self.diags.push(
                Diagnostic::incomplete("HQ0117", keyword, format!("this `{what}` has no block")).help(format!(
                    "write `{{ .. }}` after {}",
                    if matches!(what, "run" | "coverage") { format!("`{what}`") } else { "its name".to_string() }
                )),
            ),
        }
        Block { span: keyword, ..Block::default() }
    }

    pub(super) fn stack(&mut self, mut parts: Parts<'_>, keyword: Span, comments: &mut Comments) -> Option<Stack> {
        self.no_mark(&parts, "stack");
        let name = self.name(&parts, keyword);
        let parameters = parts.formals.take().map(|pair| self.parameters(pair)).unwrap_or_default();
        let from = parts.from.is_some();
        let base = parts.from.take().and_then(|pair| self.from(pair, "stack"));
        let at = name.as_ref().map_or(keyword, |n| n.span);
        let settings = Block { span: keyword, ..Block::default() };
        let name = name.unwrap_or_else(|| crate::calls::nameless(keyword));
        let mut stack = Stack { name, parameters, base, settings, levels: Vec::new(), changes: Vec::new() };
        match (parts.body, parts.junk) {
            (Some(body), _) => self.stack_body(body, &mut stack, &mut comments.behind),
            (None, Some(junk)) => {
                self.explain(junk, After::Start("a block in braces"), false);
            }
            (None, None) => self.diags.push(
                Diagnostic::incomplete("HQ0117", keyword, "this `stack` has no block")
                    .help("write `{ level NAME { .. } }` after its name"),
            ),
        }
        checks::duplicates(&stack.settings.entries, &mut self.diags);
        checks::reserved(&mut stack.settings, checks::STACK_WORDS, "stack", &mut self.diags);
        checks::changes(&mut stack, at, from, &mut self.diags);
        (!stack.name.value.is_empty()).then_some(stack)
    }
}
