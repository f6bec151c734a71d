//! References in blocks with known keys: the tables say which keys and values are names.

use std::sync::LazyLock;

use dsl::tree::{Block, Entry, Value, ValueKind};
use dsl::vocabulary::ROLES;
use dsl::{Span, Spanned};
use mission::kind::{EventInfo, Kind};
use mission::kinds::{KINDS, find};

use super::context::used;
use super::missions::is_of_controller;
use super::symbols::SymbolKind as K;
use super::{CompletionContext as C, Meaning, Resolver};
use crate::expand::Class;
use crate::sections::{
    BlockSchema, EVENT, InSyntax, Named, OF_ALL_SCENARIOS, OF_MISSIONS, SCENARIO, ValueType, WAYPOINT,
};

/// Roles of members that something is measured of, in some kind of mission.
pub(super) static MEASURED: LazyLock<Vec<&'static str>> =
    LazyLock::new(|| ROLES.iter().copied().filter(|role| KINDS.iter().any(|kind| is_measured(kind, role))).collect());

/// Those of them that an event of each kind can be of.
static ACTING: LazyLock<Vec<(&'static str, Vec<&'static str>)>> = LazyLock::new(|| {
    let acts = |kind: &&Kind, role: &str| {
        let can = |event: &EventInfo| event.not_of.iter().all(|not| not.role != role);
        is_measured(kind, role) && kind.events.iter().any(can)
    };
    let of = |kind: &&Kind| MEASURED.iter().copied().filter(|role| acts(kind, role)).collect();
    KINDS.iter().map(|kind| (kind.name, of(kind))).collect()
});

/// Roles of members that an event of a mission of this kind can be of; of an unknown kind, those of all kinds.
pub(super) fn acting(kind: Option<&Kind>) -> &'static [&'static str] {
    let known = kind.and_then(|kind| ACTING.iter().find(|(name, _)| *name == kind.name));
    known.map_or(&MEASURED, |(_, roles)| roles)
}

fn is_measured(kind: &Kind, role: &str) -> bool {
    (kind.measures)().iter().any(|measure| measure.is_of(Some(role)))
}

