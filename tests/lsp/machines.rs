//! What the server says about signals, machines and their states.

use serde_json::{Value as Json, json};

use super::common;
use super::editor::{Editor, edited, find, labels, position, under, uri};

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

fn opened() -> (Editor, String) {
    let (mut e, doc) = (Editor::ready(), uri("lsp_machine.hq"));
    e.open(&doc, "hierarq", MACHINE);
    (e, doc)
}

#[test]
fn hover_and_definition() {
    let (mut e, doc) = opened();
    for (place, range, says) in [
        ("present(fru|it) for", "fruit", "Where the fruit is. 🤖 ü"),
        ("|signal ft", "signal", "typed input"),
        ("tim|eout 500", "timeout", "How long a value counts"),
        ("position fru|it", "fruit", "point?"),
        ("-> wo|rk blend", "work", "state `work`"),
        ("on found -> work.ne|ar", "near", "stack follow(speed: 2 /s)"),
        ("on fou|nd", "found", "how `capture` came out"),
        ("on se|en", "seen", "`emit seen`"),
        ("on g|o ->", "go", "signal go : event"),
        ("do cap|ture", "capture", "`found` or `not_found`"),
        ("  |do capture", "do", "called off on leaving"),
        ("rea|ched(reach", "reached", "stands still"),
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
    ] {
        let hover = e.at("textDocument/hover", &doc, &find(MACHINE, place));
        assert!(!hover.is_null(), "{place}");
        assert_eq!(under(MACHINE, &hover["range"]), range, "{place}: {hover}");
        assert!(hover["contents"]["value"].as_str().is_some_and(|v| v.contains(says)), "{place}: {hover}");
    }
    for (from, to) in [
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
    ] {
        let place = e.at("textDocument/definition", &doc, &find(MACHINE, from));
        assert_eq!(place["range"]["start"], find(MACHINE, to), "{from}: {place}");
    }
}

#[test]
fn references_and_rename() {
    let (mut e, doc) = opened();
    let all = |e: &mut Editor, place: &str| {
        let params = json!({
            "textDocument": { "uri": doc }, "position": find(MACHINE, place), "context": { "includeDeclaration": true },
        });
        e.result("textDocument/references", params).as_array().map_or(0, Vec::len)
    };
    for (place, count) in [
        ("signal |fruit", 5),
        ("state |near", 5),
        ("state |work", 6),
        ("final state |stopped", 5),
        ("signal |go", 2),
        ("emit |seen", 2),
        ("machine |harvest {", 3),
    ] {
        assert_eq!(all(&mut e, place), count, "{place}");
    }
    let rename = |e: &mut Editor, place: &str, new: &str| {
        let position = find(MACHINE, place);
        e.ask("textDocument/rename", json!({ "textDocument": { "uri": doc }, "position": position, "newName": new }))
    };
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
        let answer = rename(&mut e, place, new);
        let renamed = edited(MACHINE, &answer["result"]["changes"][&doc]);
        let words: Vec<&str> = renamed.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).collect();
        assert!(!words.contains(&old), "{place}: {answer}\n{renamed}");
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
    for (place, new) in [
        ("on fou|nd", "seen"),
        ("signal |ft", "fruit"),
        ("state |near", "far"),
        ("final state |stopped", "look"),
        ("do cap|ture", "see"),
        ("fault(a|ny)", "all"),
        ("signal |go", "present"),
    ] {
        assert_eq!(rename(&mut e, place, new)["error"]["code"], -32803, "{place} -> {new}");
    }
}

