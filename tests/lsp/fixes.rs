//! Language server: quick fixes and inlay hints.

use serde_json::{Value as Json, json};

use super::editor::{Editor, edited, spec, text, under, uri};

/// Returns the titles of the fixes for the whole text, and the text after each.
fn fixes(e: &mut Editor, name: &str, text: &str) -> Vec<(String, String)> {
    let doc = uri(name);
    e.open(&doc, "hierarq", text);
    let end = json!({ "line": text.lines().count(), "character": 0 });
    let range = json!({ "start": { "line": 0, "character": 0 }, "end": end });
    let params = json!({ "textDocument": { "uri": doc }, "range": range, "context": { "diagnostics": [] } });
    let actions = e.result("textDocument/codeAction", params);
    let one = |a: &Json| {
        assert_eq!(a["kind"], "quickfix");
        let shown = a["diagnostics"][0].clone();
        assert!(shown["code"].as_str().is_some_and(|c| c.starts_with("HQ")), "{a}");
        assert!(!under(text, &shown["range"]).contains('\u{0}'));
        (a["title"].as_str().expect("a title").to_string(), edited(text, &a["edit"]["changes"][&doc]))
    };
    actions.as_array().expect("a list").iter().map(one).collect()
}

/// Returns the codes of the diagnostics of a text in the folder of the examples.
fn codes(name: &str, text: &str) -> Vec<&'static str> {
    let folder = crate::common::example("");
    let syntax = dsl::Syntax::of_path(name.as_ref()).expect("a spec");
    let input = compiler::Input { name, text, syntax, folder: &folder, set: &[], package_paths: &[] };
    compiler::compile(&input).report.diagnostics.iter().map(|d| d.code).collect()
}

/// Inserts one mistake into a valid spec: the fix of that title gives the expected text.
fn mended(e: &mut Editor, name: &str, good: &str, (right, wrong): (&str, &str), title: &str, wanted: &str) {
    assert_eq!(good.matches(right).count(), 1, "`{right}` does not stand once in the text");
    let bad = good.replace(right, wrong);
    let all = fixes(e, name, &bad);
    let found = all.iter().find(|f| f.0 == title);
    let found = found
        .unwrap_or_else(|| panic!("{wrong}: no `{title}` among {:?}", all.iter().map(|f| &f.0).collect::<Vec<_>>()));
    assert_eq!(found.1, good.replace(right, wanted), "{title}");
    assert!(codes(name, &bad).len() > codes(name, &found.1).len(), "{title}");
}

#[test]
fn fixes_in_hq() {
    let mut e = Editor::ready();
    let good = spec();
    for (right, wrong, title, wanted) in [
        ("tip link_7", "tip lnik_7", "Write `link_7`", "tip link_7"),
        ("gain 5 /s", "gian 5 /s", "Write `gain`", "gain 5 /s"),
        (
            "= joint_position_limits",
            "= joint_positon_limits",
            "Write `joint_position_limits`",
            "= joint_position_limits",
        ),
        ("param reach =", "param reach", "Write `=`", "param reach ="),
        ("rate 100 Hz", "rate: 100 Hz", "Delete `:`", "rate 100 Hz"),
        ("rate 100 Hz", "rate 100 Hxz", "Write `Hz`", "rate 100 Hz"),
        ("  rate 100 Hz\n", "", "Add `rate 100 Hz`", ""),
        ("urdf \"robots/arm7.urdf\"", "urdf robots/arm7.urdf", "Put it in quotes", "urdf \"robots/arm7.urdf\""),
        ("robot arm {", "robot arm", "Write the missing `{`", "robot arm {"),
        ("joint_2 0.5 rad", "joint_2 0.5", "Write the unit `rad`", "joint_2 0.5 rad"),
        ("joint_2 0.5 rad", "joint_2 0.5", "Write the unit `deg`", "joint_2 0.5 deg"),
        ("// How near", "param lost = 2\n// How near", "Remove `lost`", "// How near"),
        ("hierarq 1\n", "", "Write `hierarq 1` at the top", "hierarq 1\n"),
    ] {
        if title.starts_with("Add") {
            let bad = good.replace(right, wrong);
            let all = fixes(&mut e, "lsp_test.hq", &bad);
            let found = all.iter().find(|f| f.0 == title).unwrap_or_else(|| panic!("no `{title}` among {all:?}"));
            assert!(found.1.contains("robot arm { rate 100 Hz "), "{}", found.1);
            assert!(codes("lsp_test.hq", &found.1).is_empty(), "{:?}", codes("lsp_test.hq", &found.1));
            continue;
        }
        mended(&mut e, "lsp_test.hq", &good, (right, wrong), title, wanted);
    }
    let go = "task go = frame_position(only)";
    let bad = format!("{}\nstack other {{ level l {{ frame_position(tool) }} }}\n", good.trim_end());
    let all = fixes(&mut e, "lsp_test.hq", &bad);
    let found = all.iter().find(|f| f.0 == "Add `position initial(position)`").unwrap_or_else(|| panic!("{all:?}"));
    assert!(found.1.contains("frame_position(tool) { position initial(position) }") && found.1.contains(go));
    assert!(fixes(&mut e, "lsp_test.hq", &good).is_empty(), "a good text needs none");
    assert_eq!(e.goodbye(), Some(0));
}

