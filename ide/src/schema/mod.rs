//! JSON Schema (2020-12) of the YAML syntax, for editors: the structure of a spec, with units, ranges, defaults and
//! descriptions.
//!
//! Task types come from the registry of the compiler. A schema sees a single file and no robot, so it cannot check
//! names, and in expressions only the unit of a plain number. `hierarq check` checks the rest.

mod machines;
mod missions;
mod reuse;
mod sections;
mod tasks;
mod values;

use compiler::sections::ALLOW;
use serde_json::{Map, Value, json};

/// Schema of a spec in YAML.
pub fn schema() -> Value {
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Hierarq",
        "description": "A task hierarchy of a robot, in the YAML syntax of Hierarq.",
        "type": "object",
        "required": ["hierarq"],
        "additionalProperties": false,
        "properties": sections::all(),
        "$defs": definitions(),
    })
}

fn definitions() -> Value {
    let mut all = tasks::definitions();
    all.extend(machines::definitions());
    all.extend(missions::definitions());
    all.insert("repeats".to_string(), reuse::repeats_of_sections());
    all.insert("allow".to_string(), allow());
    all.into()
}

/// Warnings that are allowed, by code.
fn allow() -> Value {
    let codes: Vec<&str> = compiler::codes::all().filter(|page| page.warning).map(|page| page.code).collect();
    json!({
        "type": "object",
        "description": ALLOW.doc,
        "propertyNames": { "enum": codes },
        "additionalProperties": { "type": "string", "pattern": "\\S" },
    })
}

/// Mapping with these keys only, and the warnings that are allowed there.
fn object(mut properties: Map<String, Value>, required: &[&str], description: &str) -> Value {
    properties.insert(ALLOW.name.to_string(), json!({ "$ref": "#/$defs/allow" }));
    json!({
        "type": "object",
        "description": description,
        "properties": properties,
        "required": required,
        "additionalProperties": false,
    })
}

/// Mapping with user-defined names as keys; it may be empty.
fn section(description: &str, of: &Value) -> Value {
    json!({
        "type": ["object", "null"],
        "description": description,
        "propertyNames": { "pattern": values::NAME },
        "additionalProperties": of,
    })
}

/// Mapping with user-defined names that may have parameters.
fn heads(description: &str, of: &Value) -> Value {
    let mut schema = section(description, of);
    schema["propertyNames"] = json!({ "pattern": values::HEAD });
    schema
}

/// Replaces the description of a schema.
fn described(mut schema: Value, description: &str) -> Value {
    if let Some(object) = schema.as_object_mut() {
        object.insert("description".to_string(), json!(description));
    }
    schema
}
