//! Reader of the levels of a stack and their members, in `*.hq` texts.

use super::Reader;
use crate::explain::{self, After};
use crate::expr::missing;
use crate::fix::Fix;
use crate::grammar::{Pair, Rule};
use crate::tree::{
    Beside, Block, Change, Comments, Entry, Level, Member, MemberTask, Number, Removal, RepeatMembers, Stack,
    TaskDefinition, Unit, Value, ValueKind,
};
use crate::words::{has_block, nearest};
use crate::{Diagnostic, Span, Spanned, checks};

/// Weight with a unit, which is the next task.
struct UnitOfWeight<'m> {
    weight: &'m mut Value,
    number: Value,
    unit: Unit,
}

/// Returns the weight of a member if it ends in what may be a task: a unit of one symbol.
fn read_as_unit(member: &mut Member) -> Option<UnitOfWeight<'_>> {
    let weight = member.weight.as_mut()?;
    let ValueKind::Unit(number, unit) = &weight.kind else { return None };
    let [(_, 1)] = unit.factors.as_slice() else { return None };
    let (number, unit) = ((**number).clone(), unit.clone());
    Some(UnitOfWeight { weight, number, unit })
}

/// True for a member that begins with the word `weight`, in place of a task.
fn begins_with_weight(pair: &Pair<'_>) -> bool {
    let first = pair.clone().into_inner().next();
    first.is_some_and(|part| part.as_rule() == Rule::name && part.as_str() == "weight")
}

