//! Language server: imported files, with completion, hints, diagnostics, and unsaved or incomplete texts.

use serde_json::{Value as Json, json};

use super::editor::{Editor, find, labels, position};
use super::workspace::{FIRST, Folder, rename};

#[test]
fn completion_knows_the_other_files() {
    let folder = Folder::new("completion");
    for (name, old, new, has, has_not) in [
        ("first.hq", "touch, gap, base }", "touch, |, gap }", &["base"][..], &["deck", "gap", "left", "safe"][..]),
        ("first.hq", "arm, deck, touch, gap, base }", "| }", &["arm", "deck", "touch", "gap", "base"], &["left"]),
        ("first.hq", "arm, deck, touch, gap, base }\n", "arm, de|\n", &["deck", "touch"], &["arm"]),
        ("first.hq", "level safe hard { deck }", "level safe hard { | }", &["deck", "wide", "touch"], &["gap"]),
        ("first.hq", "touch(right, offset: [0, 0, gap])", "touch(|)", &["left", "right", "side", "offset"], &["deck"]),
        (
            "first.hq",
            "touch(right, offset: [0, 0, gap])",
            "touch(right, |)",
            &["gap", "offset", "among"],
            &["side", "left"],
        ),
        ("first.hq", "touch(right, offset: [0, 0, gap])", "touch(right, among: |)", &["lower", "joint_1"], &["left"]),
        (
            "first.hq",
            "touch(right, offset: [0, 0, gap])",
            "touch(right, among: lower, o|)",
            &["offset"],
            &["among", "side"],
        ),
        ("first.hq", "replace move", "replace |", &["safe", "move"], &["deck"]),
        ("first.hq", "from base", "from |", &["base"], &["deck"]),
        ("second.yaml", "[arm, deck, touch]", "[arm, |]", &["deck", "touch", "base"], &["arm"]),
        ("second.yaml", "touch(left, offset", "touch(|, offset", &["left", "right"], &["offset"]),
        ("third.hq", "table, calm }", "| }", &["table", "calm"], &["deck", "touch", "arm"]),
    ] {
        let mut e = Editor::ready_in(&folder.0);
        let (text, doc) = folder.open(&mut e, name);
        let marked = text.replacen(old, new, 1);
        let cursor = marked.find('|').unwrap_or_else(|| panic!("no cursor: {new}"));
        let changed = marked.replacen('|', "", 1);
        e.change(&doc, 2, json!([{ "text": changed }]));
        let offered = labels(&e.at("textDocument/completion", &doc, &position(&changed, cursor)));
        for want in has {
            assert!(offered.iter().any(|o| o == want), "{name} {new}: no `{want}` in {offered:?}");
        }
        for no in has_not {
            assert!(offered.iter().all(|o| o != no), "{name} {new}: `{no}` in {offered:?}");
        }
    }
}

/// Names that no word contains: those made by a repetition, and those that a task takes implicitly. The compiler checks
/// them.
#[test]
fn a_rename_after_which_a_spec_would_not_compile_is_refused() {
    let folder = Folder::new("breaks");
    let made = FIRST.replacen(
        "level safe hard { deck }  level",
        "level all { for n in [low] { joint_velocity { velocity { ${n}er 0 rad/s } } } }  level",
        1,
    );
    assert_ne!(made, FIRST);
    folder.write("first.hq", &made);
    let mut e = Editor::ready_in(&folder.0);
    let (library, lib) = folder.open(&mut e, "lib.hq");
    let answer = rename(&mut e, &lib, &find(&library, "joints { low|er"), "below");
    let message = answer["error"]["message"].as_str().unwrap_or_else(|| panic!("{answer}"));
    assert!(message.contains("`first.hq` would not compile any more: "), "{message}");
    assert!(message.contains("lower"), "{message}");
    let answer = rename(&mut e, &lib, &find(&library, "task de|ck"), "plate");
    assert!(answer["result"]["changes"].is_object(), "{answer}");
}

/// Diagnostics use unsaved texts: a change in one file affects its importers before it is saved.
#[test]
fn diagnostics_see_unsaved_imports() {
    let folder = Folder::new("diagnostics");
    let mut e = Editor::ready_in(&folder.0);
    let (_, doc) = folder.open(&mut e, "first.hq");
    let codes =
        |list: &[Json]| list.iter().filter(|d| d["severity"] == 1).map(|d| d["code"].clone()).collect::<Vec<_>>();
    assert_eq!(codes(&e.diagnostics(&doc, Some(1))), Vec::<Json>::new());
    // A request, so that the server computes the dependencies of the files.
    e.result("textDocument/documentSymbol", json!({ "textDocument": { "uri": doc } }));
    let (library, lib) = folder.open(&mut e, "lib.hq");
    e.diagnostics(&lib, Some(1));
    e.diagnostics(&doc, Some(1));
    e.change(&lib, 2, json!([{ "text": library.replacen("task deck", "task desk", 1) }]));
    e.diagnostics(&lib, Some(2));
    assert!(codes(&e.diagnostics(&doc, Some(1))).contains(&json!("HQ0213")), "there is no `deck` any more");
    e.result("textDocument/documentSymbol", json!({ "textDocument": { "uri": doc } }));
    e.change(&lib, 3, json!([{ "text": library }]));
    e.diagnostics(&lib, Some(3));
    assert_eq!(codes(&e.diagnostics(&doc, Some(1))), Vec::<Json>::new());
}

