//! Language server: signals, machines and their states.

use serde_json::{Value as Json, json};

use super::common;
use super::document::Document;
use super::editor::under;

const MACHINE: &str = r#"hierarq 1

robot arm {
  urdf "robots/arm7.urdf"
  rate 100 Hz
  home { joint_2 0.4 rad  joint_4 1.6 rad  joint_6 1.1 rad }
}

// Where the fruit is. 🤖 ü
signal fruit : point?  timeout 500 ms
signal ft : wrench { timeout 0.1 s }
signal go : event

task reach = frame_position(tool) { position initial(position) + [0, 0.1, 0] m }
task chase(gain: rate = 2 /s) = frame_position(tool) { position fruit  gain gain }

stack still { level limits hard { joint_position_limits  joint_velocity_limits } }
stack follow(speed: rate) from still { add motion { chase(speed) } }
stack move_on from still { add motion { reach } }

machine harvest {
  initial look
  blend 0.5 s
  on fault(any) -> stopped
  on fault(stale(fruit)) -> look

  // It looks.
  state look {
    stack still
    do capture(head_camera)
    enter emit seen
    exit gripper close right
    on found -> work.near
    on go -> work
    on seen -> work.near
    when norm(ft.force) < 3 N and present(fruit) for 200 ms -> work blend 1 s
    after 10 s -> stopped
  }

  state work {
    stack move_on
    initial far
    on fault(infeasible(limits)) -> stopped

    state far { on reached(reach, 5 mm) -> near }
    state near { stack follow(speed: 2 /s)  when not present(fruit) -> far }
  }

  final state stopped { stack still }
}

scenario calm {
  machine harvest
  duration 1 s
  expect never in(work.near)
  expect always (in(look) or in(stopped))
}

run { machine harvest  duration 1 s }
"#;

fn opened() -> Document {
    Document::open("lsp_machine.hq", MACHINE)
}

#[test]
fn hover_and_definition() {
    let mut doc = opened();
    doc.hovers(&[
        ("present(fru|it) for", "fruit", "Where the fruit is. 🤖 ü"),
        ("|signal ft", "signal", "typed input"),
        ("tim|eout 500", "timeout", "Time for which a value is valid"),
        ("position fru|it", "fruit", "point?"),
        ("-> wo|rk blend", "work", "state `work`"),
        ("on found -> work.ne|ar", "near", "stack follow(speed: 2 /s)"),
        ("on fou|nd", "found", "how `capture` came out"),
        ("on se|en", "seen", "`emit seen`"),
        ("on g|o ->", "go", "signal go : event"),
        ("do cap|ture", "capture", "`found` or `not_found`"),
        ("  |do capture", "do", "called off on leaving"),
        ("rea|ched(reach", "reached", "at rest"),
        ("fault(a|ny)", "any", "Every fault"),
        ("fa|ult(any)", "fault", "`fault(KIND)`"),
        ("infea|sible(limits)", "infeasible", "hard levels"),
        ("pre|sent(fruit) for", "present", "whether a signal"),
        ("  |when norm", "when", "while something holds"),
        (") |for 200", "for", "without a break"),
        ("  |after 10", "after", "after a time"),
        ("|final state", "final", "come to its end"),
        ("  |state far", "state", "inside it"),
        ("in|itial far", "initial", "entered with it"),
        ("b|lend 1 s", "blend", "go over"),
        ("  |stack move_on\n", "stack", "runs in it"),
        ("machine harv|est  dur", "harvest", "initial look"),
    ]);
    doc.definitions(&[
        ("present(fru|it) for", "signal |fruit"),
        ("stale(fr|uit)", "signal |fruit"),
        ("norm(f|t.force)", "signal |ft"),
        ("on g|o ->", "signal |go"),
        ("on se|en", "emit |seen"),
        ("on fou|nd", "do |capture"),
        ("never in(wo|rk.near)", "state |work"),
        ("never in(work.ne|ar)", "state |near"),
        ("(in(lo|ok)", "state |look {"),
        ("initial lo|ok", "state |look {"),
        ("initial fa|r", "state |far"),
        ("on found -> wo|rk.near", "state |work"),
        ("on found -> work.n|ear", "state |near"),
        ("mm) -> ne|ar", "state |near"),
        ("fault(any) -> stop|ped", "final state |stopped"),
        ("reached(re|ach", "task |reach"),
        ("stack fol|low(speed: 2", "stack |follow(speed: rate"),
        ("follow(sp|eed: 2", "follow(|speed: rate"),
        ("machine harv|est  dur", "machine |harvest {"),
    ]);
}