impl Reader<'_> {
    /// Reads the braces of a stack.
    pub(super) fn stack_body(&mut self, pair: Pair<'_>, stack: &mut Stack, behind: &mut Option<String>) {
        let span = self.of(&pair);
        stack.settings.span = span;
        self.pool.behind(span.range().start + 1, &[], behind);
        let mut open = false;
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::entry => self.entry(part, &mut stack.settings.entries),
                Rule::level => stack.levels.extend(self.level(part, "level").map(|l| l.0)),
                Rule::change => stack.changes.extend(self.change(part)),
                Rule::removal => stack.changes.extend(self.removal(part)),
                _ => open = true,
            }
        }
        if open {
            self.unclosed(span.range().start, span.range().end);
        } else {
            self.pool.before(span.range().end - 1, &mut stack.settings.closing_comments.before);
        }
    }

    /// Reads `replace NAME { .. }`, `add NAME { .. } before NAME`.
    fn change(&mut self, pair: Pair<'_>) -> Option<Change> {
        let word = if pair.as_str().starts_with("add") { "add" } else { "replace" };
        let (level, beside) = self.level(pair, word)?;
        match (word, beside) {
            ("add", beside) => Some(Change::Add(level, beside)),
            (_, Some(beside)) => {
                let message = "a level that is replaced keeps its place";
                let diagnostic = Diagnostic::error("HQ0126", beside.level.span, message);
                self.diags.push(diagnostic.help("to move a level, remove it and add it at its new place"));
                Some(Change::Replace(level))
            }
            _ => Some(Change::Replace(level)),
        }
    }

    /// Reads `remove NAME`.
    fn removal(&mut self, pair: Pair<'_>) -> Option<Change> {
        let span = self.of(&pair);
        let mut comments = Comments::default();
        self.pool.before(span.range().start, &mut comments.before);
        let level = pair.into_inner().next().map(|part| self.place().spanned(&part));
        if level.is_none() {
            let at = self.span(span.range().start, span.range().start + "remove".len());
            let diagnostic = Diagnostic::incomplete("HQ0116", at, "`remove` names no level");
            self.diags.push(diagnostic.help("write the name of the level after `remove`"));
        }
        self.pool.behind(span.range().end, &[',', ';'], &mut comments.behind);
        Some(Change::Remove(Removal { level: level?, span, comments }))
    }

    /// Reads `before NAME`, `after NAME`.
    fn beside(&mut self, pair: Pair<'_>) -> Option<Beside> {
        let span = self.of(&pair);
        let before = pair.as_str().starts_with("before");
        let level = pair.into_inner().find(|part| part.as_rule() == Rule::name).map(|part| self.place().spanned(&part));
        if level.is_none() {
            let word = if before { "before" } else { "after" };
            let diagnostic = Diagnostic::incomplete("HQ0116", span, format!("`{word}` names no level"));
            self.diags.push(diagnostic.help(format!("write the name of a level after `{word}`")));
        }
        Some(Beside { before, level: level? })
    }

    /// Reads a level that begins with the keyword `word`.
    fn level(&mut self, pair: Pair<'_>, word: &str) -> Option<(Level, Option<Beside>)> {
        let whole = self.of(&pair);
        let start = whole.range().start;
        let keyword = self.span(start, start + word.len());
        let span = self.span(start, start + pair.as_str().trim_end().len());
        let mut comments = Comments::default();
        self.pool.before(start, &mut comments.before);
        let (mut name, mut hard, mut members, mut beside) = (None, None, None, None);
        let mut settings = Block { span, ..Block::default() };
        for part in pair.into_inner() {
            let at = self.of(&part);
            match part.as_rule() {
                Rule::change_word => {}
                Rule::name => name = Some(self.place().spanned(&part)),
                Rule::hard => self.hard(&mut hard, at),
                Rule::setting => self.setting(part, &mut settings.entries, &mut hard),
                Rule::beside => beside = self.beside(part),
                Rule::level_body => {
                    let Block { entries, closing_comments, .. } = &mut settings;
                    members = Some(self.members(part, &mut comments, closing_comments, entries));
                }
                _ => {
                    self.junk(at, After::Start("`hard`, a setting or `{`"));
                    members.get_or_insert_with(Vec::new);
                }
            }
        }
        checks::duplicates(&settings.entries, &mut self.diags);
        checks::reserved(&mut settings, checks::LEVEL_WORDS, "level", &mut self.diags);
        if let Some(name) = name.as_ref().filter(|n| n.value == "hard") {
            self.diags.push(checks::hard_is_no_name(name.span));
            hard.get_or_insert(name.span);
        }
        if name.is_none() {
            self.diags.push(
                Diagnostic::incomplete("HQ0116", keyword, format!("this `{word}` has no name"))
                    .help(format!("write the name after `{word}`: letters, digits and `_`")),
            );
        }
        if members.is_none() {
            self.diags.push(
                Diagnostic::incomplete("HQ0117", keyword, format!("this `{word}` has no braces with its tasks"))
                    .help(format!("write `{word} NAME {{ task_a  task_b }}`")),
            );
        }
        self.pool.behind(span.range().end, &[',', ';'], &mut comments.behind);
        let level = Level { name: name?, hard, settings, members: members.unwrap_or_default(), span, comments };
        Some((level, beside))
    }

    fn hard(&mut self, hard: &mut Option<Span>, at: Span) {
        match hard {
            Some(first) => self.diags.push(
                Diagnostic::error("HQ0118", at, "`hard` is given twice")
                    .label(*first, "first given here")
                    .help("keep one"),
            ),
            None => *hard = Some(at),
        }
    }

    /// Reads `key value` in the head of a level.
    fn setting(&mut self, pair: Pair<'_>, entries: &mut Vec<Entry>, hard: &mut Option<Span>) {
        let end = self.of(&pair).range().end;
        let (mut key, mut mark, mut value, mut junk) = (None, None, None, None);
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::name => key = Some(self.place().spanned(&part)),
                Rule::mark => mark = Some(self.of(&part)),
                Rule::expr => value = Some(part),
                _ => junk = Some(self.of(&part)),
            }
        }
        let Some(key) = key else { return };
        let lone_name = value.as_ref().filter(|v| crate::words::is_name(v.as_str())).map(|v| self.of(v));
        if nearest(&key.value, &["hard"]).is_some() && (value.is_none() || lone_name.is_some()) {
            self.diags.push(
                Diagnostic::error("HQ0118", key.span, format!("`{}` is no setting of a level", key.value))
                    .meant("hard"),
            );
            hard.get_or_insert(key.span);
            if let Some(next) = lone_name {
                self.again(Rule::setting, next.range().start, end, |reader, pair| reader.setting(pair, entries, hard));
            }
            return;
        }
        if let Some(mark) = mark {
            let sign = &self.text[mark.range()];
            self.diags.push(
                Diagnostic::error("HQ0108", mark, format!("unexpected `{sign}` between a key and its value"))
                    .help(format!("write `{} 0.01`, with the value you mean", key.value))
                    .fix(Fix::delete(mark, sign).certain()),
            );
        }
        let value = self.head_value(&key, value, junk);
        entries.push(Entry { key, value, comments: Comments::default() });
    }

    pub(super) fn head_value(&mut self, key: &Spanned<String>, value: Option<Pair<'_>>, junk: Option<Span>) -> Value {
        let mut value = match value {
            Some(pair) => {
                let value = self.expr(pair);
                if let Some(junk) = junk {
                    self.junk(junk, After::Value(&value));
                }
                value
            }
            None => {
                match junk {
                    Some(junk) => self.junk(junk, After::Key(&key.value)),
                    None => self.diags.push(explain::no_value(&key.value, key.span)),
                }
                missing(key.span)
            }
        };
        self.no_block(&mut value);
        checks::text_value(&key.value, &mut value, self.text, &mut self.diags);
        value
    }

    fn no_block(&mut self, value: &mut Value) {
        if has_block(value) {
            self.diags.push(
                Diagnostic::unreadable("HQ0113", value.span, "a block is not allowed here")
                    .note("the setting of a level, and a weight, is a single value"),
            );
            value.kind = crate::tree::ValueKind::Missing;
        }
    }

    /// Reads the braces of a level; the warnings that are allowed there are added to its settings.
    fn members(
        &mut self,
        pair: Pair<'_>,
        comments: &mut Comments,
        closing: &mut Comments,
        settings: &mut Vec<Entry>,
    ) -> Vec<Member> {
        let span = self.of(&pair);
        self.pool.before(span.range().start, &mut comments.before);
        self.pool.behind(span.range().start + 1, &[], &mut comments.behind);
        let mut members = Vec::new();
        let mut open = false;
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::allow => self.allow(part, settings),
                Rule::member => {
                    let read = match members.last_mut().and_then(read_as_unit).filter(|_| begins_with_weight(&part)) {
                        Some(before) => Some(self.after_unit(before, part)),
                        None => self.member(part),
                    };
                    members.extend(read);
                }
                Rule::member_repeat => members.extend(self.member_repeat(part)),
                _ => open = true,
            }
        }
        if open {
            self.unclosed(span.range().start, span.range().end);
        } else {
            self.pool.before(span.range().end - 1, &mut closing.before);
        }
        members
    }

    fn member(&mut self, pair: Pair<'_>) -> Option<Member> {
        let whole = self.of(&pair);
        let start = whole.range().start;
        let mut comments = Comments::default();
        self.pool.before(start, &mut comments.before);
        let (mut name, mut args, mut body, mut weight) = (None, None, None, None);
        let mut end = start;
        for part in pair.into_inner() {
            let span = self.of(&part);
            match part.as_rule() {
                Rule::name => name = Some(self.place().spanned(&part)),
                Rule::actuals => args = Some(self.arguments(part)),
                Rule::block => body = Some(self.block(part, &mut comments.behind)),
                Rule::weight => weight = Some(self.weight(part)),
                _ => {
                    self.junk(span, weight.as_ref().map_or(After::Start("a task"), After::Value));
                    break;
                }
            }
            end = span.range().end;
        }
        let name = name?;
        let span = self.span(start, end);
        self.pool.before(end, &mut comments.before);
        self.pool.behind(end, &[',', ';'], &mut comments.behind);
        let task = if args.is_some() || body.is_some() {
            let body = body.unwrap_or(Block { span: self.span(end, end), ..Block::default() });
            let (args, named) = args.unwrap_or_default();
            MemberTask::Inline(TaskDefinition { kind: name, args, named, body, span })
        } else {
            MemberTask::Name(name)
        };
        Some(Member { task, weight, span, comments })
    }

    /// Reads what follows a task that was read as the unit of the weight before it: `weight 5` in `f weight 4  g weight 5`.
    /// Returns that task, and takes the unit from the weight.
    fn after_unit(&mut self, before: UnitOfWeight<'_>, pair: Pair<'_>) -> Member {
        let whole = self.of(&pair);
        let UnitOfWeight { weight, number, unit } = before;
        let name = Spanned { value: unit.to_string(), span: unit.span };
        let d = format!("`{}` is read as the unit of the weight before it", name.value);
        self.diags.push(
            Diagnostic::unreadable("HQ0113", unit.span, d)
                .help(format!("begin a new line before the task `{}`, or put a comma before it", name.value))
                .fix(Fix::insert("Insert a comma", number.span, ",").certain()),
        );
        let follows = pair.into_inner().nth(1).filter(|part| part.as_rule() == Rule::junk);
        let read = follows.and_then(|part| {
            let (text, span) = (part.as_str().trim(), self.of(&part));
            let span = self.span(span.range().start, span.range().start + text.len());
            let value = text.parse().ok()?;
            Some(Value { kind: ValueKind::Number(Number { value, text: text.to_string() }), span })
        });
        let span = self.span(unit.span.range().start, read.as_ref().map_or(whole.range().end, |v| v.span.range().end));
        *weight = number;
        Member { task: MemberTask::Name(name), weight: read, span, comments: Comments::default() }
    }

    /// Reads `for side in [left, right] { hold(side) }`.
    fn member_repeat(&mut self, pair: Pair<'_>) -> Option<Member> {
        let whole = self.of(&pair);
        let start = whole.range().start;
        let span = self.span(start, start + pair.as_str().trim_end().len());
        let (mut comments, mut closing_comments) = (Comments::default(), Comments::default());
        self.pool.before(start, &mut comments.before);
        let head = self.repeat_head(pair, self.span(start, start + "for".len()));
        let mut allowed = Vec::new();
        let body = head.body.map(|part| self.members(part, &mut comments, &mut closing_comments, &mut allowed));
        let body = body.unwrap_or_default();
        for entry in allowed {
            let text = "a repetition of tasks allows nothing";
            self.diags.push(
                Diagnostic::unreadable("HQ0113", entry.key.span, text).help("write it in the braces of the level"),
            );
        }
        self.pool.behind(span.range().end, &[',', ';'], &mut comments.behind);
        let repeat = RepeatMembers { variable: head.variable?, values: head.values?, body, closing_comments };
        Some(Member { task: MemberTask::For(Box::new(repeat)), weight: None, span, comments })
    }

    fn weight(&mut self, pair: Pair<'_>) -> Value {
        let span = self.of(&pair);
        let mut value = None;
        for part in pair.into_inner() {
            if part.as_rule() == Rule::expr {
                let mut read = self.expr(part);
                self.no_block(&mut read);
                value = Some(read);
            } else {
                let at = self.of(&part);
                let diagnostic = Diagnostic::error("HQ0108", at, "unexpected sign between a key and its value");
                self.diags
                    .push(diagnostic.help("write `weight 2`").fix(Fix::edit("Delete the sign", at, "").certain()));
            }
        }
        value.unwrap_or_else(|| {
            self.diags.push(explain::no_value("weight", span));
            missing(span)
        })
    }
}
