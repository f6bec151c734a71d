//! Indexes scenarios of missions: the members that they name, and their measured quantities.

use compiler::sections::{HAPPENING, OF_ALL_SCENARIOS, OF_MISSIONS, REPLY, SCENARIO, Section};
use dsl::Spanned;
use dsl::tree::{Block, Value, ValueKind};
use mission::kind::Kind;
use mission::kinds::{KINDS, find};

use super::mentions::{Class, MARKER, Slot, Walker, What};
use super::walk::{entries, items, used, word};

impl Walker<'_> {
    /// Keys that are not offered in a block: those present; in a scenario of a mission also those for controllers; in
    /// one of layers also those of schedules.
    pub(super) fn without(&self, block: &Block, section: &'static Section) -> Vec<String> {
        let mut keys = used(block);
        if std::ptr::eq(section, &SCENARIO) && block.get("mission").is_some() {
            let own = |key: &&str| !OF_ALL_SCENARIOS.contains(key) && !OF_MISSIONS.contains(key);
            keys.extend(SCENARIO.entries().filter(own).map(str::to_string));
        }
        if let Some(kind) = self.mission.as_ref().and_then(|mission| self.kind_of(mission)) {
            let absent = kind.absent.iter().map(|absent| absent.0);
            let theirs: Vec<&str> = match () {
                () if std::ptr::eq(section, &SCENARIO) => absent.collect(),
                () if std::ptr::eq(section, &HAPPENING) => {
                    HAPPENING.entries().filter(|key| KINDS.iter().any(|k| k.has(key)) && !kind.has(key)).collect()
                }
                () => Vec::new(),
            };
            keys.extend(theirs.into_iter().map(str::to_string));
        }
        keys
    }

    /// The kind of a mission.
    fn kind_of(&self, mission: &str) -> Option<&'static Kind> {
        find(self.found.missions.get(mission)?)
    }

    /// Indexes the mission of a scenario.
    pub(super) fn mission_name(&mut self, value: &Value) {
        let Some(name) = word(value) else { return };
        let names = || self.found.names(Class::Mission).map(|n| (n.to_string(), Class::Mission.word())).collect();
        if name == MARKER {
            self.found.slot = Some(Slot::Offered(names()));
            return;
        }
        self.note(name, value.span, What::Declared(Class::Mission, name.to_string()));
    }

    /// Members of the current mission with one of these roles: qualified name, role, and name.
    fn members(&self, roles: &[&'static str]) -> Vec<(String, &'static str, String)> {
        let Some(mission) = &self.mission else { return Vec::new() };
        let of = |key: &str| {
            let (role, name) = key.strip_prefix(mission.as_str())?.strip_prefix('.')?.split_once('.')?;
            let role = roles.iter().find(|r| **r == role)?;
            Some((key.to_string(), *role, name.to_string()))
        };
        self.found.names(Class::Member).filter_map(of).collect()
    }

    /// Indexes the name of a member with one of these roles.
    pub(super) fn member_name(&mut self, value: &Value, roles: &[&'static str]) {
        if let Some(name) = word(value) {
            self.member_of_mission(&Spanned::new(name.to_string(), value.span), roles);
        }
    }

    fn member_of_mission(&mut self, name: &Spanned<String>, roles: &[&'static str]) {
        let members = self.members(roles);
        if let Some((key, ..)) = members.iter().find(|m| m.2 == name.value) {
            self.note(&name.value, name.span, What::Declared(Class::Member, key.clone()));
        }
        self.marked(&name.value, || Slot::Offered(members.into_iter().map(|(_, role, name)| (name, role)).collect()));
    }

    /// Indexes the feedback of people in a scenario of a mission.
    pub(super) fn replies(&mut self, value: &Value) {
        for e in entries(value) {
            self.member_of_mission(&e.key, &["human"]);
            for item in items(&e.value) {
                if let ValueKind::Block(block) = &item.kind {
                    self.section(block, &REPLY);
                }
            }
        }
    }

    /// Indexes `h1.waited` and `vineyard.makespan`; returns false for other values.
    pub(super) fn member_field(&mut self, inner: &Value, field: &Spanned<String>) -> bool {
        let (Some(mission), ValueKind::Name(name)) = (self.mission.clone(), &inner.kind) else { return false };
        if !self.expected {
            return false;
        }
        let found = self.members(&["robot", "human", "worker"]).into_iter().find(|m| m.2 == *name);
        let (role, what) = match found {
            Some((key, role, _)) => (Some(role), What::Declared(Class::Member, key)),
            None if *name == mission => (None, What::Declared(Class::Mission, mission.clone())),
            None => return false,
        };
        self.note(name, inner.span, what);
        let measures = self.kind_of(&mission).map(|kind| (kind.measures)()).unwrap_or_default();
        let names = || measures.iter().filter(|m| m.is_of(role)).map(|m| (m.name.to_string(), "measured")).collect();
        self.marked(&field.value, || Slot::Offered(names()));
        true
    }

    /// Completion context at the start of an expectation of a mission.
    pub(super) fn of_mission(&self, mission: &str) -> Slot {
        let members = self.members(&["robot", "human", "worker"]).into_iter().map(|(_, role, name)| (name, role));
        let own = [(mission.to_string(), Class::Mission.word()), ("done".to_string(), "measured")];
        let words = ["distance", "norm", "time", "in"].map(|w| (w.to_string(), "built in"));
        Slot::Offered(members.chain(own).chain(words).collect())
    }
}
