//! Language server: words, with hover, completion, definitions, references and rename.

use serde_json::{Value as Json, json};

use super::document::Document;
use super::editor::{SPEC, find, text, under, uri};
use crate::common;

#[test]
fn hover_explains_every_kind_of_word() {
    let mut doc = Document::open("lsp_test.hq", SPEC);
    doc.hovers(&[
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
    ]);
    assert_eq!(doc.at("textDocument/hover", "|// How near"), Json::Null);
}

#[test]
fn completion_offers_what_can_stand_there() {
    let mut doc = Document::open("lsp_test.hq", SPEC);
    // Replaced text, replacement (`|` is the cursor), required items, forbidden items.
    doc.completions(&[
        ("{ points elbow", "{ | points elbow", &["gain", "on"], &["through", "points", "d_min", "urdf"]),
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
    ]);
    // Parameters are offered with their documentation, the required ones first.
    let text = SPEC.replacen("{ points elbow", "{  points elbow", 1).replace("through", "thruogh");
    doc.change(&text);
    let items = doc.editor.at("textDocument/completion", &doc.uri, &find(&text, "virtual_wall { | points"));
    let items = items.as_array().expect("a list");
    let item = |label: &str| items.iter().find(|i| i["label"] == label).expect("offered").clone();
    assert!(item("through")["sortText"].as_str() < item("gain")["sortText"].as_str());
    assert!(item("gain")["documentation"]["value"].as_str().is_some_and(|d| d.contains("how fast")), "{items:?}");
}

/// Expressions of the robot's state: their words have the usual meaning.
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
    let mut doc = Document::open("lsp_own.hq", OWN);
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
        doc.says(place, says);
    }
    doc.definitions(&[
        ("distance(el|bow", "points { |elbow"),
        ("frame(on|ly)", "arms { |only"),
        ("min: dis|tance", "param |distance"),
        ("m in on|ly", "arms { |only"),
        ("distance(wri|st, plane", "link_4  |wrist"),
    ]);
    let (renamed, _) = doc.renamed("points { el|bow", "elbow", "hinge");
    assert!(renamed.contains("keep(distance(hinge, base_link)"), "{renamed}");
    assert_eq!(common::program_of(OWN).values, common::program_of(&renamed).values);
    doc.completions(&[
        ("min: distance, gain", "|, gain", &["min"], &["frame"]),
        ("frame(only).position", "frame(|).position", &["only"], &["joint_1"]),
        ("frame(only).position", "frame(only).|", &["orientation"], &["gain"]),
        ("joint(joint_4)", "|", &["frame"], &["gain"]),
        ("distance(elbow, base_link)", "distance(elbow, |)", &["wrist"], &["joint_1"]),
        ("target initial(value)", "target initial(|)", &["value"], &["gain"]),
        ("target initial(value)", "tar|", &["target"], &["frame"]),
        ("joint(joint_4)", "co|", &["com"], &["gain"]),
        ("norm(com)", "|", &["com"], &["gain"]),
        ("plane([0, 0, -1] m in only, [0, 0, 1])", "|", &["elbow"], &["joint_1"]),
    ]);
    let items = doc.offered("min: distance, gain", "|, gain");
    let item = items.as_array().expect("a list").iter().find(|i| i["label"] == "min").expect("offered");
    assert_eq!(item["textEdit"]["newText"], "min: ");
}

#[test]
fn yaml_has_the_same() {
    let mut doc = Document::open("lsp_test.yaml", &text("../tests/corpus/specs/cooperative_motion.yaml"));
    assert_eq!(doc.diagnostics(), Vec::<Json>::new());
    doc.says("deck:\n    virtual|_wall", "thesis (3.17)");
    let place = doc.at("textDocument/definition", "d_min: 0.3 m, gain: 5 /|s");
    assert_eq!(place, Json::Null, "a unit is declared nowhere");
    let place = doc.at("textDocument/definition", "and: [column, che|st]");
    assert_eq!(under(&doc.text, &place["range"]), "chest");
    doc.completions(&[
        ("points: arms, through", "po|, through", &["points"], &[]),
        ("rate: 100 Hz\n", "rate: 100 Hz\n    |\n", &["tracking_gain"], &[]),
        ("base: unicycle", "base: |", &["planar"], &[]),
        ("tip: left_tool\n", "tip: |\n", &["left_tool"], &[]),
        ("tasks:\n", "|\n\ntasks:\n", &["params"], &[]),
        ("between: arms, and: head", "between: |, and: head", &["arms.left"], &[]),
    ]);
    // YAML files that are no specs are ignored.
    let mut other = Document::open("compose.yaml", "services:\n  web: { image: x }\n");
    assert_eq!(other.diagnostics(), Vec::<Json>::new());
    let start = json!({ "line": 1, "character": 3 });
    assert_eq!(other.editor.at("textDocument/completion", &other.uri, &start), Json::Null);
}

