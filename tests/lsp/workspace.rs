//! Several specs that import from each other: references, rename, symbols, completion and hover across files.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use serde_json::{Value as Json, json};

use super::common;
use super::editor::{Editor, edited, find, labels, position, under};

const LIBRARY: &str = r#"hierarq 1

param gap = 0.3 m { min 0 m }

robot arm {
  urdf "ROBOT"
  rate 100 Hz
  arms { left { tip link_7  points [elbow] }  right { tip link_4 } }
  points { elbow link_4 }
  joints { lower ["joint_1", "joint_2"] }
  home { joint_2 0.5 rad  joint_4 1 rad }
}

// The table top. 🤖 ü
task deck = virtual_wall { points elbow  through [[0, 0, -1], [1, 0, -1], [0, 1, -1]] m  d_min gap }

task touch(side: arm, offset: point = [0, 0, 0] m, among: joints = lower) = frame_position(side) {
  position initial(position) + offset
}

stack base {
  level safe hard { deck }
  level move { touch(left) }
}
"#;

const MORE: &str = r#"hierarq: 1

import:
  "../lib.hq": [deck as table, arm]

tasks:
  calm: { joint_velocity: { velocity: { lower: 0 rad/s } } }
"#;

const FIRST: &str = r#"hierarq 1
import "lib.hq" { arm, deck, touch, gap, base }
let twice = 2 * gap
task wide = touch(right, offset: [0, 0, gap])
stack mine from base { replace move { wide  touch(left, among: lower) } }
stack other { level safe hard { deck }  level move { touch(left, [0, 0, twice - gap - gap]) } }
run { stack mine }
"#;

const SECOND: &str = r#"hierarq: 1
import: { lib.hq: [arm, deck, touch] }
stacks:
  s:
    levels:
      - { name: safe, hard: true, tasks: [deck] }
      - { name: move, tasks: ["touch(left, offset: [0, 0, 0.1] m)"] }
run: { stack: s }
"#;

const THIRD: &str = r#"hierarq 1
import "sub/more.yaml" { arm, table, calm }
stack s { level safe hard { table }  level rest { calm } }
"#;

const APART: &str = r#"hierarq 1
robot arm { urdf "ROBOT"  rate 100 Hz  points { elbow link_4 } }
task deck = hold(link_7)
stack s { level a { deck } }
"#;

const ENTRIES: [&str; 4] = ["first.hq", "second.yaml", "third.hq", "apart.hq"];

