//! Schema of imports, named expressions, and repetitions.

use compiler::sections::REPEAT;
use dsl::vocabulary::REPEATED;
use serde_json::{Map, Value, json};

use super::{described, heads, object, section, sections};

pub(super) fn imports() -> Value {
    let names = json!({
        "type": "array",
        "items": { "type": "string", "pattern": r"^\s*[A-Za-z_][A-Za-z0-9_]*(?:\s+as\s+[A-Za-z_][A-Za-z0-9_]*)?\s*$" },
    });
    json!({
        "type": ["object", "null"],
        "description": "Names of other specs: for each file the names, `NAME` or `NAME as OTHER`. Paths start from this file.",
        "propertyNames": { "pattern": r"\.(?:hq|yaml|yml)$" },
        "additionalProperties": names,
    })
}

pub(super) fn lets() -> Value {
    let value = json!({ "type": ["number", "string", "array"] });
    section("Named expressions, which may move with `t`. `--set` does not override them.", &value)
}

pub(super) fn tasks() -> Value {
    heads("Tasks by name; one with parameters as `\"NAME(side: arm)\"`.", &json!({ "$ref": "#/$defs/task" }))
}

pub(super) fn repeats() -> Value {
    json!({ "$ref": "#/$defs/repeats", "description": "Declarations that are repeated." })
}

/// List of repetitions of declarations.
pub(super) fn repeats_of_sections() -> Value {
    let mut parts = sections::keys(&REPEAT);
    parts.extend(sections::all().into_iter().filter(|(key, _)| REPEATED.contains(&key.as_str())));
    json!({ "type": ["array", "null"], "items": object(parts, &["name", "in"], "A repetition.") })
}

/// Repeated members of a level: `{ for: { name: side, in: [left, right], tasks: [..] } }`.
pub(super) fn member_repeat() -> Value {
    let mut parts = sections::keys(&REPEAT);
    let tasks = json!({ "type": "array", "items": { "$ref": "#/$defs/member" } });
    parts.insert("tasks".to_string(), described(tasks, "The tasks that are repeated."));
    let inner = object(parts, &["name", "in", "tasks"], "A repetition.");
    object(Map::from_iter([("for".to_string(), inner)]), &["for"], "Tasks that are repeated.")
}
