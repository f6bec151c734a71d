//! What the server says about words: hover, completion, definitions, references, rename.

use serde_json::{Value as Json, json};

use crate::common;
use crate::editor::{Editor, edited, find, labels, position, spec, text, under, uri};

#[test]
fn hover_explains_every_kind_of_word() {
    let mut e = Editor::ready();
    let (text, doc) = (spec(), uri("lsp_test.hq"));
    e.open(&doc, "hierarq", &text);
    for (place, range, says) in [
        ("= virtual|_wall", "virtual_wall", "thesis (3.17)"),
        ("d_|min reach", "d_min", "default `0 m`"),
        ("rad  joint|_4 1", "joint_4", "revolute"),
        ("d_min re|ach", "reach", "How near it may come. 🤖 ü"),
        ("duration 1 |s", "s", "time"),
        ("points el|bow", "elbow", "elbow link_4"),
        ("tip |link_7", "link_7", "link `link_7`"),
        ("* si|n(", "sin", "sin(angle)"),
        ("(t| /", "t", "stack became active"),
        ("rate| 100", "rate", "0.1 Hz"),
        ("keep |hard", "hard", "no slack"),
        ("go we|ight", "weight", "default `1`"),
        ("level move { g|o", "go", "task go = frame_position(only)"),
        ("run { stack wo|rk", "work", "level keep hard"),
        ("|task limits", "task", "task NAME"),
    ] {
        let hover = e.at("textDocument/hover", &doc, &find(&text, place));
        assert_eq!(under(&text, &hover["range"]), range, "{place}: {hover}");
        let value = hover["contents"]["value"].as_str().expect("Markdown");
        assert!(value.contains(says), "{place}:\n{value}");
    }
    assert_eq!(e.at("textDocument/hover", &doc, &find(&text, "|// How near")), Json::Null);
}

#[test]
fn completion_offers_what_can_stand_there() {
    let mut e = Editor::ready();
    let doc = uri("lsp_test.hq");
    e.open(&doc, "hierarq", "");
    let whole = spec();
    let mut version = 1;
    // What is replaced, by what (`|` is the cursor), what must be offered, and what must not.
    for (old, new, has, has_not) in [
        ("{ points elbow", "{ | points elbow", &["gain", "on"][..], &["through", "points", "d_min", "urdf"][..]),
        ("= virtual_wall", "= vir|", &["virtual_wall", "hold"], &["gain"]),
        ("points elbow", "points |", &["elbow", "arms", "arms.only", "link_4"], &["joint_1"]),
        ("tip link_7", "tip |", &["link_7"], &["elbow", "joint_1"]),
        ("home { joint_2", "home { |  joint_2", &["joint_1", "all_of_it"], &["joint_2", "link_1"]),
        ("gain 5 /s", "gain 5 /|", &["s", "min"], &["gain"]),
        ("gain 5 /s", "gain 5 |", &["Hz"], &["gain"]),
        ("rate 100 Hz", "rate 100 Hz\n  |", &["base", "lock"], &["rate", "home", "gain"]),
        ("rate 100 Hz", "base un|", &["unicycle", "fixed"], &["joint_1"]),
        ("{ limits deck", "{ limits |", &["go", "deck", "hold"], &["work", "gain"]),
        ("stack work  dur", "stack |  dur", &["work"], &["go"]),
        ("run { ", "run { so|\n  ", &["solver", "simulator"], &["stack", "rate"]),
        ("d_min reach * 0", "d_min re|", &["reach", "sin", "t"], &["elbow", "gain"]),
        ("initial(frame(only).position)", "initial(|)", &["position", "frame", "distance", "com", "norm"], &["reach"]),
        ("initial(frame(only).position)", "initial(norm(|))", &["com", "point", "reach"], &["gain"]),
        ("initial(frame(only).position)", "initial(distance(|, link_2))", &["elbow", "link_4"], &["com"]),
        ("initial(frame(only).position)", "initial(frame(only).|)", &["position", "orientation", "pose"], &["frame"]),
        ("frame_position(only)", "frame_position(|)", &["only", "link_7"], &["joint_1"]),
        ("(only) { position", "(only) { |  position", &["gain"], &["frame", "position"]),
        ("level keep hard", "level keep |hard", &["damping"], &["gain"]),
        ("param reach = 0.4 m", "par|", &["param", "task", "robot"], &["gain"]),
        ("🤖 ü", "🤖 ü |", &[], &["param", "task"]),
    ] {
        assert_eq!(whole.matches(old).count(), 1, "{old}");
        let marked = whole.replacen(old, new, 1);
        let cursor = marked.find('|').expect("a cursor");
        let text = marked.replacen('|', "", 1);
        version += 1;
        e.change(&doc, version, json!([{ "text": text }]));
        let items = e.at("textDocument/completion", &doc, &position(&text, cursor));
        let offered = labels(&items);
        for label in has {
            assert!(offered.iter().any(|o| o == label), "{new}: no `{label}` in {offered:?}");
        }
        for label in has_not {
            assert!(!offered.iter().any(|o| o == label), "{new}: `{label}` in {offered:?}");
        }
        // What is inserted replaces the word before the cursor.
        if let Some(first) = items.as_array().and_then(|i| i.first()) {
            let word = text[..cursor].trim_end_matches(|c: char| c.is_ascii_alphanumeric() || c == '_');
            assert_eq!(under(&text, &first["textEdit"]["range"]), &text[word.len()..cursor], "{new}");
        }
    }
    // Parameters come with their documents, the required ones first.
    let text = whole.replacen("{ points elbow", "{  points elbow", 1).replace("through", "thruogh");
    e.change(&doc, 99, json!([{ "text": text }]));
    let items = e.at("textDocument/completion", &doc, &find(&text, "virtual_wall { | points"));
    let items = items.as_array().expect("a list");
    let item = |label: &str| items.iter().find(|i| i["label"] == label).expect("offered").clone();
    assert!(item("through")["sortText"].as_str() < item("gain")["sortText"].as_str());
    assert!(item("gain")["documentation"]["value"].as_str().is_some_and(|d| d.contains("how fast")), "{items:?}");
}

