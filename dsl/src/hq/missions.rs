//! Reader of missions, their members, and repeated members, in `*.hq` texts.

use super::Reader;
use crate::explain::After;
use crate::fix::Fix;
use crate::grammar::{Pair, Rule};
use crate::missions::{self, Body};
use crate::tree::{Comments, Entry, Mission, MissionMember, MissionRepeat, ValueKind};
use crate::vocabulary::ROLES;
use crate::words::is_name;
use crate::{Diagnostic, Span, Spanned, calls};

impl Reader<'_> {
    /// Reads `NAME : KIND { .. }`; a body with a missing opening brace moves `end`.
    pub(super) fn mission(
        &mut self,
        pair: Pair<'_>,
        keyword: Span,
        end: &mut usize,
        comments: &mut Comments,
    ) -> Option<Mission> {
        let (mut name, mut mark, mut kind, mut block, mut junk) = (None, None, None, None, Vec::new());
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::name => name = Some(self.place().spanned(&part)),
                Rule::mark => mark = Some(self.of(&part)),
                Rule::mission_kind => kind = Some(self.place().spanned(&part)),
                Rule::mission_body => block = Some(part),
                _ => junk.push(self.of(&part)),
            }
        }
        let name = self.needed_name(name, keyword);
        self.kind(name.as_ref(), mark, kind.as_ref());
        for junk in &junk {
            self.unfit(*junk, "a kind of mission");
        }
        let mut body = Body::empty(keyword);
        if let Some(block) = block {
            body = self.mission_body(block, "mission", comments);
        } else if junk.is_empty()
            && let Some(block) = self.lost_brace("mission", keyword, *end)
        {
            let base = std::mem::replace(&mut self.base, block.open);
            if let Some(pair) = block.pair(Rule::mission_body) {
                body = self.mission_body(pair, "mission", comments);
            }
            self.base = base;
            self.read = block.end;
            *end = block.end;
        }
        let name = name?;
        let kind = kind.unwrap_or_else(|| calls::nameless(name.span));
        Some(Mission { name, kind, settings: body.settings, members: body.members, repeats: body.repeats })
    }

    /// Reports errors between the name of a mission and its kind.
    fn kind(&mut self, name: Option<&Spanned<String>>, mark: Option<Span>, kind: Option<&Spanned<String>>) {
        let Some(name) = name else { return };
        let Some(kind) = kind else {
            self.diags.push(missions::no_kind(&name.value, name.span));
            return;
        };
        let help = format!("write `mission {} : {}`", name.value, kind.value);
        match mark {
            Some(mark) if &self.text[mark.range()] == ":" => {}
            Some(mark) => {
                let text = "expected `:` between the name of a mission and its kind, found `=`";
                let fix = Fix::replace(mark, ":").certain();
                self.diags.push(Diagnostic::error("HQ0104", mark, text).help(help).fix(fix));
            }
            None => {
                let at = name.span.range().end;
                let text = format!("`:` is missing after `{}`", name.value);
                let fix = Fix::insert("Write `:`", name.span, " :").certain();
                self.diags.push(Diagnostic::error("HQ0104", self.span(at, at), text).help(help).fix(fix));
            }
        }
    }

    /// Converts a node `mission_body`; `what` is `mission`, or the role of the member that owns the body.
    fn mission_body(&mut self, pair: Pair<'_>, what: &str, comments: &mut Comments) -> Body {
        let mut body = self.parts(pair, comments);
        self.slips(&mut body, what);
        body.members.sort_by_key(|member| member.span.start);
        let owner = if what == "mission" { what.to_owned() } else { missions::owner(what) };
        missions::settings(&mut body.settings, &owner, &mut self.diags);
        missions::distinct(&mut body.members, &mut self.diags);
        missions::in_order(&body.members, &body.repeats, &mut self.diags);
        body
    }

    /// Converts the content of a node `mission_body`, as written.
    fn parts(&mut self, pair: Pair<'_>, comments: &mut Comments) -> Body {
        let span = self.of(&pair);
        self.pool.before(span.range().start, &mut comments.before);
        self.pool.behind(span.range().start + 1, &[], &mut comments.behind);
        let (mut body, mut open) = (Body::empty(span), false);
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::mission_key => self.lone_key(part, &mut body.settings.entries),
                Rule::entry => self.entry(part, &mut body.settings.entries),
                Rule::mission_member => body.members.extend(self.mission_member(part)),
                Rule::mission_repeat => body.repeats.extend(self.mission_repeat(part)),
                _ => open = true,
            }
        }
        if open {
            self.unclosed(span.range().start, span.range().end);
        } else {
            self.pool.before(span.range().end - 1, &mut body.settings.closing_comments.before);
        }
        body
    }

    /// Reads `robot m1 { .. }`, `task left_foot = pick_and_place { .. }`.
    fn mission_member(&mut self, pair: Pair<'_>) -> Option<MissionMember> {
        let start = self.of(&pair).range().start;
        let span = self.span(start, start + pair.as_str().trim_end().len());
        let mut comments = Comments::default();
        self.pool.before(start, &mut comments.before);
        let (mut role, mut name, mut mark, mut action, mut block, mut junk) = (None, None, None, None, None, None);
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::role => role = Some(self.place().spanned(&part)),
                Rule::name => name = Some(self.place().spanned(&part)),
                Rule::mark => mark = Some(self.of(&part)),
                Rule::member_action => action = Some(self.place().spanned(&part)),
                Rule::mission_body => block = Some(part),
                _ => junk = Some(self.of(&part)),
            }
        }
        let role = role?;
        // `task t { pick }`, `task t { pick { .. } }`, `task t { action pick }`: the action is inside the braces.
        let inside = role.value == "task" && mark.is_none() && action.is_none();
        let alone = block.as_ref().map(|block| block.as_str().trim_matches(['{', '}']).trim().to_owned());
        let alone = alone.filter(|word| inside && is_name(word));
        let mut body = Body::empty(self.span(span.range().end, span.range().end));
        let has_block = block.is_some();
        if let Some(block) = block.filter(|_| alone.is_none()) {
            body = self.mission_body(block, &role.value, &mut comments);
        } else if !has_block && role.value != "task" && junk.is_none() {
            self.diags.push(missions::no_block(&role.value, role.span));
        }
        let meant = alone.or_else(|| if inside { missions::meant_action(&mut body.settings) } else { None });
        let action = match (&name, meant) {
            (Some(name), Some(meant)) => {
                self.diags.push(missions::action_inside(name, &meant, body.settings.entries.is_empty()));
                None
            }
            (Some(name), None) => self.action_of(&role, name, mark, action),
            (None, _) => {
                self.diags.push(missions::no_name(&role.value, role.span));
                None
            }
        };
        if let Some(junk) = junk {
            self.unfit(junk, if role.value == "task" { "an action" } else { "a member of a mission" });
        }
        self.pool.before(span.range().end, &mut comments.before);
        self.pool.behind(span.range().end, &[',', ';'], &mut comments.behind);
        Some(body.member((role, name?), action, span, comments))
    }

    /// Reports text between a name and a block.
    fn unfit(&mut self, junk: Span, what: &str) {
        if !self.text[junk.range()].starts_with('(') {
            self.explain(junk, After::Start("a block in braces"), false);
            return;
        }
        self.unread.push(junk);
        let span = self.span(junk.range().start, junk.range().start + self.text[junk.range()].trim_end().len());
        let diagnostic = Diagnostic::error("HQ0128", span, format!("{what} takes nothing in parentheses"));
        self.diags.push(diagnostic.help("write what it needs in its braces"));
    }

    /// Returns the action after the `=` of a task; reports any other text between a name and its block.
    fn action_of(
        &mut self,
        role: &Spanned<String>,
        name: &Spanned<String>,
        mark: Option<Span>,
        action: Option<Spanned<String>>,
    ) -> Option<Spanned<String>> {
        if role.value != "task" {
            if let Some(mark) = mark {
                let sign = &self.text[mark.range()];
                let text = format!("unexpected `{sign}` after the name of a {}", role.value);
                let diagnostic = Diagnostic::error("HQ0104", mark, text);
                self.diags.push(
                    diagnostic.help("delete it; the block follows the name").fix(Fix::delete(mark, sign).certain()),
                );
            }
            return None;
        }
        match (&action, mark) {
            (Some(action), Some(mark)) if &self.text[mark.range()] == ":" => {
                let text = "expected `=` after the name of a task, found `:`";
                let help = format!("write `task {} = {}`", name.value, action.value);
                let fix = Fix::sign(name.span, mark, "=").certain();
                self.diags.push(Diagnostic::error("HQ0104", mark, text).help(help).fix(fix));
            }
            (None, _) => self.diags.push(missions::no_action(&name.value, name.span)),
            _ => {}
        }
        action
    }

    /// Reads `for i in 1..4 { human h${i} { .. } }`.
    fn mission_repeat(&mut self, pair: Pair<'_>) -> Option<MissionRepeat> {
        let start = self.of(&pair).range().start;
        let span = self.span(start, start + pair.as_str().trim_end().len());
        let mut comments = Comments::default();
        self.pool.before(start, &mut comments.before);
        let head = self.repeat_head(pair, self.span(start, start + "for".len()));
        let mut body = head.body.map_or_else(|| Body::empty(span), |part| self.parts(part, &mut comments));
        self.slips(&mut body, "mission");
        for entry in &body.settings.entries {
            self.diags.push(missions::not_repeated(&entry.key));
        }
        missions::distinct(&mut body.members, &mut self.diags);
        missions::in_order(&body.members, &body.repeats, &mut self.diags);
        self.pool.behind(span.range().end, &[',', ';'], &mut comments.behind);
        let (variable, values) = (head.variable?, head.values?);
        let Body { settings, members, repeats } = body;
        Some(MissionRepeat {
            variable,
            values,
            members,
            repeats,
            closing_comments: settings.closing_comments,
            span,
            comments,
        })
    }

    /// Converts and reports members that were parsed as settings: without a block, without the `=` of a task, or after
    /// a misspelt role.
    fn slips(&mut self, body: &mut Body, what: &str) {
        let mut entries = std::mem::take(&mut body.settings.entries).into_iter().peekable();
        while let Some(entry) = entries.next() {
            let key = entry.key.value.as_str();
            let role = ROLES.contains(&key);
            match &entry.value.kind {
                ValueKind::Name(name) if role && (what == "mission" || ["task", "layer"].contains(&key)) => {
                    let name = Spanned::new(name.clone(), entry.value.span);
                    let action = entries.next_if(|next| key == "task" && self.is_action(&name, next));
                    body.members.push(self.unmarked(entry.key, name, action, entry.comments));
                }
                _ => match missions::misspelt(&entry) {
                    Some((role, inner)) => {
                        let text = format!("`{key}` is not a role of a mission");
                        let diagnostic = Diagnostic::unknown_key("HQ0145", entry.key.span, text);
                        self.diags.push(diagnostic.meant(role));
                        let mut own = Body::empty(inner.value.span);
                        if let ValueKind::Block(block) = &inner.value.kind {
                            own.settings = block.clone();
                        }
                        let role = Spanned::new(role.to_owned(), entry.key.span);
                        let span = entry.key.span.to(entry.value.span);
                        body.members.push(own.member((role, inner.key.clone()), None, span, entry.comments));
                    }
                    _ => body.settings.entries.push(entry),
                },
            }
        }
    }

    /// Returns true for `pick_and_place { .. }` after `task left_foot` on the same line.
    fn is_action(&self, name: &Spanned<String>, next: &Entry) -> bool {
        let gap = self.text.get(name.span.range().end..next.key.span.range().start);
        matches!(next.value.kind, ValueKind::Block(_)) && gap.is_some_and(|gap| !gap.contains('\n'))
    }

    /// Converts `robot m1` without a block, `task left_foot pick_and_place { .. }` without its `=`.
    fn unmarked(
        &mut self,
        role: Spanned<String>,
        name: Spanned<String>,
        action: Option<Entry>,
        comments: Comments,
    ) -> MissionMember {
        let mut body = Body::empty(name.span);
        let mut span = role.span.to(name.span);
        let action = match action {
            Some(entry) => {
                let at = name.span.range().end;
                let text = format!("`=` is missing after `{}`", name.value);
                let help = format!("write `task {} = {}`", name.value, entry.key.value);
                let fix = Fix::insert("Write `=`", name.span, " =").certain();
                self.diags.push(Diagnostic::error("HQ0104", self.span(at, at), text).help(help).fix(fix));
                span = span.to(entry.value.span);
                if let ValueKind::Block(block) = entry.value.kind {
                    body.settings = block;
                }
                Some(entry.key)
            }
            None if role.value == "task" => {
                self.diags.push(missions::no_action(&name.value, name.span));
                None
            }
            None => {
                self.diags.push(missions::no_block(&role.value, role.span));
                None
            }
        };
        body.member((role, name), action, span, comments)
    }
}
