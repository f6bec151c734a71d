//! Reader of the levels of a stack and their members, in YAML.

use super::Reader;
use super::events::{Kind, NodeId};
use crate::diagnostic::clip;
use crate::tree::{
    Beside, Block, Comments, Entry, Level, Member, MemberTask, Parameter, Stack, TaskDefinition, Value, ValueKind,
};
use crate::vocabulary::ALLOW;
use crate::words::{has_block, nearest};
use crate::{Diagnostic, Span, Spanned, checks};

impl Reader<'_> {
    /// Reads a stack: settings, and the sequence `levels`, or `from` and the sequence `changes`.
    pub(super) fn stack(&mut self, id: NodeId, name: &Spanned<String>, parameters: Vec<Parameter>) -> Stack {
        let settings = Block { span: self.span(id), ..Block::default() };
        let (levels, changes) = (Vec::new(), Vec::new());
        let mut stack = Stack { name: name.clone(), parameters, base: None, settings, levels, changes };
        if !matches!(self.node(id).kind, Kind::Mapping(_)) {
            self.wrong_shape(id, "a mapping with `levels`", "write `levels:` and, below it, `- name: ..`");
            return stack;
        }
        let (mut has_levels, mut from) = (false, false);
        for (key, value) in self.distinct(id) {
            match key.value.as_str() {
                "levels" => {
                    has_levels = true;
                    stack.levels = self.levels(value, &key);
                }
                "from" => {
                    from = true;
                    let mut comments = Comments::default();
                    self.pool.before(key.span.range().start, &mut comments.before);
                    stack.base = self.call(value, key.span);
                    self.pool.behind(self.later(value, key.span).range().end, &[','], &mut comments.behind);
                    let closing = &mut stack.settings.closing_comments.before;
                    // Comments around `from` are attached to what follows it.
                    closing.extend(comments.before);
                    closing.extend(comments.behind);
                }
                "changes" => stack.changes = self.changes(value),
                _ => {
                    let entry = self.setting(key, value);
                    stack.settings.entries.push(entry);
                }
            }
        }
        self.closing(id, &mut stack.settings.closing_comments);
        let meant_levels = stack.settings.get("level").is_some();
        checks::reserved(&mut stack.settings, checks::STACK_WORDS, "stack", &mut self.diags);
        if !has_levels && !meant_levels && !from && stack.changes.is_empty() {
            self.diags.push(
                Diagnostic::incomplete(
                    "HQ0117",
                    name.span,
                    format!("the stack `{}` has no `levels`", clip(&name.value)),
                )
                .help("write `levels:` and, below it, `- name: ..`"),
            );
        }
        checks::changes(&mut stack, name.span, from, &mut self.diags);
        stack
    }

    /// Reads `key: value`, as in any block.
    pub(super) fn setting(&mut self, key: Spanned<String>, value: NodeId) -> Entry {
        let mut comments = self.key_comments(key.span);
        let end = self.later(value, key.span).range().end;
        let value = self.value(value, Some(&key));
        if !matches!(value.kind, ValueKind::Block(_)) {
            self.pool.before(end, &mut comments.before);
        }
        self.pool.behind(end, &[','], &mut comments.behind);
        Entry { key, value, comments }
    }

    fn levels(&mut self, id: NodeId, key: &Spanned<String>) -> Vec<Level> {
        let items = match &self.node(id).kind {
            Kind::Sequence(items) => items.clone(),
            _ => {
                let help = "levels are ordered: write `- name: ..` for each, the most important first";
                if self.is_null(id) {
                    self.diags.push(Diagnostic::incomplete("HQ0117", key.span, "`levels` is empty").help(help));
                } else {
                    self.wrong_shape(id, "a sequence of levels", help);
                }
                return Vec::new();
            }
        };
        items.into_iter().filter_map(|item| self.level(item, "name").map(|l| l.0)).collect()
    }

    /// Reads a level whose name follows the key `word`: `name`, or the `replace` or `add` of a change.
    pub(super) fn level(&mut self, id: NodeId, word: &str) -> Option<(Level, Option<Beside>)> {
        if !self.enter(id) {
            return None;
        }
        let help = "write `- name: ..`, `hard: true` where it applies, and `tasks: [..]`";
        if !matches!(self.node(id).kind, Kind::Mapping(_)) {
            self.wrong_shape(id, "a mapping with `name` and `tasks`", help);
            return None;
        }
        let span = self.span(id);
        let told = self.diags.len();
        let (mut name, mut hard, mut members, mut beside) = (None, None, None, None);
        let mut settings = Block { span, ..Block::default() };
        let mut comments = Comments::default();
        self.pool.before(span.range().start, &mut comments.before);
        let pairs = self.distinct(id);
        let absent: Vec<&str> =
            [word, "tasks"].into_iter().filter(|word| pairs.iter().all(|(key, _)| key.value != *word)).collect();
        for (key, value) in pairs {
            // A misspelt required key is reported once, and read as the intended one.
            let meant = nearest(&key.value, &absent).filter(|_| key.value != "hard");
            if let Some(meant) = meant {
                let text = format!("`{}` is not a key of a level", clip(&key.value));
                self.diags.push(Diagnostic::unknown_key("HQ0132", key.span, text).meant(meant));
            }
            match meant.unwrap_or(key.value.as_str()) {
                key_word if key_word == word => {
                    name = self.name(value, "the level");
                    if let Some(name) = name.as_ref().filter(|n: &&Spanned<String>| n.value == "hard") {
                        self.diags.push(checks::hard_is_no_name(name.span));
                    }
                    self.pool.before(key.span.range().start, &mut comments.before);
                    self.pool.behind(self.later(value, key.span).range().end, &[','], &mut comments.behind);
                }
                "hard" => {
                    self.pool.before(key.span.range().start, &mut comments.before);
                    hard = self.hard(key.span, value);
                }
                "tasks" => {
                    self.pool.before(key.span.range().start, &mut comments.before);
                    self.pool.behind(key.span.range().end, &[':', '['], &mut comments.behind);
                    members = Some(self.members(value));
                }
                place @ ("before" | "after") if word == "add" => {
                    self.pool.before(key.span.range().start, &mut comments.before);
                    let before = place == "before";
                    let level = self.name(value, "a level");
                    self.pool.behind(self.later(value, key.span).range().end, &[','], &mut comments.behind);
                    beside = level.map(|level| Beside { before, level }).or(beside);
                }
                _ => {
                    let entry = self.setting(key, value);
                    if has_block(&entry.value) && entry.key.value != ALLOW {
                        self.diags.push(
                            Diagnostic::error("HQ0131", entry.value.span, "a setting of a level is a single value")
                                .here("there is a mapping in this")
                                .help("write `key: value`"),
                        );
                        continue;
                    }
                    settings.entries.push(entry);
                }
            }
        }
        self.closing(id, &mut settings.closing_comments);
        checks::reserved(&mut settings, checks::LEVEL_WORDS, "level", &mut self.diags);
        let at = self.first_character(id);
        if name.is_none() && self.diags.len() == told && !self.broken_in(span) {
            self.diags.push(Diagnostic::incomplete("HQ0116", at, "this level has no name").help(help));
        }
        if members.is_none() {
            self.diags.push(Diagnostic::incomplete("HQ0117", at, "this level has no `tasks`").help(help));
        }
        let level = Level { name: name?, hard, settings, members: members.unwrap_or_default(), span, comments };
        Some((level, beside))
    }

    fn hard(&mut self, key: Span, value: NodeId) -> Option<Span> {
        match self.scalar(value) {
            Some(("true", _)) => Some(key),
            Some(("false", _)) => None,
            other => {
                let written = other.map_or_else(|| "this".to_owned(), |s| format!("`{}`", clip(s.0)));
                let span = self.later(value, key);
                self.diags.push(
                    Diagnostic::error("HQ0118", span, format!("`hard` is true or false, not {written}"))
                        .help("write `hard: true`, or leave the line out"),
                );
                None
            }
        }
    }

    pub(super) fn members(&mut self, id: NodeId) -> Vec<Member> {
        let items = match &self.node(id).kind {
            Kind::Sequence(items) => items.clone(),
            _ => {
                self.wrong_shape(id, "a sequence of tasks", "write `[task_a, task_b]`, or `[]` for none");
                return Vec::new();
            }
        };
        items.into_iter().filter_map(|item| self.member(item)).collect()
    }

    fn member(&mut self, id: NodeId) -> Option<Member> {
        if !self.enter(id) {
            return None;
        }
        if let Some(repeat) = self.member_repeat(id) {
            return Some(repeat);
        }
        let span = self.span(id);
        let mut comments = Comments::default();
        self.pool.before(span.range().start, &mut comments.before);
        let (mut task, mut weight) = (None, None);
        let wrapped = matches!(&self.node(id).kind, Kind::Mapping(entries)
            if entries.iter().any(|(key, _)| matches!(self.scalar(*key), Some(("task", _)))));
        if wrapped {
            for (key, value) in self.distinct(id) {
                self.pool.before(key.span.range().start, &mut comments.before);
                match key.value.as_str() {
                    "task" => {
                        self.pool.behind(key.span.range().end, &[':'], &mut comments.behind);
                        task = self.member_task(value, &mut comments);
                        self.pool.behind(self.span(value).range().end, &[','], &mut comments.behind);
                    }
                    "weight" => weight = Some(self.weight(value, &key)),
                    other => self.diags.push(
                        Diagnostic::unknown_key(
                            "HQ0132",
                            key.span,
                            format!("`{}` is not a key of a member", clip(other)),
                        )
                        .help("a member has `task` and `weight`; write parameters below the kind of the task"),
                    ),
                }
            }
        } else {
            task = self.member_task(id, &mut comments);
        }
        self.pool.before(span.range().end, &mut comments.before);
        self.pool.behind(span.range().end, &[','], &mut comments.behind);
        Some(Member { task: task?, weight, span, comments })
    }

    fn weight(&mut self, id: NodeId, key: &Spanned<String>) -> Value {
        let mut value = self.value(id, Some(key));
        if has_block(&value) {
            self.wrong_shape(id, "a number", "write `weight: 2`");
            value.kind = ValueKind::Missing;
        }
        value
    }

    /// Reads a name, `kind(args)`, or `{ kind: { .. } }`.
    fn member_task(&mut self, id: NodeId, comments: &mut Comments) -> Option<MemberTask> {
        if let Some((text, _)) = self.scalar(id).filter(|_| self.plain_name(id) && !self.is_null(id)) {
            let name = Spanned::new(text.to_owned(), self.span(id));
            return Some(MemberTask::Name(name));
        }
        if self.is_null(id) {
            self.diags.push(
                Diagnostic::incomplete("HQ0116", self.span(id), "a task is missing here")
                    .help("write the name of a task, `KIND(..)` or `KIND: { .. }`"),
            );
            return None;
        }
        let owner = Spanned::new("member".to_owned(), self.span(id));
        let (definition, called) = self.definition(id, &owner, &mut comments.behind)?;
        Some(self.named_or_inline(definition, called, id))
    }

    /// Treats a scalar that is a bare name after all (`"name "`) as the name of a task.
    fn named_or_inline(&self, definition: TaskDefinition, called: bool, id: NodeId) -> MemberTask {
        if self.scalar(id).is_some() && !called {
            MemberTask::Name(definition.kind)
        } else {
            MemberTask::Inline(definition)
        }
    }
}