/// Expressions of the robot's state: words in them have the meaning that they have elsewhere.
const OWN: &str = r#"hierarq 1

param distance = 0.3 m

robot arm {
  urdf "robots/arm7.urdf"
  rate 100 Hz
  arms { only { tip link_7 } }
  points { elbow link_4  wrist link_6 }
  home { joint_2 0.4 rad  joint_4 1.6 rad  joint_6 1.1 rad }
}

task gap = keep(distance(elbow, base_link) + 0*norm(frame(only).position), min: distance, gain: 5 /s)

task turn = track(if(joint(joint_2) < 1 rad, joint(joint_4), 2 rad)) { target initial(value) }

task deck = keep(distance(wrist, plane([0, 0, -1] m in only, [0, 0, 1]))) { min -1 m  max initial(norm(com)) + 9 m }

stack work { level keep hard { gap  deck }  level move { turn } }
"#;

#[test]
fn expressions_of_the_state() {
    let mut e = Editor::ready();
    let doc = uri("lsp_own.hq");
    e.open(&doc, "hierarq", OWN);
    for (place, says) in [
        ("gap = keep(dist|ance(", "between points, segments and shapes"),
        ("frame(on|ly)", "tip link_7"),
        ("min: dis|tance", "0.3 m"),
        ("m|in: distance", "smallest"),
        ("joint(join|t_2)", "revolute"),
        ("track(i|f(", "condition"),
        ("= tra|ck(", "thesis (2.5)"),
        ("pla|ne(", "its normal"),
        ("m in on|ly", "tip link_7"),
        ("norm(co|m)", "centre of mass"),
        ("initi|al(norm", "becomes active"),
        ("distance(wri|st, plane", "wrist link_6"),
    ] {
        let hover = e.at("textDocument/hover", &doc, &find(OWN, place));
        assert!(hover["contents"]["value"].as_str().is_some_and(|v| v.contains(says)), "{place}: {hover}");
    }
    for (from, to) in [
        ("distance(el|bow", "points { |elbow"),
        ("frame(on|ly)", "arms { |only"),
        ("min: dis|tance", "param |distance"),
        ("m in on|ly", "arms { |only"),
        ("distance(wri|st, plane", "link_4  |wrist"),
    ] {
        let place = e.at("textDocument/definition", &doc, &find(OWN, from));
        assert_eq!(place["range"]["start"], find(OWN, to), "{from}");
    }
    let params = json!({
        "textDocument": { "uri": doc }, "position": find(OWN, "points { el|bow"), "newName": "hinge",
    });
    let answer = e.ask("textDocument/rename", params);
    let renamed = edited(OWN, &answer["result"]["changes"][&doc]);
    assert!(renamed.contains("keep(distance(hinge, base_link)"), "{renamed}");
    assert_eq!(common::program_of(OWN).values, common::program_of(&renamed).values);
    for (version, old, new, has, has_not) in [
        (2, "min: distance, gain", "|, gain", "min", "frame"),
        (3, "frame(only).position", "frame(|).position", "only", "joint_1"),
        (4, "frame(only).position", "frame(only).|", "orientation", "gain"),
        (5, "joint(joint_4)", "|", "frame", "gain"),
        (6, "distance(elbow, base_link)", "distance(elbow, |)", "wrist", "joint_1"),
        (7, "target initial(value)", "target initial(|)", "value", "gain"),
        (8, "target initial(value)", "tar|", "target", "frame"),
        (9, "joint(joint_4)", "co|", "com", "gain"),
        (10, "norm(com)", "|", "com", "gain"),
        (11, "plane([0, 0, -1] m in only, [0, 0, 1])", "|", "elbow", "joint_1"),
    ] {
        let marked = OWN.replacen(old, new, 1);
        let cursor = marked.find('|').expect("a cursor");
        let changed = marked.replacen('|', "", 1);
        e.change(&doc, version, json!([{ "text": changed }]));
        let items = e.at("textDocument/completion", &doc, &position(&changed, cursor));
        let offered = labels(&items);
        assert!(offered.iter().any(|o| o == has), "{new}: no `{has}` in {offered:?}");
        assert!(!offered.iter().any(|o| o == has_not), "{new}: `{has_not}` in {offered:?}");
        if has == "min" {
            let item = items.as_array().expect("a list").iter().find(|i| i["label"] == "min").expect("offered");
            assert_eq!(item["textEdit"]["newText"], "min: ");
        }
    }
}