#[test]
fn definitions_lead_to_declarations_and_into_the_urdf() {
    let mut doc = Document::open("lsp_test.hq", SPEC);
    doc.definitions(&[
        ("d_min rea|ch", "param |reach"),
        ("level move { |go", "task |go"),
        ("{ limits de|ck", "task |deck"),
        ("run { stack |work", "stack |work {"),
        ("points el|bow", "points { |elbow"),
        ("points [el|bow", "points { |elbow"),
        ("frame_position(on|ly)", "arms { |only"),
    ]);
    let urdf = std::fs::read_to_string(common::example("robots/arm7.urdf")).expect("readable");
    for (from, tag) in [("tip link|_7", "<link name=\"link_7\""), ("rad  |joint_4", "<joint name=\"joint_4\"")] {
        let place = doc.at("textDocument/definition", from);
        assert_eq!(place["uri"], uri("robots/arm7.urdf"));
        assert!(under(&urdf, &place["range"]).starts_with(tag), "{place}");
    }
    let place = doc.at("textDocument/definition", "robots/|arm7.urdf");
    assert_eq!(place["uri"], uri("robots/arm7.urdf"));
}

#[test]
fn references_and_rename_reach_every_use() {
    let mut doc = Document::open("lsp_test.hq", SPEC);
    for (place, declaration, uses) in
        [("param |reach", true, 3), ("param |reach", false, 2), ("points { |elbow", true, 3), ("arms { |only", true, 3)]
    {
        assert_eq!(doc.references(place, declaration), uses, "{place}");
    }
    for (place, old, new, uses) in [
        ("d_min re|ach", "reach", "nearest", 3),
        ("points { |elbow", "elbow", "joint_of_mine", 3),
        ("frame_position(|only)", "only", "main_arm", 3),
        ("{ limits d|eck", "deck", "table", 2),
        ("stack w|ork {", "work", "shift", 2),
    ] {
        // Every whole word except for those in the comment, and no similar names.
        let (renamed, edits) = doc.renamed(place, old, new);
        assert_eq!(edits, uses, "{place}:\n{renamed}");
        let before = common::program_of(SPEC);
        let after = common::program_of(&renamed);
        assert_eq!(before.stacks.len(), after.stacks.len());
        assert_eq!(before.values, after.values, "the same program, with another name in it");
    }
    doc.refused(&[
        ("param |reach", "two words"),
        ("param |reach", ""),
        ("param |reach", "pi"),
        ("task |deck", "go"),
        // This name would refer to a link instead of the arm.
        ("arms { |only", "tool"),
        ("= virtual|_wall", "wall"),
        ("tip |link_7", "tool"),
    ]);
    let range = doc.at("textDocument/prepareRename", "d_min re|ach");
    assert_eq!((under(SPEC, &range["range"]), &range["placeholder"]), ("reach", &json!("reach")));
    assert_eq!(doc.at("textDocument/prepareRename", "= virtual|_wall"), Json::Null);
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
  expect always reversals(wrist) <= 0 and acceleration(tool) < 9 m/s^2
}
";

#[test]
fn words_of_scenarios() {
    let mut doc = Document::open("lsp_test.hq", SCENARIO);
    doc.hovers(&[
        ("|scenario rough", "scenario", "world of its own"),
        ("se|ed 7", "seed", "whole number"),
        ("lo|st {", "lost", "not a number"),
        ("fr|om 1 s", "from", "From when"),
        ("always mar|gin(", "margin", "smallest margin"),
        ("speed(jo|int_3", "joint_3", "revolute"),
        ("margin(li|mits)", "limits", "joint_position_limits"),
        ("rever|sals(", "reversals", "turned round and back"),
        ("acceler|ation(", "acceleration", "velocity that the controller chose"),
        ("acceleration(to|ol", "tool", "link"),
    ]);
    let there = doc.at("textDocument/definition", "margin(li|mits)");
    assert_eq!(under(SCENARIO, &there["range"]), "limits", "{there}");
    assert_eq!(there["range"]["start"]["line"], 2);
    let (text, _) = doc.renamed("margin(li|mits)", "limits", "rim");
    assert!(text.contains("task rim =") && text.contains("{ rim }") && text.contains("margin(rim)"), "{text}");
    doc.completions(&[
        ("seed 7", "se|", &["seed", "signals", "late"], &[]),
        ("margin(limits) >= 0", "|", &["margin", "error", "in", "fault", "speed", "frame"], &[]),
        ("margin(limits)", "margin(|)", &["limits"], &[]),
        ("speed(joint_3)", "speed(|)", &["joint_3", "wrist"], &[]),
        ("reversals(wrist)", "reversals(|)", &["joint_3", "wrist", "all"], &[]),
        ("acceleration(tool)", "acceleration(|)", &["joint_3"], &[]),
        ("margin(limits) >= 0", "|", &["acceleration", "reversals"], &[]),
        ("from 1 s  to", "|  to", &["from"], &[]),
        ("stack s\n  seed", "stack |\n  seed", &["s"], &[]),
    ]);
    doc.editor.goodbye();
}
