//! Reader of missions in YAML: the kind below the name, and its settings and members below the kind.

use super::Reader;
use super::events::{Kind, NodeId};
use crate::calls;
use crate::diagnostic::clip;
use crate::missions::{self, Body};
use crate::tree::{Comments, Mission, MissionMember, MissionRepeat};
use crate::vocabulary::{MEMBER_KEYS, ROLES, TASK_SETTINGS};
use crate::words::{is_name, nearest};
use crate::{Diagnostic, Spanned};

impl Reader<'_> {
    /// Reads `schedule: { confidence: 0.9, robots: { .. } }`.
    pub(super) fn mission(&mut self, name: &Spanned<String>, id: NodeId, comments: &mut Comments) -> Mission {
        let (kind, body) = self.kind(name, id, comments);
        let Body { settings, members, repeats } = body;
        Mission { name: name.clone(), kind, settings, members, repeats }
    }

    fn kind(&mut self, name: &Spanned<String>, id: NodeId, comments: &mut Comments) -> (Spanned<String>, Body) {
        let none = (calls::nameless(name.span), Body::empty(self.span(id)));
        if !matches!(self.node(id).kind, Kind::Mapping(_)) {
            let help =
                format!("write `{}: {{ schedule: {{ .. }} }}`, with the kind above its parts", clip(&name.value));
            if self.is_null(id) {
                let text = format!("the mission `{}` is empty", clip(&name.value));
                self.diags.push(Diagnostic::incomplete("HQ0117", name.span, text).help(help));
            } else {
                self.wrong_shape(id, "a mapping with the kind of the mission", &help);
            }
            return none;
        }
        if !self.enter(id) {
            return none;
        }
        let pairs = self.distinct(id);
        let Some(kind) = self.kind_among(&pairs) else {
            self.diags.push(missions::no_kind(&name.value, name.span));
            return (none.0, self.mission_body(pairs, id, "mission"));
        };
        let mut others = pairs;
        let (key, value) = others.remove(kind);
        if let (true, Some((first, _))) = (self.is_null(value), others.first()) {
            self.too_far_left(&key, first.span);
            return (key, self.mission_body(others, id, "mission"));
        }
        self.one_kind(&key, &others);
        self.pool.before(key.span.range().start, &mut comments.before);
        self.pool.behind(key.span.range().end, &[':', '{'], &mut comments.behind);
        self.depth += 1;
        let body = self.body_of(value, &key, "mission");
        self.depth -= 1;
        (key, body)
    }

    /// Returns the index of the entry below the name of a mission that is its kind: the first one that holds members, or
    /// else the first entry. A part such as `layers`, which is also a kind, is one only if it is the only entry or holds
    /// members.
    fn kind_among(&self, pairs: &[(Spanned<String>, NodeId)]) -> Option<usize> {
        let holds_parts =
            |value: NodeId| self.is_null(value) || matches!(self.node(value).kind, Kind::Mapping(_) | Kind::Broken);
        let first = pairs.first().filter(|(key, value)| {
            holds_parts(*value) && (pairs.len() == 1 || !MEMBER_KEYS.contains(&key.value.as_str()))
        });
        let holds_members = |(_, value): &(Spanned<String>, NodeId)| match &self.node(*value).kind {
            Kind::Mapping(below) => {
                below.iter().any(|(key, _)| self.scalar(*key).is_some_and(|key| MEMBER_KEYS.contains(&key.0)))
            }
            _ => false,
        };
        pairs.iter().position(holds_members).or(first.map(|_| 0))
    }

    /// Reports keys beside the kind of a mission, or beside the action of a task.
    fn one_kind(&mut self, kind: &Spanned<String>, others: &[(Spanned<String>, NodeId)]) {
        let Some((second, _)) = others.first() else { return };
        self.unread.extend(others.iter().map(|(key, _)| key.span));
        self.diags.push(
            Diagnostic::error(
                "HQ0131",
                second.span,
                format!("`{}` is not below `{}`", clip(&second.value), kind.value),
            )
            .label(kind.span, "everything else must be below this")
            .help(match second.span.start < kind.span.start {
                true => format!("move it below `{}:`, and indent it", clip(&kind.value)),
                false => format!("indent it below `{}:`", clip(&kind.value)),
            }),
        );
    }

    /// Reads the mapping of a mission or a member; `what` is `mission` or the role.
    fn body_of(&mut self, id: NodeId, owner: &Spanned<String>, what: &str) -> Body {
        let span = self.span(id);
        if !matches!(self.node(id).kind, Kind::Mapping(_)) {
            let help = "write its keys below it, indented, as `key: value`; or `{}` if there are none";
            if self.is_null(id) {
                let text = format!("`{}` says nothing", clip(&owner.value));
                self.diags.push(Diagnostic::incomplete("HQ0117", owner.span, text).help(help));
            } else {
                self.wrong_shape(id, &format!("a mapping with the parts of the {what}"), help);
            }
            return Body::empty(span);
        }
        if !self.enter(id) {
            return Body::empty(span);
        }
        let pairs = self.distinct(id);
        self.mission_body(pairs, id, what)
    }

    /// Reads the entries of the mapping `id` as settings, members and repetitions.
    fn mission_body(&mut self, pairs: Vec<(Spanned<String>, NodeId)>, id: NodeId, what: &str) -> Body {
        let mut body = Body::empty(self.span(id));
        self.depth += 1;
        for (key, value) in pairs {
            // A list below the plural of a role is a setting of a member that holds no members, as `targets: [a]` of a source.
            let is_list = matches!(self.node(value).kind, Kind::Sequence(_)) && !missions::holds_members(what);
            let role = missions::role_below(&key.value).filter(|_| !is_list);
            if let Some(role) = role.or_else(|| self.meant_role(&key, value)) {
                self.members_of(role, &key, value, &mut body.members);
            } else if key.value == "for" {
                self.mission_repeats(value, &mut body.repeats);
            } else {
                let entry = self.setting(key, value);
                body.settings.entries.push(entry);
            }
        }
        self.depth -= 1;
        self.closing(id, &mut body.settings.closing_comments);
        let owner = if what == "mission" { what.to_owned() } else { missions::owner(what) };
        missions::settings(&mut body.settings, &owner, &mut self.diags);
        body
    }

    /// Returns the role that a misspelt key such as `robot:` or `robts:` stands for, if it has a mapping of mappings
    /// below it; reports the error.
    fn meant_role(&mut self, key: &Spanned<String>, value: NodeId) -> Option<&'static str> {
        let Kind::Mapping(below) = &self.node(value).kind else { return None };
        let members = below.iter().all(|(_, value)| matches!(self.node(*value).kind, Kind::Mapping(_)));
        let same = ROLES.iter().find(|role| **role == key.value).copied();
        let near = || nearest(&key.value, MEMBER_KEYS).and_then(missions::role_below).filter(|_| !below.is_empty());
        let role = same.or_else(|| near().filter(|_| members))?;
        let text = format!("`{}` has no members", clip(&key.value));
        self.diags.push(Diagnostic::unknown_key("HQ0132", key.span, text).meant(format!("{role}s")));
        Some(role)
    }

    /// Reads `robots: { m1: { .. }, m2: { .. } }`.
    fn members_of(&mut self, role: &str, title: &Spanned<String>, id: NodeId, out: &mut Vec<MissionMember>) {
        if self.is_null(id) || !self.enter(id) {
            return;
        }
        if !matches!(self.node(id).kind, Kind::Mapping(_)) {
            let help = format!("write `NAME: {{ .. }}` lines below `{}:`", clip(&title.value));
            return self.wrong_shape(id, "a mapping of names", &help);
        }
        self.depth += 1;
        for (name, value) in self.distinct(id) {
            let mut comments = self.key_comments(name.span);
            let later = self.later(value, name.span);
            let span = name.span.to(later);
            let role = Spanned::new(role.to_owned(), title.span);
            let (action, body) = match role.value.as_str() {
                "task" => self.task_of(&name, value, &mut comments),
                what => (None, self.body_of(value, &name, what)),
            };
            self.pool.behind(later.range().end, &[','], &mut comments.behind);
            out.push(body.member((role, name), action, span, comments));
        }
        self.depth -= 1;
    }

    /// Reads `wait`, or `{ pick_and_place: { .. } }`: the action and its body.
    fn task_of(
        &mut self,
        name: &Spanned<String>,
        id: NodeId,
        comments: &mut Comments,
    ) -> (Option<Spanned<String>>, Body) {
        let none = Body::empty(self.span(id));
        if self.is_null(id) {
            self.diags.push(missions::no_action(&name.value, name.span));
            return (None, none);
        }
        if self.scalar(id).is_some() {
            return (self.name(id, "an action"), none);
        }
        if !matches!(self.node(id).kind, Kind::Mapping(_)) {
            self.wrong_shape(id, "a task", "write `ACTION`, or `ACTION: { .. }`");
            return (None, none);
        }
        if !self.enter(id) {
            return (None, none);
        }
        let pairs = self.distinct(id);
        let Some(((key, value), others)) = pairs.split_first().map(|(first, rest)| (first.clone(), rest)) else {
            self.diags.push(missions::no_action(&name.value, name.span));
            return (None, none);
        };
        if TASK_SETTINGS.contains(&key.value.as_str()) {
            self.diags.push(missions::no_action(&name.value, name.span));
            return (None, self.mission_body(pairs, id, "task"));
        }
        if missions::says_action(&key.value) && self.scalar(value).is_some_and(|(word, _)| is_name(word)) {
            let word = self.scalar(value).map_or_else(String::new, |scalar| scalar.0.to_owned());
            let fix = match others.is_empty() {
                true => format!("{}: {word}", name.value),
                false => format!("{}: {{ {word}: {{ .. }} }}", name.value),
            };
            self.diags.push(missions::keyed_action(&key, &fix));
            return (None, self.mission_body(others.to_vec(), id, "task"));
        }
        self.one_kind(&key, others);
        self.pool.before(key.span.range().start, &mut comments.before);
        self.pool.behind(key.span.range().end, &[':', '{'], &mut comments.behind);
        self.depth += 1;
        let body = self.body_of(value, &key, "task");
        self.depth -= 1;
        (Some(key), body)
    }

    /// Reads `for`: a sequence of `{ name: i, in: 1..4, humans: { .. } }`.
    fn mission_repeats(&mut self, id: NodeId, out: &mut Vec<MissionRepeat>) {
        if self.is_null(id) {
            return;
        }
        let Kind::Sequence(all) = &self.node(id).kind else {
            let help = "write `- { name: i, in: 1..4, humans: { .. } }`";
            return self.wrong_shape(id, "a sequence of repetitions", help);
        };
        for id in all.clone() {
            if self.depth >= crate::limits::MAX_DEPTH || !self.enter(id) {
                return;
            }
            let span = self.span(id);
            let (mut comments, mut closing_comments) = (Comments::default(), Comments::default());
            self.pool.before(span.range().start, &mut comments.before);
            let (mut members, mut repeats) = (Vec::new(), Vec::new());
            self.depth += 1;
            let head = self.repeat_head(id, MEMBER_KEYS, &mut comments, &mut |reader, key, value, _| {
                if key.value == "for" {
                    reader.mission_repeats(value, &mut repeats);
                } else if let Some(role) = missions::role_below(&key.value) {
                    reader.members_of(role, key, value, &mut members);
                } else {
                    return false;
                }
                true
            });
            self.depth -= 1;
            self.closing(id, &mut closing_comments);
            self.pool.behind(span.range().end, &[','], &mut comments.behind);
            if let Some((variable, values)) = head {
                out.push(MissionRepeat { variable, values, members, repeats, closing_comments, span, comments });
            }
        }
    }
}
