//! Reader of declarations that use others, in YAML: `import`, parameters of declarations, `from`, `changes`.

use std::collections::BTreeMap;

use super::Reader;
use super::events::{Kind, NodeId, Style};
use crate::calls;
use crate::diagnostic::clip;
use crate::explain;
use crate::expr::missing;
use crate::grammar::{Grammar, Pair, Rule};
use crate::tree::{
    Block, Call, Change, Comments, Import, ImportName, Item, ItemKind, Param, Parameter, Removal, Value, ValueKind,
};
use crate::words::is_name;
use crate::{Diagnostic, Span, Spanned, checks};
use pest::Parser;

impl Reader<'_> {
    /// Reads the entries of a section in which names may have parameters, `"reach(side: arm)": ..`, each with the span
    /// of its whole key.
    pub(super) fn heads(&mut self, id: NodeId) -> Vec<(Spanned<String>, Span, Vec<Parameter>, NodeId)> {
        let mut out: Vec<(Spanned<String>, Span, Vec<Parameter>, NodeId)> = Vec::new();
        let mut seen: BTreeMap<String, Span> = BTreeMap::new();
        for (key, value) in self.pairs(id) {
            let Some((name, parameters)) = self.head(key) else { continue };
            if let Some(first) = seen.get(&name.value) {
                self.diags.push(checks::duplicate(&name.value, *first, name.span));
                continue;
            }
            seen.insert(name.value.clone(), name.span);
            out.push((name, self.span(key), parameters, value));
        }
        out
    }

    fn head(&mut self, id: NodeId) -> Option<(Spanned<String>, Vec<Parameter>)> {
        let called = self.scalar(id).is_some_and(|(text, _)| text.contains('('));
        if !called {
            return self.key(id).map(|name| (name, Vec::new()));
        }
        let (text, place) = self.spelled(id);
        if let Some(diagnostic) = self.unfit(&text, place) {
            self.diags.push(diagnostic);
            return None;
        }
        let parsed = Grammar::parse(Rule::scalar_head, &text).ok().and_then(|mut p| p.next())?;
        let (mut name, mut parameters, mut rest) = (None, Vec::new(), text.len());
        for part in parsed.into_inner() {
            match part.as_rule() {
                Rule::name => name = Some(place.spanned(&part)),
                Rule::formals => {
                    let mut diags = Vec::new();
                    parameters = calls::parameters(part, place, &mut |part| self.flat(part, place), &mut diags);
                    self.diags.extend(diags);
                }
                _ => rest = part.as_span().start(),
            }
        }
        if !text[rest..].trim().is_empty() || name.is_none() {
            let start = if name.is_some() { rest } else { 0 };
            let message = format!("`{}` cannot be read as a name with its parameters", clip(text[start..].trim()));
            let diagnostic = Diagnostic::error("HQ0128", place.span(start, text.len()), message);
            self.diags.push(diagnostic.help("write `\"NAME(side: arm, gain: rate = 5 /s)\":`"));
        }
        name.map(|name| (name, parameters))
    }

    /// Converts a node `expr` that must not contain blocks.
    pub(super) fn flat(&mut self, pair: Pair<'_>, place: crate::expr::Place) -> Value {
        crate::expr::value(pair, place, &mut self.diags, &mut |block, diags| {
            let span = place.of(&block);
            diags.push(
                Diagnostic::unreadable("HQ0113", span, "a block of the native syntax is not allowed in YAML")
                    .help("write a YAML mapping"),
            );
            missing(span)
        })
    }

    /// Reads a `param`: a value, or a mapping with the value and its range.
    pub(super) fn param(&mut self, name: &Spanned<String>, id: NodeId, comments: &mut Comments) -> Param {
        // Keys that take text are keys of blocks only; a parameter may have such a name without taking text.
        let key = Some(name).filter(|n| !crate::words::is_text_key(&n.value));
        let at = self.later(id, name.span).range().end;
        let mut range = Block { span: Span::new(self.source, at, at), ..Block::default() };
        if !matches!(self.node(id).kind, Kind::Mapping(_)) {
            let value = self.value(id, key);
            self.pool.before(at, &mut comments.before);
            return Param { name: name.clone(), value, range };
        }
        let mut block = self.block(id);
        let value = block.entries.iter().position(|e| e.key.value == "value").map(|at| block.entries.remove(at));
        let value = match value {
            Some(entry) => {
                comments.before.extend(entry.comments.before);
                comments.behind = comments.behind.take().or(entry.comments.behind);
                entry.value
            }
            None => {
                let diagnostic = explain::no_value(&name.value, name.span);
                self.diags.push(diagnostic.help("write `{ value: 0.15 m, min: 0.05 m, max: 0.3 m }`"));
                missing(name.span)
            }
        };
        let mut value = value;
        if crate::words::has_block(&value) {
            self.wrong_shape(id, "a value", "a parameter is a single value, such as `0.5 m`");
            value.kind = ValueKind::Missing;
        }
        range.entries = block.entries;
        range.closing_comments = block.closing_comments;
        checks::range(&mut range, &mut self.diags);
        Param { name: name.clone(), value, range }
    }

    /// Removes the robot named by `from` from the body, and returns its name.
    pub(super) fn robot_base(&mut self, body: &mut Block, comments: &mut Comments) -> Option<Spanned<String>> {
        let at = body.entries.iter().position(|e| e.key.value == "from")?;
        let entry = body.entries.remove(at);
        comments.before.extend(entry.comments.before);
        comments.before.extend(entry.comments.behind);
        match entry.value.kind {
            ValueKind::Name(name) => Some(Spanned::new(name, entry.value.span)),
            ValueKind::Missing => None,
            _ => {
                let diagnostic = Diagnostic::incomplete("HQ0116", entry.value.span, "`from` names no robot");
                self.diags.push(diagnostic.help("write the name of the robot after `from:`"));
                None
            }
        }
    }

    /// Reads `guarded` or `guarded(left)`.
    pub(super) fn call(&mut self, id: NodeId, key: Span) -> Option<Call> {
        if self.scalar(id).is_none() || self.is_null(id) {
            let span = if self.is_null(id) { key } else { self.span(id) };
            let diagnostic = Diagnostic::incomplete("HQ0116", span, "`from` names no stack");
            self.diags.push(diagnostic.help("write the name of the stack after `from:`"));
            return None;
        }
        let span = self.span(id);
        let end = Span { start: span.end, ..span };
        let (definition, _) = self.task_head(id, Block { span: end, ..Block::default() })?;
        Some(Call { name: definition.kind, args: definition.args, named: definition.named, span })
    }

    /// Reads `changes`: `- { replace: motion, tasks: [..] }`, `- { add: extra, before: posture, tasks: [..] }`,
    /// `- { remove: posture }`.
    pub(super) fn changes(&mut self, id: NodeId) -> Vec<Change> {
        let Kind::Sequence(items) = &self.node(id).kind else {
            let help = "write `- replace: NAME`, `- add: NAME` or `- remove: NAME` for each";
            self.wrong_shape(id, "a sequence of changes", help);
            return Vec::new();
        };
        items.clone().into_iter().filter_map(|item| self.change(item)).collect()
    }

    fn change(&mut self, id: NodeId) -> Option<Change> {
        let words = ["replace", "add", "remove"];
        let help = "write `- replace: NAME`, `- add: NAME` or `- remove: NAME`";
        let word = match &self.node(id).kind {
            Kind::Mapping(own) => own.iter().find_map(|(k, v)| {
                let (text, _) = self.scalar(*k)?;
                words.iter().find(|w| **w == text).map(|w| (*w, *v))
            }),
            _ => {
                self.wrong_shape(id, "a mapping", help);
                return None;
            }
        };
        match word {
            Some(("remove", _)) => self.removal(id),
            Some((word, _)) => {
                let (level, beside) = self.level(id, word)?;
                Some(if word == "add" { Change::Add(level, beside) } else { Change::Replace(level) })
            }
            None => {
                let at = self.first_character(id);
                self.diags.push(Diagnostic::error("HQ0126", at, "expected `replace`, `add` or `remove`").help(help));
                None
            }
        }
    }

    fn removal(&mut self, id: NodeId) -> Option<Change> {
        let span = self.span(id);
        let mut comments = Comments::default();
        self.pool.before(span.range().start, &mut comments.before);
        let mut level = None;
        for (key, value) in self.distinct(id) {
            if key.value == "remove" {
                level = self.name(value, "the level");
            } else {
                let text = format!("`{}` has no meaning beside `remove`", clip(&key.value));
                self.diags.push(Diagnostic::unknown_key("HQ0132", key.span, text).help("write `- remove: NAME`"));
            }
        }
        self.pool.before(span.range().end, &mut comments.before);
        self.pool.behind(span.range().end, &[',', '}'], &mut comments.behind);
        Some(Change::Remove(Removal { level: level?, span, comments }))
    }

    /// Reads `import`: `common/safety.hq: [deck, canopies as robot]`.
    pub(super) fn imports(&mut self, title: &Spanned<String>, id: NodeId, items: &mut Vec<Item>) {
        let help = "write `common/safety.hq: [deck, canopies]` below `import:`";
        if self.is_null(id) {
            return;
        }
        if !matches!(self.node(id).kind, Kind::Mapping(_)) {
            self.wrong_shape(id, "a mapping of files", help);
            return;
        }
        let mut seen: BTreeMap<String, Span> = BTreeMap::new();
        for (key, value) in self.pairs(id) {
            let span = self.span(key);
            let Some(path) = self.scalar(key).map(|s| Spanned::new(s.0.to_owned(), span)).filter(|p| !p.is_empty())
            else {
                self.diags.push(Diagnostic::error("HQ0124", title.span, "an import names a file").help(help));
                continue;
            };
            if let Some(first) = seen.get(&path.value) {
                self.diags.push(checks::duplicate(&path.value, *first, path.span));
                continue;
            }
            seen.insert(path.value.clone(), path.span);
            let mut comments = self.key_comments(span);
            let mut closing_comments = Comments::default();
            let names = match &self.node(value).kind {
                Kind::Sequence(names) => {
                    let names = names.clone();
                    let names = names.into_iter().filter_map(|name| self.import_name(name)).collect();
                    self.closing(value, &mut closing_comments);
                    names
                }
                _ => {
                    let diagnostic = Diagnostic::error("HQ0124", span, "this import names nothing to import");
                    self.diags.push(diagnostic.help(help));
                    Vec::new()
                }
            };
            let later = self.later(value, span);
            self.pool.behind(later.range().end, &[','], &mut comments.behind);
            let kind = ItemKind::Import(Import { path, names, closing_comments });
            items.push(Item { kind, span: span.to(later), comments });
        }
    }

    fn import_name(&mut self, id: NodeId) -> Option<ImportName> {
        let help = "write the name of a declaration, or `NAME as NAME`";
        let span = self.span(id);
        let mut comments = Comments::default();
        self.pool.before(span.range().start, &mut comments.before);
        if self.scalar(id).is_none() || self.is_null(id) {
            self.wrong_shape(id, "a name", help);
            return None;
        }
        let (text, place) = self.spelled(id);
        let parsed = Grammar::parse(Rule::scalar_import, &text).ok().and_then(|mut p| p.next())?;
        let (mut name, mut alias, mut rest) = (None, None, text.len());
        for part in parsed.into_inner() {
            match part.as_rule() {
                Rule::name if name.is_none() => name = Some(place.spanned(&part)),
                Rule::name => alias = Some(place.spanned(&part)),
                _ => rest = part.as_span().start(),
            }
        }
        if !text[rest..].trim().is_empty() || name.is_none() {
            let message = format!("`{}` is no name to import", clip(text.trim()));
            self.diags.push(Diagnostic::error("HQ0124", span, message).help(help));
        }
        self.pool.behind(span.range().end, &[','], &mut comments.behind);
        Some(ImportName { name: name?, alias, comments })
    }

    /// Returns true for a name that needs no parsing.
    pub(super) fn plain_name(&self, id: NodeId) -> bool {
        self.scalar(id).is_some_and(|(text, style)| style != Style::Block && is_name(text))
    }
}
