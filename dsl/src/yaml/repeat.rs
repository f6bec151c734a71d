//! Reader of repetitions in YAML: declarations in the section `for`, and members of a level.

use super::Reader;
use super::events::{Kind, NodeId, Style};
use crate::calls;
use crate::diagnostic::clip;
use crate::explain::{self, After};
use crate::grammar::{Grammar, Rule};
use crate::tree::{Comments, Item, ItemKind, Member, MemberTask, RepeatItems, RepeatMembers, Values};
use crate::vocabulary::REPEATED;
use crate::words::nearest;
use crate::{Diagnostic, Spanned};
use pest::Parser;

/// Reads the value of a key of a repetition; returns false if the key is unknown.
type PartReader<'f, R> = &'f mut dyn FnMut(&mut R, &Spanned<String>, NodeId, &mut Comments) -> bool;

impl Reader<'_> {
    /// Reads `for`: a sequence of `{ name: side, in: [left, right], tasks: { .. } }`.
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
            let head = self.repeat_head(id, REPEATED, &mut comments, &mut |reader, key, value, _| {
                let word = key.value.as_str();
                if !REPEATED.contains(&word) {
                    return false;
                }
                if word == "for" {
                    reader.repeats(value, &mut body);
                } else if word == "scenarios" {
                    reader.scenarios(key, value, &mut body);
                } else if word == "coverage" {
                    reader.coverage(key, value, &mut body);
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

    /// Reads `for: { name: side, in: [left, right], tasks: [..] }` in place of a member.
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
        let head = self.repeat_head(value, &["tasks"], &mut comments, &mut |reader, key, value, comments| {
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
            let diagnostic = Diagnostic::incomplete("HQ0117", self.span(key), "this `for` has no `tasks`");
            self.diags.push(diagnostic.help("write `for: { name: side, in: [left, right], tasks: [..] }`"));
        }
        let (variable, values) = head?;
        let repeat = RepeatMembers { variable, values, body: body.unwrap_or_default(), closing_comments };
        Some(Member { task: MemberTask::For(Box::new(repeat)), weight: None, span, comments })
    }

    /// Reads `name` and `in` of a repetition. `part` reads the other keys, which are listed in `words`, and returns
    /// false for an unknown one.
    pub(super) fn repeat_head(
        &mut self,
        id: NodeId,
        words: &[&str],
        comments: &mut Comments,
        part: PartReader<'_, Self>,
    ) -> Option<(Spanned<String>, Values)> {
        let form = "write `{ name: side, in: [left, right], tasks: .. }`, or `in: 1..4`";
        if !matches!(self.node(id).kind, Kind::Mapping(_)) {
            self.wrong_shape(id, "a mapping with `name`, `in` and the declarations to repeat", form);
            return None;
        }
        let at = self.first_character(id);
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
                let known = [&["name", "in"], words].concat();
                self.diags.push(match nearest(&key.value, &known) {
                    Some(near) => diagnostic.meant(near),
                    None => diagnostic
                        .note(format!(
                            "`for` takes `name`, `in` and the declarations to repeat: `{}`",
                            words.join("`, `")
                        ))
                        .help("write it outside the `for`"),
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

    /// Reads `[left, right]` or `1..4`.
    fn values(&mut self, id: NodeId, key: &Spanned<String>) -> Option<Values> {
        let plain = self.scalar(id).is_some_and(|(text, style)| text.contains("..") && style != Style::Block);
        if !plain {
            return Some(Values::List(self.value(id, Some(key))));
        }
        let (text, place) = self.spelled(id);
        if let Some(diagnostic) = self.unfit(&text, place) {
            self.diags.push(diagnostic);
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
            self.diags.push(diagnostic);
        }
        values
    }
}