/// A folder with the specs, gone when it is dropped.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Folder {
        let folder = std::env::temp_dir().join(format!("hierarq_workspace_{name}_{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(folder.join("sub")).expect("a folder");
        let all = Folder(folder);
        for (name, text) in [
            ("lib.hq", LIBRARY),
            ("sub/more.yaml", MORE),
            ("first.hq", FIRST),
            ("second.yaml", SECOND),
            ("third.hq", THIRD),
            ("apart.hq", APART),
        ] {
            all.write(name, text);
        }
        all
    }

    fn write(&self, name: &str, text: &str) {
        let robot = common::example("robots/arm7.urdf").display().to_string();
        std::fs::write(self.0.join(name), text.replace("ROBOT", &robot)).expect("written");
    }

    fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.0.join(name)).expect("there")
    }

    fn uri(&self, name: &str) -> String {
        format!("file://{}", self.0.join(name).display())
    }

    fn open(&self, e: &mut Editor, name: &str) -> (String, String) {
        let (text, uri) = (self.text(name), self.uri(name));
        e.open(&uri, name.rsplit('.').next().expect("an ending"), &text);
        (text, uri)
    }

    /// Codes of what the compiler says of each entry, and the shape of its program.
    fn compiled(&self) -> Vec<(Vec<&'static str>, Option<String>)> {
        let one = |name: &str| {
            let compiled = hierarq::project::compile(&self.0.join(name), &hierarq::project::Settings::default());
            let codes = compiled.report.diagnostics.iter().map(|d| d.code).collect();
            let shape = compiled.program.map(|p| {
                let levels: Vec<Vec<Vec<usize>>> = p
                    .stacks
                    .iter()
                    .map(|s| s.levels.iter().map(|l| l.members.iter().map(|m| m.task).collect()).collect())
                    .collect();
                let kinds: Vec<&str> = p.tasks.iter().map(|t| t.kind.as_str()).collect();
                format!("{levels:?} {kinds:?} {:?}", p.values)
            });
            (codes, shape)
        };
        ENTRIES.iter().map(|name| one(name)).collect()
    }

    /// The folder with edits applied, under another name.
    fn with(&self, name: &str, changes: &Json) -> Folder {
        let other = Folder::new(name);
        for (uri, edits) in changes.as_object().expect("changes by address") {
            let path = uri.strip_prefix("file://").expect("a file");
            let name = Path::new(path).strip_prefix(&self.0).expect("in the folder").display().to_string();
            other.write(&name, &edited(&self.text(&name), edits));
        }
        other
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn rename(e: &mut Editor, uri: &str, at: &Json, new: &str) -> Json {
    e.ask("textDocument/rename", json!({ "textDocument": { "uri": uri }, "position": at, "newName": new }))
}

/// How many edits each file gets.
fn counts(folder: &Folder, answer: &Json) -> BTreeMap<String, usize> {
    let changes = answer["result"]["changes"].as_object().unwrap_or_else(|| panic!("{answer}"));
    let short = |uri: &String| uri.trim_start_matches(&folder.uri("")).to_string();
    changes.iter().map(|(uri, edits)| (short(uri), edits.as_array().map_or(0, Vec::len))).collect()
}

fn expected(list: &[(&str, usize)]) -> BTreeMap<String, usize> {
    list.iter().map(|(name, count)| ((*name).to_string(), *count)).collect()
}

#[test]
fn the_specs_of_these_tests_are_good() {
    let folder = Folder::new("good");
    for ((codes, shape), name) in folder.compiled().into_iter().zip(ENTRIES) {
        assert!(shape.is_some() && codes.iter().all(|c| c.starts_with("HQ06")), "{name}: {codes:?}");
    }
}

#[test]
fn a_rename_reaches_every_file_that_imports_the_name() {
    let folder = Folder::new("rename");
    let mut e = Editor::ready_in(&folder.0);
    let (first, doc) = folder.open(&mut e, "first.hq");
    let (third, other) = folder.open(&mut e, "third.hq");
    let (library, lib) = folder.open(&mut e, "lib.hq");
    // From a use in a file that imports it, and from its declaration: the same.
    for (uri, at) in [(&doc, find(&first, "hard { de|ck }")), (&lib, find(&library, "task de|ck"))] {
        let answer = rename(&mut e, uri, &at, "plate");
        let all = [("first.hq", 2), ("lib.hq", 2), ("second.yaml", 2), ("sub/more.yaml", 1)];
        assert_eq!(counts(&folder, &answer), expected(&all));
    }
    // A name that an import chose is renamed there, and where that is imported.
    let answer = rename(&mut e, &other, &find(&third, "hard { ta|ble }"), "plate");
    assert_eq!(counts(&folder, &answer), expected(&[("sub/more.yaml", 1), ("third.hq", 2)]));
    // A parameter of a task, a level of a stack, an arm of a robot, a param.
    for (at, new, all) in [
        ("touch(right, off|set", "way", &[("first.hq", 1), ("lib.hq", 2), ("second.yaml", 1)][..]),
        ("replace mo|ve", "act", &[("first.hq", 1), ("lib.hq", 1)]),
        ("touch(ri|ght", "starboard", &[("first.hq", 1), ("lib.hq", 1)]),
        ("among: low|er", "below", &[("first.hq", 1), ("lib.hq", 2), ("sub/more.yaml", 1)]),
        ("2 * g|ap", "space", &[("first.hq", 5), ("lib.hq", 2)]),
        (
            "import \"lib.hq\" { a|rm",
            "machine",
            &[("first.hq", 1), ("lib.hq", 1), ("second.yaml", 1), ("sub/more.yaml", 1), ("third.hq", 1)],
        ),
        ("from ba|se", "ground", &[("first.hq", 2), ("lib.hq", 1)]),
        ("let twi|ce", "double", &[("first.hq", 2)]),
    ] {
        let answer = rename(&mut e, &doc, &find(&first, at), new);
        assert_eq!(counts(&folder, &answer), expected(all), "{at}");
    }
    assert_eq!(e.goodbye(), Some(0));
}

/// Every word of every file is renamed; what the compiler makes of the files is the same as before.
#[test]
fn after_any_rename_the_programs_are_the_same() {
    let folder = Folder::new("any");
    let before = folder.compiled();
    let mut e = Editor::ready_in(&folder.0);
    let mut seen = BTreeSet::new();
    for name in ["lib.hq", "sub/more.yaml", "first.hq", "second.yaml", "third.hq", "apart.hq"] {
        let (text, doc) = folder.open(&mut e, name);
        let letter = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let starts = text.char_indices().filter(|(i, c)| letter(*c) && !text[..*i].ends_with(letter));
        for (start, _) in starts {
            let answer = rename(&mut e, &doc, &position(&text, start), "zzz_other");
            let changes = &answer["result"]["changes"];
            if changes.is_object() && seen.insert(changes.to_string()) {
                let after = folder.with("any_after", changes).compiled();
                assert_eq!(after, before, "{name}: {:?}\n{changes}", text[start..].lines().next());
            }
        }
    }
    assert!(seen.len() >= 25, "only {} names could be renamed", seen.len());
    assert_eq!(e.goodbye(), Some(0));
}

#[test]
fn a_name_that_means_something_else_in_a_file_is_refused() {
    let folder = Folder::new("clash");
    let mut e = Editor::ready_in(&folder.0);
    let (library, lib) = folder.open(&mut e, "lib.hq");
    for (at, new, place) in [
        ("task de|ck", "wide", "`first.hq`"),
        ("param g|ap", "twice", "`first.hq`"),
        ("task de|ck", "touch", "`lib.hq`"),
        ("stack ba|se", "mine", "`first.hq`"),
        ("arms { le|ft", "right", "`lib.hq`"),
        ("param g|ap", "pi", "word of the language"),
        ("task de|ck", "hold", "word of the language"),
        ("task de|ck", "two words", "is no name"),
    ] {
        let answer = rename(&mut e, &lib, &find(&library, at), new);
        assert_eq!(answer["error"]["code"], -32803, "{at} -> {new}: {answer}");
        assert!(answer["error"]["message"].as_str().is_some_and(|m| m.contains(place)), "{at} -> {new}: {answer}");
    }
    // What stands outside of the workspace is not touched.
    let mut e = Editor::ready_in(&folder.0.join("sub"));
    let (more, doc) = folder.open(&mut e, "sub/more.yaml");
    let answer = rename(&mut e, &doc, &find(&more, "de|ck as"), "plate");
    assert!(answer["error"]["message"].as_str().is_some_and(|m| m.contains("outside of the workspace")), "{answer}");
    let answer = rename(&mut e, &doc, &find(&more, "as ta|ble"), "plate");
    assert_eq!(counts(&folder, &answer), expected(&[("sub/more.yaml", 1)]));
}

#[test]
fn references_go_through_imports_and_other_names() {
    let folder = Folder::new("references");
    let mut e = Editor::ready_in(&folder.0);
    let (third, doc) = folder.open(&mut e, "third.hq");
    let mut all = |declaration: bool| {
        let params = json!({
            "textDocument": { "uri": doc }, "position": find(&third, "hard { ta|ble }"),
            "context": { "includeDeclaration": declaration },
        });
        let list = e.result("textDocument/references", params);
        let list = list.as_array().expect("a list");
        let one = |l: &Json| {
            let name = l["uri"].as_str().expect("an address").trim_start_matches(&folder.uri("")).to_string();
            let text = folder.text(&name);
            (name, under(&text, &l["range"]).to_string())
        };
        list.iter().map(one).collect::<Vec<_>>()
    };
    let found = all(true);
    let count = |name: &str, word: &str| found.iter().filter(|(n, w)| n == name && w == word).count();
    for (name, word, n) in [
        ("lib.hq", "deck", 2),
        ("first.hq", "deck", 2),
        ("second.yaml", "deck", 2),
        ("sub/more.yaml", "deck", 1),
        ("sub/more.yaml", "table", 1),
        ("third.hq", "table", 2),
    ] {
        assert_eq!(count(name, word), n, "{name}: {found:?}");
    }
    assert_eq!(found.len(), 10, "{found:?}");
    assert_eq!(all(false).len(), 9, "without the declaration");
    // To the declaration, through both files.
    let place = e.at("textDocument/definition", &doc, &find(&third, "hard { ta|ble }"));
    assert_eq!((&place["uri"], under(&folder.text("lib.hq"), &place["range"])), (&json!(folder.uri("lib.hq")), "deck"));
    let hover = e.at("textDocument/hover", &doc, &find(&third, "hard { ta|ble }"));
    let says = hover["contents"]["value"].as_str().expect("Markdown");
    for part in ["virtual_wall", "The table top. 🤖 ü", "Declared in `lib.hq`"] {
        assert!(says.contains(part), "{says}");
    }
}

#[test]
fn symbols_of_the_whole_workspace() {
    let folder = Folder::new("symbols");
    std::fs::create_dir_all(folder.0.join("target")).expect("a folder");
    folder.write("target/built.hq", APART);
    folder.write("compose.yaml", "services:\n  deck: { image: x }\n");
    let mut e = Editor::ready_in(&folder.0);
    let mut found = |query: &str| {
        let list = e.result("workspace/symbol", json!({ "query": query }));
        let list = list.as_array().expect("a list").iter();
        list.map(|s| format!("{} {}", s["containerName"].as_str().unwrap_or(""), s["name"].as_str().unwrap_or("")))
            .collect::<Vec<_>>()
    };
    assert_eq!(found("dEck"), ["apart.hq deck", "lib.hq deck"]);
    assert_eq!(found("tch"), ["lib.hq touch"]);
    assert!(found("").len() > 20);
    assert_eq!(found("no such name"), Vec::<String>::new());
}

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

/// What no word shows: names that a repetition makes, and those that a task takes by itself. The compiler is asked.
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

/// Diagnostics too see what is open: a change in one file shows in those that import from it, before it is saved.
#[test]
fn diagnostics_see_unsaved_imports() {
    let folder = Folder::new("diagnostics");
    let mut e = Editor::ready_in(&folder.0);
    let (_, doc) = folder.open(&mut e, "first.hq");
    let codes =
        |list: &[Json]| list.iter().filter(|d| d["severity"] == 1).map(|d| d["code"].clone()).collect::<Vec<_>>();
    assert_eq!(codes(&e.diagnostics(&doc, Some(1))), Vec::<Json>::new());
    // Something asks, so that the server knows what rests on what.
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

/// Values in SI stand behind quantities in other units, also where a unit comes through an import.
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

/// What is open counts as it stands in the editor, saved or not.
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
    // The edits fit the text of the editor.
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
    // And on the disk, when something is saved.
    folder.write("lib.hq", &library.replacen("task deck", "task dock", 1));
    e.notify("textDocument/didSave", json!({ "textDocument": { "uri": doc } }));
    let offered = labels(&e.at("textDocument/completion", &doc, &find(&import, "arm, |, touch")));
    assert!(offered.contains(&"dock".to_string()), "{offered:?}");
}

/// A file that others import from is cut anywhere, or imports those that import it: there is an answer to everything.
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
