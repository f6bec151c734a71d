//! Reader of declarations in `*.hq` texts: `hierarq`, `param`, `robot`, named blocks (`human`, `obstacle`), `task`,
//! `stack`, `coverage`, `run`. The modules beside this one read the others.

use super::Reader;
use super::parts::Parts;
use crate::diagnostic::Topic;
use crate::diagnostic::clip;
use crate::explain::After;
use crate::fix::Fix;
use crate::grammar::{Pair, Rule};
use crate::tree::{BlockKind, Comments, Coverage, Item, ItemKind, NamedBlock, Robot, Run, Spec};
use crate::vocabulary::ALLOW;
use crate::words::nearest;
use crate::{Diagnostic, Span, Spanned, checks};

/// The keywords of declarations.
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
    "obstacle",
    "variable",
    "machine",
    "mission",
    "scenario",
    "for",
    "coverage",
    "run",
];

/// Returns the diagnostic for a missing header; `line` is the line to write.
pub(crate) fn no_header(span: Span, line: &str) -> Diagnostic {
    let top = Span { start: 0, end: 0, ..span };
    Diagnostic::error("HQ0101", span, "the spec has no language version")
        .about(Topic::Header)
        .fix(Fix::edit(format!("Write `{line}` at the top"), top, format!("{line}\n")).certain())
        .note("with the version, a later Hierarq can read this file unchanged")
        .help(format!("write `{line}` at the top"))
}

/// Returns the diagnostic for a language version that this reader does not support.
pub(crate) fn bad_version(span: Span, written: &str) -> Diagnostic {
    Diagnostic::error("HQ0102", span, format!("language version `{}` is not known", clip(written)))
        .about(Topic::Header)
        .here("this Hierarq reads version 1")
        .help("write `1`, or use the Hierarq version that the spec was written for")
}

