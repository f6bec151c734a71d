//! Missions, their members, and members that are repeated.

use super::expressions::*;
use super::stacks::values;
use hierarq_dsl::Span;
use hierarq_dsl::tree::*;
use hierarq_dsl::vocabulary::ROLES;
use proptest::prelude::*;
use std::collections::BTreeSet;

/// Settings whose keys mean nothing else in a mission.
fn own() -> BoxedStrategy<Block> {
    settings(&["for", "robots", "humans", "workers", "objects", "places", "layers", "tasks"], any_value(), true)
        .prop_map(|mut block| {
            block.entries.retain(|e| !ROLES.contains(&e.key.as_str()));
            block
        })
        .boxed()
}

/// Without what has the role and name of an earlier one.
fn unique(mut members: Vec<MissionMember>) -> Vec<MissionMember> {
    let mut seen = BTreeSet::new();
    members.retain(|m| seen.insert((m.role.value.clone(), m.name.value.clone())));
    members
}

type Inner = BoxedStrategy<(Vec<MissionMember>, Vec<MissionRepeat>)>;

fn member(inner: Inner) -> impl Strategy<Value = MissionMember> {
    (prop::sample::select(ROLES), name(), name(), own(), inner, comments()).prop_map(
        |(role, name, action, settings, (members, repeats), comments)| MissionMember {
            action: (*role == *"task").then(|| spanned(action)),
            role: spanned(role.to_owned()),
            name: spanned(name),
            settings,
            members,
            repeats,
            span: Span::default(),
            comments,
        },
    )
}

fn repeat(inner: Inner) -> impl Strategy<Value = MissionRepeat> {
    (name(), values(), inner, before(), comments()).prop_map(
        |(variable, values, (members, repeats), closing_comments, comments)| MissionRepeat {
            variable: spanned(variable),
            values,
            members,
            repeats,
            closing_comments,
            span: Span::default(),
            comments,
        },
    )
}

fn parts() -> Inner {
    let none = Just((Vec::new(), Vec::new())).boxed();
    none.prop_recursive(3, 12, 3, |inner| {
        let members = prop::collection::vec(member(inner.clone()), 0..4).prop_map(unique);
        (members, prop::collection::vec(repeat(inner), 0..2)).boxed()
    })
    .boxed()
}

pub(super) fn mission() -> BoxedStrategy<Mission> {
    (name(), name(), own(), parts())
        .prop_map(|(name, kind, settings, (members, repeats))| Mission {
            name: spanned(name),
            kind: spanned(kind),
            settings,
            members,
            repeats,
        })
        .boxed()
}
