//! `plan --json` satisfies its schema for every kind of mission, and the book documents each of its keys.

use crate::common::cli;

use std::collections::BTreeSet;

use cli::{hierarq, text};
use serde_json::Value;

fn data(args: &[&str]) -> Value {
    let out = hierarq(args);
    assert_eq!(out.status.code(), Some(0), "{args:?}: {}", text(&out.stderr));
    serde_json::from_slice(&out.stdout).expect("JSON")
}

fn schema() -> Value {
    let schema = data(&["schema", "plan"]);
    jsonschema::draft202012::meta::validate(&schema).expect("a schema by the rules of 2020-12");
    schema
}

/// Checks the consistency of a plan: every reference is to a listed item, every position has three coordinates, and the
/// cost is the sum of its parts.
fn refers(plan: &Value) {
    // A kind has only its own lists.
    let list = |key: &str| plan[key].as_array().cloned().unwrap_or_default();
    let names = |key: &str| list(key).iter().map(|one| one["name"].to_string()).collect::<BTreeSet<String>>();
    let (agents, objects, layers, tasks) = (names("agents"), names("objects"), names("layers"), names("tasks"));
    let sources = names("sources");
    let known = |value: &Value, among: &BTreeSet<String>| value.is_null() || among.contains(&value.to_string());
    for one in list("activities").iter().chain(&list("services")) {
        assert!(known(&one["agent"], &agents) && known(&one["operation"]["of"], &agents), "{one}");
        assert!(
            known(&one["object"], &objects) && known(&one["layer"], &layers) && known(&one["task"], &tasks),
            "{one}"
        );
        assert!(known(&one["source"], &sources) && known(&one["awaits"], &agents), "{one}");
        let work = [one["operation"].is_object(), one["task"].is_string(), one["way"].is_array()];
        assert_eq!(work.into_iter().filter(|is| *is).count(), 1, "one of these: {one}");
    }
    let parts = plan["cost"]["parts"].as_array().expect("parts");
    let number = |value: &Value| value.as_f64().expect("a number");
    let sum: f64 = parts.iter().map(|part| number(&part["cost"])).sum();
    assert!((sum - number(&plan["cost"]["total"])).abs() < 1e-9, "{}", plan["cost"]);
    for part in parts.iter().filter(|part| part["weight"].is_number()) {
        assert!((number(&part["value"]) * number(&part["weight"]) - number(&part["cost"])).abs() < 1e-12);
    }
}

#[test]
fn plans_of_all_kinds_keep_to_the_schema() {
    let judge = jsonschema::draft202012::new(&schema()).expect("a schema");
    let mut kinds = BTreeSet::new();
    for args in [
        &["plan", "examples/vineyard.hq", "--set", "boxes=1", "--json"][..],
        &["plan", "examples/vineyard.yaml", "--set", "boxes=1", "--json", "--formulation", "batches"],
        &["plan", "examples/vineyard_picker.hq", "--json"],
        &["plan", "examples/letters.hq", "letter_d", "--json"],
        &["plan", "examples/letters.yaml", "letter_h", "--json", "--batch", "4"],
        &["plan", "examples/panel.hq", "together", "--json"],
        &["plan", "examples/supermarket.yaml", "--json", "--formulation", "greedy"],
    ] {
        let plan = data(args);
        let faults: Vec<String> = judge.iter_errors(&plan).map(|e| format!("{}: {e}", e.instance_path())).collect();
        assert!(faults.is_empty(), "{args:?}: {faults:?}");
        refers(&plan);
        kinds.insert(plan["kind"].to_string());
        let own: &[&str] = match plan["kind"].as_str() {
            Some("schedule") => &["services"],
            Some("layers") => &["objects", "layers", "tasks"],
            _ => &["sources"],
        };
        for key in ["services", "objects", "layers", "tasks", "sources"] {
            assert_eq!(plan[key].is_array(), own.contains(&key), "{args:?}: `{key}`");
        }
        // The schema is not trivial: it rejects missing and unknown keys.
        for key in ["version", "kind", "agents", "cost"] {
            let mut without = plan.clone();
            without.as_object_mut().expect("an object").remove(key);
            assert!(!judge.is_valid(&without), "{key}");
        }
        let mut more = plan.clone();
        more["activities"][0]["actor"] = Value::Null;
        assert!(!judge.is_valid(&more));
    }
    assert_eq!(kinds.len(), 3);
}

/// A mission in space has all three coordinates.
#[test]
fn places_have_three_coordinates() {
    let plan = data(&["plan", "examples/letters.hq", "letter_h", "--json"]);
    let places =
        |key: &str| plan[key].as_array().expect("a list").iter().map(|one| one["place"].clone()).collect::<Vec<_>>();
    for place in places("agents").iter().chain(&places("objects")).chain(&places("activities")) {
        assert_eq!(place.as_array().map(Vec::len), Some(3), "{place}");
    }
}

/// Collects the keys of a schema, including nested ones.
fn keys(schema: &Value, found: &mut BTreeSet<String>) {
    match schema {
        Value::Object(object) => {
            if let Some(Value::Object(properties)) = object.get("properties") {
                for (key, of) in properties {
                    found.insert(key.clone());
                    assert!(of["description"].is_string() || of["$ref"].is_string(), "`{key}` says nothing");
                }
            }
            object.values().for_each(|value| keys(value, found));
        }
        Value::Array(list) => list.iter().for_each(|value| keys(value, found)),
        _ => {}
    }
}

#[test]
fn the_book_knows_every_key() {
    let book = std::fs::read_to_string("docs/src/plans.md").expect("a page");
    let mut all = BTreeSet::new();
    keys(&schema(), &mut all);
    assert!(all.len() > 40);
    for key in all {
        assert!(book.contains(&format!("`{key}`")), "the book says nothing of `{key}`");
    }
}
