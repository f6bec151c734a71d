//! Reader of machines and their states in YAML.

use super::Reader;
use super::events::{Kind, NodeId};
use crate::diagnostic::clip;
use crate::grammar::{Grammar, Rule};
use crate::limits::MAX_STATE_NESTING;
use crate::tree::{Action, Block, Comments, Machine, Moment, State, StateBody};
use crate::words::{has_block, nearest};
use crate::{Diagnostic, Span, Spanned, actions, transitions};
use pest::Parser;

/// The keys of a state that are not settings.
const STATE_KEYS: &[&str] = &["final", "stack", "enter", "do", "exit", "transitions", "check", "states", "regions"];

impl Reader<'_> {
    /// Reads `initial: look`, `states: { .. }`.
    pub(super) fn machine(&mut self, name: &Spanned<String>, id: NodeId) -> Machine {
        let body = self.state_body(id, name, "machine", &mut None, &mut Comments::default());
        Machine { name: name.clone(), body }
    }

    /// Reads the mapping of a machine or a state. Comments around `final` are added to `comments`.
    fn state_body(
        &mut self,
        id: NodeId,
        owner: &Spanned<String>,
        what: &str,
        final_: &mut Option<Span>,
        comments: &mut Comments,
    ) -> StateBody {
        let mut body =
            StateBody { settings: Block { span: self.span(id), ..Block::default() }, ..StateBody::default() };
        if !matches!(self.node(id).kind, Kind::Mapping(_)) {
            let help = "write `stack: NAME`, `transitions:` and the like below the name";
            if self.is_null(id) {
                let text = format!("the {what} `{}` is empty", clip(&owner.value));
                self.diags.push(Diagnostic::incomplete("HQ0117", owner.span, text).help(help));
            } else {
                self.wrong_shape(id, &format!("a mapping with the parts of the {what}"), help);
            }
            return body;
        }
        if !self.enter(id) {
            return body;
        }
        self.depth += 1;
        for (key, value) in self.distinct(id) {
            let later = self.later(value, key.span).range().end;
            match key.value.as_str() {
                "final" if what == "state" => {
                    self.pool.before(key.span.range().start, &mut comments.before);
                    *final_ = self.is_final(key.span, value);
                    self.pool.behind(later, &[','], &mut comments.behind);
                }
                "stack" => {
                    body.stack_comments = self.key_comments(key.span);
                    if self.is_null(value) {
                        let diagnostic = Diagnostic::incomplete("HQ0116", key.span, "`stack` names no stack");
                        self.diags.push(diagnostic.help("write the name of a stack after `stack:`"));
                    } else if self.scalar(value).is_none() {
                        let help = "write `stack: NAME`, or `stack: NAME(left)`; declare its levels below `stacks:`";
                        self.wrong_shape(value, "the name of a stack", help);
                    } else {
                        body.stack = self.call(value, key.span);
                    }
                    self.pool.behind(later, &[','], &mut body.stack_comments.behind);
                }
                "enter" => self.actions(Moment::Enter, &key, value, &mut body.actions),
                "do" => self.actions(Moment::Do, &key, value, &mut body.actions),
                "exit" => self.actions(Moment::Exit, &key, value, &mut body.actions),
                "transitions" => body.transitions = self.transitions(value),
                "check" => body.properties = self.expects(&key, value),
                "states" => body.states.extend(self.states(value, &key, "state")),
                "regions" => body.states.extend(self.states(value, &key, "region")),
                _ => {
                    let entry = self.setting(key, value);
                    body.settings.entries.push(entry);
                }
            }
        }
        self.depth -= 1;
        self.closing(id, &mut body.closing_comments);
        transitions::settings(&mut body.settings, what, &mut self.diags);
        transitions::distinct_states(&mut body.states, &mut self.diags);
        self.slips(&mut body.settings);
        body
    }

    /// Reports keys that are nearly a key of a state and have a mapping or sequence as value, and removes them from the
    /// settings.
    fn slips(&mut self, settings: &mut Block) {
        settings.entries.retain(|entry| {
            let meant = nearest(&entry.key.value, STATE_KEYS).filter(|_| has_block(&entry.value));
            if let Some(meant) = meant {
                let text = format!("`{}` is not a key of a state", clip(&entry.key.value));
                let diagnostic = Diagnostic::unknown_key("HQ0132", entry.key.span, text);
                self.diags.push(diagnostic.meant(meant));
                self.unread.push(entry.value.span);
            }
            meant.is_none()
        });
    }

    /// Reads `final: true`.
    fn is_final(&mut self, key: Span, value: NodeId) -> Option<Span> {
        match self.scalar(value) {
            Some(("true", _)) => return Some(key),
            Some(("false", _)) => {}
            other => {
                let written = other.map_or_else(|| "this".to_owned(), |s| format!("`{}`", clip(s.0)));
                let text = format!("`final` is true or false, not {written}");
                let diagnostic = Diagnostic::error("HQ0118", self.later(value, key), text);
                self.diags.push(diagnostic.help("write `final: true`, or leave the line out"));
            }
        }
        None
    }

    fn states(&mut self, id: NodeId, key: &Spanned<String>, what: &str) -> Vec<State> {
        let mut states = Vec::new();
        if self.is_null(id) {
            return states;
        }
        if !matches!(self.node(id).kind, Kind::Mapping(_)) {
            let help = format!("write `NAME: {{ stack: .. }}` lines below `{what}s:`");
            self.wrong_shape(id, &format!("a mapping of {what}s"), &help);
            return states;
        }
        if self.states >= MAX_STATE_NESTING {
            self.diags.push(transitions::too_deep(key.span));
            return states;
        }
        self.states += 1;
        for (name, value) in self.distinct(id) {
            let mut comments = self.key_comments(name.span);
            let mut final_ = None;
            let body = self.state_body(value, &name, what, &mut final_, &mut comments);
            let later = self.later(value, name.span);
            self.pool.behind(later.range().end, &[','], &mut comments.behind);
            let span = name.span.to(later);
            states.push(State { name, region: what == "region", final_, body, span, comments });
        }
        self.states -= 1;
        states
    }

    /// Reads `say "text"`, or a sequence of such actions.
    fn actions(&mut self, moment: Moment, key: &Spanned<String>, id: NodeId, out: &mut Vec<Action>) {
        let moment = Spanned::new(moment, key.span);
        let Kind::Sequence(items) = &self.node(id).kind else {
            let mut comments = self.key_comments(key.span);
            out.extend(self.action(moment, id, &mut comments));
            return;
        };
        for item in items.clone() {
            let mut comments = Comments::default();
            self.pool.before(self.span(item).range().start, &mut comments.before);
            out.extend(self.action(moment.clone(), item, &mut comments));
        }
    }

    fn action(&mut self, moment: Spanned<Moment>, id: NodeId, comments: &mut Comments) -> Option<Action> {
        let word = moment.value.word();
        if !self.enter(id) {
            return None;
        }
        if self.is_null(id) {
            self.diags.push(actions::nothing(word, moment.span));
            return None;
        }
        if self.scalar(id).is_none() {
            self.wrong_shape(id, "an action", "write for instance `capture(head_camera)`, or a sequence of such");
            return None;
        }
        let span = self.span(id);
        let (text, place) = self.spelled(id);
        if let Some(diagnostic) = self.unfit(&text, place) {
            self.diags.push(diagnostic);
            return None;
        }
        let parsed = Grammar::parse(Rule::scalar_action, &text).ok().and_then(|mut p| p.next())?;
        let (mut done, mut rest) = (None, text.len());
        for part in parsed.into_inner() {
            if part.as_rule() == Rule::action_call {
                let mut diags = Vec::new();
                done = Some(actions::call(part, place, &mut |part| self.flat(part, place), &mut diags));
                self.diags.extend(diags);
            } else {
                rest = part.as_span().start();
            }
        }
        if !text[rest..].trim().is_empty() || done.is_none() {
            let said = text[rest..].trim();
            let message = format!("`{}` cannot be read in an action", clip(said));
            let start = rest + text[rest..].len() - text[rest..].trim_start().len();
            self.diags.push(
                Diagnostic::error("HQ0142", place.span(start, start + said.len()), message)
                    .note("texts, names and numbers need no parentheses; write everything else in parentheses")
                    .help("write `VERB(a + b, [0, 0, 1] m)`"),
            );
        }
        let done = done?;
        self.pool.before(span.range().end, &mut comments.before);
        self.pool.behind(span.range().end, &[','], &mut comments.behind);
        let comments = std::mem::take(comments);
        Some(Action { moment, verb: done.verb, args: done.args, named: done.named, bare: done.bare, span, comments })
    }
}