#[test]
fn references_and_rename() {
    let mut doc = opened();
    for (place, count) in [
        ("signal |fruit", 5),
        ("state |near", 5),
        ("state |work", 6),
        ("final state |stopped", 5),
        ("signal |go", 2),
        ("emit |seen", 2),
        ("machine |harvest {", 3),
    ] {
        assert_eq!(doc.references(place, true), count, "{place}");
    }
    for (place, old, new) in [
        ("signal |ft", "ft", "wrist"),
        ("state |near", "near", "close_by"),
        ("on found -> wo|rk.near", "work", "pick"),
        ("initial lo|ok", "look", "watch"),
        ("signal |go", "go", "begin"),
        ("on se|en", "seen", "noticed"),
        ("reached(re|ach", "reach", "touch"),
        ("machine |harvest {", "harvest", "vintage"),
    ] {
        let (renamed, _) = doc.renamed(place, old, new);
        let (before, after) = (common::program_of(MACHINE), common::program_of(&renamed));
        let shape = |p: &runtime::Program| {
            let m = p.machine.clone().expect("a machine");
            let ways = |s: &runtime::program::StateProgram| {
                s.transitions.iter().map(|t| (t.trigger.clone(), t.target)).collect::<Vec<_>>()
            };
            m.states.iter().map(|s| (s.parent, s.initial, s.stack, ways(s))).collect::<Vec<_>>()
        };
        assert_eq!(shape(&before), shape(&after), "the same machine, with another name in it");
    }
    doc.refused(&[
        ("on fou|nd", "seen"),
        ("signal |ft", "fruit"),
        ("state |near", "far"),
        ("final state |stopped", "look"),
        ("do cap|ture", "see"),
        ("fault(a|ny)", "all"),
        ("signal |go", "present"),
    ]);
}

#[test]
fn completion() {
    let mut doc = opened();
    doc.completions(&[
        ("on go -> work", "on | -> work", &["go", "found", "not_found", "seen", "reached", "fault"], &["fruit"]),
        ("fault(any)", "fault(|)", &["any", "stale", "infeasible", "limit", "deadline"], &["go"]),
        ("stale(fruit)", "stale(|)", &["fruit", "ft"], &["go", "reach"]),
        ("present(fruit) for", "present(|) for", &["fruit", "ft"], &["go", "norm"]),
        ("infeasible(limits)", "infeasible(|)", &["limits", "motion"], &["reach"]),
        ("reached(reach,", "reached(|,", &["reach"], &["fruit", "hold"]),
        ("on go -> work\n", "on go -> |\n", &["look", "work", "work.near", "stopped"], &["near", "go", "still"]),
        ("on found -> work.near", "on found -> work.|", &["near", "far"], &["look", "stopped"]),
        ("mm) -> near", "mm) -> |", &["near", "look", "stopped"], &["harvest"]),
        ("initial far", "initial |", &["far", "near"], &["look"]),
        ("initial look", "initial |", &["look", "work", "stopped"], &["near"]),
        ("do capture(head_camera)", "do |", &["capture", "say", "gripper", "emit"], &["found"]),
        ("emit seen", "emit |", &["go", "found"], &["reached", "fruit"]),
        ("gripper close right", "gripper |", &["open", "close"], &["right"]),
        ("stack move_on\n", "stack |\n", &["move_on", "follow", "still"], &["reach"]),
        ("follow(speed: 2 /s)", "follow(|)", &["speed"], &["gain"]),
        (
            "    initial far",
            "    |\n    initial far",
            &["blend", "on", "when", "after", "enter", "do", "state", "final"],
            &["initial", "rate"],
        ),
        ("  blend 0.5 s\n", "  |\n", &["blend", "state", "on"], &["initial"]),
        ("signal ft : wrench {", "signal ft : | {", &["event", "flag", "wrench", "point", "length"], &["arm", "fruit"]),
        ("{ timeout 0.1 s }", "{ | }", &["timeout"], &["blend"]),
        ("norm(ft.force)", "norm(ft.|)", &["force", "moment"], &["position"]),
        ("norm(ft.force)", "norm(|)", &["ft", "fruit", "frame", "reversals"], &["go", "margin"]),
        ("(in(look)", "(in(|)", &["look", "work.near"], &["near", "go"]),
        ("run { machine harvest", "run { machine |", &["harvest"], &["look"]),
    ]);
}