impl Reader<'_> {
    pub(super) fn header(&mut self, pair: Pair<'_>, spec: &mut Spec, header: &mut Option<Span>) {
        let whole = self.of(&pair);
        let word = self.span(whole.range().start, whole.range().start + "hierarq".len());
        if let Some(first) = header {
            let first = *first;
            let twice = spec.version.is_some();
            let diagnostic = Diagnostic::error("HQ0101", word, "the language version must appear once, at the top")
                .about(Topic::Header);
            if twice {
                self.diags.push(diagnostic.label(first, "already said here").help("delete this line"));
            } else {
                // The header was reported as missing at the first declaration, or as invalid: one message is enough.
                if let Some(told) = self.diags.iter().rposition(|d| d.topic == Topic::Header) {
                    self.diags.remove(told);
                }
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
                self.junk(span, After::Start("a new line"));
            } else {
                said = true;
                self.diags.push(bad_version(span, part.as_str().trim_end()).help("write `hierarq 1`"));
            }
        }
        if !said {
            self.diags.push(
                Diagnostic::error("HQ0102", word, "`hierarq` has no version number")
                    .about(Topic::Header)
                    .help("write `hierarq 1`")
                    .fix(Fix::insert("Write `1`", word, " 1").certain()),
            );
        }
        self.pool.behind(whole.range().end, &[], &mut spec.opening_comments.behind);
    }

    /// Converts a node of a declaration, and adds the declaration to `items`.
    pub(super) fn item(&mut self, pair: Pair<'_>, items: &mut Vec<Item>) {
        let start = self.of(&pair).range().start;
        let word = |n: usize| self.span(start, start + n);
        let keyword = match pair.as_rule() {
            Rule::allow => return self.allowed(pair, items),
            Rule::import => word(6),
            Rule::param | Rule::robot | Rule::stack => word(5),
            Rule::task => word(4),
            Rule::named_block => {
                let text = pair.as_str();
                word(text.find(|c: char| !c.is_ascii_alphabetic() && c != '_').unwrap_or(text.len()))
            }
            Rule::signal => word(6),
            Rule::machine | Rule::mission => word(7),
            Rule::scenario | Rule::variable | Rule::coverage => word(8),
            Rule::run | Rule::let_ | Rule::repeat => word(3),
            _ => return self.stray(pair, items),
        };
        if let Some(rest) = pair.into_inner().next() {
            self.rest(rest, keyword, items);
        }
    }

    /// Converts the part of a declaration after its keyword.
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
            Rule::mission_rest => self.mission(pair, keyword, &mut end, &mut comments).map(ItemKind::Mission),
            Rule::scenario_rest => self.scenario(pair, keyword, &mut end, &mut comments).map(ItemKind::Scenario),
            _ => self.named(pair, keyword, &mut end, &mut comments),
        };
        let end = end.max(keyword.range().end);
        self.pool.behind(end, &[';'], &mut comments.behind);
        if let Some(kind) = kind {
            items.push(Item { kind, span: self.span(keyword.range().start, end), comments });
        }
    }

    /// Converts a declaration that begins with a name. `end` is its end; a body with a missing opening brace moves it.
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
        // Inside a repetition, the next closing brace is that of the repetition.
        let unclosed = !self.nested
            && parts.junk.is_none()
            && match &parts.body {
                None => {
                    parts.from.is_none()
                        && matches!(
                            rule,
                            Rule::robot_rest
                                | Rule::block_rest
                                | Rule::stack_rest
                                | Rule::coverage_rest
                                | Rule::run_rest
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
                    self.diags.push(diagnostic.help("write the changes in braces: `{ home { .. } }`"));
                }
                let mut body = self.body(parts, keyword, "robot", comments);
                checks::reserved(&mut body, &["from"], "robot", &mut self.diags);
                name.map(|name| ItemKind::Robot(Robot { name, base: base.map(|call| call.name), body }))
            }
            Rule::block_rest => {
                let written = self.text.get(keyword.range()).unwrap_or_default();
                let kind = BlockKind::of_keyword(written).or_else(|| self.meant.take())?;
                self.no_mark(&parts, kind.keyword());
                let name = self.name(&parts, keyword);
                let mut body = self.body(parts, keyword, kind.keyword(), comments);
                checks::reserved(&mut body, &[], kind.keyword(), &mut self.diags);
                name.map(|name| ItemKind::Block(NamedBlock { kind, name, body }))
            }
            Rule::stack_rest => self.stack(parts, keyword, comments).map(ItemKind::Stack),
            Rule::coverage_rest => {
                Some(ItemKind::Coverage(Coverage { body: self.body(parts, keyword, "coverage", comments) }))
            }
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

    /// Handles text at the top level that begins no declaration.
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
        let diagnostic = Diagnostic::error("HQ0103", keyword, format!("`{}` is not a declaration", clip(word)));
        let Some(meant) = nearest(word, KEYWORDS) else {
            self.unread.push(span);
            self.diags.push(if word == ALLOW {
                diagnostic
                    .note("a warning is allowed by its code, with the reason")
                    .help("write `allow HQ0707 \"the reason\"`")
            } else if word == "level" {
                diagnostic.note("levels are declared inside a stack").help("write `stack NAME { level .. }`")
            } else {
                diagnostic.note(format!(
                    "a declaration begins with one of {}",
                    names::list(KEYWORDS.iter().copied(), KEYWORDS.len())
                ))
            });
            return;
        };
        self.diags.push(diagnostic.meant(meant));
        self.meant = BlockKind::of_keyword(meant);
        let rule = match meant {
            "import" => Rule::import_rest,
            "param" => Rule::param_rest,
            "let" => Rule::let_rest,
            "for" => Rule::repeat_rest,
            "robot" => Rule::robot_rest,
            "task" => Rule::task_rest,
            "stack" => Rule::stack_rest,
            "signal" => Rule::signal_rest,
            word if BlockKind::of_keyword(word).is_some() => Rule::block_rest,
            "variable" => Rule::variable_rest,
            "machine" => Rule::machine_rest,
            "mission" => Rule::mission_rest,
            "scenario" => Rule::scenario_rest,
            "coverage" => Rule::coverage_rest,
            _ => Rule::run_rest,
        };
        self.again(rule, start + length, end, |reader, pair| reader.rest(pair, keyword, items));
    }
}
