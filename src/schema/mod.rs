//! A JSON Schema (2020-12) of the YAML spelling, for editors: what stands where, with units, ranges, defaults and texts.
//!
//! Task types come from the registry that the compiler reads. A schema sees one file and no robot: it knows no names, and
//! of an expression only whether a plain number has a unit that fits. `hierarq check` knows the rest.

mod machines;
mod missions;
mod reuse;
mod sections;
mod tasks;
mod values;

use serde_json::{Map, Value, json};

/// The schema of a spec in YAML.
pub fn schema() -> Value {
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Hierarq",
        "description": "A task hierarchy of a robot, in the YAML spelling of Hierarq.",
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
    all.into()
}

/// A mapping with these keys and no others.
fn object(properties: Map<String, Value>, required: &[&str], description: &str) -> Value {
    json!({
        "type": "object",
        "description": description,
        "properties": properties,
        "required": required,
        "additionalProperties": false,
    })
}

/// A mapping of names that the user chooses; it may be empty.
fn section(description: &str, of: &Value) -> Value {
    json!({
        "type": ["object", "null"],
        "description": description,
        "propertyNames": { "pattern": values::NAME },
        "additionalProperties": of,
    })
}

/// A mapping of names that may have parameters.
fn heads(description: &str, of: &Value) -> Value {
    let mut schema = section(description, of);
    schema["propertyNames"] = json!({ "pattern": values::HEAD });
    schema
}

/// A schema with another description.
fn described(mut schema: Value, description: &str) -> Value {
    if let Some(object) = schema.as_object_mut() {
        object.insert("description".to_string(), json!(description));
    }
    schema
}
