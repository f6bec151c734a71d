//! Declarations: `hierarq`, `param`, `robot`, `human`, `safety_field`, `task`, `stack`, `run`; the others stand in `reuse`.

use super::Reader;
use crate::explain::{self, After, clip};
use crate::expr::{Place, missing};
use crate::grammar::{Pair, Rule};
use crate::tree::{
    Block, Comments, Human, Item, ItemKind, Param, Robot, Run, SafetyField, Spec, Stack, Task, TaskDefinition, Value,
};
use crate::words::nearest;
use crate::{Diagnostic, Span, Spanned, checks};

/// The words that begin a declaration.
pub(crate) const KEYWORDS: &[&str] = &[
    "import",
    "param",
    "let",
    "robot",
    "task",
    "stack",
    "signal",
    "human",
    "safety_field",
    "variable",
    "machine",
    "scenario",
    "for",
    "run",
];

/// The header is missing; `line` is what to write.
pub(crate) fn no_header(span: Span, line: &str) -> Diagnostic {
    Diagnostic::error("HQ0101", span, "the spec does not say its language version")
        .note("the version lets a later Hierarq read this file as it was meant")
        .help(format!("write `{line}` at the top"))
}

/// The version is not one that this reader knows.
pub(crate) fn bad_version(span: Span, written: &str) -> Diagnostic {
    Diagnostic::error("HQ0102", span, format!("language version `{}` is not known", clip(written)))
        .here("this Hierarq reads version 1")
        .help("write `1`, or read the spec with the Hierarq it was written for")
}

/// The parts of a declaration, by kind.
#[derive(Default)]
pub(super) struct Parts<'p> {
    name: Option<Spanned<String>>,
    mark: Option<Span>,
    formals: Option<Pair<'p>>,
    from: Option<Pair<'p>>,
    body: Option<Pair<'p>>,
    /// The range of a `param`.
    range: Option<Pair<'p>>,
    junk: Option<Span>,
}