/// Values in SI are shown after quantities in other units, also if a unit comes through an import.
#[test]
fn hints_beside_imports() {
    let folder = Folder::new("hints");
    let mut e = Editor::ready_in(&folder.0);
    let (first, doc) = folder.open(&mut e, "first.hq");
    let text = first.replacen("[0, 0, gap]", "[0, 0, 5] cm", 1);
    e.change(&doc, 2, json!([{ "text": text }]));
    let all = json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 99, "character": 0 } });
    let hints = e.result("textDocument/inlayHint", json!({ "textDocument": { "uri": doc }, "range": all }));
    let hints: Vec<&str> = hints.as_array().expect("a list").iter().filter_map(|h| h["label"].as_str()).collect();
    assert_eq!(hints, ["= [0, 0, 0.05] m"]);
}

/// The text in the editor counts, saved or not.
#[test]
fn unsaved_texts_are_what_others_see() {
    let folder = Folder::new("unsaved");
    let mut e = Editor::ready_in(&folder.0);
    let (first, doc) = folder.open(&mut e, "first.hq");
    let deck = find(&first, "hard { de|ck }");
    let line = |e: &mut Editor| e.at("textDocument/definition", &doc, &deck)["range"]["start"]["line"].clone();
    let before = line(&mut e).as_u64().expect("a line");
    let (library, lib) = folder.open(&mut e, "lib.hq");
    e.change(&lib, 2, json!([{ "text": library.replacen("task deck", "\n\n\ntask deck", 1) }]));
    assert_eq!(line(&mut e), before + 3);
    // The edits refer to the text in the editor.
    let answer = rename(&mut e, &doc, &deck, "plate");
    let start = &answer["result"]["changes"][&lib][0]["range"]["start"]["line"];
    assert_eq!(start, before + 3, "{answer}");
    e.change(&lib, 3, json!([{ "text": library.replacen("task deck", "task desk", 1) }]));
    let import = first.replacen("arm, deck", "arm, ", 1);
    e.change(&doc, 2, json!([{ "text": import }]));
    let offered = labels(&e.at("textDocument/completion", &doc, &find(&import, "arm, |, touch")));
    assert!(offered.contains(&"desk".to_string()), "{offered:?}");
    e.notify("textDocument/didClose", json!({ "textDocument": { "uri": lib } }));
    let offered = labels(&e.at("textDocument/completion", &doc, &find(&import, "arm, |, touch")));
    assert!(offered.contains(&"deck".to_string()) && !offered.contains(&"desk".to_string()), "{offered:?}");
    // Files on the disk are read again after a save.
    folder.write("lib.hq", &library.replacen("task deck", "task dock", 1));
    e.notify("textDocument/didSave", json!({ "textDocument": { "uri": doc } }));
    let offered = labels(&e.at("textDocument/completion", &doc, &find(&import, "arm, |, touch")));
    assert!(offered.contains(&"dock".to_string()), "{offered:?}");
}

/// An imported file is truncated, or imports are cyclic: every request gets a response.
#[test]
fn half_written_files_and_circles() {
    let folder = Folder::new("half");
    folder.write("round.hq", "hierarq 1\nimport \"about.hq\" { x }\nimport \"round.hq\" { y }\ntask y = hold(x)\n");
    folder.write("about.hq", "hierarq 1\nimport \"round.hq\" { y as x }\nstack s { level a { x } }\n");
    let mut e = Editor::ready_in(&folder.0);
    let (first, doc) = folder.open(&mut e, "first.hq");
    let (_, round) = folder.open(&mut e, "round.hq");
    let (library, lib) = folder.open(&mut e, "lib.hq");
    let mut state = 2026u64;
    for i in 0..20i64 {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        let places: Vec<usize> = library.char_indices().map(|c| c.0).collect();
        let from = places[(state >> 33) as usize % places.len()];
        let to = if i % 2 == 0 { library.len() } else { *places.iter().find(|p| **p > from + 7).unwrap_or(&from) };
        e.change(&lib, i + 2, json!([{ "text": format!("{}{}", &library[..from], &library[to..]) }]));
        for (uri, at) in [
            (&doc, find(&first, "hard { de|ck }")),
            (&doc, find(&first, "touch(right, off|set")),
            (&round, json!({ "line": 1, "character": 21 })),
            (&round, json!({ "line": 3, "character": 5 })),
        ] {
            for method in ["hover", "completion", "definition", "prepareRename"] {
                e.at(&format!("textDocument/{method}"), uri, &at);
            }
            let params = json!({
                "textDocument": { "uri": uri }, "position": at, "context": { "includeDeclaration": true },
            });
            e.result("textDocument/references", params);
            let answer = rename(&mut e, uri, &at, "plate");
            assert_ne!(answer["error"]["code"], -32603, "a fault in the server: {answer}");
        }
    }
    e.result("workspace/symbol", json!({ "query": "d" }));
    assert_eq!(e.goodbye(), Some(0));
}