#[test]
fn fixes_in_yaml() {
    let mut e = Editor::ready();
    let good = text("hello.yaml");
    for (right, wrong, title, wanted) in [
        ("rate: 100 Hz", "rtae: 100 Hz", "Write `rate`", "rate: 100 Hz"),
        ("rate: 100 Hz", "rate: 100 hz", "Write `Hz`", "rate: 100 Hz"),
        ("robots:", "robot:", "Write `robots`", "robots:"),
        (
            "\"initial(position) + [0, 0.2, 0.1] m * sin(pi*t/(4 s))\"",
            "initial(position) + [0, 0.2, 0.1] m * sin(pi*t/(4 s))",
            "Put it in quotes",
            "\"initial(position) + [0, 0.2, 0.1] m * sin(pi*t/(4 s))\"",
        ),
        (" rate: 100 Hz,", "", "Add `rate 100 Hz`", "arm: { rate: 100 Hz, urdf"),
    ] {
        let bad = good.replace(right, wrong);
        let all = fixes(&mut e, "lsp_test.yaml", &bad);
        let found = all.iter().find(|f| f.0 == title).unwrap_or_else(|| panic!("no `{title}` among {all:?}"));
        assert!(found.1.contains(wanted), "{}", found.1);
        assert!(codes("lsp_test.yaml", &found.1).is_empty(), "{:?}\n{}", codes("lsp_test.yaml", &found.1), found.1);
    }
    // The robot in block style, with each entry on a line.
    let flow = good.lines().find(|l| l.contains("arm:")).expect("the robot");
    let block = "  arm:\n    urdf: robots/arm7.urdf\n    home: { joint_4: 1 rad }";
    let all = fixes(&mut e, "lsp_test.yaml", &good.replace(flow, block));
    let found = all.iter().find(|f| f.0 == "Add `rate 100 Hz`").unwrap_or_else(|| panic!("{all:?}"));
    assert!(found.1.contains("  arm:\n    rate: 100 Hz\n    urdf"), "{}", found.1);
    assert!(codes("lsp_test.yaml", &found.1).is_empty());
    assert_eq!(e.goodbye(), Some(0));
}

#[test]
fn other_kinds_of_actions_are_none_of_ours() {
    let mut e = Editor::ready();
    let (bad, doc) = (spec().replace("tip link_7", "tip lnik_7"), uri("lsp_test.hq"));
    e.open(&doc, "hierarq", &bad);
    let range = json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 99, "character": 0 } });
    let context = json!({ "diagnostics": [], "only": ["source.organizeImports"] });
    let params = json!({ "textDocument": { "uri": doc }, "range": range, "context": context });
    assert_eq!(e.result("textDocument/codeAction", params), json!([]));
    // There are no fixes at places other than the mistake.
    let top = json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 0, "character": 3 } });
    let params = json!({ "textDocument": { "uri": doc }, "range": top, "context": { "diagnostics": [] } });
    assert_eq!(e.result("textDocument/codeAction", params), json!([]));
    assert_eq!(e.goodbye(), Some(0));
}

#[test]
fn hints_show_si() {
    let mut e = Editor::ready();
    for (name, text) in [
        (
            "lsp_test.hq",
            "hierarq 1\nparam u = 45 deg\nparam a = [1, -2] cm\nparam b = 2 m + 30 ms * (1 m/s)\nparam c = 3 rad\n",
        ),
        (
            "lsp_test.yaml",
            "hierarq: 1\nparams:\n  u: 45 deg\n  a: \"[1, -2] cm\"\n  b: 2 m + 30 ms * (1 m/s)\n  c: 3 rad\n",
        ),
    ] {
        let doc = uri(name);
        e.open(&doc, "hierarq", text);
        let range = json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 9, "character": 0 } });
        let hints = e.result("textDocument/inlayHint", json!({ "textDocument": { "uri": doc }, "range": range }));
        let hints = hints.as_array().expect("a list");
        let labels: Vec<&str> = hints.iter().filter_map(|h| h["label"].as_str()).collect();
        assert_eq!(labels, ["= 0.785398 rad", "= [0.01, -0.02] m", "= 0.03 s"], "{name}");
        for (hint, before) in hints.iter().zip(["45 deg", "cm", "30 ms"]) {
            let start = json!({ "line": hint["position"]["line"], "character": 0 });
            let line = under(text, &json!({ "start": start, "end": hint["position"] }));
            assert!(line.ends_with(before), "{line}");
        }
        let one = json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 1, "character": 0 } });
        let none = e.result("textDocument/inlayHint", json!({ "textDocument": { "uri": doc }, "range": one }));
        assert_eq!(none, json!([]), "none in the first line");
    }
    assert_eq!(e.goodbye(), Some(0));
}
