//! Language server: demands on limits.

use super::common;
use super::document::Document;

const COVERED: &str = include_str!("../../examples/covered.hq");

const DEMANDED: &str = "people { worker { links [grip, elbow] } }";

fn opened() -> Document {
    Document::open("covered.hq", COVERED)
}

#[test]
fn hover_and_definition() {
    let mut doc = opened();
    assert!(doc.diagnostics().is_empty());
    doc.hovers(&[
        ("cov|erage {", "coverage", "Demands on the limits of stacks"),
        ("accel|eration soft", "acceleration", "each joint that moves"),
        ("people { wor|ker {", "worker", "human"),
        ("limits { ta|ble {", "table", "virtual_wall"),
    ]);
    doc.definitions(&[
        ("people { wor|ker {", "human |worker"),
        ("limits { ta|ble {", "task |table"),
        ("worker { links [gr|ip", "points { |grip tool"),
    ]);
}

#[test]
fn completion_offers_keys_and_names() {
    let mut doc = opened();
    doc.completions(&[
        (DEMANDED, "|", &["states", "people", "self_collision"], &["velocity", "duration"]),
        (DEMANDED, "states [|]", &["wait", "reach"], &["moving"]),
        (DEMANDED, "stacks [|]", &["waiting", "moving"], &["wait"]),
        (DEMANDED, "joints [|]", &["joint_1"], &["link_1"]),
        (DEMANDED, "people { worker { | } }", &["links", "points", "level"], &["between"]),
        (DEMANDED, "people { worker { links [|] } }", &["grip", "link_4"], &["joint_1", "worker"]),
        (DEMANDED, "people { worker { points [|] } }", &["chest", "hand"], &["grip"]),
        (DEMANDED, "people { worker { links [grip]  level | } }", &["hard", "soft"], &["grip"]),
        (DEMANDED, "self_collision { | }", &["between", "and", "level"], &["links"]),
        ("  velocity hard\n", "  velocity |\n", &["hard", "soft"], &["limits"]),
    ]);
}

#[test]
fn references_and_rename() {
    let mut doc = opened();
    let (renamed, _) = doc.renamed("task ta|ble", "table", "bench");
    assert!(renamed.contains("limits { bench {"), "{renamed}");
    let (renamed, _) = doc.renamed("human wor|ker", "worker", "person");
    assert!(renamed.contains("people { person {"), "{renamed}");
    assert_eq!(common::program_of(COVERED).tasks.len(), common::program_of(&renamed).tasks.len());
}