impl Reader<'_> {
    pub(super) fn header(&mut self, pair: Pair<'_>, spec: &mut Spec, header: &mut Option<Span>) {
        let whole = self.of(&pair);
        let word = self.span(whole.range().start, whole.range().start + "hierarq".len());
        if let Some(first) = header {
            let first = *first;
            let twice = spec.version.is_some();
            let diagnostic = Diagnostic::error("HQ0101", word, "the language version stands once, at the top");
            if twice {
                self.diags.push(diagnostic.label(first, "already said here").help("delete this line"));
            } else {
                // Reported as missing where the first declaration began; one message is enough.
                self.diags.retain(|d| d.code != "HQ0101");
                self.diags.push(diagnostic.help("move it before the first declaration"));
            }
            return;
        }
        *header = Some(word);
        self.pool.before(whole.range().start, &mut spec.opening_comments.before);
        let mut said = false;
        for part in pair.into_inner() {
            let span = self.of(&part);
            if part.as_rule() == Rule::version {
                said = true;
                let number = part.as_str();
                if number != "1" {
                    self.diags.push(bad_version(span, number));
                }
                spec.version = number.parse().ok().map(|n| Spanned::new(n, span));
            } else if said {
                let place = Place::Exact(self.source, 0);
                let range = span.range();
                self.diags.push(explain::junk(
                    self.text,
                    range.start,
                    range.end,
                    place,
                    After::Start("a new line"),
                    false,
                ));
            } else {
                said = true;
                self.diags.push(bad_version(span, part.as_str().trim_end()).help("write `hierarq 1`"));
            }
        }
        if !said {
            self.diags.push(Diagnostic::error("HQ0102", word, "`hierarq` lacks its number").help("write `hierarq 1`"));
        }
        self.pool.behind(whole.range().end, &[], &mut spec.opening_comments.behind);
    }

    /// A node of a declaration: adds it to `items`.
    pub(super) fn item(&mut self, pair: Pair<'_>, items: &mut Vec<Item>) {
        let start = self.of(&pair).range().start;
        let word = |n: usize| self.span(start, start + n);
        let keyword = match pair.as_rule() {
            Rule::import => word(6),
            Rule::param | Rule::robot | Rule::stack | Rule::human => word(5),
            Rule::task => word(4),
            Rule::safety => word(12),
            Rule::signal => word(6),
            Rule::machine => word(7),
            Rule::scenario | Rule::variable => word(8),
            Rule::run | Rule::let_ | Rule::repeat => word(3),
            _ => return self.stray(pair, items),
        };
        if let Some(rest) = pair.into_inner().next() {
            self.rest(rest, keyword, items);
        }
    }

    /// The part of a declaration behind its keyword.
    fn rest(&mut self, pair: Pair<'_>, keyword: Span, items: &mut Vec<Item>) {
        let mut comments = Comments::default();
        self.pool.before(keyword.range().start, &mut comments.before);
        let rule = pair.as_rule();
        let mut end = self.base + pair.as_str().trim_end().len() + pair.as_span().start();
        let kind = match rule {
            Rule::import_rest => self.import(pair, keyword, &mut comments).map(ItemKind::Import),
            Rule::repeat_rest => self.repeat(pair, keyword, &mut comments).map(ItemKind::For),
            Rule::signal_rest => self.signal(pair, keyword, &mut comments).map(ItemKind::Signal),
            Rule::variable_rest => self.variable(pair, keyword, &mut comments).map(ItemKind::Variable),
            Rule::machine_rest => self.machine(pair, keyword, &mut end, &mut comments).map(ItemKind::Machine),
            Rule::scenario_rest => self.scenario(pair, keyword, &mut end, &mut comments).map(ItemKind::Scenario),
            _ => self.named(pair, keyword, &mut end, &mut comments),
        };
        let end = end.max(keyword.range().end);
        self.pool.behind(end, &[';'], &mut comments.behind);
        if let Some(kind) = kind {
            items.push(Item { kind, span: self.span(keyword.range().start, end), comments });
        }
    }

    /// What is declared, of the declarations that begin with a name.
    /// `end` is where it ends; a body that lacks its opening brace moves it.
    fn named(&mut self, pair: Pair<'_>, keyword: Span, end: &mut usize, comments: &mut Comments) -> Option<ItemKind> {
        let rule = pair.as_rule();
        let mut parts = Parts::default();
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::name => parts.name = Some(self.place().spanned(&part)),
                Rule::mark => parts.mark = Some(self.of(&part)),
                Rule::junk => parts.junk = Some(self.of(&part)),
                Rule::formals => parts.formals = Some(part),
                Rule::from => parts.from = Some(part),
                Rule::block if rule == Rule::param_rest => parts.range = Some(part),
                _ => parts.body = Some(part),
            }
        }
        // Inside a repetition, the next brace is that of the repetition.
        let unclosed = !self.nested
            && parts.junk.is_none()
            && match &parts.body {
                None => {
                    parts.from.is_none()
                        && matches!(
                            rule,
                            Rule::robot_rest | Rule::human_rest | Rule::safety_rest | Rule::stack_rest | Rule::run_rest
                        )
                }
                Some(body) => rule == Rule::task_rest && body.clone().into_inner().all(|p| p.as_rule() != Rule::block),
            };
        let headless = if unclosed { self.headless(*end) } else { None };
        if let Some(block) = &headless {
            let what = self.text.get(keyword.range()).unwrap_or("");
            self.no_brace(&format!("`{what}`"), keyword, block);
        }
        let base = self.base;
        if let Some(block) = headless.as_ref().filter(|_| rule != Rule::task_rest) {
            self.base = block.open;
            parts.body = block.pair(if rule == Rule::stack_rest { Rule::stack_body } else { Rule::block });
        }
        let mut kind = match rule {
            Rule::param_rest => self.param(parts, keyword, comments).map(ItemKind::Param),
            Rule::let_rest => self.let_(parts, keyword, comments).map(ItemKind::Let),
            Rule::task_rest => self.task(parts, keyword, comments).map(ItemKind::Task),
            Rule::robot_rest => {
                self.no_mark(&parts, "robot");
                let name = self.name(&parts, keyword);
                let base = parts.from.take().and_then(|from| self.from(from, "robot"));
                if let Some(call) = base.as_ref().filter(|call| call.span != call.name.span) {
                    let at = Span::new(self.source, call.name.span.range().end, call.span.range().end);
                    let diagnostic = Diagnostic::error("HQ0128", at, "a robot takes nothing in parentheses");
                    self.diags.push(diagnostic.help("write what differs in braces: `{ home { .. } }`"));
                }
                let mut body = self.body(parts, keyword, "robot", comments);
                checks::reserved(&mut body, &["from"], "robot", &mut self.diags);
                name.map(|name| ItemKind::Robot(Robot { name, base: base.map(|call| call.name), body }))
            }
            Rule::human_rest => {
                self.no_mark(&parts, "human");
                let name = self.name(&parts, keyword);
                let mut body = self.body(parts, keyword, "human", comments);
                checks::reserved(&mut body, &[], "human", &mut self.diags);
                name.map(|name| ItemKind::Human(Human { name, body }))
            }
            Rule::safety_rest => {
                self.no_mark(&parts, "safety_field");
                let name = self.name(&parts, keyword);
                let mut body = self.body(parts, keyword, "safety_field", comments);
                checks::reserved(&mut body, &[], "safety_field", &mut self.diags);
                name.map(|name| ItemKind::SafetyField(SafetyField { name, body }))
            }
            Rule::stack_rest => self.stack(parts, keyword, comments).map(ItemKind::Stack),
            _ => Some(ItemKind::Run(Run { body: self.body(parts, keyword, "run", comments) })),
        };
        if let (Some(ItemKind::Task(task)), Some(block)) = (&mut kind, &headless) {
            self.base = block.open;
            if let Some(pair) = block.pair(Rule::block) {
                task.definition.body = self.block(pair, &mut comments.behind);
            }
        }
        self.base = base;
        if let Some(block) = headless {
            self.read = block.end;
            *end = block.end;
        }
        kind
    }

    fn name(&mut self, parts: &Parts<'_>, keyword: Span) -> Option<Spanned<String>> {
        if parts.name.is_none() {
            let word = self.text.get(keyword.range()).unwrap_or("").to_owned();
            self.diags.push(
                Diagnostic::error("HQ0116", keyword, format!("this `{word}` has no name"))
                    .help(format!("write the name behind `{word}`: letters, digits and `_`")),
            );
        }
        parts.name.clone()
    }

    pub(super) fn explain(&mut self, junk: Span, after: After<'_>, unit_only: bool) -> &'static str {
        let range = junk.range();
        let place = Place::Exact(self.source, 0);
        self.unread.push(junk);
        let diagnostic = explain::junk(self.text, range.start, range.end, place, after, unit_only);
        let code = diagnostic.code;
        // The brace that closes a block of the same line, whose declaration lost a bracket before it.
        let lost = |d: &Diagnostic| {
            let from = d.primary.span.range().start;
            d.code == "HQ0105" && self.text.get(from..range.start).is_some_and(|t| !t.contains('\n'))
        };
        if code != "HQ0106" || !self.diags.last().is_some_and(lost) {
            self.diags.push(diagnostic);
        }
        code
    }

    /// Reports a missing or wrong `=` behind a name.
    fn equals(&mut self, parts: &Parts<'_>, what: &str) {
        let Some(name) = &parts.name else { return };
        match parts.mark {
            Some(mark) if &self.text[mark.range()] == "=" => {}
            Some(mark) => self.diags.push(
                Diagnostic::error("HQ0104", mark, format!("`=` stands behind the name of a {what}, not `:`"))
                    .help(format!("write `{what} {} = ..`", name.value)),
            ),
            None if parts.body.is_some() || parts.junk.is_some() => {
                let at = name.span.range().end;
                self.diags.push(
                    Diagnostic::error("HQ0104", self.span(at, at), format!("`=` is missing behind `{}`", name.value))
                        .label(name.span, format!("the name of the {what}"))
                        .help(format!("write `{what} {} = ..`", name.value)),
                );
            }
            None => {}
        }
    }

    fn no_mark(&mut self, parts: &Parts<'_>, what: &str) {
        if let Some(mark) = parts.mark {
            let sign = &self.text[mark.range()];
            let diagnostic =
                Diagnostic::error("HQ0104", mark, format!("no `{sign}` stands behind the name of a {what}"));
            self.diags.push(diagnostic.help("delete it; the block follows the name"));
        }
    }

    fn param(&mut self, mut parts: Parts<'_>, keyword: Span, comments: &mut Comments) -> Option<Param> {
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

    /// `NAME = VALUE`; the range of a `param` is left.
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
                    && self.explain(junk, After::Value(&value), true) == "HQ0112"
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
                        Diagnostic::error("HQ0107", at, format!("`{shown}` has no value"))
                            .help(format!("write `{what} {shown} = 0.5 m`, with the value you mean")),
                    );
                }
                missing(at)
            }
        };
        (name, value)
    }

    fn task(&mut self, mut parts: Parts<'_>, keyword: Span, comments: &mut Comments) -> Option<Task> {
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
                        Diagnostic::error("HQ0107", name.span, format!("the task `{}` is not defined", name.value))
                            .help(format!("write `task {} = KIND {{ .. }}`", name.value)),
                    );
                }
            }
            (Some(_), None) => {}
        }
        let definition = definition.unwrap_or_else(|| TaskDefinition::unread(at));
        Some(Task { name: name?, parameters, definition })
    }

    /// A node `definition`: `kind(args) { .. }`.
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

    /// The block of a robot, a human, a safety field or a run.
    fn body(&mut self, parts: Parts<'_>, keyword: Span, what: &str, comments: &mut Comments) -> Block {
        match (parts.body, parts.junk) {
            (Some(body), _) => return self.block(body, &mut comments.behind),
            (None, Some(junk)) => {
                if what == "run" && self.text[junk.range()].starts_with(|c: char| c.is_ascii_alphabetic()) {
                    self.diags.push(
                        Diagnostic::error("HQ0113", junk, "a run has no name")
                            .help("write `run { stack NAME  duration 10 s }`"),
                    );
                } else {
                    self.explain(junk, After::Start("a block in braces"), false);
                }
            }
            (None, None) => self.diags.push(
                Diagnostic::error("HQ0117", keyword, format!("this `{what}` has no block"))
                    .help(format!("write `{{ .. }}` behind {}", if what == "run" { "`run`" } else { "its name" })),
            ),
        }
        Block { span: keyword, ..Block::default() }
    }

    fn stack(&mut self, mut parts: Parts<'_>, keyword: Span, comments: &mut Comments) -> Option<Stack> {
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
                Diagnostic::error("HQ0117", keyword, "this `stack` has no block")
                    .help("write `{ level NAME { .. } }` behind its name"),
            ),
        }
        checks::duplicates(&stack.settings.entries, &mut self.diags);
        checks::reserved(&mut stack.settings, checks::STACK_WORDS, "stack", &mut self.diags);
        checks::changes(&mut stack, at, from, &mut self.diags);
        (!stack.name.value.is_empty()).then_some(stack)
    }

    /// Text at the top level that begins no declaration.
    fn stray(&mut self, pair: Pair<'_>, items: &mut Vec<Item>) {
        let span = self.of(&pair);
        let (start, end) = (span.range().start, span.range().end);
        let text = self.text;
        let length = text[start..end].find(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).unwrap_or(end - start);
        let word = &text[start..start + length];
        if !crate::words::is_name(word) {
            self.explain(span, After::Start("a declaration"), false);
            return;
        }
        let keyword = self.span(start, start + length);
        let diagnostic = Diagnostic::error("HQ0103", keyword, format!("`{}` begins no declaration", clip(word)));
        let Some(meant) = nearest(word, KEYWORDS) else {
            self.unread.push(span);
            self.diags.push(if word == "level" {
                diagnostic.note("a level stands inside the braces of a stack").help("write `stack NAME { level .. }`")
            } else {
                let words =
                    "declarations begin with `import`, `param`, `let`, `robot`, `task`, `stack`, `signal`, `human`, `safety_field`, `variable`, `machine`, `scenario`, `for` or `run`";
                diagnostic.note(words)
            });
            return;
        };
        self.diags.push(diagnostic.help(format!("did you mean `{meant}`?")));
        let rule = match meant {
            "import" => Rule::import_rest,
            "param" => Rule::param_rest,
            "let" => Rule::let_rest,
            "for" => Rule::repeat_rest,
            "robot" => Rule::robot_rest,
            "task" => Rule::task_rest,
            "stack" => Rule::stack_rest,
            "signal" => Rule::signal_rest,
            "human" => Rule::human_rest,
            "safety_field" => Rule::safety_rest,
            "variable" => Rule::variable_rest,
            "machine" => Rule::machine_rest,
            "scenario" => Rule::scenario_rest,
            _ => Rule::run_rest,
        };
        self.again(rule, start + length, end, |reader, pair| reader.rest(pair, keyword, items));
    }
}
