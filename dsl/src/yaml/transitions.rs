//! Reader of transitions in YAML: trigger, target and settings.

use super::Reader;
use super::events::{Kind, NodeId};
use crate::explain::{self, After};
use crate::tree::{Block, Comments, Transition, Trigger};
use crate::words::{has_block, is_name};
use crate::{Diagnostic, Span, Spanned, calls, transitions};

impl Reader<'_> {
    /// Reads the transitions of a state.
    pub(super) fn transitions(&mut self, id: NodeId) -> Vec<Transition> {
        if self.is_null(id) {
            return Vec::new();
        }
        let Kind::Sequence(items) = &self.node(id).kind else {
            self.wrong_shape(id, "a sequence of transitions", "write `- { on: found, to: STATE }` for each");
            return Vec::new();
        };
        items.clone().into_iter().filter_map(|item| self.transition(item)).collect()
    }

    /// Reads `{ when: x < 3 N, for: 3 s, to: grasp, blend: 1 s }`.
    fn transition(&mut self, id: NodeId) -> Option<Transition> {
        if !self.enter(id) {
            return None;
        }
        let help = "write `- { on: found, to: STATE }`, `- { when: x < 3 N, for: 3 s, to: STATE }` or `- { after: 10 s, to: STATE }`";
        if !matches!(self.node(id).kind, Kind::Mapping(_)) {
            self.wrong_shape(id, "a mapping with `on`, `when` or `after`, and `to`", help);
            return None;
        }
        let span = self.span(id);
        let mut comments = Comments::default();
        self.pool.before(span.range().start, &mut comments.before);
        let mut settings = Block { span, ..Block::default() };
        let (mut first, mut hold, mut target, mut named) = (None::<(&str, Span, _)>, None, None, false);
        for (key, value) in self.distinct(id) {
            let word = key.value.as_str();
            if !matches!(word, "on" | "when" | "after" | "for" | "to") {
                let entry = self.setting(key, value);
                if has_block(&entry.value) {
                    self.diags.push(
                        Diagnostic::error("HQ0131", entry.value.span, "a setting of a transition is a single value")
                            .here("there is a mapping in this")
                            .help("write `key: value`"),
                    );
                    continue;
                }
                settings.entries.push(entry);
                continue;
            }
            self.pool.before(key.span.range().start, &mut comments.before);
            if word == "to" {
                named = true;
                target = self.target(value);
            } else {
                let mut read = self.value(value, Some(&key));
                if has_block(&read) {
                    self.wrong_shape(value, "a single value", help);
                    read.kind = crate::tree::ValueKind::Missing;
                }
                match (word, &first) {
                    ("for", _) => hold = Some((key.span, read)),
                    (_, Some((other, at, _))) => self.diags.push(
                        Diagnostic::error("HQ0141", key.span, "a transition has one trigger")
                            .label(*at, format!("it has `{other}` already"))
                            .help("join conditions by `and` after one `when`, or write two transitions"),
                    ),
                    ("when", None) => first = Some(("when", key.span, read)),
                    ("after", None) => first = Some(("after", key.span, read)),
                    _ => first = Some(("on", key.span, read)),
                }
            }
            self.pool.before(self.later(value, key.span).range().end, &mut comments.before);
            self.pool.behind(self.later(value, key.span).range().end, &[','], &mut comments.behind);
        }
        self.closing(id, &mut settings.closing_comments);
        self.pool.behind(span.range().end, &[','], &mut comments.behind);
        let at = self.first_character(id);
        if let (Some((key, _)), Some((word, ..))) = (&hold, &first)
            && *word != "when"
        {
            self.diags.push(transitions::no_hold(word, *key));
        }
        if !named {
            self.diags.push(transitions::no_target(at));
        }
        let trigger = match first {
            Some(("when", _, condition)) => Trigger::When { condition, hold: hold.map(|h| h.1) },
            Some(("after", _, value)) => Trigger::After(value),
            Some((_, _, value)) => Trigger::On(value),
            None => {
                let text = "this transition has no trigger";
                self.diags.push(Diagnostic::error("HQ0141", at, text).help(help));
                Trigger::Missing
            }
        };
        transitions::transition_settings(&mut settings, &mut self.diags);
        let target = target.unwrap_or_else(|| calls::nameless(span));
        Some(Transition { trigger, target, settings, span, comments })
    }

    /// Reads `grasp` or `outer.inner`.
    fn target(&mut self, id: NodeId) -> Option<Spanned<String>> {
        let Some((text, _)) = self.scalar(id).filter(|_| !self.is_null(id)) else {
            self.wrong_shape(id, "the name of a state", "write a single word, or a path `OUTER.INNER`");
            return None;
        };
        let path = Spanned::new(text.to_owned(), self.span(id));
        if path.split('.').all(is_name) {
            return Some(path);
        }
        let (text, place) = self.spelled(id);
        let diagnostic = explain::junk(&text, 0, text.len(), place, After::Start("the name of a state"), false);
        let diagnostic = Diagnostic { code: "HQ0135", ..diagnostic };
        self.diags.push(diagnostic);
        None
    }
}
