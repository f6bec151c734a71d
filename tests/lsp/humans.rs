//! What the server says about humans and their points.

use serde_json::json;

use super::common;
use super::editor::{Editor, edited, find, labels, position, under, uri};

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

fn opened() -> (Editor, String) {
    let (mut e, doc) = (Editor::ready(), uri("lsp_human.hq"));
    e.open(&doc, "hierarq", HUMANS);
    (e, doc)
}

#[test]
fn hover_and_definition() {
    let (mut e, doc) = opened();
    assert!(e.diagnostics(&doc, Some(1)).is_empty());
    for (place, range, says) in [
        ("|human operator", "human", "whose points are tracked"),
        ("- oper|ator.hand", "operator", "Who works here. 🤖 ü"),
        ("operator.ha|nd)) { min 0.3", "hand", "point of a human `hand`"),
        ("lo|st hold", "lost", "readings stop"),
        ("uncer|tainty(operator)", "uncertainty", "nobody sees"),
        ("sha|pe {", "shape", "Where each point is"),
        ("  humans { oper|ator {", "operator", "Who works here"),
    ] {
        let hover = e.at("textDocument/hover", &doc, &find(HUMANS, place));
        assert!(!hover.is_null(), "{place}");
        assert_eq!(under(HUMANS, &hover["range"]), range, "{place}: {hover}");
        assert!(hover["contents"]["value"].as_str().is_some_and(|v| v.contains(says)), "{place}: {hover}");
    }
    for (from, to) in [
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
    ] {
        let place = e.at("textDocument/definition", &doc, &find(HUMANS, from));
        assert_eq!(place["range"]["start"], find(HUMANS, to), "{from}: {place}");
    }
}

#[test]
fn references_and_rename() {
    let (mut e, doc) = opened();
    let mut all = |place: &str| {
        let params = json!({
            "textDocument": { "uri": doc }, "position": find(HUMANS, place), "context": { "includeDeclaration": true },
        });
        e.result("textDocument/references", params).as_array().map_or(0, Vec::len)
    };
    assert_eq!((all("human |operator"), all("points [|chest"), all("[chest, |hand]\n  links")), (9, 5, 6));
    for (place, old, new) in [
        ("human |operator", "operator", "helper"),
        ("[chest, |hand]\n  links", "hand", "wrist"),
        ("shape { che|st", "chest", "heart"),
    ] {
        let position = find(HUMANS, place);
        let params = json!({ "textDocument": { "uri": doc }, "position": position, "newName": new });
        let answer = e.ask("textDocument/rename", params);
        let renamed = edited(HUMANS, &answer["result"]["changes"][&doc]);
        let words: Vec<&str> = renamed.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).collect();
        assert!(!words.contains(&old), "{place}: {answer}\n{renamed}");
        let (before, after) = (common::program_of(HUMANS), common::program_of(&renamed));
        assert_eq!((before.tasks, before.values), (after.tasks, after.values), "the same tasks");
    }
    for (place, new) in [("points [|chest", "hand"), ("human |operator", "present")] {
        let params = json!({ "textDocument": { "uri": doc }, "position": find(HUMANS, place), "newName": new });
        assert_eq!(e.ask("textDocument/rename", params)["error"]["code"], -32803, "{place} -> {new}");
    }
}

#[test]
fn completion() {
    let (mut e, doc) = opened();
    let mut version = 1;
    for (old, new, has, has_not) in [
        (
            "- operator.hand)) { min 0.3 m + u",
            "- operator.|)) { min 0.3 m + u",
            &["chest", "hand"][..],
            &["velocity", "norm"][..],
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
    ] {
        assert_eq!(HUMANS.matches(old).count(), 1, "{old}");
        let marked = HUMANS.replacen(old, new, 1);
        let cursor = marked.find('|').expect("a cursor");
        let text = marked.replacen('|', "", 1);
        version += 1;
        e.change(&doc, version, json!([{ "text": text }]));
        let offered = labels(&e.at("textDocument/completion", &doc, &position(&text, cursor)));
        for label in has {
            assert!(offered.iter().any(|o| o == label), "{new}: no `{label}` in {offered:?}");
        }
        for label in has_not {
            assert!(!offered.iter().any(|o| o == label), "{new}: `{label}` in {offered:?}");
        }
    }
}

#[test]
fn the_outline_has_the_points() {
    let (mut e, doc) = opened();
    let symbols = e.result("textDocument/documentSymbol", json!({ "textDocument": { "uri": doc } }));
    let human =
        symbols.as_array().and_then(|s| s.iter().find(|s| s["name"] == "operator")).cloned().unwrap_or_default();
    let points: Vec<&str> =
        human["children"].as_array().map_or(Vec::new(), |c| c.iter().filter_map(|p| p["name"].as_str()).collect());
    assert_eq!((human["detail"].as_str(), points), (Some("human"), vec!["chest", "hand"]));
}

#[test]
fn yaml_has_the_same() {
    let (tree, diagnostics) = dsl::parse(dsl::SourceId(0), HUMANS, dsl::Spelling::Hq);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    let text = dsl::print(&tree, dsl::Spelling::Yaml);
    let (mut e, doc) = (Editor::ready(), uri("lsp_human.yaml"));
    e.open(&doc, "yaml", &text);
    assert!(e.diagnostics(&doc, Some(1)).is_empty());
    for (from, to) in [
        ("- operator.ha|nd", "points: [chest, |hand]"),
        ("uncertainty(oper|ator", "|operator: { points"),
        ("shape: { che|st", "points: [|chest"),
    ] {
        let place = e.at("textDocument/definition", &doc, &find(&text, from));
        assert_eq!(place["range"]["start"], find(&text, to), "{from}: {place}\n{text}");
    }
    for (version, old, new, has) in [
        (2, "lost: hold", "lost: |", "fault"),
        (3, "lost: hold }", "| }", "growth"),
        (4, "uncertainty(operator)", "uncertainty(|)", "operator"),
    ] {
        let marked = text.replacen(old, new, 1);
        let cursor = marked.find('|').expect("a cursor");
        let changed = marked.replacen('|', "", 1);
        e.change(&doc, version, json!([{ "text": changed }]));
        let offered = labels(&e.at("textDocument/completion", &doc, &position(&changed, cursor)));
        assert!(offered.iter().any(|o| o == has), "{new}: no `{has}` in {offered:?}");
    }
}
