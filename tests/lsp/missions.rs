//! Language server: missions, with their kinds, members, settings, and the names of members.

use serde_json::{Value as Json, json};

use super::document::Document;
use super::editor::under;

const SPEC: &str = r#"hierarq 1

param pace = 0.2 m/s

// Two carriers.
mission vineyard : schedule {
  confidence 0.9
  weights { worker_wait 1  energy 1 }
  distances {
    m1 { anna 12 m  w1 15 m  w2 9 m  w3 9 m  w4 9 m }
    m2 { anna 11 m  w1 14 m  w2 8 m  w3 8 m  w4 8 m }
  }

  // The first.
  robot m1 { depot [-10.4, 7] m  speed [0.05 m/s, pace]  serve 20 s }
  robot m2 { depot [-8.4, 7] m  speed 0.1 m/s  serve 20 s }
  human anna { place [1, -1.375] m  duration normal(204 s, 20.4 s)  severity 0.5  approaches { m2 { speed 0.1 m/s } } }
  worker w1 { place [2.3, -15.125] m  duration 250 s }

  for i in 2..4 {
    worker w${i} { place [2*i, -15] m  duration 250 s }
  }
}
"#;

fn opened() -> Document {
    Document::open("lsp_mission.hq", SPEC)
}

#[test]
fn hover_and_definition() {
    let mut doc = opened();
    assert_eq!(doc.diagnostics(), Vec::<Json>::new());
    doc.hovers(&[
        ("|mission viney", "mission", "hierarq plan"),
        ("mission vine|yard", "vineyard", "Two carriers."),
        (" : sche|dule", "schedule", "Who serves whom"),
        ("  confi|dence", "confidence", "probability"),
        ("worker_|wait", "worker_wait", "Of the waits"),
        ("  |robot m1", "robot", "that serves"),
        ("m|1 { anna", "m1", "The first."),
        ("  |human anna", "human", "who is served"),
        ("seve|rity 0.5", "severity", "working conditions"),
    ]);
    doc.definitions(&[
        ("m|1 { anna", "robot |m1"),
        ("m1 { an|na", "human |anna"),
        ("approaches { m|2", "robot |m2"),
        ("m/s, pa|ce]", "param |pace"),
        ("[2*|i, -15]", "for |i in"),
    ]);
}

#[test]
fn references_and_rename() {
    let mut doc = opened();
    assert_eq!(doc.references("robot |m1", true), 2);
    assert_eq!(doc.references("human |anna", false), 2);
    for (place, old, new) in [
        ("robot |m1", "m1", "first"),
        ("approaches { |m2", "m2", "second"),
        ("human |anna", "anna", "bert"),
        ("mission |vineyard", "vineyard", "rows"),
        ("param |pace", "pace", "fastest"),
    ] {
        let (renamed, edits) = doc.renamed(place, old, new);
        assert!(!renamed.contains(old) && edits > 0, "{place}:\n{renamed}");
    }
}

#[test]
fn the_same_in_yaml() {
    let mut doc = Document::open_in_yaml("lsp_mission.yaml", SPEC);
    assert_eq!(doc.diagnostics(), Vec::<Json>::new());
    doc.hovers(&[
        ("  sche|dule:", "schedule", "Who serves whom"),
        ("  rob|ots:", "robots", "by name"),
        ("  work|ers:\n        w1", "workers", "by name"),
        ("m|1: { anna", "m1", "The first."),
    ]);
    doc.definitions(&[("m|1: { anna", "|m1: { depot"), ("m1: { an|na", "|anna:\n")]);
    assert_eq!(doc.references("approaches: { |m2", true), 3);
}

#[test]
fn completion() {
    let mut doc = opened();
    doc.completions(&[
        ("  confidence 0.9\n", "  |\n", &["batch", "robot", "worker"], &["weights", "robots", "depot"]),
        ("mission vineyard : schedule", "mission vineyard : |", &["schedule"], &["robot"]),
        ("weights { worker_wait 1  energy 1 }", "weights { | }", &["makespan", "energy"], &["robot"]),
        ("speed 0.1 m/s  serve 20 s", "speed 0.1 m/s  serve 20 s  |", &["factor", "deposit"], &["serve", "place"]),
        ("    m2 { anna", "    | { anna", &["m2"], &["anna", "confidence"]),
        ("[0.05 m/s, pace]", "[0.05 m/s, |]", &["pace"], &[]),
    ]);
    let mut yaml = Document::open_in_yaml("lsp_mission_2.yaml", SPEC);
    yaml.completions(&[
        ("      confidence: 0.9\n", "      |\n", &["batch", "robots"], &["weights", "robot"]),
        ("severity: 0.5\n", "severity: 0.5\n          |\n", &["operations"], &["place", "severity"]),
    ]);
}

#[test]
fn outline() {
    let mut doc = opened();
    let symbols = doc.whole("textDocument/documentSymbol");
    let mission = &symbols.as_array().expect("symbols")[1];
    assert_eq!((&mission["name"], &mission["detail"]), (&json!("vineyard"), &json!("mission, schedule")));
    let inside: Vec<&str> =
        mission["children"].as_array().expect("members").iter().filter_map(|s| s["name"].as_str()).collect();
    assert_eq!(inside, ["m1", "m2", "anna", "w1", "i"]);
    assert_eq!(under(SPEC, &mission["children"][4]["children"][0]["selectionRange"]), "w${i}");
}

const JOB: &str = r#"hierarq 1

mission job : layers {
  // Where boxes wait.
  place shelf { at [1, 0, 0] m }
  place table { at [0, 1, 0] m }
  robot arm { place [0, 0, 0] m  speed 0.1 m/s  skills { pick 2 s } }
  object box { place shelf  features [box] }

  layer only {
    task bring = pick { features [box]  via [shelf, [0, 0, 1] m]  to table }
  }
}
"#;

#[test]
fn places_of_a_job() {
    let mut doc = Document::open("lsp_job.hq", JOB);
    assert_eq!(doc.diagnostics(), Vec::<Json>::new());
    doc.hovers(&[("box { place sh|elf", "shelf", "Where boxes wait.")]);
    doc.definitions(&[("via [sh|elf", "place |shelf { at"), ("to tab|le", "place |table { at")]);
    assert_eq!(doc.references("place |shelf { at", true), 3);
    let (renamed, edits) = doc.renamed("place |shelf { at", "shelf", "rack");
    assert!(!renamed.contains("shelf") && edits == 3, "{renamed}");
    doc.completions(&[
        ("to table", "to |", &["shelf", "table"], &["arm", "box"]),
        ("via [shelf,", "via [|,", &["shelf", "table"], &["arm"]),
        ("box { place shelf", "box { place |", &["shelf", "table"], &["arm"]),
    ]);
}
