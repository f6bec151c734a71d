//! Language server: specs that workers of missions run, with their signals and states in other files.

use serde_json::Value as Json;

use super::common::example;
use super::document::Document;
use super::editor::{Editor, edited, find};
use super::workspace::{Folder, rename};

const SPEC: &str = r#"hierarq 1

mission morning : schedule {
  robot m1 { depot [0, 0] m  speed 0.4 m/s  serve 10 s }
  // It fills boxes.
  worker w1 {
    place [9, 5] m
    duration 40 s
    runs { spec "picker.hq"  scenario "two boxes"  go box_in_place  done waiting }
  }
  worker w2 { place [9, 7] m  duration 40 s }
}

scenario day {
  mission morning
  duration 500 s
  expect eventually in(w1.carry)
  expect never w1.faulted
}
"#;

fn opened() -> Document {
    Document::open("lsp_workers.hq", SPEC)
}

/// Checks that the definition of a place is a piece of the other file.
fn leads(doc: &mut Document, from: &str, to: &str) {
    let text = std::fs::read_to_string(example("picker.hq")).expect("readable");
    let there = doc.at("textDocument/definition", from);
    assert!(there["uri"].as_str().is_some_and(|u| u.ends_with("/picker.hq")), "{from}: {there}");
    assert_eq!(there["range"]["start"], find(&text, to), "{from}: {there}");
}

#[test]
fn hover_and_definition() {
    let mut doc = opened();
    assert_eq!(doc.diagnostics(), Vec::<Json>::new());
    doc.hovers(&[
        ("    run|s {", "runs", "what its machine makes of it"),
        ("  g|o box", "go", "true while an operation goes on"),
        ("go box_|in_place", "box_in_place", "signal box_in_place : flag"),
        ("in(w|1.carry)", "w1", "It fills boxes."),
        ("spec \"pick|er.hq\"", "picker.hq", "declares"),
    ]);
    leads(&mut doc, "go box_|in_place", "signal |box_in_place");
    leads(&mut doc, "done wai|ting", "state |waiting");
    leads(&mut doc, "in(w1.ca|rry)", "state |carry");
    let there = doc.at("textDocument/definition", "spec \"pick|er.hq\"");
    assert!(there["uri"].as_str().is_some_and(|u| u.ends_with("/picker.hq")), "{there}");
    doc.definitions(&[("in(w|1.carry)", "worker |w1")]);
}

#[test]
fn in_yaml_too() {
    let mut doc = Document::open_in_yaml("lsp_workers.yaml", SPEC);
    assert_eq!(doc.diagnostics(), Vec::<Json>::new());
    leads(&mut doc, "go: box_|in_place", "signal |box_in_place");
    leads(&mut doc, "done: wai|ting", "state |waiting");
    doc.completions(&[
        ("go: box_in_place", "go: |", &["box_in_place"], &["bunches"]),
        ("done: waiting", "done: |", &["waiting", "reach"], &["box_in_place"]),
    ]);
}

#[test]
fn completion() {
    let mut doc = opened();
    doc.completions(&[
        ("go box_in_place  done", "go |  done", &["box_in_place"], &["bunches", "waiting"]),
        ("done waiting", "done |", &["waiting", "reach", "stopped"], &["box_in_place"]),
        ("in(w1.carry)", "in(|)", &["w1"], &["w2", "m1"]),
        ("in(w1.carry)", "in(w1.|)", &["waiting", "carry"], &["served"]),
        ("spec \"picker.hq\"  scenario", "spec \"picker.hq\"  |  scenario", &[], &["spec", "go", "place"]),
        ("never w1.faulted", "never w1.|", &["faulted", "served"], &["makespan"]),
        ("duration 40 s }", "duration 40 s  | }", &["runs"], &["spec"]),
    ]);
}

#[test]
fn mistakes_of_the_other_file_are_shown_where_it_is_named() {
    let mut doc = opened();
    doc.change(&SPEC.replace("go box_in_place", "go box_in_plce"));
    let found = doc.diagnostics();
    assert!(
        found.len() == 1 && found[0]["message"].as_str().is_some_and(|m| m.contains("did you mean `box_in_place`"))
    );
    // The text in the editor counts before it is saved.
    let folder = Folder::new("workers");
    folder.write("day.hq", &SPEC.replace("picker.hq", "own.hq"));
    folder.write("own.hq", &picker());
    let mut e = Editor::ready_in(&folder.0);
    let (_, day) = folder.open(&mut e, "day.hq");
    assert_eq!(e.diagnostics(&day, Some(1)), Vec::<Json>::new());
    e.result("textDocument/documentSymbol", serde_json::json!({ "textDocument": { "uri": day } }));
    let (text, own) = folder.open(&mut e, "own.hq");
    assert_eq!(e.diagnostics(&own, Some(1)), Vec::<Json>::new());
    e.diagnostics(&day, Some(1));
    e.change(&own, 2, serde_json::json!([{ "text": text.replace("-> carry", "-> crry") }]));
    let shown = e.diagnostics(&day, Some(1));
    let message = shown[0]["message"].as_str().unwrap_or_default();
    assert!(message.contains("`carry`") && message.contains("own.hq:"), "{shown:?}");
}

/// Returns the picker with a placeholder for its robot's path.
fn picker() -> String {
    std::fs::read_to_string(example("picker.hq")).expect("readable").replace("robots/arm7.urdf", "ROBOT")
}

#[test]
fn a_rename_reaches_the_missions_that_run_the_spec() {
    let folder = Folder::new("workers_rename");
    let day = SPEC.replace("picker.hq", "own.hq");
    folder.write("day.hq", &day);
    folder.write("own.hq", &picker());
    let mut e = Editor::ready_in(&folder.0);
    let (own, doc) = folder.open(&mut e, "own.hq");
    for (place, new, old, expected) in [
        ("state |carry", "bring", "in(w1.carry)", "in(w1.bring)"),
        ("signal |box_in_place", "box_there", "go box_in_place", "go box_there"),
    ] {
        let answer = rename(&mut e, &doc, &find(&own, place), new);
        let changes = &answer["result"]["changes"];
        let text = edited(&day, &changes[&folder.uri("day.hq")]);
        assert_eq!(text, day.replace(old, expected), "{answer}");
        assert!(changes[&doc].as_array().is_some_and(|edits| edits.len() > 1), "{answer}");
    }
}
