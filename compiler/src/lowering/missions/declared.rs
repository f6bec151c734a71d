//! A mission bound by the schema of its kind: settings, and members by their roles.

use std::collections::BTreeMap;

use blocks::{Block, BlockSchema, BoundBlock, Located, Role};
use dsl::Diagnostic;
use dsl::tree::{Mission, MissionMember};
use mission::declare::common::PlaceBlock;
use mission::declare::{DeclaredMember, DeclaredMission};
use names::list;

use super::super::Lowerer;
use super::super::declared::twice;
use crate::block_binding::{PLACE, Scope};

/// A member whose role is known.
#[derive(Clone, Copy)]
struct Known<'m> {
    member: &'m MissionMember,
    role: Role,
}

impl Lowerer<'_> {
    /// Binds a mission. Members that are wrong as a whole are left out.
    pub(super) fn declared_mission(&mut self, m: &Mission, schema: &'static BlockSchema) -> DeclaredMission {
        let before = self.errors();
        let known = self.known_members(&m.members, schema);
        let incomplete = known.len() < m.members.len() || self.errors() > before;
        let mut scope = Scope { mission: m.name.value.clone(), ..Scope::default() };
        for Known { member, role } in &known {
            scope.members.entry(role.name).or_default().push(member.name.value.clone());
        }
        // Places come first, because other members name them.
        let places = known.iter().map(|known| (known.role.name == PLACE).then(|| self.settings(known, &scope)));
        let places: Vec<Option<BoundBlock>> = places.collect();
        for (Known { member, .. }, place) in known.iter().zip(&places) {
            let at = place.as_ref().map(|place| PlaceBlock::read(place).at);
            scope.places.extend(at.map(|at| (member.name.value.clone(), at)));
        }
        let settings = self.block_binder(&scope).block(&m.settings, schema, m.name.span);
        let mut members = Vec::new();
        for (known, place) in known.iter().zip(places) {
            let settings = place.unwrap_or_else(|| self.settings(known, &scope));
            members.push(self.declared_member(known, settings, &scope));
        }
        DeclaredMission { name: m.name.value.clone(), at: settings.at, settings, members, incomplete }
    }

    fn settings(&mut self, known: &Known, scope: &Scope) -> BoundBlock {
        let Known { member, role } = known;
        self.block_binder(scope).block(&member.settings, role.schema, member.name.span)
    }

    fn declared_member(&mut self, known: &Known, settings: BoundBlock, scope: &Scope) -> DeclaredMember {
        let Known { member, role } = known;
        let mut members = Vec::new();
        for inner in self.inner_members(member, role.schema) {
            let settings = self.settings(&inner, scope);
            members.push(self.declared_member(&inner, settings, scope));
        }
        let action = member.action.as_ref();
        DeclaredMember {
            role: role.name,
            name: member.name.value.clone(),
            at: settings.at,
            action: action.map(|a| Located { at: self.origins.add(a.span), value: a.value.clone() }),
            settings,
            members,
        }
    }

    /// Members of known roles with distinct names. A role that holds members is a namespace of its own.
    fn known_members<'m>(&mut self, members: &'m [MissionMember], schema: &'static BlockSchema) -> Vec<Known<'m>> {
        let mut names: BTreeMap<&str, Known> = BTreeMap::new();
        let mut distinct = Vec::new();
        for member in members {
            let Some(known) = self.known(member, schema) else { continue };
            let apart = |known: &Known| known.role.schema.roles().next().is_some();
            match names.get(member.name.value.as_str()) {
                // Two of one role were reported when repetitions were unrolled.
                Some(first) if first.role.name == known.role.name => continue,
                Some(first) if !apart(&known) && !apart(first) => {
                    self.push(twice(&member.name, first.member.name.span));
                }
                Some(_) => {}
                None => drop(names.insert(&member.name.value, known)),
            }
            distinct.push(known);
        }
        distinct
    }

    /// Members inside a member.
    fn inner_members<'m>(&mut self, member: &'m MissionMember, schema: &'static BlockSchema) -> Vec<Known<'m>> {
        if schema.roles().next().is_some() {
            return member.members.iter().filter_map(|inner| self.known(inner, schema)).collect();
        }
        for inner in &member.members {
            let text = format!("{} holds nothing of its own", schema.name);
            let d = Diagnostic::unknown_key("HQ0205", inner.role.span, text);
            self.push(d.help("write it beside the others, or leave it out"));
        }
        Vec::new()
    }

    /// The role of a member; reports one that the block around it does not have.
    fn known<'m>(&mut self, member: &'m MissionMember, schema: &'static BlockSchema) -> Option<Known<'m>> {
        let word = member.role.value.as_str();
        let found = schema.roles().find(|role| role.name == word);
        if found.is_none() {
            let d = Diagnostic::unknown_key("HQ0205", member.role.span, format!("{} has no `{word}`", schema.name));
            self.push(d.help(format!("members of it are {}", list(schema.roles().map(|role| role.name), 8))));
        }
        found.map(|role| Known { member, role })
    }
}
