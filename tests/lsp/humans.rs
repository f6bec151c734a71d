//! Language server: humans and their points.

use super::common;
use super::document::Document;

const HUMANS: &str = r#"hierarq 1

robot arm {
  urdf "robots/arm7.urdf"
  rate 100 Hz
  points { tip tool }
  home { joint_2 0.4 rad  joint_4 1.6 rad  joint_6 1.1 rad }
}

// Who works here. 🤖 ü
human operator {
  points [chest, hand]
  links [[chest, hand]]
  timeout 200 ms
  lost hold
}

task away = keep(norm(frame(tool).position - operator.hand)) { min 0.3 m + uncertainty(operator) }
task slow = keep(norm(frame(tool).position - operator.chest)) { min if(present(operator), 0.3 m, 0.5 m) + 0.1 s * norm(operator.chest.velocity) }

stack work { level people hard { away  slow } }

scenario calm {
  stack work
  duration 1 s
  humans { operator { value [2, 0, 0] m  shape { chest [0, 0, 1.2] m  hand [0, 0, 0.9] m } } }
  expect always norm(operator.hand) > 1 m
  expect always distance(tip, operator.hand) > 0.1 m
}

run { stack work  duration 1 s }
"#;

fn opened() -> Document {
    Document::open("lsp_human.hq", HUMANS)
}

#[test]
fn hover_and_definition() {
    let mut doc = opened();
    assert!(doc.diagnostics().is_empty());
    doc.hovers(&[
        ("|human operator", "human", "whose points are tracked"),
        ("- oper|ator.hand", "operator", "Who works here. 🤖 ü"),
        ("operator.ha|nd)) { min 0.3", "hand", "point of a human `hand`"),
        ("lo|st hold", "lost", "readings stop"),
        ("uncer|tainty(operator)", "uncertainty", "not observed"),
        ("sha|pe {", "shape", "Position of each point"),
        ("  humans { oper|ator {", "operator", "Who works here"),
    ]);
    doc.definitions(&[
        ("- oper|ator.hand", "human |operator"),
        ("- operator.ha|nd", "[chest, |hand]\n  links"),
        ("operator.ch|est.velocity", "points [|chest"),
        ("oper|ator.chest.velocity", "human |operator"),
        ("present(oper|ator)", "human |operator"),
        ("uncertainty(oper|ator)", "human |operator"),
        ("[[che|st, hand]]", "points [|chest"),
        ("shape { che|st", "points [|chest"),
        ("norm(operator.ha|nd) >", "[chest, |hand]\n  links"),
        ("distance(tip, oper|ator.hand)", "human |operator"),
        ("distance(tip, operator.ha|nd)", "[chest, |hand]\n  links"),
    ]);
}

#[test]
fn references_and_rename() {
    let mut doc = opened();
    for (place, uses) in [("human |operator", 9), ("points [|chest", 5), ("[chest, |hand]\n  links", 6)] {
        assert_eq!(doc.references(place, true), uses, "{place}");
    }
    for (place, old, new) in [
        ("human |operator", "operator", "helper"),
        ("[chest, |hand]\n  links", "hand", "wrist"),
        ("shape { che|st", "chest", "heart"),
    ] {
        let (renamed, _) = doc.renamed(place, old, new);
        let (before, after) = (common::program_of(HUMANS), common::program_of(&renamed));
        assert_eq!((before.tasks, before.values), (after.tasks, after.values), "the same tasks");
    }
    doc.refused(&[("points [|chest", "hand"), ("human |operator", "present")]);
}

#[test]
fn completion() {
    let mut doc = opened();
    doc.completions(&[
        (
            "- operator.hand)) { min 0.3 m + u",
            "- operator.|)) { min 0.3 m + u",
            &["chest", "hand"],
            &["velocity", "norm"],
        ),
        ("operator.chest.velocity", "operator.chest.|", &["velocity", "x"], &["hand"]),
        ("uncertainty(operator)", "uncertainty(|)", &["operator"], &["away"]),
        ("present(operator)", "present(|)", &["operator"], &["away"]),
        ("norm(operator.hand)", "norm(|)", &["operator", "frame"], &[]),
        ("distance(tip, operator.hand)", "distance(tip, |)", &["operator", "tip"], &["away"]),
        ("distance(tip, operator.hand)", "distance(tip, operator.|)", &["hand"], &["tip"]),
        ("  lost hold", "  lost |", &["fault", "hold"], &["measured"]),
        ("  lost hold", "  |", &["lost", "velocity", "growth"], &["timeout", "rate"]),
        ("[[chest, hand]]", "[[chest, |]]", &["chest", "hand"], &["tool"]),
        ("value [2, 0, 0] m  shape", "|  shape", &["path", "file", "noise"], &["shape", "points_of"]),
        ("shape { chest [0, 0, 1.2] m", "shape { | [0, 0, 1.2] m", &["chest"], &["noise"]),
    ]);
}

#[test]
fn the_outline_has_the_points() {
    let mut doc = opened();
    let symbols = doc.whole("textDocument/documentSymbol");
    let human =
        symbols.as_array().and_then(|s| s.iter().find(|s| s["name"] == "operator")).cloned().unwrap_or_default();
    let points: Vec<&str> =
        human["children"].as_array().map_or(Vec::new(), |c| c.iter().filter_map(|p| p["name"].as_str()).collect());
    assert_eq!((human["detail"].as_str(), points), (Some("human"), vec!["chest", "hand"]));
}

#[test]
fn yaml_has_the_same() {
    let mut doc = Document::open_in_yaml("lsp_human.yaml", HUMANS);
    assert!(doc.diagnostics().is_empty());
    doc.definitions(&[
        ("- operator.ha|nd", "points: [chest, |hand]"),
        ("uncertainty(oper|ator", "|operator: { points"),
        ("shape: { che|st", "points: [|chest"),
    ]);
    doc.completions(&[
        ("lost: hold", "lost: |", &["fault"], &[]),
        ("lost: hold }", "| }", &["growth"], &[]),
        ("uncertainty(operator)", "uncertainty(|)", &["operator"], &[]),
    ]);
}