#[test]
fn yaml_has_the_same() {
    let mut e = Editor::ready();
    let (text, doc) = (text("../tests/corpus/specs/cooperative_motion.yaml"), uri("lsp_test.yaml"));
    e.open(&doc, "yaml", &text);
    assert_eq!(e.diagnostics(&doc, Some(1)), Vec::<Json>::new());
    let hover = e.at("textDocument/hover", &doc, &find(&text, "deck:\n    virtual|_wall"));
    assert!(hover["contents"]["value"].as_str().is_some_and(|v| v.contains("thesis (3.17)")), "{hover}");
    let place = e.at("textDocument/definition", &doc, &find(&text, "d_min: 0.3 m, gain: 5 /|s"));
    assert_eq!(place, Json::Null, "a unit is declared nowhere");
    let place = e.at("textDocument/definition", &doc, &find(&text, "and: [column, che|st]"));
    assert_eq!(under(&text, &place["range"]), "chest");
    for (version, old, new, has) in [
        (2, "points: arms, through", "po|, through", "points"),
        (3, "rate: 100 Hz\n", "rate: 100 Hz\n    |\n", "tracking_gain"),
        (4, "base: unicycle", "base: |", "planar"),
        (5, "tip: left_tool\n", "tip: |\n", "left_tool"),
        (6, "tasks:\n", "|\n\ntasks:\n", "params"),
        (7, "between: arms, and: head", "between: |, and: head", "arms.left"),
    ] {
        let marked = text.replacen(old, new, 1);
        let cursor = marked.find('|').expect("a cursor");
        let changed = marked.replacen('|', "", 1);
        e.change(&doc, version, json!([{ "text": changed }]));
        let offered = labels(&e.at("textDocument/completion", &doc, &position(&changed, cursor)));
        assert!(offered.iter().any(|o| o == has), "{new}: no `{has}` in {offered:?}");
    }
    // YAML that is no spec is none of our business.
    let other = uri("compose.yaml");
    e.open(&other, "yaml", "services:\n  web: { image: x }\n");
    assert_eq!(e.diagnostics(&other, Some(1)), Vec::<Json>::new());
    let start = json!({ "line": 1, "character": 3 });
    assert_eq!(e.at("textDocument/completion", &other, &start), Json::Null);
}