#[test]
fn completion() {
    let (mut e, doc) = opened();
    let mut version = 1;
    for (old, new, has, has_not) in [
        (
            "on go -> work",
            "on | -> work",
            &["go", "found", "not_found", "seen", "reached", "fault"][..],
            &["fruit"][..],
        ),
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
        ("norm(ft.force)", "norm(|)", &["ft", "fruit", "frame"], &["go"]),
        ("(in(look)", "(in(|)", &["look", "work.near"], &["near", "go"]),
        ("run { machine harvest", "run { machine |", &["harvest"], &["look"]),
    ] {
        assert_eq!(MACHINE.matches(old).count(), 1, "{old}");
        let marked = MACHINE.replacen(old, new, 1);
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
fn symbols_tokens_and_hints() {
    let (mut e, doc) = opened();
    let symbols = e.result("textDocument/documentSymbol", json!({ "textDocument": { "uri": doc } }));
    let named = |list: &Json, name: &str| list.as_array().expect("a list").iter().find(|s| s["name"] == name).cloned();
    let machine = named(&symbols, "harvest").expect("the machine");
    let work = named(&machine["children"], "work").expect("a state");
    assert_eq!(labels_of(&work["children"]), ["far", "near"]);
    assert_eq!(labels_of(&machine["children"]), ["look", "work", "stopped"]);
    assert_eq!(named(&symbols, "fruit").expect("the signal")["detail"], "signal, point?");
    let range = json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 99, "character": 0 } });
    let hints = e.result("textDocument/inlayHint", json!({ "textDocument": { "uri": doc }, "range": range }));
    let hints: Vec<&str> = hints.as_array().expect("a list").iter().filter_map(|h| h["label"].as_str()).collect();
    assert_eq!(hints, ["= 0.5 s", "= 0.2 s", "= 0.005 m"]);
    let tokens = e.result("textDocument/semanticTokens/full", json!({ "textDocument": { "uri": doc } }));
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
    let (tree, diagnostics) = dsl::parse(dsl::SourceId(0), MACHINE, dsl::Spelling::Hq);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    let text = dsl::print(&tree, dsl::Spelling::Yaml);
    let (mut e, doc) = (Editor::ready(), uri("lsp_machine.yaml"));
    e.open(&doc, "yaml", &text);
    assert!(e.diagnostics(&doc, Some(1)).iter().all(|d| d["severity"] != 1));
    for (from, to) in [
        ("on: found, to: wo|rk.near", "|work:"),
        ("on: found, to: work.ne|ar", "|near:"),
        ("initial: lo|ok", "|look:"),
        ("on: g|o,", "|go:"),
        ("on: se|en", "emit |seen"),
        ("present(fr|uit), for", "|fruit:"),
        ("reached(rea|ch", "|reach:"),
        ("run: { machine: harv|est", "|harvest:"),
    ] {
        let place = e.at("textDocument/definition", &doc, &find(&text, from));
        assert_eq!(place["range"]["start"], find(&text, to), "{from}: {place}\n{text}");
    }
    for (place, says) in [
        ("on: go, t|o: work", "leads to"),
        ("do: cap|ture", "`found` or `not_found`"),
        ("ex|it: gripper", "on leaving"),
        ("on: found, to: work.ne|ar", "state `near`"),
    ] {
        let hover = e.at("textDocument/hover", &doc, &find(&text, place));
        assert!(hover["contents"]["value"].as_str().is_some_and(|v| v.contains(says)), "{place}: {hover}");
    }
    for (version, old, new, has) in [
        (2, "on: go,", "on: |,", "reached"),
        (3, "initial: far", "initial: |", "near"),
        (4, "do: capture(head_camera)", "do: |", "capture"),
        (5, "type: wrench", "type: |", "flag"),
        (6, "fault(any)", "fault(|)", "deadline"),
        (7, "      look:\n", "      look:\n        |\n", "transitions"),
        (8, "on: found, to: work.near", "on: found, to: |", "work.near"),
    ] {
        assert_eq!(text.matches(old).count(), 1, "{old}\n{text}");
        let marked = text.replacen(old, new, 1);
        let cursor = marked.find('|').expect("a cursor");
        let changed = marked.replacen('|', "", 1);
        e.change(&doc, version, json!([{ "text": changed }]));
        let offered = labels(&e.at("textDocument/completion", &doc, &position(&changed, cursor)));
        assert!(offered.iter().any(|o| o == has), "{new}: no `{has}` in {offered:?}");
    }
}
