//! Schema of signals, machines, and nested states.

use compiler::sections::{self, BlockSchema, SIGNAL, STATE, TRANSITION, VARIABLE};
use serde_json::{Map, Value, json};

use super::{described, object, section, sections as of, values};

/// Shared definitions `state` and `transition`.
pub(super) fn definitions() -> Map<String, Value> {
    Map::from_iter([("state".to_string(), body(&STATE, "A state.")), ("transition".to_string(), transition())])
}

/// Machines by name.
pub(super) fn machines() -> Value {
    let mut machine = body(&sections::MACHINE, "A state machine.");
    machine["required"] = json!(["initial", "states"]);
    section("", &machine)
}

/// Mapping of a machine or a state.
fn body(section: &BlockSchema, description: &str) -> Value {
    let mut parts = of::keys(section);
    let actions = json!({ "type": ["string", "array"], "minLength": 1, "items": values::name() });
    for key in ["enter", "do", "exit"] {
        let doc = parts.get(key).or(of::keys(&STATE).get(key)).map(|s| s["description"].clone());
        parts.insert(key.to_string(), described(actions.clone(), doc.as_ref().and_then(Value::as_str).unwrap_or("")));
    }
    replace(&mut parts, "stack", values::name());
    replace(&mut parts, "transitions", json!({ "type": "array", "items": { "$ref": "#/$defs/transition" } }));
    replace(&mut parts, "states", states());
    replace(&mut parts, "check", super::sections::formulas());
    if !parts.contains_key("stack") {
        parts.insert("stack".to_string(), described(values::name(), "The stack of states that name none."));
    }
    object(parts, &[], description)
}

/// Replaces a schema and keeps its description.
fn replace(parts: &mut Map<String, Value>, key: &str, schema: Value) {
    if let Some(old) = parts.get_mut(key) {
        let doc = old["description"].as_str().unwrap_or("").to_string();
        *old = described(schema, &doc);
    }
}

/// States by name; a state without entries is an empty mapping.
fn states() -> Value {
    section("", &json!({ "$ref": "#/$defs/state" }))
}

/// A transition: `{ when: x < 3 N, for: 3 s, to: grasp, blend: 1 s }`.
fn transition() -> Value {
    let mut parts = of::keys(&TRANSITION);
    replace(&mut parts, "when", json!({ "type": ["string", "boolean"] }));
    replace(&mut parts, "to", json!({ "type": "string", "pattern": TARGET }));
    let mut schema = object(parts, &["to"], "A way out.");
    schema["oneOf"] = json!([{ "required": ["on"] }, { "required": ["when"] }, { "required": ["after"] }]);
    schema["dependentRequired"] = json!({ "for": ["when"] });
    schema
}

/// A path of states, `outer.inner`.
static TARGET: &str = r"^\s*[A-Za-z0-9_${}+*-]+(?:\.[A-Za-z0-9_${}+*-]+)*\s*$";

/// Variables by name: `point?`, or `{ type: number, value: 0 }`.
pub(super) fn variables() -> Value {
    let words: Vec<&str> = compiler::signal_types().filter(|t| !matches!(*t, "event" | "wrench")).collect();
    let ty = json!({ "type": "string", "pattern": format!(r"^\s*(?:{})\??\s*$", words.join("|")) });
    let mut parts = of::keys(&VARIABLE);
    replace(&mut parts, "type", ty.clone());
    let mut variable = object(parts, &["type"], "What the machine keeps.");
    variable["type"] = json!(["string", "object"]);
    variable["pattern"] = ty["pattern"].clone();
    section("", &variable)
}

/// Signals by name: `point?`, or `{ type: point?, timeout: 0.5 s }`.
pub(super) fn signals() -> Value {
    let words: Vec<&str> = compiler::signal_types().collect();
    let ty = json!({ "type": "string", "pattern": format!(r"^\s*(?:{})\??\s*$", words.join("|")) });
    let mut parts = of::keys(&SIGNAL);
    replace(&mut parts, "type", ty.clone());
    let mut signal = object(parts, &["type"], "A typed input.");
    signal["type"] = json!(["string", "object"]);
    signal["pattern"] = ty["pattern"].clone();
    section("", &signal)
}
