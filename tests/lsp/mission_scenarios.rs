//! Language server: scenarios of missions, with the mission, the named members, and their quantities.

use serde_json::Value as Json;

use super::document::Document;

const SPEC: &str = r#"hierarq 1

// All rows.
mission vineyard : schedule {
  // The first.
  robot m1 { depot [-10.4, 7] m  speed 0.2 m/s  serve 20 s }
  robot m2 { depot [-8.4, 7] m  speed 0.1 m/s  serve 20 s }
  // She picks.
  human anna { place [1, -1.375] m  duration normal(204 s, 20.4 s) }
  worker w1 { place [2.3, -15.125] m  duration 250 s }
}

scenario slow {
  mission vineyard
  duration 2000 s
  travel bases
  happens [{ at 120 s  late anna  by 60 s }, { at 300 s  lost m2 }]
  feedback { anna { wait too_long } }
  expect eventually done
  expect always vineyard.makespan < 1800 s
  expect always (anna.waited < 300 s and distance(m1, w1) >= 0 m)
}
"#;

fn opened() -> Document {
    Document::open("lsp_mission_scenario.hq", SPEC)
}

#[test]
fn hover_and_definition() {
    let mut doc = opened();
    assert_eq!(doc.diagnostics(), Vec::<Json>::new());
    doc.hovers(&[
        ("  trav|el bases", "travel", "wheeled bases"),
        ("  happ|ens", "happens", "each at its time"),
        ("late an|na", "anna", "She picks."),
        ("mission vine|yard\n", "vineyard", "All rows."),
    ]);
    doc.definitions(&[
        ("  mission vine|yard\n", "mission |vineyard :"),
        ("late an|na", "human |anna"),
        ("lost m|2", "robot |m2"),
        ("feedback { an|na", "human |anna"),
        ("(an|na.waited", "human |anna"),
        ("distance(m|1", "robot |m1"),
        ("vine|yard.makespan", "mission |vineyard :"),
    ]);
}

#[test]
fn references_and_rename() {
    let mut doc = opened();
    for (place, old, new) in
        [("human |anna", "anna", "bert"), ("lost |m2", "m2", "second"), ("|vineyard.makespan", "vineyard", "rows")]
    {
        let (renamed, edits) = doc.renamed(place, old, new);
        assert!(!renamed.contains(old) && edits > 1, "{place}:\n{renamed}");
    }
}

#[test]
fn completion() {
    let mut doc = opened();
    doc.completions(&[
        ("  travel bases\n", "  |\n", &["travel", "replan", "step"], &["push", "machine", "mission"]),
        ("travel bases", "travel |", &["bases", "planned"], &["sampled"]),
        ("  mission vineyard\n", "  mission |\n", &["vineyard"], &["anna"]),
        ("late anna", "late |", &["anna", "w1", "m1"], &["vineyard"]),
        ("lost m2 }", "lost m2  | }", &["to", "wait"], &["at", "lost"]),
        ("feedback { anna {", "feedback { | {", &["anna"], &["w1", "m1"]),
        ("wait too_long", "wait |", &["too_short", "ok"], &["close"]),
        ("(anna.waited", "(anna.|", &["waited", "served"], &["travelled", "makespan"]),
        ("vineyard.makespan", "vineyard.|", &["makespan", "done"], &["waited"]),
        ("eventually done", "eventually |", &["done", "anna", "vineyard"], &["margin"]),
        ("distance(m1, w1)", "distance(m1, |)", &["m2", "anna"], &["vineyard"]),
    ]);
}

const LAYERS: &str = r#"hierarq 1

// One letter.
mission letter : layers {
  // It picks.
  robot arm { place [0, 0, 0] m  speed [0.1, 0.4] m/s  skills { pick 2 s }  spread 0.05 }
  // She helps.
  human anna { place [1, 0, 0] m  speed 0.5 m/s  skills { pick 3 s } }
  object red { place [0.3, 0, 0] m  features [cube] }
  layer base { task foot = pick { features [cube]  to [0.4, 0.2, 0] m } }
}

scenario slow {
  mission letter
  duration 60 s
  happens [{ at 1 s  late anna  by 6 s }, { at 3 s  lost arm }]
  expect eventually done
  expect always letter.layer < 9
  expect always (anna.workload < 9 kg s and distance(arm, anna) >= 0 m and arm.energy >= 0 J)
}
"#;

#[test]
fn scenarios_of_layers() {
    let mut doc = Document::open("lsp_layers_scenario.hq", LAYERS);
    assert_eq!(doc.diagnostics(), Vec::<Json>::new());
    doc.hovers(&[("  spr|ead", "spread", "operations sampled"), ("late an|na", "anna", "She helps.")]);
    doc.definitions(&[
        ("lost a|rm", "robot |arm"),
        ("(an|na.workload", "human |anna"),
        ("distance(a|rm", "robot |arm"),
        ("let|ter.layer", "mission |letter :"),
    ]);
    doc.completions(&[
        ("skills { pick 3 s } }", "skills { pick 3 s }  | }", &["spread", "reach"], &["factor"]),
        ("late anna", "late |", &["anna", "arm"], &["red", "foot", "letter"]),
        ("  duration 60 s\n", "  |\n", &["operations", "replan", "step"], &["travel", "feedback", "push"]),
        ("lost arm }", "| }", &["lost", "failed", "by"], &["moved", "served", "begun", "wait", "to"]),
        ("(anna.workload", "(anna.|", &["workload", "tasks"], &["waited", "energy", "layer"]),
        ("arm.energy", "arm.|", &["energy", "worked"], &["workload", "served"]),
        ("letter.layer", "letter.|", &["layer", "dropped"], &["workloads", "served"]),
        ("distance(arm, anna)", "distance(arm, |)", &["anna"], &["letter"]),
    ]);
    let mut doc = Document::open("lsp_layers_renamed.hq", LAYERS);
    for (place, old, new) in [("human |anna", "anna", "bert"), ("distance(|arm", "arm", "hand")] {
        let (renamed, edits) = doc.renamed(place, old, new);
        assert!(!renamed.contains(old) && edits > 1, "{place}:\n{renamed}");
    }
}
