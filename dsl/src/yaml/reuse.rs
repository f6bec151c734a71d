//! Declarations that use others: `import`, `for`, and what stands behind a name: parameters, `from`, `changes`.

use super::Reader;
use super::events::{Kind, NodeId, Style};
use crate::calls;
use crate::explain::{self, After, clip};
use crate::expr::missing;
use crate::grammar::{Grammar, Pair, Rule};
use crate::tree::{
    Block, Call, Change, Comments, Import, ImportName, Item, ItemKind, Member, MemberTask, Param, Parameter, Removal,
    RepeatItems, RepeatMembers, Value, ValueKind, Values,
};
use crate::words::{is_name, nearest};
use crate::{Diagnostic, Span, Spanned, checks};
use pest::Parser;

/// The sections that a repetition may hold.
const REPEATED: &[&str] = &["params", "lets", "tasks", "stacks", "for"];

/// Reads what stands behind a key of a repetition; says whether it knows the key.
type PartReader<'f, R> = &'f mut dyn FnMut(&mut R, &Spanned<String>, NodeId, &mut Comments) -> bool;

impl Reader<'_> {
    /// The entries of a section in which a name may have parameters, `"reach(side: arm)": ..`: each with the place of
    /// its whole key.
    pub(super) fn heads(&mut self, id: NodeId) -> Vec<(Spanned<String>, Span, Vec<Parameter>, NodeId)> {
        let mut out: Vec<(Spanned<String>, Span, Vec<Parameter>, NodeId)> = Vec::new();
        for (key, value) in self.pairs(id) {
            let Some((name, parameters)) = self.head(key) else { continue };
            if let Some(first) = out.iter().find(|o| o.0 == name) {
                self.diags.push(checks::duplicate(&name.value, first.0.span, name.span));
                continue;
            }
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
            self.report(diagnostic);
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
            let diagnostic = Diagnostic::error("HQ0122", place.span(start, text.len()), message);
            self.diags.push(diagnostic.help("write `\"NAME(side: arm, gain: rate = 5 /s)\":`"));
        }
        name.map(|name| (name, parameters))
    }

    /// A node `expr`, in which no block may stand.
    pub(super) fn flat(&mut self, pair: Pair<'_>, place: crate::expr::Place) -> Value {
        crate::expr::value(pair, place, &mut self.diags, &mut |block, diags| {
            let span = place.of(&block);
            diags.push(
                Diagnostic::error("HQ0113", span, "no block of the native spelling can stand in YAML")
                    .help("write a YAML mapping"),
            );
            missing(span)
        })
    }

    /// A `param`: a value, or a mapping with the value and its range.
    pub(super) fn param(&mut self, name: &Spanned<String>, id: NodeId, comments: &mut Comments) -> Param {
        // The keys that take text are keys of blocks; a parameter may have any name.
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

    /// The robot behind `from`, taken out of the body.
    pub(super) fn robot_base(&mut self, body: &mut Block, comments: &mut Comments) -> Option<Spanned<String>> {
        let at = body.entries.iter().position(|e| e.key.value == "from")?;
        let entry = body.entries.remove(at);
        comments.before.extend(entry.comments.before);
        comments.before.extend(entry.comments.behind);
        match entry.value.kind {
            ValueKind::Name(name) => Some(Spanned::new(name, entry.value.span)),
            ValueKind::Missing => None,
            _ => {
                let diagnostic = Diagnostic::error("HQ0116", entry.value.span, "`from` names no robot");
                self.diags.push(diagnostic.help("write the name of the robot behind `from:`"));
                None
            }
        }
    }

    /// `guarded`, `guarded(left)`.
    pub(super) fn call(&mut self, id: NodeId, key: Span) -> Option<Call> {
        if self.scalar(id).is_none() || self.is_null(id) {
            let span = if self.is_null(id) { key } else { self.span(id) };
            let diagnostic = Diagnostic::error("HQ0116", span, "`from` names no stack");
            self.diags.push(diagnostic.help("write the name of the stack behind `from:`"));
            return None;
        }
        let span = self.span(id);
        let end = Span { start: span.end, ..span };
        let (definition, _) = self.task_head(id, Block { span: end, ..Block::default() })?;
        Some(Call { name: definition.kind, args: definition.args, named: definition.named, span })
    }

    /// `changes`: `- { replace: motion, tasks: [..] }`, `- { add: extra, before: posture, tasks: [..] }`,
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
                let span = self.span(id);
                let first = self.text.get(span.range()).and_then(|t| t.chars().next()).map_or(1, char::len_utf8);
                let at = Span { end: span.start + first as u32, ..span };
                self.diags.push(Diagnostic::error("HQ0126", at, "this says nothing of what changes").help(help));
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
                self.diags.push(Diagnostic::error("HQ0132", key.span, text).help("write `- remove: NAME`"));
            }
        }
        self.pool.before(span.range().end, &mut comments.before);
        self.pool.behind(span.range().end, &[',', '}'], &mut comments.behind);
        Some(Change::Remove(Removal { level: level?, span, comments }))
    }

    /// `import`: `common/safety.hq: [deck, canopies as robot]`.
    pub(super) fn imports(&mut self, title: &Spanned<String>, id: NodeId, items: &mut Vec<Item>) {
        let help = "write `common/safety.hq: [deck, canopies]` below `import:`";
        if self.is_null(id) {
            return;
        }
        if !matches!(self.node(id).kind, Kind::Mapping(_)) {
            self.wrong_shape(id, "a mapping of files", help);
            return;
        }
        let mut seen: Vec<Spanned<String>> = Vec::new();
        for (key, value) in self.pairs(id) {
            let span = self.span(key);
            let Some(path) = self.scalar(key).map(|s| Spanned::new(s.0.to_owned(), span)).filter(|p| !p.is_empty())
            else {
                self.diags.push(Diagnostic::error("HQ0124", title.span, "an import names a file").help(help));
                continue;
            };
            if let Some(first) = seen.iter().find(|p| **p == path) {
                self.diags.push(checks::duplicate(&path.value, first.span, path.span));
                continue;
            }
            seen.push(path.clone());
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

    /// `for`: a sequence of `{ name: side, in: [left, right], tasks: { .. } }`.
    pub(super) fn repeats(&mut self, id: NodeId, items: &mut Vec<Item>) {
        if self.is_null(id) {
            return;
        }
        let Kind::Sequence(all) = &self.node(id).kind else {
            let help = "write `- { name: side, in: [left, right], tasks: { .. } }`";
            self.wrong_shape(id, "a sequence of repetitions", help);
            return;
        };
        for id in all.clone() {
            if self.depth >= crate::limits::MAX_DEPTH || !self.enter(id) {
                return;
            }
            let span = self.span(id);
            let mut comments = Comments::default();
            self.pool.before(span.range().start, &mut comments.before);
            self.depth += 1;
            let mut body = Vec::new();
            let mut closing_comments = Comments::default();
            let head = self.repeat_head(id, &mut comments, &mut |reader, key, value, _| {
                let word = key.value.as_str();
                if !REPEATED.contains(&word) {
                    return false;
                }
                if word == "for" {
                    reader.repeats(value, &mut body);
                } else {
                    reader.section(word, key, value, &mut body);
                }
                true
            });
            self.depth -= 1;
            self.closing(id, &mut closing_comments);
            if let Some((variable, values)) = head {
                let kind = ItemKind::For(RepeatItems { variable, values, body, closing_comments });
                items.push(Item { kind, span, comments });
            }
        }
    }

    /// `for: { name: side, in: [left, right], tasks: [..] }` in the place of a member.
    pub(super) fn member_repeat(&mut self, id: NodeId) -> Option<Member> {
        let Kind::Mapping(own) = &self.node(id).kind else { return None };
        let [(key, value)] = own.as_slice() else { return None };
        let (key, value) = (*key, *value);
        if !matches!(self.scalar(key), Some(("for", _))) || !matches!(self.node(value).kind, Kind::Mapping(_)) {
            return None;
        }
        let span = self.span(id);
        let (mut comments, mut closing_comments) = (Comments::default(), Comments::default());
        self.pool.before(span.range().start, &mut comments.before);
        self.pool.behind(self.span(key).range().end, &[':', '{'], &mut comments.behind);
        let mut body = None;
        self.depth += 1;
        let head = self.repeat_head(value, &mut comments, &mut |reader, key, value, comments| {
            if key.value == "tasks" {
                reader.pool.before(key.span.range().start, &mut comments.before);
                reader.pool.behind(key.span.range().end, &[':', '['], &mut comments.behind);
                body = Some(reader.members(value));
            }
            key.value == "tasks"
        });
        self.depth -= 1;
        self.closing(value, &mut closing_comments);
        self.pool.before(span.range().end, &mut comments.before);
        self.pool.behind(span.range().end, &[','], &mut comments.behind);
        if body.is_none() {
            let diagnostic = Diagnostic::error("HQ0117", self.span(key), "this `for` has no `tasks`");
            self.diags.push(diagnostic.help("write `for: { name: side, in: [left, right], tasks: [..] }`"));
        }
        let (variable, values) = head?;
        let repeat = RepeatMembers { variable, values, body: body.unwrap_or_default(), closing_comments };
        Some(Member { task: MemberTask::For(Box::new(repeat)), weight: None, span, comments })
    }

    /// `name` and `in` of a repetition; `part` reads the other keys and says whether it knows one.
    fn repeat_head(
        &mut self,
        id: NodeId,
        comments: &mut Comments,
        part: PartReader<'_, Self>,
    ) -> Option<(Spanned<String>, Values)> {
        let form = "write `{ name: side, in: [left, right], tasks: .. }`, or `in: 1..4`";
        if !matches!(self.node(id).kind, Kind::Mapping(_)) {
            self.wrong_shape(id, "a mapping with `name`, `in` and what is repeated", form);
            return None;
        }
        let span = self.span(id);
        let at = Span { end: span.start + 1, ..span };
        let (mut name, mut values) = (None, None);
        for (key, value) in self.distinct(id) {
            if matches!(key.value.as_str(), "name" | "in") {
                self.pool.before(key.span.range().start, &mut comments.before);
                if key.value == "name" {
                    name = self.name(value, "the repeated name");
                } else {
                    values = self.values(value, &key);
                }
                self.pool.behind(self.later(value, key.span).range().end, &[','], &mut comments.behind);
            } else if !part(self, &key, value, comments) {
                let text = format!("`{}` cannot be repeated", clip(&key.value));
                let diagnostic = Diagnostic::error("HQ0125", key.span, text);
                self.diags.push(match nearest(&key.value, &["name", "in", "params", "lets", "tasks", "stacks"]) {
                    Some(near) => diagnostic.help(format!("did you mean `{near}`?")),
                    None => diagnostic.help(form),
                });
            }
        }
        if name.is_none() {
            self.diags.push(calls::incomplete(at, "name").help(form));
        } else if values.is_none() {
            self.diags.push(calls::incomplete(at, "values").help(form));
        }
        Some((name?, values?))
    }

    /// `[left, right]`, `1..4`.
    fn values(&mut self, id: NodeId, key: &Spanned<String>) -> Option<Values> {
        let plain = self.scalar(id).is_some_and(|(text, style)| text.contains("..") && style != Style::Block);
        if !plain {
            return Some(Values::List(self.value(id, Some(key))));
        }
        let (text, place) = self.spelled(id);
        if let Some(diagnostic) = self.unfit(&text, place) {
            self.report(diagnostic);
            return None;
        }
        let parsed = Grammar::parse(Rule::scalar_values, &text).ok().and_then(|mut p| p.next())?;
        let (mut values, mut rest) = (None, text.len());
        for part in parsed.into_inner() {
            if part.as_rule() == Rule::values {
                values = Some(calls::values(part, place, &mut |part| self.flat(part, place)));
            } else {
                rest = part.as_span().start();
            }
        }
        if !text[rest..].trim().is_empty() {
            let diagnostic = explain::junk(&text, rest, text.len(), place, After::Start("a list or a range"), false);
            self.report(diagnostic);
        }
        values
    }

    /// True for a name that needs no parsing.
    pub(super) fn plain_name(&self, id: NodeId) -> bool {
        self.scalar(id).is_some_and(|(text, style)| style != Style::Block && is_name(text))
    }
}
