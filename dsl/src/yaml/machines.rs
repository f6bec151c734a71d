//! Signals, machines and their states.

use super::Reader;
use super::events::{Kind, NodeId};
use crate::explain::{self, After, clip};
use crate::grammar::{Grammar, Rule};
use crate::limits::MAX_STATE_NESTING;
use crate::tree::{
    Action, Block, Comments, Machine, Moment, Signal, State, StateBody, Transition, Trigger, Value, ValueKind, Variable,
};
use crate::words::{has_block, is_name, nearest};
use crate::{Diagnostic, Span, Spanned, actions, calls, checks, transitions};
use pest::Parser;

/// The keys of a state beside its settings.
const STATE_KEYS: &[&str] = &["final", "stack", "enter", "do", "exit", "transitions", "states"];

impl Reader<'_> {
    /// `point?`, or `{ type: point?, timeout: 0.5 s }`.
    pub(super) fn signal(&mut self, name: &Spanned<String>, id: NodeId, comments: &mut Comments) -> Signal {
        let mut settings = Block { span: self.span(id), ..Block::default() };
        let mut ty = None;
        if matches!(self.node(id).kind, Kind::Mapping(_)) {
            for (key, value) in self.distinct(id) {
                if key.value == "type" {
                    self.pool.before(key.span.range().start, &mut comments.before);
                    ty = Some(value);
                    self.pool.behind(self.later(value, key.span).range().end, &[','], &mut comments.behind);
                } else {
                    let entry = self.setting(key, value);
                    settings.entries.push(entry);
                }
            }
            self.closing(id, &mut settings.closing_comments);
            checks::reserved(&mut settings, &[], "signal", &mut self.diags);
        } else {
            ty = Some(id);
        }
        let read = ty.filter(|id| !self.is_null(*id)).map(|id| self.signal_type(id));
        if read.is_none() {
            self.diags.push(transitions::no_type(&name.value, name.span));
        }
        let (ty, optional) = read.flatten().unwrap_or_else(|| (calls::nameless(name.span), None));
        Signal { name: name.clone(), ty, optional, settings }
    }

    /// `point?`, or `{ type: number, value: 0 }`.
    pub(super) fn variable(&mut self, name: &Spanned<String>, id: NodeId, comments: &mut Comments) -> Variable {
        let (mut ty, mut value) = (None, None);
        if matches!(self.node(id).kind, Kind::Mapping(_)) {
            for (key, node) in self.distinct(id) {
                match key.value.as_str() {
                    "type" | "value" => {
                        self.pool.before(key.span.range().start, &mut comments.before);
                        if key.value == "type" {
                            ty = Some(node);
                        } else {
                            let read = self.value(node, Some(&key));
                            value = (!self.is_null(node)).then_some(read);
                        }
                        self.pool.behind(self.later(node, key.span).range().end, &[','], &mut comments.behind);
                    }
                    other => {
                        value.get_or_insert(Value { kind: ValueKind::Missing, span: key.span });
                        let text = format!("`{}` is no part of a variable", clip(other));
                        let d = Diagnostic::error("HQ0121", key.span, text);
                        self.diags.push(match nearest(other, &["type", "value"]) {
                            Some(near) => d.help(format!("did you mean `{near}`?")),
                            None => d.help("write `{ type: number, value: 0 }`"),
                        });
                    }
                }
            }
        } else {
            ty = Some(id);
        }
        let read = ty.filter(|id| !self.is_null(*id)).map(|id| self.signal_type(id));
        if read.is_none() {
            self.diags.push(transitions::no_variable_type(&name.value, name.span));
        }
        let (ty, optional) = read.flatten().unwrap_or_else(|| (calls::nameless(name.span), None));
        if let Some(Value { kind: kind @ ValueKind::Block(_), span }) = &mut value {
            let d = Diagnostic::error("HQ0104", *span, "a variable holds a value, and these are keys");
            self.diags.push(d.help("write what it holds at the start, such as `value: 0`"));
            *kind = ValueKind::Missing;
        }
        Variable { name: name.clone(), ty, optional, value }
    }

    /// `point`, `point?`: the type, and where the `?` stands.
    fn signal_type(&mut self, id: NodeId) -> Option<(Spanned<String>, Option<Span>)> {
        if self.scalar(id).is_none() {
            self.wrong_shape(id, "the type of a signal", "write for instance `point` or `point?`");
            return None;
        }
        let (text, place) = self.spelled(id);
        let word = text.strip_suffix('?').unwrap_or(&text);
        if !is_name(word) {
            self.diags.push(transitions::bad_type(&text, self.span(id)));
            return None;
        }
        let optional = (word.len() < text.len()).then(|| place.span(word.len(), text.len()));
        Some((Spanned::new(word.to_owned(), place.span(0, word.len())), optional))
    }

    /// `initial: look`, `states: { .. }`
    pub(super) fn machine(&mut self, name: &Spanned<String>, id: NodeId) -> Machine {
        let body = self.state_body(id, name, "machine", &mut None, &mut Comments::default());
        Machine { name: name.clone(), body }
    }

    /// The mapping of a machine or a state. Comments around `final` go to `comments`.
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
                let text = format!("the {what} `{}` says nothing", clip(&owner.value));
                self.diags.push(Diagnostic::error("HQ0117", owner.span, text).help(help));
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
                        let diagnostic = Diagnostic::error("HQ0116", key.span, "`stack` names no stack");
                        self.diags.push(diagnostic.help("write the name of a stack behind `stack:`"));
                    } else if self.scalar(value).is_none() {
                        let help = "write `stack: NAME`, or `stack: NAME(left)`; the levels stand below `stacks:`";
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
                "states" => body.states = self.states(value, &key),
                _ => {
                    let entry = self.setting(key, value);
                    body.settings.entries.push(entry);
                }
            }
        }
        self.depth -= 1;
        self.closing(id, &mut body.closing_comments);
        transitions::settings(&mut body.settings, what, &mut self.diags);
        self.slips(&mut body.settings);
        body
    }

    /// A mapping or sequence below a key that is nearly one of a state: said once, and not kept as a setting.
    fn slips(&mut self, settings: &mut Block) {
        settings.entries.retain(|entry| {
            let meant = nearest(&entry.key.value, STATE_KEYS).filter(|_| has_block(&entry.value));
            if let Some(meant) = meant {
                let text = format!("`{}` is no part of a state", clip(&entry.key.value));
                let diagnostic = Diagnostic::error("HQ0132", entry.key.span, text);
                self.diags.push(diagnostic.help(format!("did you mean `{meant}`?")));
                self.unread.push(entry.value.span);
            }
            meant.is_none()
        });
    }

    /// `final: true`
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

    fn states(&mut self, id: NodeId, key: &Spanned<String>) -> Vec<State> {
        let mut states = Vec::new();
        if self.is_null(id) {
            return states;
        }
        if !matches!(self.node(id).kind, Kind::Mapping(_)) {
            self.wrong_shape(id, "a mapping of states", "write `NAME: { stack: .. }` lines below `states:`");
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
            let body = self.state_body(value, &name, "state", &mut final_, &mut comments);
            let later = self.later(value, name.span);
            self.pool.behind(later.range().end, &[','], &mut comments.behind);
            let span = name.span.to(later);
            states.push(State { name, final_, body, span, comments });
        }
        self.states -= 1;
        states
    }

    /// `say "text"`, or a sequence of such.
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
            self.report(diagnostic);
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
                    .note("without parentheses stand texts, names and numbers; everything else stands in parentheses")
                    .help("write `VERB(a + b, [0, 0, 1] m)`"),
            );
        }
        let done = done?;
        self.pool.before(span.range().end, &mut comments.before);
        self.pool.behind(span.range().end, &[','], &mut comments.behind);
        let comments = std::mem::take(comments);
        Some(Action { moment, verb: done.verb, args: done.args, named: done.named, bare: done.bare, span, comments })
    }

    fn transitions(&mut self, id: NodeId) -> Vec<Transition> {
        if self.is_null(id) {
            return Vec::new();
        }
        let Kind::Sequence(items) = &self.node(id).kind else {
            self.wrong_shape(id, "a sequence of transitions", "write `- { on: found, to: STATE }` for each");
            return Vec::new();
        };
        items.clone().into_iter().filter_map(|item| self.transition(item)).collect()
    }

    /// `{ when: x < 3 N, for: 3 s, to: grasp, blend: 1 s }`
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
                        Diagnostic::error("HQ0141", key.span, "a transition waits for one thing")
                            .label(*at, format!("`{other}` says already for what"))
                            .help("join conditions by `and` behind one `when`, or write two transitions"),
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
        let start = self.text.get(span.range()).and_then(|t| t.chars().next()).map_or(1, char::len_utf8);
        let at = Span { end: span.start + start as u32, ..span };
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
                let text = "this transition does not say what it waits for";
                self.diags.push(Diagnostic::error("HQ0141", at, text).help(help));
                Trigger::Missing
            }
        };
        transitions::transition_settings(&mut settings, &mut self.diags);
        let target = target.unwrap_or_else(|| calls::nameless(span));
        Some(Transition { trigger, target, settings, span, comments })
    }

    /// `grasp`, `outer.inner`
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
        self.report(diagnostic);
        None
    }
}
