//! Schema of all parts of a spec except tasks, from the table of keys.

use compiler::sections::{self, BlockSchema, InSyntax, Key, SPEC, ValueType};
use dsl::Syntax;
use serde_json::{Map, Value, json};
use stdlib_tasks::dimension::LENGTH;
use stdlib_tasks::params::Presence;

use super::{described, machines, missions, object, reuse, section, values};

/// Schemas of the top-level keys.
pub(super) fn all() -> Map<String, Value> {
    let one = |key: &Key| match key.name {
        "hierarq" => json!({ "enum": [1, "1"] }),
        "import" => reuse::imports(),
        "allow" => json!({ "$ref": "#/$defs/allow" }),
        "params" => params(),
        "lets" => reuse::lets(),
        "tasks" => reuse::tasks(),
        "stacks" => stacks(),
        "robots" => robots(),
        "signals" => machines::signals(),
        "variables" => machines::variables(),
        "machines" => machines::machines(),
        "missions" => missions::missions(),
        "for" => reuse::repeats(),
        "scenarios" => scenarios(),
        _ => held(&key.value),
    };
    SPEC.written(Syntax::Yaml).map(|key| (key.name.to_string(), described(one(key), key.doc))).collect()
}

/// Keys of a section in YAML.
pub(super) fn keys(section: &BlockSchema) -> Map<String, Value> {
    let schema = |key: &Key| {
        let mut schema = described(held(&key.value), key.doc);
        if let Presence::Default(text) = key.presence {
            schema["default"] = if matches!(key.value, ValueType::Flag) { json!(text == "true") } else { json!(text) };
        }
        schema
    };
    section.written(Syntax::Yaml).map(|key| (key.name.to_string(), schema(key))).collect()
}

/// Mapping with the keys of a section, including the list of required ones.
fn block(section: &BlockSchema) -> Value {
    let needed: Vec<&str> =
        section.written(Syntax::Yaml).filter(|k| k.presence == Presence::Required).map(|k| k.name).collect();
    object(keys(section), &needed, "")
}

/// Schema of a key's value.
fn held(holds: &ValueType) -> Value {
    match holds {
        ValueType::Number(q) | ValueType::Count(q) | ValueType::Spread(q) => values::scalar(q),
        ValueType::NumberOr(q, words) => json!({ "anyOf": [values::scalar(q), { "enum": words }] }),
        ValueType::Function(_) => json!({ "type": ["number", "string"] }),
        ValueType::Vector(q) => values::vector(q.dimension),
        ValueType::Spot => values::vector(LENGTH),
        ValueType::Pair(d) => values::pair(*d),
        ValueType::Range(q) => values::range(q),
        ValueType::OfJoint { .. } | ValueType::Bound => json!({ "type": ["number", "string"] }),
        ValueType::WordOr(_) => values::name(),
        ValueType::Value => json!({ "type": ["number", "string", "array"] }),
        ValueType::People => json!({ "type": ["string", "array"] }),
        ValueType::Numbers(q) => {
            let one = values::scalar(q);
            json!({ "anyOf": [one, { "type": "array", "minItems": 1, "items": one }] })
        }
        ValueType::Sent => json!({ "type": ["number", "string", "array", "boolean", "object"] }),
        ValueType::Values => json!({ "type": ["array", "string"] }),
        ValueType::Flag => json!({ "enum": [true, false] }),
        ValueType::Choice(words) => json!({ "enum": words }),
        ValueType::NewName => json!({ "type": "string", "pattern": values::NAME }),
        ValueType::Text
        | ValueType::File
        | ValueType::FileWith(_)
        | ValueType::Binary(_)
        | ValueType::Urdf
        | ValueType::Srdf
        | ValueType::Spec
        | ValueType::Name(_)
        | ValueType::Link => values::name(),
        ValueType::Geometries | ValueType::Links | ValueType::Joints => values::names(),
        ValueType::Locks => {
            let mut locks = values::per_joint();
            locks["type"] = json!(["string", "array", "object"]);
            locks["items"] = values::name();
            locks
        }
        ValueType::Positions => {
            let mut positions = values::per_joint();
            // The name of a posture.
            positions["type"] = json!(["object", "string"]);
            positions
        }
        // By reference, because states are nested.
        ValueType::Block(section) if std::ptr::eq(*section, &sections::STATE) => json!({ "$ref": "#/$defs/state" }),
        ValueType::Block(section) => block(section),
        ValueType::Blocks(section) => {
            let one = block(section);
            json!({ "anyOf": [one, { "type": "array", "minItems": 1, "items": one }] })
        }
        ValueType::LinkOr(section) => {
            let mut either = block(section);
            either["type"] = json!(["string", "object"]);
            either
        }
        ValueType::Each(inner) | ValueType::Of(_, inner) => section("", &held(inner)),
        ValueType::PerJoint(inner) => json!({
            "type": "object",
            "propertyNames": { "pattern": values::JOINT_KEY },
            "additionalProperties": held(inner),
        }),
        ValueType::List(ValueType::Block(section)) if std::ptr::eq(*section, &sections::MEMBER) => {
            json!({ "type": "array", "minItems": 1, "items": { "$ref": "#/$defs/member" } })
        }
        ValueType::List(ValueType::Block(section)) if std::ptr::eq(*section, &sections::CHANGE) => {
            json!({ "type": "array", "items": change() })
        }
        // A list may also be a text, with a unit after it.
        ValueType::List(ValueType::Vector(q)) => {
            json!({ "type": ["string", "array"], "items": values::vector(q.dimension) })
        }
        ValueType::List(ValueType::Pair(d)) => json!({ "type": ["string", "array"], "items": values::pair(*d) }),
        ValueType::List(ValueType::Spot) => json!({ "type": ["string", "array"], "items": values::vector(LENGTH) }),
        ValueType::List(inner) => json!({ "type": "array", "minItems": 1, "items": held(inner) }),
        ValueType::Tasks | ValueType::Declarations => json!({}),
    }
}

