//! Schema of task types and of their uses, from the registry.

use compiler::sections::MEMBER;
use serde_json::{Map, Value, json};
use stdlib_tasks::KINDS;
use stdlib_tasks::axis_rows::AXES;
use stdlib_tasks::dimension::RATE;
use stdlib_tasks::kinds::safety_planner::{PATH, TURN};
use stdlib_tasks::params::{Form, ParamInfo, ParamType, Presence, Quantity};
use stdlib_tasks::task::TaskKind;

use super::{described, object, sections, values};
use crate::catalogue;

/// Shared definitions: `task`, `member`, and the parameters of each type.
pub(super) fn definitions() -> Map<String, Value> {
    let mut all = Map::new();
    all.insert("task".to_string(), task());
    all.insert("member".to_string(), member());
    for kind in KINDS {
        all.insert(kind.name.to_string(), body(kind, &[]));
        if !kind.positional.is_empty() {
            all.insert(called(kind), body(kind, kind.positional));
        }
    }
    all
}

/// Name of the definition of a type whose first parameters are in parentheses.
fn called(kind: &TaskKind) -> String {
    format!("{}()", kind.name)
}

fn required(p: &ParamInfo) -> bool {
    p.presence == Presence::Required
}

/// Block of a type; parameters in `given` are not required.
fn body(kind: &TaskKind, given: &[&str]) -> Value {
    let required: Vec<&str> =
        kind.params.iter().filter(|p| required(p) && !given.contains(&p.name)).map(|p| p.name).collect();
    object(parameters(kind.params), &required, &format!("{}.\n\n{}", sentence(kind.summary), kind.docs))
}

/// Capitalises the first letter.
fn sentence(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map(|c| c.to_uppercase().chain(chars).collect()).unwrap_or_default()
}

fn parameters(infos: &[ParamInfo]) -> Map<String, Value> {
    infos.iter().map(|p| (p.name.to_string(), parameter(p))).collect()
}

fn parameter(p: &ParamInfo) -> Value {
    let schema = match &p.ty {
        ParamType::Scalar(q) | ParamType::AutoScalar(q) => values::scalar(q),
        ParamType::Vector(d) => values::vector(*d),
        ParamType::PerAxis(q) => values::per_axis(q),
        ParamType::Vectors { least, most, dimension } => values::vectors(*least, *most, *dimension),
        ParamType::Rotation | ParamType::Frame | ParamType::Arm | ParamType::Task | ParamType::Field => values::name(),
        ParamType::Deviations => deviations(),
        ParamType::Gains(names) => gains(names),
        ParamType::Frames | ParamType::Geometries | ParamType::Joints | ParamType::Obstacles => values::names(),
        ParamType::Pairs(_) => json!({
            "type": "array",
            "items": { "type": "array", "minItems": 2, "maxItems": 2, "items": values::names() },
        }),
        ParamType::JointPositions | ParamType::JointVelocities | ParamType::JointAccelerations => {
            let mut schema = values::per_joint();
            schema["type"] = json!(["object", "number", "string"]);
            schema
        }
        ParamType::PerArm(d) => values::per_arm(*d),
        ParamType::PerFrame(infos) => json!({
            "type": "object",
            "minProperties": 1,
            "additionalProperties": object(parameters(infos), &[], ""),
        }),
        ParamType::Choice(words) => json!({ "enum": words }),
        ParamType::Axes => json!({
            "anyOf": [{ "enum": AXES }, { "type": "array", "minItems": 1, "maxItems": 3, "items": { "enum": AXES } }],
        }),
        ParamType::Expression(Form::Number(q)) => values::scalar(q),
        ParamType::Expression(Form::Vector(d)) => values::vector(*d),
        ParamType::Expression(_) => values::any(),
        ParamType::Group(inner) => {
            let needed: Vec<&str> = inner.iter().filter(|p| required(p)).map(|p| p.name).collect();
            object(parameters(inner), &needed, "")
        }
    };
    let mut schema = described(schema, &format!("{}\n\n{}.", p.text(), sentence(&catalogue::describe(&p.ty))));
    if let Presence::Default(text) = p.presence {
        // The default of a group is the defaults of its members.
        schema["default"] = if matches!(p.ty, ParamType::Group(_)) { json!({}) } else { json!(text) };
    }
    schema
}

