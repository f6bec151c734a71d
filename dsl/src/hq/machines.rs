//! Reader of signals, variables, and the heads of machines, in `*.hq` texts.

use super::Reader;
use super::headless::Headless;
use crate::explain::After;
use crate::fix::Fix;
use crate::grammar::{Pair, Rule};
use crate::tree::{Block, Comments, Entry, Machine, Signal, StateBody, Value, Variable};
use crate::{Diagnostic, Span, Spanned, calls, checks, explain, transitions};

impl Reader<'_> {
    /// Reads `NAME : point?  timeout 0.5 s`.
    pub(super) fn signal(&mut self, pair: Pair<'_>, keyword: Span, comments: &mut Comments) -> Option<Signal> {
        let (mut name, mut mark, mut ty, mut optional) = (None::<Spanned<String>>, None, None, None);
        let mut settings = Block { span: keyword, ..Block::default() };
        let mut junk = None;
        for part in pair.into_inner() {
            let at = self.of(&part);
            match part.as_rule() {
                Rule::name => name = Some(self.place().spanned(&part)),
                Rule::mark => mark = Some(at),
                Rule::signal_type => {
                    for part in part.into_inner() {
                        match part.as_rule() {
                            Rule::name => ty = Some(self.place().spanned(&part)),
                            _ => optional = Some(self.of(&part)),
                        }
                    }
                }
                Rule::plain_setting => self.plain_setting(part, &mut settings.entries),
                Rule::block => settings = self.block(part, &mut comments.behind),
                _ => junk = Some(at),
            }
        }
        let name = self.needed_name(name, keyword)?;
        match (mark, &ty) {
            (Some(mark), _) if &self.text[mark.range()] != ":" => self.diags.push(
                Diagnostic::error("HQ0104", mark, "expected `:` between the name of a signal and its type, found `=`")
                    .help(format!("write `signal {} : point`", name.value))
                    .fix(Fix::replace(mark, ":").certain()),
            ),
            (None, Some(ty)) => {
                let at = name.span.range().end;
                self.diags.push(
                    Diagnostic::error("HQ0104", self.span(at, at), format!("`:` is missing after `{}`", name.value))
                        .help(format!("write `signal {} : {}`", name.value, ty.value))
                        .fix(Fix::insert("Write `:`", name.span, " :").certain()),
                );
            }
            _ => {}
        }
        let after = settings.entries.last().map(|entry| entry.value.clone());
        match (&ty, junk) {
            (None, Some(junk)) => {
                let text = self.text.get(junk.range()).unwrap_or("").trim_end();
                let at = Span { end: junk.start + text.len() as u32, ..junk };
                self.diags.push(transitions::bad_type(text, at));
            }
            (None, None) => self.diags.push(transitions::no_type(&name.value, name.span)),
            (Some(_), Some(junk)) => {
                let after = after.as_ref().map_or(After::Start("a setting"), After::Value);
                self.explain(junk, after, false);
            }
            (Some(_), None) => {}
        }
        checks::reserved(&mut settings, &["type"], "signal", &mut self.diags);
        let ty = ty.unwrap_or_else(|| calls::nameless(name.span));
        Some(Signal { name, ty, optional, settings })
    }

    /// Reads `NAME : number = 0`.
    pub(super) fn variable(&mut self, pair: Pair<'_>, keyword: Span, comments: &mut Comments) -> Option<Variable> {
        let (mut name, mut mark, mut ty, mut optional) = (None::<Spanned<String>>, None, None, None);
        let (mut value, mut junk) = (None, None);
        for part in pair.into_inner() {
            let at = self.of(&part);
            match part.as_rule() {
                Rule::name => name = Some(self.place().spanned(&part)),
                Rule::mark => mark = Some(at),
                Rule::signal_type => {
                    for part in part.into_inner() {
                        match part.as_rule() {
                            Rule::name => ty = Some(self.place().spanned(&part)),
                            _ => optional = Some(self.of(&part)),
                        }
                    }
                }
                Rule::given => value = self.given(part, comments),
                _ => junk = Some(at),
            }
        }
        let name = self.needed_name(name, keyword)?;
        let form = format!("write `variable {} : number = 0`", name.value);
        let colon = mark.is_some_and(|m| &self.text[m.range()] == ":");
        if let Some(mark) = mark.filter(|_| !colon) {
            let text = "expected `:` and a type between the name of a variable and its value";
            let fix = Fix::replace(mark, ":").certain();
            self.diags.push(Diagnostic::error("HQ0104", mark, text).help(form).fix(fix));
        } else if let (None, Some(ty)) = (mark, &ty) {
            let at = name.span.range().end;
            let text = format!("`:` is missing after `{}`", name.value);
            let d = Diagnostic::error("HQ0104", self.span(at, at), text);
            self.diags.push(
                d.help(format!("write `variable {} : {}`", name.value, ty.value))
                    .fix(Fix::insert("Write `:`", name.span, " :").certain()),
            );
        } else if ty.is_none() {
            self.diags.push(transitions::no_variable_type(&name.value, name.span));
        } else if let Some(junk) = junk {
            let after = value.as_ref().map_or(After::Start("`=` and a value"), After::Value);
            self.explain(junk, after, false);
        }
        let ty = ty.unwrap_or_else(|| calls::nameless(name.span));
        Some(Variable { name, ty, optional, value })
    }

    /// Reads `= 0`.
    fn given(&mut self, pair: Pair<'_>, comments: &mut Comments) -> Option<Value> {
        let (mut mark, mut value) = (None, None);
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::mark => mark = Some(self.of(&part)),
                _ => value = Some(part),
            }
        }
        let mark = mark?;
        if &self.text[mark.range()] == ":" {
            let text = "expected `=` before the value of a variable, found `:`";
            let fix = Fix::replace(mark, "=").certain();
            self.diags.push(Diagnostic::error("HQ0104", mark, text).help("write `= 0`").fix(fix));
        }
        let Some(value) = value else {
            let text = "expected a value after `=`";
            self.diags
                .push(Diagnostic::incomplete("HQ0107", mark, text).help("write the initial value of the variable"));
            return None;
        };
        let value = self.expr(value);
        self.pool.before(value.span.range().end, &mut comments.before);
        Some(value)
    }

    /// Returns the name of a declaration, and reports a missing one.
    pub(super) fn needed_name(&mut self, name: Option<Spanned<String>>, keyword: Span) -> Option<Spanned<String>> {
        if name.as_ref().is_none_or(|name| name.value.is_empty()) {
            let word = self.text.get(keyword.range()).unwrap_or("").to_owned();
            self.diags.push(
                Diagnostic::incomplete("HQ0116", keyword, format!("this `{word}` has no name"))
                    .help(format!("write the name after `{word}`: letters, digits and `_`")),
            );
            return None;
        }
        name
    }

    /// Reads a `key value` that follows other parts on their line.
    pub(super) fn plain_setting(&mut self, pair: Pair<'_>, entries: &mut Vec<Entry>) {
        let start = self.of(&pair).range().start;
        let (mut key, mut mark, mut value) = (None::<Spanned<String>>, None, None);
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::name => key = Some(self.place().spanned(&part)),
                Rule::mark => mark = Some(self.of(&part)),
                _ => value = Some(part),
            }
        }
        let Some(key) = key else { return };
        if value.is_none() && mark.is_none() && self.follows_bare_number(entries, start) {
            self.diags.push(explain::unknown_unit(&key.value, key.span));
            if let Some(last) = entries.last_mut() {
                last.value.kind = crate::tree::ValueKind::Missing;
            }
            return;
        }
        if let Some(mark) = mark {
            let sign = &self.text[mark.range()];
            self.diags.push(
                Diagnostic::error("HQ0108", mark, format!("unexpected `{sign}` between a key and its value"))
                    .help(format!("write `{} 0.5`, with the value you mean", key.value))
                    .fix(Fix::delete(mark, sign).certain()),
            );
        }
        let value = self.head_value(&key, value, None);
        entries.push(Entry { key, value, comments: Comments::default() });
    }

    /// Returns the block of a declaration with a missing opening brace, if there is one; reports the error.
    pub(super) fn lost_brace(&mut self, what: &str, keyword: Span, end: usize) -> Option<Headless> {
        let block = if self.nested { None } else { self.headless(end) };
        match &block {
            Some(block) => self.no_brace(&format!("`{what}`"), keyword, block),
            None => self.diags.push(
                Diagnostic::incomplete("HQ0117", keyword, format!("this `{what}` has no block"))
                    .help("write `{ .. }` after its name"),
            ),
        }
        block
    }

    /// Reports text in a head that has no meaning there.
    pub(super) fn head(&mut self, mark: Option<Span>, junk: &[Span], what: &str) {
        if let Some(mark) = mark {
            let sign = &self.text[mark.range()];
            let text = format!("unexpected `{sign}` after the name of a {what}");
            self.diags.push(
                Diagnostic::error("HQ0104", mark, text)
                    .help("delete it; the block follows the name")
                    .fix(Fix::delete(mark, sign).certain()),
            );
        }
        for junk in junk {
            self.explain(*junk, After::Start("a block in braces"), false);
        }
    }

    /// Reads `NAME { initial look  state look { .. } }`; a body with a missing opening brace moves `end`.
    pub(super) fn machine(
        &mut self,
        pair: Pair<'_>,
        keyword: Span,
        end: &mut usize,
        comments: &mut Comments,
    ) -> Option<Machine> {
        let (mut name, mut mark, mut body, mut junk) = (None, None, None, Vec::new());
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::name => name = Some(self.place().spanned(&part)),
                Rule::mark => mark = Some(self.of(&part)),
                Rule::state_body => body = Some(part),
                _ => junk.push(self.of(&part)),
            }
        }
        let name = self.needed_name(name, keyword);
        self.head(mark, &junk, "machine");
        let mut read = StateBody { settings: Block { span: keyword, ..Block::default() }, ..StateBody::default() };
        if let Some(body) = body {
            read = self.state_body(body, "machine", &mut comments.behind);
        } else if junk.is_empty()
            && let Some(block) = self.lost_brace("machine", keyword, *end)
        {
            let base = std::mem::replace(&mut self.base, block.open);
            if let Some(pair) = block.pair(Rule::state_body) {
                read = self.state_body(pair, "machine", &mut comments.behind);
            }
            self.base = base;
            self.read = block.end;
            *end = block.end;
        }
        name.map(|name| Machine { name, body: read })
    }
}