#[test]
fn definitions_lead_to_declarations_and_into_the_urdf() {
    let mut e = Editor::ready();
    let (text, doc) = (spec(), uri("lsp_test.hq"));
    e.open(&doc, "hierarq", &text);
    for (from, to) in [
        ("d_min rea|ch", "param |reach"),
        ("level move { |go", "task |go"),
        ("{ limits de|ck", "task |deck"),
        ("run { stack |work", "stack |work {"),
        ("points el|bow", "points { |elbow"),
        ("points [el|bow", "points { |elbow"),
        ("frame_position(on|ly)", "arms { |only"),
    ] {
        let place = e.at("textDocument/definition", &doc, &find(&text, from));
        assert_eq!(place["uri"], doc, "{from}");
        assert_eq!(place["range"]["start"], find(&text, to), "{from}");
    }
    let urdf = std::fs::read_to_string(common::example("robots/arm7.urdf")).expect("readable");
    for (from, tag) in [("tip link|_7", "<link name=\"link_7\""), ("rad  |joint_4", "<joint name=\"joint_4\"")] {
        let place = e.at("textDocument/definition", &doc, &find(&text, from));
        assert_eq!(place["uri"], uri("robots/arm7.urdf"));
        assert!(under(&urdf, &place["range"]).starts_with(tag), "{place}");
    }
    let place = e.at("textDocument/definition", &doc, &find(&text, "robots/|arm7.urdf"));
    assert_eq!(place["uri"], uri("robots/arm7.urdf"));
}

#[test]
fn references_and_rename_reach_every_use() {
    let mut e = Editor::ready();
    let (text, doc) = (spec(), uri("lsp_test.hq"));
    e.open(&doc, "hierarq", &text);
    let mut all = |place: &str, declaration: bool| {
        let params = json!({
            "textDocument": { "uri": doc }, "position": find(&text, place),
            "context": { "includeDeclaration": declaration },
        });
        e.result("textDocument/references", params).as_array().map_or(0, Vec::len)
    };
    assert_eq!(all("param |reach", true), 3);
    assert_eq!(all("param |reach", false), 2);
    assert_eq!(all("points { |elbow", true), 3);
    assert_eq!(all("arms { |only", true), 3);
    let mut rename = |place: &str, new: &str| {
        let params = json!({ "textDocument": { "uri": doc }, "position": find(&text, place), "newName": new });
        e.ask("textDocument/rename", params)
    };
    for (place, old, new, uses) in [
        ("d_min re|ach", "reach", "nearest", 3),
        ("points { |elbow", "elbow", "joint_of_mine", 3),
        ("frame_position(|only)", "only", "main_arm", 3),
        ("{ limits d|eck", "deck", "table", 2),
        ("stack w|ork {", "work", "shift", 2),
    ] {
        let answer = rename(place, new);
        let edits = &answer["result"]["changes"][&doc];
        assert_eq!(edits.as_array().map(Vec::len), Some(uses), "{place}: {answer}");
        let renamed = edited(&text, edits);
        // By hand: every whole word, but for the comment and what only sounds alike.
        let by_hand: Vec<&str> = renamed.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).collect();
        assert!(!by_hand.contains(&old), "{place}:\n{renamed}");
        let before = common::program_of(&text);
        let after = common::program_of(&renamed);
        assert_eq!(before.stacks.len(), after.stacks.len());
        assert_eq!(before.values, after.values, "the same program, with another name in it");
    }
    for (place, new) in [
        ("param |reach", "two words"),
        ("param |reach", ""),
        ("param |reach", "pi"),
        ("task |deck", "go"),
        // A link of this name would be meant where the arm was.
        ("arms { |only", "tool"),
        ("= virtual|_wall", "wall"),
        ("tip |link_7", "tool"),
    ] {
        assert_eq!(rename(place, new)["error"]["code"], -32803, "{place} -> {new:?}");
    }
    let range = e.at("textDocument/prepareRename", &doc, &find(&text, "d_min re|ach"));
    assert_eq!((under(&text, &range["range"]), &range["placeholder"]), ("reach", &json!("reach")));
    assert_eq!(e.at("textDocument/prepareRename", &doc, &find(&text, "= virtual|_wall")), Json::Null);
}