/// Deviations, in the groups of the other task's parameters; a block with a speed is a deviation.
fn deviations() -> Value {
    let one = |infos: &[ParamInfo]| object(parameters(infos), &["speed"], "");
    let either = json!({ "anyOf": [one(PATH), one(TURN)] });
    let group = json!({ "type": "object", "additionalProperties": either });
    json!({
        "type": "object",
        "additionalProperties": { "if": { "required": ["speed"] }, "then": either, "else": group },
    })
}

/// One rate, or one for each name.
fn gains(names: &[&str]) -> Value {
    let rate = values::scalar(&Quantity::at_least(RATE, 0.0));
    let mut schema = rate.clone();
    schema["type"] = json!(["number", "string", "object"]);
    schema["properties"] = names.iter().map(|n| ((*n).to_string(), rate.clone())).collect::<Map<_, _>>().into();
    schema["required"] = json!(names);
    schema["additionalProperties"] = json!(false);
    schema
}

/// Pattern of a task as text: the bare type if no parameter is required, or a type with parentheses.
fn text() -> String {
    let mut forms = Vec::new();
    for kind in KINDS {
        let needed: Vec<&str> = kind.params.iter().filter(|p| required(p)).map(|p| p.name).collect();
        if needed.is_empty() {
            forms.push(kind.name.to_string());
        }
        if !kind.positional.is_empty() && needed.iter().all(|n| kind.positional.contains(n)) {
            forms.push(format!(r"{}\(.+\)", kind.name));
        }
    }
    // A task of the spec with arguments.
    let library: Vec<&str> = KINDS.iter().map(|k| k.name).collect();
    forms.push(format!(r"(?!(?:{})\s*\(){NAME}\(.*\)", library.join("|")));
    format!(r"\s*(?:{})\s*", forms.join("|"))
}

/// Pattern of a name.
static NAME: &str = r"(?:[A-Za-z0-9_]|\$\{[-+* A-Za-z0-9_]+\})+";

/// One type with its parameters: `{ virtual_wall: .. }` or `{ "hold(left, right)": .. }`.
fn with_parameters() -> Value {
    let plain: Map<String, Value> =
        KINDS.iter().map(|k| (k.name.to_string(), json!({ "$ref": format!("#/$defs/{}", k.name) }))).collect();
    let patterns: Map<String, Value> = KINDS
        .iter()
        .filter(|k| !k.positional.is_empty())
        .map(|k| (format!(r"^{}\(.+\)\s*$", k.name), json!({ "$ref": format!("#/$defs/{}", called(k)) })))
        .collect();
    json!({
        "properties": plain,
        "patternProperties": patterns,
        "additionalProperties": false,
        "minProperties": 1,
        "maxProperties": 1,
    })
}

/// A task: `KIND`, `KIND(..)`, or a mapping with one type.
fn task() -> Value {
    let mut schema = with_parameters();
    schema["type"] = json!(["string", "object"]);
    schema["pattern"] = json!(format!("^{}$", text()));
    schema["patternErrorMessage"] =
        json!("no task type that can stand without parameters; write `KIND: { key: value }`, see `hierarq tasks`");
    described(schema, "A task: `KIND`, `KIND(..)`, or `KIND: { parameters }`.")
}

/// A member of a level: the name of a task, an inline task, or `{ task, weight }`.
fn member() -> Value {
    let mut properties = sections::keys(&MEMBER);
    properties.insert("task".to_string(), member_task());
    json!({
        "description": "The name of a task, a task in place, or `{ task: .., weight: .. }`.",
        "if": { "type": "object", "required": ["task"] },
        "then": object(properties, &["task"], "A task with a weight."),
        "else": {
            "if": { "type": "object", "required": ["for"] },
            "then": super::reuse::member_repeat(),
            "else": member_task(),
        },
    })
}

fn member_task() -> Value {
    let mut schema = with_parameters();
    schema["type"] = json!(["string", "object"]);
    schema["pattern"] = json!(format!(r"^(?:\s*{NAME}\s*|{})$", text()));
    described(schema, "The name of a task, or a task in place.")
}
