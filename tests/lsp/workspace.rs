//! Language server: several specs that import from each other, with references, rename and symbols across files.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use serde_json::{Value as Json, json};

use super::common;
use super::editor::{Editor, edited, find, position, under};

const LIBRARY: &str = r#"hierarq 1

param gap = 0.3 m { min 0 m }

robot arm {
  urdf "ROBOT"
  rate 100 Hz
  arms { left { tip link_7  points [elbow] }  right { tip link_6 } }
  points { elbow link_4 }
  joints { lower ["joint_1", "joint_2"] }
  home { joint_2 0.5 rad  joint_4 1.6 rad }
}

// The table top. 🤖 ü
task deck = virtual_wall { points elbow  through [[0, 0, 0.1], [1, 0, 0.1], [0, 1, 0.1]] m  d_min gap }

task touch(side: arm, offset: point = [0, 0, 0] m, among: joints = lower) = frame_position(side) {
  position initial(position) + offset
}

stack base {
  level gentle hard { joint_position_limits  joint_velocity_limits  joint_acceleration_limits }
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

pub(super) const FIRST: &str = r#"hierarq 1
import "lib.hq" { arm, deck, touch, gap, base }
let twice = 2 * gap
task wide = touch(right, offset: [0, 0, gap])
stack mine from base { replace move { wide weight 2  touch(left, among: lower) } }
stack other { level gentle hard { joint_position_limits  joint_velocity_limits  joint_acceleration_limits }  level safe hard { deck }  level move { touch(left, [0, 0, twice - gap - gap]) } }
run { stack mine }
"#;

const SECOND: &str = r#"hierarq: 1
import: { lib.hq: [arm, deck, touch] }
stacks:
  s:
    levels:
      - { name: gentle, hard: true, tasks: [joint_position_limits, joint_velocity_limits, joint_acceleration_limits] }
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

/// A folder with the specs, removed when it is dropped.
pub(super) struct Folder(pub(super) PathBuf);

impl Folder {
    pub(super) fn new(name: &str) -> Folder {
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

    pub(super) fn write(&self, name: &str, text: &str) {
        let robot = common::example("robots/arm7.urdf").display().to_string();
        std::fs::write(self.0.join(name), text.replace("ROBOT", &robot)).expect("written");
    }

    pub(super) fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.0.join(name)).expect("there")
    }

    pub(super) fn uri(&self, name: &str) -> String {
        format!("file://{}", self.0.join(name).display())
    }

    pub(super) fn open(&self, e: &mut Editor, name: &str) -> (String, String) {
        let (text, uri) = (self.text(name), self.uri(name));
        e.open(&uri, name.rsplit('.').next().expect("an ending"), &text);
        (text, uri)
    }

    /// Returns the codes of the diagnostics of each entry, and the structure of its program.
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

    /// Returns a copy of the folder with edits applied, under another name.
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

pub(super) fn rename(e: &mut Editor, uri: &str, at: &Json, new: &str) -> Json {
    e.ask("textDocument/rename", json!({ "textDocument": { "uri": uri }, "position": at, "newName": new }))
}

/// Returns the number of edits of each file.
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
    // From a use in an importing file and from its declaration: the same.
    for (uri, at) in [(&doc, find(&first, "hard { de|ck }")), (&lib, find(&library, "task de|ck"))] {
        let answer = rename(&mut e, uri, &at, "plate");
        let all = [("first.hq", 2), ("lib.hq", 2), ("second.yaml", 2), ("sub/more.yaml", 1)];
        assert_eq!(counts(&folder, &answer), expected(&all));
    }
    // An alias of an import is renamed there, and in the importers of that file.
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

/// Every word of every file is renamed, and the compiled programs are the same as before.
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
    // Files outside of the workspace are not changed.
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