const SCENARIO: &str = "hierarq 1
robot r { urdf \"robots/arm7.urdf\"  rate 100 Hz  joints { wrist [joint_6, joint_7] } }
task limits = joint_position_limits
stack s { level one hard { limits } }
scenario rough {
  stack s
  seed 7
  lost { wrist { from 1 s  to 2 s } }
  expect \"inside\" always margin(limits) >= 0
  expect never speed(joint_3) > 1 rad/s
}
";

#[test]
fn words_of_scenarios() {
    let mut e = Editor::ready();
    let doc = uri("lsp_test.hq");
    e.open(&doc, "hierarq", SCENARIO);
    for (place, range, says) in [
        ("|scenario rough", "scenario", "world of its own"),
        ("se|ed 7", "seed", "whole number"),
        ("lo|st {", "lost", "not a number"),
        ("fr|om 1 s", "from", "From when"),
        ("always mar|gin(", "margin", "smallest margin"),
        ("speed(jo|int_3", "joint_3", "revolute"),
        ("margin(li|mits)", "limits", "joint_position_limits"),
    ] {
        let hover = e.at("textDocument/hover", &doc, &find(SCENARIO, place));
        assert_eq!(under(SCENARIO, &hover["range"]), range, "{place}: {hover}");
        let value = hover["contents"]["value"].as_str().expect("Markdown");
        assert!(value.contains(says), "{place}:\n{value}");
    }
    let there = e.at("textDocument/definition", &doc, &find(SCENARIO, "margin(li|mits)"));
    assert_eq!(under(SCENARIO, &there["range"]), "limits", "{there}");
    assert_eq!(there["range"]["start"]["line"], 2);
    let params =
        json!({ "textDocument": { "uri": doc }, "position": find(SCENARIO, "margin(li|mits)"), "newName": "rim" });
    let changed = e.result("textDocument/rename", params);
    let text = edited(SCENARIO, &changed["changes"][&doc]);
    assert!(text.contains("task rim =") && text.contains("{ rim }") && text.contains("margin(rim)"), "{text}");
    for (version, (old, new, has)) in [
        ("seed 7", "se|", &["seed", "signals", "late"][..]),
        ("margin(limits) >= 0", "|", &["margin", "error", "in", "fault", "speed", "frame"]),
        ("margin(limits)", "margin(|)", &["limits"]),
        ("speed(joint_3)", "speed(|)", &["joint_3", "wrist"]),
        ("from 1 s  to", "|  to", &["from"]),
        ("stack s\n  seed", "stack |\n  seed", &["s"]),
    ]
    .into_iter()
    .enumerate()
    {
        let marked = SCENARIO.replacen(old, new, 1);
        let cursor = marked.find('|').expect("a cursor");
        let text = marked.replacen('|', "", 1);
        e.change(&doc, version as i64 + 2, json!([{ "text": text }]));
        let offered = labels(&e.at("textDocument/completion", &doc, &position(&text, cursor)));
        for label in has {
            assert!(offered.iter().any(|o| o == label), "{new}: no `{label}` in {offered:?}");
        }
    }
    e.goodbye();
}