impl Resolver<'_> {
    /// Resolves a block with known keys.
    pub(super) fn section(&mut self, block: &Block, section: &'static BlockSchema) {
        for e in &block.entries {
            if self.is_cursor(&e.key.value, |r| C::Keys(section, r.without(block, section))) {
                continue;
            }
            if let Some(key) = section.key(&e.key.value, self.syntax) {
                self.note(&e.key.value, e.key.span, Meaning::Key(key));
                self.held(&key.value, &e.value);
            }
        }
    }

    /// Keys that are not offered in a block: those present, and those that have no meaning in this kind of scenario.
    fn without(&self, block: &Block, section: &'static BlockSchema) -> Vec<String> {
        let mut keys = used(block);
        if std::ptr::eq(section, &SCENARIO) && block.get("mission").is_some() {
            let own = |key: &&str| !OF_ALL_SCENARIOS.contains(key) && !OF_MISSIONS.contains(key);
            keys.extend(SCENARIO.entries().filter(own).map(str::to_string));
        }
        if let Some(kind) = self.around.mission.and_then(|m| find(&self.out.symbol(m).ty)) {
            let absent = kind.absent.iter().map(|absent| absent.0);
            let theirs: Vec<&str> = match () {
                () if std::ptr::eq(section, &SCENARIO) => absent.collect(),
                () if std::ptr::eq(section, &EVENT) => {
                    EVENT.entries().filter(|key| KINDS.iter().any(|k| k.has(key)) && !kind.has(key)).collect()
                }
                () => Vec::new(),
            };
            keys.extend(theirs.into_iter().map(str::to_string));
        }
        keys
    }

    /// Resolves the value of a key.
    fn held(&mut self, holds: &'static ValueType, value: &Value) {
        match holds {
            ValueType::Number(_)
            | ValueType::Count(_)
            | ValueType::Vector(_)
            | ValueType::Pair(_)
            | ValueType::Spread(_)
            | ValueType::OfJoint { .. }
            | ValueType::Bound
            | ValueType::Value
            | ValueType::People => self.expression(value),
            ValueType::Function(of) => {
                self.with(super::Around { arguments: of.arguments, ..self.around.clone() }, |r| r.expression(value));
            }
            ValueType::Numbers(_) | ValueType::Range(_) => value.items().iter().for_each(|v| self.expression(v)),
            ValueType::Sent => self.anything(value),
            ValueType::Spot => self.place_name(value),
            ValueType::List(ValueType::Spot) => value.items().iter().for_each(|v| self.place_name(v)),
            ValueType::Text | ValueType::File | ValueType::FileWith(_) | ValueType::Binary(_) | ValueType::NewName => {
                self.offer(value, |_| C::Nothing)
            }
            ValueType::Urdf => self.described_path(value, false),
            ValueType::Srdf => self.described_path(value, true),
            ValueType::Spec => self.spec_path(value),
            ValueType::Flag => self.offer(value, |_| C::Words(&["true", "false"])),
            ValueType::Choice(words) => self.offer(value, |_| C::Words(words)),
            ValueType::Name(named) => self.named(*named, value),
            ValueType::Link => self.frame(value, &[K::Link]),
            ValueType::Geometries => self.geometries(value, C::Geometry { arms: false, people: false }),
            ValueType::Links => self.links(value),
            ValueType::WordOr(words) | ValueType::NumberOr(_, words) => match &value.kind {
                ValueKind::Name(name)
                    if self.is_cursor(name, |_| C::Words(words)) || words.contains(&name.as_str()) => {}
                _ => self.expression(value),
            },
            ValueType::Joints => self.joints(value),
            ValueType::Positions => {
                if value.block().is_some() || !self.cursor_in(value, |_| C::Symbols(&[K::Posture])) {
                    self.positions(value, |r, v| r.expression(v));
                }
            }
            ValueType::Locks if value.block().is_none() => self.joints(value),
            ValueType::Locks => self.joint_block(value, |r, v| r.expression(v)),
            ValueType::Block(section) | ValueType::LinkOr(section) | ValueType::Blocks(section) => {
                for item in value.items() {
                    match (item.block(), holds) {
                        (Some(block), _) if is_of_controller(section) => self.runs(block, section),
                        (Some(block), _) => self.section(block, section),
                        (None, ValueType::LinkOr(_)) => self.frame(item, &[K::Link]),
                        (None, _) => self.offer(item, |_| C::Nothing),
                    }
                }
            }
            ValueType::List(ValueType::Block(section)) if std::ptr::eq(*section, &WAYPOINT) => {
                const PATH: &ValueType = &ValueType::Blocks(&WAYPOINT);
                self.held(PATH, value);
            }
            ValueType::List(ValueType::Pair(_)) => self.expression(value),
            ValueType::List(inner @ (ValueType::NewName | ValueType::List(_) | ValueType::Name(_))) => {
                value.items().iter().for_each(|item| self.held(inner, item));
            }
            ValueType::Each(inner) => value.entries().iter().for_each(|e| self.held(inner, &e.value)),
            ValueType::Of(named, inner) => self.of_names(*named, inner, value),
            ValueType::PerJoint(inner) => self.joint_block(value, |r, v| r.held(inner, v)),
            // The parser stores these in other parts of the tree.
            ValueType::Values | ValueType::List(_) | ValueType::Tasks | ValueType::Declarations => {}
        }
    }

    /// Resolves a block whose keys are names.
    fn of_names(&mut self, named: Named, inner: &'static ValueType, value: &Value) {
        for Entry { key, value, .. } in value.entries() {
            self.name(named, &key.value, key.span);
            if named == Named::Human {
                let human = self.declared(Class::Value, &key.value);
                self.with(super::Around { human, ..self.around.clone() }, |r| r.held(inner, value));
            } else {
                self.held(inner, value);
            }
        }
    }

    fn named(&mut self, named: Named, value: &Value) {
        match named {
            Named::StateThere => self.state_there(value),
            Named::StatePath => self.state_of_machine(value),
            _ => {
                if let Some(name) = value.word() {
                    self.name(named, name, value.span);
                }
            }
        }
    }

    /// Resolves a name.
    fn name(&mut self, named: Named, name: &str, span: Span) {
        let declared = |r: &mut Self, class, kind, offered| r.spanned_name(name, span, class, kind, offered);
        match named {
            Named::Robot => declared(self, Class::Robot, K::Robot, &[K::Robot]),
            Named::Task => declared(self, Class::Task, K::Task, &[K::Task]),
            Named::Stack => declared(self, Class::Stack, K::Stack, &[K::Stack]),
            Named::Machine => declared(self, Class::Machine, K::Machine, &[K::Machine]),
            Named::Mission => declared(self, Class::Mission, K::Mission, &[K::Mission]),
            Named::Signal => declared(self, Class::Value, K::Signal, &[K::Signal, K::Variable]),
            Named::Flag => declared(self, Class::Value, K::Signal, &[K::Signal]),
            Named::Human => declared(self, Class::Value, K::Human, &[K::Human]),
            Named::Obstacle => declared(self, Class::Value, K::Obstacle, &[K::Obstacle]),
            Named::Event => self.event_name(name, span, false),
            Named::Point => self.human_point(&Spanned::new(name.to_string(), span)),
            Named::State => self.initial_state(name, span),
            Named::Member => self.member(name, span, self.around.roles),
            Named::Own(members) => self.member(name, span, members.roles),
            Named::Person => self.member(name, span, &["human"]),
            Named::SignalThere(ty) => self.signal_there(name, span, ty),
            Named::HumanThere => self.human_there(name, span),
            // The parser stores levels in other parts of the tree; a state of another spec is a path.
            Named::Level | Named::StateThere | Named::StatePath => {}
        }
    }
}
