//! What the server says about safety fields.

use serde_json::json;

use super::common;
use super::editor::{Editor, edited, find, labels, position, under, uri};

const FIELDS: &str = r#"hierarq 1

robot arm {
  urdf "robots/arm7.urdf"
  rate 100 Hz
  home { joint_2 0.4 rad  joint_4 1.6 rad  joint_6 1.1 rad }
  arms { only { tip tool } }
}

human operator { points [chest, hand] }

// How far all of the arm is. 🤖
safety_field nearness {
  of [operator.chest, operator.hand]
  links only
  points minimum
}

task apart = keep(field(nearness)) { min 0.3 m }

stack work { level people { apart } }

scenario calm {
  stack work
  duration 1 s
  humans { operator { value [2, 0, 0] m  shape { chest [0, 0, 1.2] m  hand [0, 0, 0.9] m } } }
  expect always field(nearness) > 1 m
}

run { stack work  duration 1 s }
"#;

fn opened() -> (Editor, String) {
    let (mut e, doc) = (Editor::ready(), uri("lsp_field.hq"));
    e.open(&doc, "hierarq", FIELDS);
    (e, doc)
}

#[test]
fn hover_and_definition() {
    let (mut e, doc) = opened();
    assert!(e.diagnostics(&doc, Some(1)).is_empty());
    for (place, range, says) in [
        ("saf|ety_field", "safety_field", "read as `field(NAME)`"),
        ("keep(field(near|ness", "nearness", "How far all of the arm is. 🤖"),
        ("keep(fie|ld(", "field", "value of a safety field"),
        ("  li|nks only", "links", "the whole robot"),
        ("links on|ly", "only", "arm"),
        ("of [oper|ator", "operator", "human"),
    ] {
        let hover = e.at("textDocument/hover", &doc, &find(FIELDS, place));
        assert!(!hover.is_null(), "{place}");
        assert_eq!(under(FIELDS, &hover["range"]), range, "{place}: {hover}");
        assert!(hover.to_string().contains(says), "{place}: {hover}");
    }
    for (from, to) in [
        ("expect always field(near|ness", "safety_field |nearness"),
        ("links on|ly", "arms { |only"),
        ("[operator.ch|est", "points [|chest"),
    ] {
        let place = e.at("textDocument/definition", &doc, &find(FIELDS, from));
        assert_eq!(place["range"]["start"], find(FIELDS, to), "{from}: {place}");
    }
}

#[test]
fn completion_offers_fields_words_and_links() {
    let (mut e, doc) = opened();
    let mut version = 1;
    for (old, new, has, has_not) in [
        ("keep(field(nearness))", "keep(field(|))", &["nearness"][..], &["operator"][..]),
        ("points minimum", "points |", &["mean", "minimum", "soft_minimum"], &["nearness"]),
        ("  links only\n", "  links |\n", &["only", "link_3"], &["joint_1"]),
        ("  links only\n", "  |\n", &["links", "distance"], &["of", "timeout"]),
    ] {
        let marked = FIELDS.replacen(old, new, 1);
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
fn references_and_rename() {
    let (mut e, doc) = opened();
    let position = find(FIELDS, "safety_field near|ness");
    let params = json!({
        "textDocument": { "uri": doc }, "position": position, "context": { "includeDeclaration": true },
    });
    assert_eq!(e.result("textDocument/references", params).as_array().map_or(0, Vec::len), 3);
    let params = json!({ "textDocument": { "uri": doc }, "position": position, "newName": "room" });
    let answer = e.ask("textDocument/rename", params);
    let renamed = edited(FIELDS, &answer["result"]["changes"][&doc]);
    assert!(!renamed.contains("nearness") && renamed.contains("field(room)"), "{renamed}");
    let (before, after) = (common::program_of(FIELDS), common::program_of(&renamed));
    assert_eq!((before.fields[0].points.clone(), before.values), (after.fields[0].points.clone(), after.values));
    let params = json!({ "textDocument": { "uri": doc }, "position": position, "newName": "operator" });
    assert_eq!(e.ask("textDocument/rename", params)["error"]["code"], -32803, "a human has that name");
}