pub(super) fn params() -> Value {
    let mut value = block(&sections::PARAM);
    value["type"] = json!(["number", "string", "array", "object"]);
    section(
        "Values with a name: numbers, vectors, orientations, poses.",
        &described(value, "A value, or `{ value, min, max }`."),
    )
}

fn robots() -> Value {
    let mut robot = block(&sections::ROBOT);
    // A derived robot inherits the keys of its base.
    let needed = robot["required"].take();
    robot["required"] = json!([]);
    robot["if"] = json!({ "required": ["from"] });
    robot["else"] = json!({ "required": needed });
    section("", &described(robot, "A robot."))
}

/// A replaced or added level, or the name of a removed one.
fn change() -> Value {
    let mut parts = keys(&sections::LEVEL);
    parts.remove("name");
    parts.extend(keys(&sections::CHANGE));
    let mut change = object(parts, &[], "A level that is replaced, added or removed.");
    change["oneOf"] =
        json!([{ "required": ["replace", "tasks"] }, { "required": ["add", "tasks"] }, { "required": ["remove"] }]);
    change
}

/// Scenarios with their expectations; their names are arbitrary texts.
pub(super) fn scenarios() -> Value {
    let mut scenario = block(&sections::SCENARIO);
    let text = scenario["properties"]["expect"]["description"].as_str().unwrap_or_default().to_string();
    scenario["properties"]["expect"] = described(formulas(), &text);
    json!({ "type": ["object", "null"], "additionalProperties": scenario })
}

/// Formulas with or without labels, one or a sequence.
pub(super) fn formulas() -> Value {
    let labelled = json!({ "type": "object", "minProperties": 1, "additionalProperties": { "type": "string" } });
    let formula = json!({ "anyOf": [{ "type": "string" }, labelled] });
    json!({ "anyOf": [formula, { "type": "array", "items": formula }] })
}

pub(super) fn stacks() -> Value {
    let mut stack = described(block(&sections::STACK), "A hierarchy of tasks.");
    stack["oneOf"] = json!([{ "required": ["levels"] }, { "required": ["from"] }]);
    super::heads("Hierarchies of tasks, by name; one with parameters as `\"NAME(side: arm)\"`.", &stack)
}
