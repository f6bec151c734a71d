//! Indexes missions and their members.

use std::collections::BTreeMap;

use compiler::sections::{Holds, MISSION, Section};
use dsl::tree::{Block, Item, Mission, MissionMember, MissionRepeat, Value, ValueKind};
use dsl::{Span, Syntax};

use super::mentions::{Class, MARKER, Mention, Slot, Walker, What};
use super::walk::{used, word};

/// Context of the current part of a mission.
struct Around<'m> {
    /// Keys of the kind of mission, or of the enclosing member.
    section: Option<&'static Section>,
    /// Qualified names of members, by name.
    members: &'m BTreeMap<String, String>,
    /// Skills of the robots.
    skills: &'m [String],
}

/// Section of the block of a key.
fn inside(section: &'static Section, name: &str, syntax: Syntax) -> Option<&'static Section> {
    match section.key(name, syntax)?.holds {
        Holds::Block(section) => Some(section),
        _ => None,
    }
}

impl Walker<'_> {
    pub(super) fn declared_mission(&mut self, m: &Mission, item: &Item) {
        self.declare((Class::Mission, m.name.value.clone()), &m.name, item.span, &item.comments.before);
        self.found.missions.insert(m.name.value.clone(), m.kind.value.clone());
        self.declared_members(&m.name.value, &m.members, &m.repeats);
    }

    fn declared_members(&mut self, path: &str, members: &[MissionMember], repeats: &[MissionRepeat]) {
        for m in members {
            let own = format!("{path}.{}.{}", m.role.value, m.name.value);
            self.declare((Class::Member, own.clone()), &m.name, m.span, &m.comments.before);
            self.declared_runs(&own, m);
            self.declared_members(&own, &m.members, &m.repeats);
        }
        for r in repeats {
            self.declared_members(path, &r.members, &r.repeats);
        }
    }

    pub(super) fn mission(&mut self, m: &Mission) {
        if !self.marked(&m.kind.value, || Slot::Keys(&MISSION, Vec::new()))
            && let Some(key) = MISSION.key(&m.kind.value, self.syntax)
        {
            self.note(&m.kind.value, m.kind.span, What::Key(key));
        }
        let before = format!("{}.", m.name.value);
        let own = self.found.names(Class::Member).filter(|name| name.starts_with(&before));
        let own = own.filter_map(|name| Some((name.rsplit('.').next()?.to_string(), name.to_string())));
        let members: BTreeMap<String, String> = own.collect();
        let skills = m.members.iter().filter_map(|m| match &m.settings.get("skills")?.value.kind {
            ValueKind::Block(block) => Some(used(block)),
            _ => None,
        });
        let mut skills: Vec<String> = skills.flatten().filter(|skill| skill != MARKER).collect();
        skills.sort();
        skills.dedup();
        let section = inside(&MISSION, &m.kind.value, self.syntax);
        let around = Around { section, members: &members, skills: &skills };
        self.own_settings(&m.settings, &around);
        self.mission_members(&m.members, &m.repeats, &around);
    }

    fn mission_members(&mut self, members: &[MissionMember], repeats: &[MissionRepeat], around: &Around<'_>) {
        let mut title = None;
        for m in members {
            // In YAML, members share the key that contains them.
            if title.replace(m.role.span) != Some(m.role.span) {
                self.role(m, around);
            }
            if let Some(action) = &m.action {
                let skills = || around.skills.iter().map(|s| (s.clone(), "skill")).collect();
                self.marked(&action.value, || Slot::Offered(skills()));
            }
            let section = around.section.and_then(|s| inside(s, &m.role.value, Syntax::Native));
            let own = Around { section, ..*around };
            self.own_settings(&m.settings, &own);
            self.mission_members(&m.members, &m.repeats, &own);
        }
        for r in repeats {
            let outer = self.scope.len();
            self.repeated_over(&r.variable, &r.values);
            self.mission_members(&r.members, &r.repeats, around);
            self.scope.truncate(outer);
        }
    }

    /// Records the key of a role: `robot`, or `robots` in YAML.
    fn role(&mut self, m: &MissionMember, around: &Around<'_>) {
        let role = &m.role.value;
        let word = if self.syntax == Syntax::Yaml { format!("{role}s") } else { role.clone() };
        if let Some(key) = around.section.and_then(|s| s.key(&word, self.syntax)) {
            self.note(&word, m.role.span, What::Key(key));
        }
    }

    /// Indexes a position, or the name of a place.
    pub(super) fn spot(&mut self, value: &Value) {
        let of_place = |key: &str| {
            let (outer, name) = key.rsplit_once('.')?;
            outer.ends_with(".place").then(|| (name.to_string(), "place"))
        };
        let mut places: Vec<(String, &'static str)> = self.found.names(Class::Member).filter_map(of_place).collect();
        places.dedup();
        if !word(value).is_some_and(|name| self.marked(name, || Slot::Offered(places))) {
            self.expression(value);
        }
    }

    fn own_settings(&mut self, settings: &Block, around: &Around<'_>) {
        let from = self.found.all.len();
        match around.section {
            Some(section) => self.section(settings, section),
            None => settings.entries.iter().for_each(|e| self.anything(&e.value)),
        }
        for e in &settings.entries {
            self.named_members(&e.value, around, from);
        }
    }

    /// Indexes members that a value names, as names or as keys.
    fn named_members(&mut self, value: &Value, around: &Around<'_>, from: usize) {
        match &value.kind {
            ValueKind::Name(name) => self.named_member(name, value.span, around, from),
            ValueKind::List(items) => items.iter().for_each(|item| self.named_members(item, around, from)),
            ValueKind::Block(block) => {
                for e in &block.entries {
                    if e.key.value == MARKER && self.found.slot.is_none() {
                        let names = around.members.keys().map(|name| (name.clone(), Class::Member.word()));
                        self.found.slot = Some(Slot::Offered(names.collect()));
                    }
                    self.named_member(&e.key.value, e.key.span, around, from);
                    self.named_members(&e.value, around, from);
                }
            }
            _ => {}
        }
    }

    /// Records a member of the mission, unless the word has another known meaning. Words of the same settings were
    /// recorded from index `from` on.
    fn named_member(&mut self, name: &str, span: Span, around: &Around<'_>, from: usize) {
        let Some(key) = around.members.get(name) else { return };
        let what = What::Declared(Class::Member, key.clone());
        let (place, exact) = self.place(name, span);
        let declared = |what: &What| match what {
            What::Declared(class, name) => self.has(*class, name),
            _ => true,
        };
        match self.found.all.iter().skip(from).position(|m| m.place == place) {
            Some(at) if declared(&self.found.all[from + at].what) => {}
            Some(at) => self.found.all[from + at].what = what,
            None => self.found.all.push(Mention { place, exact, declares: false, what }),
        }
    }
}
