//! Schema of missions, from the sections of their kinds: members by name below the plurals of their roles, and
//! repetitions.

use compiler::sections::{ALL, BlockSchema, InSyntax, Key, MISSION, REPEAT, ValueType};
use dsl::Syntax;
use dsl::vocabulary::ROLES;
use serde_json::{Map, Value, json};
use stdlib_tasks::params::Presence;

use super::{described, object, section, sections as of};

/// Missions by name, each with its kind as the only key.
pub(super) fn missions() -> Value {
    let mut mission = object(bodies(&MISSION), &[], "A mission: its kind, and everything else below that.");
    mission["minProperties"] = json!(1);
    mission["maxProperties"] = json!(1);
    section("", &mission)
}

/// Shared definitions: repetitions in each section with members.
pub(super) fn definitions() -> Map<String, Value> {
    let with_members = ALL.iter().filter(|section| members(section).next().is_some());
    with_members.map(|section| (repeats_name(section), repeats(section))).collect()
}

/// Role of the members below a key.
fn role_below(key: &Key) -> Option<&'static str> {
    ROLES.iter().find(|role| key.name.strip_suffix('s') == Some(role)).copied()
}

/// Keys of a section that contain members, each with the role and the member's section.
fn members(section: &BlockSchema) -> impl Iterator<Item = (&'static Key, &'static str, &'static BlockSchema)> {
    section.written(Syntax::Yaml).filter_map(|key| match key.value {
        ValueType::Each(ValueType::Block(inner)) => Some((key, role_below(key)?, *inner)),
        _ => None,
    })
}

/// Contents of each kind of mission.
fn bodies(kinds: &BlockSchema) -> Map<String, Value> {
    let one = |key: &'static Key| match key.value {
        ValueType::Block(section) => Some((key.name.to_string(), described(body(section), key.doc))),
        _ => None,
    };
    kinds.written(Syntax::Yaml).filter_map(one).collect()
}

/// Mapping of a mission of a kind, or of a member.
fn body(section: &BlockSchema) -> Value {
    let mut parts = of::keys(section);
    let below = by_role(section);
    let needed = section.written(Syntax::Yaml).filter(|k| k.presence == Presence::Required);
    let (needed_members, needed): (Vec<&Key>, Vec<&Key>) = needed.partition(|k| below.contains_key(k.name));
    let needed: Vec<&str> = needed.iter().map(|k| k.name).collect();
    if below.is_empty() {
        return object(parts, &needed, "");
    }
    parts.extend(below);
    parts.insert("for".to_string(), reference(section));
    let mut schema = object(parts, &needed, "");
    // Required members may be in a repetition.
    let one = |key: &&Key| json!({ "anyOf": [{ "required": [key.name] }, { "required": ["for"] }] });
    let all: Vec<Value> = needed_members.iter().map(one).collect();
    if !all.is_empty() {
        schema["allOf"] = json!(all);
    }
    schema
}

/// Members by name, for each role of a section.
fn by_role(of: &BlockSchema) -> Map<String, Value> {
    let one = |(key, role, inner): (&'static Key, &str, &'static BlockSchema)| {
        let member = if role == "task" { task(inner) } else { body(inner) };
        (key.name.to_string(), described(section("", &member), key.doc))
    };
    members(of).map(one).collect()
}

/// A task: `wait`, or `{ pick_and_place: { .. } }`.
fn task(inner: &'static BlockSchema) -> Value {
    json!({
        "type": ["string", "object"],
        "minProperties": 1,
        "maxProperties": 1,
        "additionalProperties": body(inner),
    })
}

fn repeats_name(section: &BlockSchema) -> String {
    format!("repeats in {}", section.name).replace(' ', "_")
}

fn reference(section: &BlockSchema) -> Value {
    json!({ "$ref": format!("#/$defs/{}", repeats_name(section)), "description": "Members that are repeated." })
}

/// List of repetitions of members.
fn repeats(section: &BlockSchema) -> Value {
    let mut parts = of::keys(&REPEAT);
    parts.retain(|key, _| key == "name" || key == "in");
    parts.extend(by_role(section));
    parts.insert("for".to_string(), reference(section));
    json!({ "type": ["array", "null"], "items": object(parts, &["name", "in"], "A repetition.") })
}
