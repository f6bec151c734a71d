//! Reader of states and their content in `*.hq` texts: the stack, settings, actions, transitions.

use super::Reader;
use crate::diagnostic::clip;
use crate::explain::{self, After};
use crate::expr::{Place, missing};
use crate::grammar::{Pair, Rule};
use crate::limits::MAX_STATE_NESTING;
use crate::tree::{Action, Block, Comments, Entry, Moment, State, StateBody, Transition, Trigger, Value};
use crate::words::is_name;
use crate::{Diagnostic, Span, Spanned, actions, calls, transitions};

impl Reader<'_> {
    /// Converts a node `state_body` or `headless_body` of a machine or a state.
    pub(super) fn state_body(&mut self, pair: Pair<'_>, what: &str, behind: &mut Option<String>) -> StateBody {
        let span = self.of(&pair);
        let (start, end) = (span.range().start, span.range().end);
        if pair.as_rule() == Rule::state_body {
            self.pool.behind(start + 1, &[], behind);
        }
        let mut body = StateBody { settings: Block { span, ..Block::default() }, ..StateBody::default() };
        let mut open = false;
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::lone_key => self.lone_key(part, &mut body.settings.entries),
                Rule::entry => self.entry(part, &mut body.settings.entries),
                Rule::state => body.states.extend(self.state(part)),
                Rule::stack_use => self.stack_use(part, &mut body),
                Rule::action => body.actions.extend(self.action(part)),
                Rule::transition => body.transitions.push(self.transition(part)),
                Rule::property => body.properties.push(self.expect(part, "check")),
                _ => open = true,
            }
        }
        if open {
            self.unclosed(start, end);
        } else {
            self.pool.before(end - 1, &mut body.closing_comments.before);
        }
        transitions::settings(&mut body.settings, what, &mut self.diags);
        transitions::distinct_states(&mut body.states, &mut self.diags);
        body
    }

    /// Reports a key without a value.
    pub(super) fn lone_key(&mut self, pair: Pair<'_>, entries: &mut Vec<Entry>) {
        let key = self.place().spanned(&pair);
        if key.span.range().start < self.read {
            return;
        }
        if self.follows_bare_number(entries, key.span.range().start) {
            self.diags.push(explain::unknown_unit(&key.value, key.span));
            if let Some(last) = entries.last_mut() {
                last.value.kind = crate::tree::ValueKind::Missing;
            }
            return;
        }
        self.diags.push(explain::no_value(&key.value, key.span));
        entries.push(Entry { value: missing(key.span), key, comments: Comments::default() });
    }

    /// Converts a node `state`; one that is nested too deeply is left out.
    fn state(&mut self, pair: Pair<'_>) -> Option<State> {
        let whole = self.of(&pair);
        let start = whole.range().start;
        let span = self.span(start, start + pair.as_str().trim_end().len());
        let mut comments = Comments::default();
        self.pool.before(start, &mut comments.before);
        let (mut name, mut mark, mut final_, mut block, mut junk) = (None::<Spanned<String>>, None, None, None, None);
        let mut region = None;
        for part in pair.into_inner() {
            let at = self.of(&part);
            match part.as_rule() {
                Rule::region_word => region = Some(at),
                Rule::final_word => final_ = Some(at),
                Rule::name => name = Some(self.place().spanned(&part)),
                Rule::mark => mark = Some(at),
                Rule::state_body | Rule::headless_body => block = Some(part),
                _ => junk = Some(at),
            }
        }
        let what = if region.is_some() { "region" } else { "state" };
        let keyword = final_.or(region).unwrap_or_else(|| self.span(start, start + "state".len()));
        if final_.is_some() && name.is_none() && junk.is_some() {
            junk.into_iter().for_each(|junk| {
                self.explain(junk, After::Start("`state` and a name"), false);
            });
            return None;
        }
        self.head(mark, junk.as_slice(), what);
        if name.is_none() {
            self.diags.push(
                Diagnostic::incomplete("HQ0116", keyword, format!("this {what} has no name"))
                    .help(format!("write the name after `{what}`: letters, digits and `_`")),
            );
        }
        if self.states >= MAX_STATE_NESTING {
            self.diags.push(transitions::too_deep(keyword));
            return None;
        }
        let mut body = StateBody { settings: Block { span, ..Block::default() }, ..StateBody::default() };
        match block {
            Some(block) => {
                if block.as_rule() == Rule::headless_body {
                    let end = self.of(&block).range().end;
                    self.diags.push(
                        Diagnostic::incomplete("HQ0117", keyword, format!("the `{{` of this {what} is missing"))
                            .label(self.span(end - 1, end), "this brace closes it")
                            .help("write `{` at the end of the line"),
                    );
                }
                self.states += 1;
                body = self.state_body(block, what, &mut comments.behind);
                self.states -= 1;
            }
            None if region.is_some() && junk.is_none() => self.diags.push(
                Diagnostic::incomplete("HQ0117", keyword, "this region has no block")
                    .help("write `{ initial STATE  state STATE { .. } }` after its name"),
            ),
            None if final_.is_none() && junk.is_none() => self.diags.push(
                Diagnostic::incomplete("HQ0117", keyword, "this state has no block")
                    .help("write `{ stack NAME  on found -> STATE }` after its name; a last one is written `final state NAME`"),
            ),
            None => {}
        }
        self.pool.behind(span.range().end, &[',', ';'], &mut comments.behind);
        Some(State { name: name?, region: region.is_some(), final_, body, span, comments })
    }

    /// Reads `stack reach_to(goal: peduncle)`.
    fn stack_use(&mut self, pair: Pair<'_>, body: &mut StateBody) {
        let whole = self.of(&pair);
        let start = whole.range().start;
        let keyword = self.span(start, start + "stack".len());
        self.pool.before(start, &mut body.stack_comments.before);
        let (mut name, mut args, mut named, mut junk) = (None::<Spanned<String>>, Vec::new(), Vec::new(), None);
        let mut end = keyword.range().end;
        for part in pair.into_inner() {
            let at = self.of(&part);
            match part.as_rule() {
                Rule::name => name = Some(self.place().spanned(&part)),
                Rule::actuals => (args, named) = self.arguments(part),
                _ => {
                    junk = Some(at);
                    continue;
                }
            }
            end = at.range().end;
        }
        match (&name, junk) {
            (_, Some(junk)) => {
                self.explain(junk, After::Start("a stack, such as `reach_to(left)`,"), false);
            }
            (None, None) => self
                .diags
                .push(Diagnostic::incomplete("HQ0116", keyword, "`stack` names no stack").help(
                    "write the name of a stack after it; declare its levels in a `stack` at the top of the spec",
                )),
            _ => {}
        }
        self.pool.before(end, &mut body.stack_comments.before);
        self.pool.behind(end, &[',', ';'], &mut body.stack_comments.behind);
        let Some(name) = name else { return };
        if let Some(first) = &body.stack {
            self.diags.push(crate::checks::duplicate("stack", first.span, keyword));
            return;
        }
        let span = self.span(name.span.range().start, end);
        body.stack = Some(crate::tree::Call { name, args, named, span });
    }

    /// Reads `enter say "text"`.
    fn action(&mut self, pair: Pair<'_>) -> Option<Action> {
        let whole = self.of(&pair);
        let start = whole.range().start;
        let mut comments = Comments::default();
        self.pool.before(start, &mut comments.before);
        let (mut moment, mut done, mut junk) = (Spanned::new(Moment::Do, whole), None, None);
        let mut end = start;
        for part in pair.into_inner() {
            let at = self.of(&part);
            match part.as_rule() {
                Rule::moment => {
                    let word = part.as_str();
                    let known = Moment::ALL.into_iter().find(|moment| moment.word() == word);
                    moment = Spanned::new(known.unwrap_or(Moment::Do), at);
                }
                Rule::action_call => {
                    let (place, mut diags) = (self.place(), Vec::new());
                    done = Some(actions::call(part, place, &mut |part| self.expr(part), &mut diags));
                    self.diags.extend(diags);
                }
                _ => {
                    junk = Some(at);
                    continue;
                }
            }
            end = at.range().end;
        }
        self.pool.before(end, &mut comments.before);
        self.pool.behind(end, &[',', ';'], &mut comments.behind);
        let span = self.span(start, end);
        if let Some(junk) = junk {
            self.unread.push(junk);
            let text = self.text.get(junk.range()).unwrap_or("").trim_end();
            let at = Span { end: junk.start + text.len() as u32, ..junk };
            let message = format!("`{}` cannot be read in an action", clip(text));
            self.diags.push(
                Diagnostic::error("HQ0142", at, message)
                    .note("texts, names and numbers need no parentheses; write everything else in parentheses")
                    .help("write `VERB(a + b, [0, 0, 1] m)`"),
            );
        } else if done.is_none() {
            self.diags.push(actions::nothing(moment.value.word(), moment.span));
        }
        let done = done?;
        Some(Action { moment, verb: done.verb, args: done.args, named: done.named, bare: done.bare, span, comments })
    }

    /// Reads `when x < 3 N for 3 s -> grasp blend 1 s`.
    fn transition(&mut self, pair: Pair<'_>) -> Transition {
        let whole = self.of(&pair);
        let start = whole.range().start;
        let mut comments = Comments::default();
        self.pool.before(start, &mut comments.before);
        let mut settings = Block { span: whole, ..Block::default() };
        let (mut trigger, mut target, mut arrow, mut junk) = (Trigger::Missing, None, None, None);
        let mut end = start;
        for part in pair.into_inner() {
            let at = self.of(&part);
            match part.as_rule() {
                Rule::trigger => trigger = self.trigger(part),
                Rule::arrow => arrow = Some(at),
                Rule::target => target = Some(self.place().spanned(&part)),
                Rule::plain_setting => self.plain_setting(part, &mut settings.entries),
                _ => {
                    junk = Some(at);
                    continue;
                }
            }
            end = at.range().end;
        }
        self.pool.before(end, &mut comments.before);
        let span = self.span(start, start + self.text[start..end].trim_end().len());
        self.pool.behind(span.range().end, &[',', ';'], &mut comments.behind);
        match (arrow, junk) {
            (None, Some(junk)) => target = self.lost_arrow(junk, &trigger),
            (Some(_), Some(junk)) => {
                let after = settings.entries.last().map(|entry| entry.value.clone());
                let after = after.as_ref().map_or(After::Start("a state"), After::Value);
                self.explain(junk, after, false);
            }
            (arrow, None) if target.is_none() => self.diags.push(transitions::no_target(arrow.unwrap_or(span))),
            _ => {}
        }
        transitions::transition_settings(&mut settings, &mut self.diags);
        let target = target.unwrap_or_else(|| calls::nameless(span));
        Transition { trigger, target, settings, span, comments }
    }

    /// Handles text in place of `->`: `on found pre_grasp`, `on found => pre_grasp`. Returns the state if one is named.
    fn lost_arrow(&mut self, junk: Span, trigger: &Trigger) -> Option<Spanned<String>> {
        let text = self.text.get(junk.range()).unwrap_or("").trim_end();
        let name = text.trim_start_matches(['=', '>', '-', '→']).trim_start();
        let word = name.find(char::is_whitespace).map_or(name, |n| &name[..n]);
        let start = junk.range().start + text.len() - name.len();
        let known =
            word.split('.').all(is_name).then(|| Spanned::new(word.to_owned(), self.span(start, start + word.len())));
        let Some(state) = &known else {
            let after = match trigger {
                Trigger::On(value) | Trigger::When { condition: value, hold: None } | Trigger::After(value) => {
                    After::Value(value)
                }
                _ => After::Start("`->` and the next state"),
            };
            self.explain(junk, after, false);
            return None;
        };
        let at = junk.range().start;
        let sign = &text[..text.len() - name.len()];
        let span = self.span(at, at + sign.trim_end().len().max(if sign.is_empty() { word.len() } else { 0 }));
        self.diags.push(
            Diagnostic::error("HQ0141", span, "`->` is missing before the next state")
                .help(format!("write `-> {}`", state.value)),
        );
        known
    }

    fn trigger(&mut self, pair: Pair<'_>) -> Trigger {
        let (mut word, mut at, mut value, mut hold) = ("on", self.of(&pair), None, None);
        for part in pair.into_inner() {
            let span = self.of(&part);
            match part.as_rule() {
                Rule::trigger_word => {
                    at = span;
                    word = match part.as_str() {
                        "when" => "when",
                        "after" => "after",
                        _ => "on",
                    };
                }
                Rule::hold => hold = Some(self.hold(part)),
                _ => value = Some(self.expr(part)),
            }
        }
        if let Some(hold) = hold.as_ref().filter(|_| word != "when") {
            self.diags.push(transitions::no_hold(word, hold.span));
        }
        let Some(value) = value else {
            self.diags.push(transitions::no_condition(word, at));
            return Trigger::Missing;
        };
        match word {
            "when" => Trigger::When { condition: value, hold },
            "after" => Trigger::After(value),
            _ => Trigger::On(value),
        }
    }

    /// Reads `for 3 s`.
    fn hold(&mut self, pair: Pair<'_>) -> Value {
        let span = self.of(&pair);
        match pair.into_inner().next() {
            Some(part) => self.expr(part),
            None => {
                self.diags
                    .push(explain::no_value("for", span).help("write for how long the condition must hold: `for 3 s`"));
                missing(span)
            }
        }
    }

    /// Returns the place of byte positions in the whole text.
    pub(super) fn exact(&self) -> Place {
        Place::Exact(self.source, 0)
    }
}
