//! A plan as data: the JSON of `hierarq plan --json`, in one form for all kinds of mission.
//!
//! An *agent* is a participant of the mission: a robot, a person or a working robot. All references are names, and labels
//! are given in addition to names. The form has a [`VERSION`] and a JSON Schema, [`schema`]. The keys that all kinds have
//! are here; each kind adds its own, with their part of the schema.

use std::fmt::Debug;

use serde::Serialize;
use serde_json::{Map, Value, json};

use crate::plan::{Statistics, Status};

/// The version of the form. An incompatible change increases it.
pub const VERSION: u32 = 3;

/// The keys that all kinds have.
static COMMON: &str = include_str!("schema.json");

/// The keys of a plan that precede those of its kind. Times in s, lengths in m, speeds in m/s, masses in kg.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Head<'p> {
    /// [`VERSION`].
    pub version: u32,
    /// True: there is a plan.
    pub ok: bool,
    /// The file of the spec.
    pub spec: &'p str,
    /// Name of the mission.
    pub mission: &'p str,
    /// The kind of mission.
    pub kind: &'static str,
    /// Planning method.
    pub formulation: &'static str,
    /// Reason for that formulation.
    pub why: &'p str,
    /// The solver.
    pub engine: &'p str,
    /// True: the validator, which is independent of the planner, accepts the plan.
    pub valid: bool,
    /// Proof or optimality gap.
    pub status: &'p Status,
    /// Amount of search.
    pub statistics: Statistics,
    /// The cost.
    pub cost: &'p Cost,
}

/// The cost of a plan.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Cost {
    /// The minimised cost, without unit: the sum of the parts.
    pub total: f64,
    /// Its parts.
    pub parts: Vec<Part>,
}

/// A part of the cost.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Part {
    /// The quantity.
    pub name: &'static str,
    /// Its share of the total.
    pub cost: f64,
    /// The normalised quantity before its weight; none if operations have weights of their own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// Its weight, if there is one for the whole mission.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weight: Option<f64>,
}

impl Part {
    /// A normalised quantity with its weight.
    pub fn weighted(name: &'static str, value: f64, weight: f64) -> Part {
        Part { name, cost: weight * value, value: Some(value), weight: Some(weight) }
    }

    /// A quantity that contains its weights.
    pub fn plain(name: &'static str, cost: f64) -> Part {
        Part { name, cost, value: None, weight: None }
    }
}

/// A name with the text that people read in its place.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Named {
    /// The name.
    pub name: String,
    /// The label; none: the name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
}

impl Named {
    /// A name with its label, which may be the name itself.
    pub fn new(name: &str, label: &str) -> Named {
        Named { name: name.to_string(), label: (label != name).then(|| label.to_string()) }
    }
}

/// The part of a plan's JSON that only its kind knows: `agents`, `activities`, and keys of its own.
pub trait PlanData: Debug {
    /// Returns the JSON of the plan that begins with this head.
    ///
    /// # Errors
    /// It cannot be serialised, which the types of the kinds exclude.
    fn to_json(&self, head: &Head<'_>) -> serde_json::Result<String>;
}

#[derive(Serialize)]
struct Whole<'w, D> {
    #[serde(flatten)]
    head: &'w Head<'w>,
    #[serde(flatten)]
    rest: &'w D,
}

impl<D: Serialize + Debug> PlanData for D {
    fn to_json(&self, head: &Head<'_>) -> serde_json::Result<String> {
        serde_json::to_string_pretty(&Whole { head, rest: self })
    }
}

/// The form of the plans of a kind of mission.
#[derive(Clone, Copy, Debug)]
pub struct Form {
    /// Name of the kind.
    pub kind: &'static str,
    /// The same in messages, with an article.
    pub title: &'static str,
    /// JSON with the keys that this kind adds to a plan, a part of the cost, an agent and an activity, each an object schema.
    pub keys: &'static str,
}

/// Returns the JSON Schema of the plans of these kinds: for each kind an object with the keys that all kinds have and its
/// own.
pub fn schema(kinds: &[Form]) -> Value {
    let common = parsed(COMMON);
    let mut definitions = Map::new();
    for kind in kinds {
        let own = parsed(kind.keys);
        definitions.extend(own["$defs"].as_object().cloned().unwrap_or_default());
        definitions.insert(kind.kind.into(), plan(kind, &common, &own));
    }
    let plans: Vec<Value> = kinds.iter().map(|kind| json!({ "$ref": format!("#/$defs/{}", kind.kind) })).collect();
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": format!("A plan of Hierarq, version {VERSION}"),
        "description": "The output of `hierarq plan --json`. Times in s, lengths in m, speeds in m/s, masses in kg.",
        "oneOf": plans,
        "$defs": definitions,
    })
}

/// The schema of the plans of one kind.
fn plan(kind: &Form, common: &Value, own: &Value) -> Value {
    let mut plan = merged(&common["plan"], &own["plan"]);
    plan["description"] = format!("A plan of {}.", kind.title).into();
    let properties = &mut plan["properties"];
    properties["version"] = json!({ "const": VERSION, "description": "The version of this form." });
    properties["kind"] = json!({ "const": kind.kind, "description": "The kind of mission." });
    properties["cost"]["properties"]["parts"]["items"] = merged(&common["part"], &own["part"]);
    for (list, one) in [("agents", "agent"), ("activities", "activity")] {
        properties[list]["items"] = merged(&common[one], &own[one]);
    }
    plan
}

/// An object with the keys of two schemas; a key of the second replaces one of the first.
fn merged(common: &Value, own: &Value) -> Value {
    let keys = |of: &Value| of["properties"].as_object().cloned().unwrap_or_default();
    let properties: Map<String, Value> = keys(common).into_iter().chain(keys(own)).collect();
    let required = [common, own].into_iter().filter_map(|of| of["required"].as_array()).flatten();
    json!({
        "type": "object",
        "description": common["description"],
        "properties": properties,
        "required": required.collect::<Vec<_>>(),
        "additionalProperties": false,
    })
}

/// The schema of a text that is a part of the program; null if it is no JSON, which tests exclude.
fn parsed(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_default()
}