#[test]
fn symbols_tokens_and_hints() {
    let mut doc = opened();
    let symbols = doc.whole("textDocument/documentSymbol");
    let named = |list: &Json, name: &str| list.as_array().expect("a list").iter().find(|s| s["name"] == name).cloned();
    let machine = named(&symbols, "harvest").expect("the machine");
    let work = named(&machine["children"], "work").expect("a state");
    assert_eq!(labels_of(&work["children"]), ["far", "near"]);
    assert_eq!(labels_of(&machine["children"]), ["look", "work", "stopped"]);
    assert_eq!(named(&symbols, "fruit").expect("the signal")["detail"], "signal, point?");
    let range = json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 99, "character": 0 } });
    let params = json!({ "textDocument": { "uri": doc.uri }, "range": range });
    let hints = doc.editor.result("textDocument/inlayHint", params);
    let hints: Vec<&str> = hints.as_array().expect("a list").iter().filter_map(|h| h["label"].as_str()).collect();
    assert_eq!(hints, ["= 0.5 s", "= 0.2 s", "= 0.005 m"]);
    let tokens = doc.whole("textDocument/semanticTokens/full");
    let data: Vec<u64> = tokens["data"].as_array().expect("numbers").iter().filter_map(Json::as_u64).collect();
    let (mut line, mut column, mut kinds) = (0, 0, Vec::new());
    for t in data.chunks(5) {
        column = if t[0] == 0 { column + t[1] } else { t[1] };
        line += t[0];
        let start = json!({ "line": line, "character": column });
        let end = json!({ "line": line, "character": column + t[2] });
        kinds.push((under(MACHINE, &json!({ "start": start, "end": end })), t[3]));
    }
    for word in
        [("machine", 0), ("state", 0), ("enter", 0), ("when", 0), ("fruit", 3), ("near", 5), ("capture", 4), ("any", 5)]
    {
        assert!(kinds.contains(&word), "{word:?} in {kinds:?}");
    }
}

fn labels_of(symbols: &Json) -> Vec<&str> {
    symbols.as_array().map_or(Vec::new(), |s| s.iter().filter_map(|s| s["name"].as_str()).collect())
}

#[test]
fn yaml_has_the_same() {
    let mut doc = Document::open_in_yaml("lsp_machine.yaml", MACHINE);
    assert!(doc.diagnostics().iter().all(|d| d["severity"] != 1));
    doc.definitions(&[
        ("on: found, to: wo|rk.near", "|work:"),
        ("on: found, to: work.ne|ar", "|near:"),
        ("initial: lo|ok", "|look:"),
        ("on: g|o,", "|go:"),
        ("on: se|en", "emit |seen"),
        ("present(fr|uit), for", "|fruit:"),
        ("reached(rea|ch", "|reach:"),
        ("run: { machine: harv|est", "|harvest:"),
    ]);
    for (place, says) in [
        ("on: go, t|o: work", "leads to"),
        ("do: cap|ture", "`found` or `not_found`"),
        ("ex|it: gripper", "on leaving"),
        ("on: found, to: work.ne|ar", "state `near`"),
    ] {
        doc.says(place, says);
    }
    doc.completions(&[
        ("on: go,", "on: |,", &["reached"], &[]),
        ("initial: far", "initial: |", &["near"], &[]),
        ("do: capture(head_camera)", "do: |", &["capture"], &[]),
        ("type: wrench", "type: |", &["flag"], &[]),
        ("fault(any)", "fault(|)", &["deadline"], &[]),
        ("      look:\n", "      look:\n        |\n", &["transitions"], &[]),
        ("on: found, to: work.near", "on: found, to: |", &["work.near"], &[]),
    ]);
}
