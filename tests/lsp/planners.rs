//! What the server says about safety planners: the task that one protects, its field, and what it tells.

use serde_json::json;

use super::common;
use super::editor::{Editor, edited, find, labels, position, under, uri};

const SPEC: &str = r#"hierarq 1

robot arm {
  urdf "robots/arm7.urdf"
  rate 100 Hz
  home { joint_2 0.4 rad  joint_4 1.6 rad  joint_6 1.1 rad }
  points { tip tool }
}

human walker { points [chest] }

// How far away people are.
safety_field nearness { of walker }

// To and fro.
task reach = frame_position(tool) { position initial(position) + [0, 0.1, 0] m * sin(t/(1 s)) }
task separation = speed_separation(tip) { from walker.chest  reaction 0.1 s  deceleration 3 m/s^2  intrusion 0.1 m }
task guard = safety_planner(reach) {
  field nearness
  min 0.5 m
  deviate { position { speed 0.4 m/s  most 0.2 m } }
}

stack work { level people { separation }  level motion { reach }  level internal { guard } }

scenario calm {
  duration 1 s
  humans { walker { value [2, 0, 1] m } }
  expect always guard.scaling > 0.5
  expect always separation.room > 0 m
}
"#;

fn opened() -> (Editor, String) {
    let (mut e, doc) = (Editor::ready(), uri("lsp_planner.hq"));
    e.open(&doc, "hierarq", SPEC);
    (e, doc)
}

#[test]
fn hover_and_definition() {
    let (mut e, doc) = opened();
    assert!(e.diagnostics(&doc, Some(1)).is_empty());
    for (place, range, says) in [
        ("safety_planner(rea|ch)", "reach", "To and fro."),
        ("  field near|ness", "nearness", "How far away people are."),
        ("mo|st 0.2 m", "most", "greatest deviation"),
        ("always gua|rd.scaling", "guard", "task"),
        ("guard.scal|ing > 0.5", "scaling", "how fast the clock goes"),
        ("separation.ro|om >", "room", "it is to stand"),
    ] {
        let hover = e.at("textDocument/hover", &doc, &find(SPEC, place));
        assert!(!hover.is_null(), "{place}");
        assert_eq!(under(SPEC, &hover["range"]), range, "{place}: {hover}");
        assert!(hover["contents"]["value"].as_str().is_some_and(|v| v.contains(says)), "{place}: {hover}");
    }
    for (from, to) in [
        ("safety_planner(rea|ch)", "task |reach"),
        ("  field near|ness", "safety_field |nearness"),
        ("always gua|rd.scaling", "task |guard"),
        ("always separ|ation.room", "task |separation"),
    ] {
        let found = e.at("textDocument/definition", &doc, &find(SPEC, from));
        assert_eq!(found["range"]["start"], find(SPEC, to), "{from}: {found}");
    }
}

#[test]
fn rename() {
    let (mut e, doc) = opened();
    for (place, old, new) in [("task |reach", "reach", "move"), ("safety_field |nearness", "nearness", "room")] {
        let params = json!({ "textDocument": { "uri": doc }, "position": find(SPEC, place), "newName": new });
        let answer = e.ask("textDocument/rename", params);
        let renamed = edited(SPEC, &answer["result"]["changes"][&doc]);
        assert!(!renamed.contains(old), "{place}: {answer}\n{renamed}");
        common::program_of(&renamed);
    }
}

#[test]
fn completion() {
    let (mut e, doc) = opened();
    let mut version = 1;
    for (old, new, has) in [
        ("safety_planner(reach)", "safety_planner(|)", "reach"),
        ("  field nearness", "  field |", "nearness"),
        ("  min 0.5 m\n", "  min 0.5 m\n  |\n", "internal"),
        ("guard.scaling", "guard.|", "deviation"),
        ("separation.room", "separation.|", "speed_limit"),
        ("speed 0.4 m/s  most 0.2 m", "speed 0.4 m/s  |", "return"),
    ] {
        assert_eq!(SPEC.matches(old).count(), 1, "{old}");
        let marked = SPEC.replacen(old, new, 1);
        let cursor = marked.find('|').expect("a cursor");
        let text = marked.replacen('|', "", 1);
        version += 1;
        e.change(&doc, version, json!([{ "text": text }]));
        let offered = labels(&e.at("textDocument/completion", &doc, &position(&text, cursor)));
        assert!(offered.iter().any(|o| o == has), "{new}: no `{has}` in {offered:?}");
    }
}
