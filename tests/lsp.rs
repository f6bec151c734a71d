//! The language server, tested by an editor of our own over the pipes of the real process.

use crate::common;
mod allowances;
mod coverage;
mod document;
mod editor;
mod fields;
mod files;
mod fixes;
mod humans;
mod imports;
mod machines;
mod mission_scenarios;
mod missions;
mod planners;
mod reuse;
mod signals;
mod words;
mod workers;
mod workspace;

use std::io::Write;

use serde_json::{Value as Json, json};

use editor::{Editor, edited, find, position, spec, text, under, uri};

#[test]
fn says_hello_and_goodbye() {
    let mut e = Editor::new();
    assert_eq!(e.error("textDocument/hover", json!({})), -32002, "not before it is initialised");
    let hello = e.result("initialize", json!({ "capabilities": {} }));
    assert_eq!(hello["serverInfo"]["name"], "hierarq");
    let able = &hello["capabilities"];
    for what in [
        "hover",
        "definition",
        "references",
        "rename",
        "completion",
        "documentSymbol",
        "workspaceSymbol",
        "documentFormatting",
        "codeAction",
        "inlayHint",
    ] {
        assert!(!able[format!("{what}Provider")].is_null(), "{what}");
    }
    e.notify("initialized", json!({}));
    assert_eq!(e.error("textDocument/conjure", json!({})), -32601);
    assert_eq!(e.error("workspace/executeCommand", json!({ "command": "x" })), -32601, "never advertised");
    assert_eq!(e.error("textDocument/hover", json!({ "textDocument": 7 })), -32602);
    e.notify("$/cancelRequest", json!({ "id": 1 }));
    e.notify("textDocument/didOpen", json!("nonsense"));
    let nowhere = json!({ "line": 3, "character": 4 });
    assert_eq!(e.at("textDocument/hover", "file:///not/open.hq", &nowhere), Json::Null);
    assert_eq!(e.result("shutdown", Json::Null), Json::Null);
    assert_eq!(e.error("textDocument/hover", json!({})), -32600, "nothing after the shutdown");
    e.notify("exit", Json::Null);
    assert_eq!(e.process.wait().expect("it ends").code(), Some(0));
}

#[test]
fn leaves_when_the_editor_does() {
    let mut e = Editor::ready();
    e.notify("exit", Json::Null);
    assert_eq!(e.process.wait().expect("it ends").code(), Some(1), "without a shutdown");
    let mut e = Editor::ready();
    drop(e.to.take());
    assert_eq!(e.process.wait().expect("it ends").code(), Some(1), "the pipe closed");
    let mut e = Editor::ready();
    e.to.as_mut().expect("open").write_all(b"Content-Length: 3\r\n\r\n{{{").expect("written");
    let code = e.process.wait().expect("it ends").code();
    assert!(matches!(code, Some(1 | 2)), "no protocol, and {code:?}");
}

#[test]
fn diagnostics_follow_the_text() {
    let mut e = Editor::ready();
    let good = spec();
    let doc = uri("lsp_test.hq");
    let bad = good.replace("tip link_7", "tip lnik_7").replace("duration 1 s", "title \"ä\" duration 1 m");
    e.open(&doc, "hierarq", &bad);
    let found = e.diagnostics(&doc, Some(1));
    let by = |code: &str| found.iter().find(|d| d["code"] == code).unwrap_or_else(|| panic!("no {code}: {found:?}"));
    let name = by("HQ0201");
    assert_eq!(under(&bad, &name["range"]), "lnik_7");
    assert_eq!(name["severity"], 1);
    assert!(name["message"].as_str().is_some_and(|m| m.contains("help: did you mean `link_7`?")), "{name}");
    assert_eq!(under(&bad, &by("HQ0301")["range"]), "1 m");
    let twice = found.iter().find(|d| !d["relatedInformation"].is_null()).expect("`title` stands twice");
    let other = &twice["relatedInformation"][0]["location"];
    assert_eq!(other["uri"], doc);
    assert!(under(&bad, &other["range"]).starts_with("title"), "{twice}");
    // The command line reports the same.
    let folder = common::example("");
    let input = compiler::Input {
        name: "x",
        text: &bad,
        syntax: dsl::Syntax::Native,
        folder: &folder,
        set: &[],
        package_paths: &[],
    };
    let expected: Vec<&str> = compiler::compile(&input).report.diagnostics.iter().map(|d| d.code).collect();
    let codes: Vec<&str> = found.iter().filter_map(|d| d["code"].as_str()).collect();
    assert_eq!(codes, expected);
    // Two partial changes in one message, the second relative to the result of the first.
    let half = bad.replace("lnik_7", "link_7");
    let one = json!({ "start": find(&bad, "tip |lnik_7"), "end": find(&bad, "tip lnik_7|") });
    let two = json!({ "start": find(&half, "|title \"ä\" dur"), "end": find(&half, "title \"ä\" duration 1 m|") });
    let changes = json!([{ "range": one, "text": "link_7" }, { "range": two, "text": "duration 1 s" }]);
    e.change(&doc, 2, changes);
    assert_eq!(e.diagnostics(&doc, Some(2)), Vec::<Json>::new());
    e.change(&doc, 3, json!([{ "text": "hierarq 1\nrobot" }]));
    assert!(!e.diagnostics(&doc, Some(3)).is_empty());
    e.notify("textDocument/didClose", json!({ "textDocument": { "uri": doc } }));
    assert_eq!(e.diagnostics(&doc, None), Vec::<Json>::new(), "taken back");
    assert_eq!(e.goodbye(), Some(0));
}

#[test]
fn what_is_wrong_in_the_urdf_is_shown_where_the_spec_names_it() {
    let folder = std::env::temp_dir().join(format!("hierarq lsp ü {}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let urdf = "<robot name=\"r\">\n  <link name=\"a\"/>\n  <joint name=\"ü\" type=\"sliding\"/>\n</robot>\n";
    std::fs::write(folder.join("bad.urdf"), urdf).expect("written");
    let spec = "hierarq 1\nrobot r { urdf \"bad.urdf\"  rate 100 Hz }\n";
    let address: String = folder.join("a.hq").display().to_string().replace(' ', "%20").replace('ü', "%C3%BC");
    let doc = format!("file://{address}");
    let mut e = Editor::ready();
    e.open(&doc, "hierarq", spec);
    let found = e.diagnostics(&doc, Some(1));
    let d = found.iter().find(|d| d["code"] == "HQ0402").unwrap_or_else(|| panic!("{found:?}"));
    assert!(under(spec, &d["range"]).contains("bad.urdf"), "{d}");
    let place = &d["relatedInformation"][0]["location"];
    assert_eq!(place["uri"], doc.replace("a.hq", "bad.urdf"));
    assert_eq!(place["range"]["start"]["line"], 2, "{d}");
    let _ = std::fs::remove_dir_all(folder);
}

#[test]
fn formatting_is_that_of_the_command_line() {
    let mut e = Editor::ready();
    for (name, syntax) in [("hello.hq", dsl::Syntax::Native), ("hello.yaml", dsl::Syntax::Yaml)] {
        let (good, doc) = (text(name), uri(name));
        let messy = good.replacen("\n\n", "\n\n\n\n", 1).replace("  rate", "      rate");
        let messy = if syntax == dsl::Syntax::Yaml { good.replacen("\n\n", "\n\n\n\n", 1) } else { messy };
        assert_ne!(messy, good);
        e.open(&doc, "hierarq", &messy);
        let params = json!({ "textDocument": { "uri": doc }, "options": { "tabSize": 2, "insertSpaces": true } });
        let edits = e.result("textDocument/formatting", params.clone());
        let source = dsl::Sources::default().add("", "");
        let expected = dsl::print(&dsl::parse(source, &messy, syntax).0, syntax);
        assert_eq!(edited(&messy, &edits), expected, "{name}");
        e.change(&doc, 2, json!([{ "text": expected }]));
        assert_eq!(e.result("textDocument/formatting", params.clone()), json!([]), "nothing to do");
        e.change(&doc, 3, json!([{ "text": messy.replace('{', "{ ) ").replace("rate:", "[rate:") }]));
        assert_eq!(e.result("textDocument/formatting", params), Json::Null, "a broken text is left alone");
    }
}

#[test]
fn the_outline_and_the_words() {
    let mut e = Editor::ready();
    let (text, doc) = (spec(), uri("lsp_test.hq"));
    e.open(&doc, "hierarq", &text);
    let params = json!({ "textDocument": { "uri": doc } });
    let symbols = e.result("textDocument/documentSymbol", params.clone());
    let names = |list: &Json| -> Vec<String> {
        let list = list.as_array().expect("a list").iter();
        list.map(|s| s["name"].as_str().expect("a name").to_string()).collect()
    };
    assert_eq!(names(&symbols), ["reach", "arm", "limits", "deck", "go", "work", "run"]);
    assert_eq!(names(&symbols[1]["children"]), ["only", "elbow", "all_of_it"]);
    assert_eq!(names(&symbols[5]["children"]), ["keep", "gentle", "move"]);
    assert_eq!(under(&text, &symbols[3]["selectionRange"]), "deck");
    assert!(under(&text, &symbols[3]["range"]).starts_with("task deck = virtual_wall {"));
    // Tokens, reconstructed from their relative positions.
    let tokens = e.result("textDocument/semanticTokens/full", params);
    let data: Vec<u64> = tokens["data"].as_array().expect("numbers").iter().filter_map(Json::as_u64).collect();
    let (mut line, mut column) = (0, 0);
    let mut words = Vec::new();
    for t in data.chunks(5) {
        (line, column) = if t[0] == 0 { (line, column + t[1]) } else { (line + t[0], t[1]) };
        let start = json!({ "line": line, "character": column });
        let end = json!({ "line": line, "character": column + t[2] });
        words.push((under(&text, &json!({ "start": start, "end": end })).to_string(), t[3]));
    }
    for (word, kind) in
        [("virtual_wall", 1), ("d_min", 2), ("deck", 3), ("sin", 4), ("joint_4", 5), ("t", 5), ("reach", 6)]
    {
        assert!(words.contains(&(word.to_string(), kind)), "{word}: {words:?}");
    }
    assert!(words.iter().all(|(w, _)| w.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_')), "{words:?}");
}

/// Texts truncated anywhere, or with a piece missing: every request gets a response, and the session continues.
#[test]
fn half_written_texts() {
    let mut e = Editor::ready();
    let mut version = 1;
    for (name, whole) in [("lsp_test.hq", spec()), ("lsp_test.yaml", text("hello.yaml"))] {
        let doc = uri(name);
        e.open(&doc, "hierarq", "");
        let mut state = 12345u64;
        for i in 0..120usize {
            // Pseudo-random cuts that are the same in every run.
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            let places: Vec<usize> = whole.char_indices().map(|c| c.0).collect();
            let from = places[(state >> 33) as usize % places.len()];
            let length = if i % 3 == 0 { whole.len() } else { i };
            let to = places.iter().copied().find(|p| *p >= from + length).unwrap_or(whole.len());
            let text = format!("{}{}", &whole[..from], &whole[to..]);
            version += 1;
            e.change(&doc, version, json!([{ "text": text }]));
            let at = position(&text, from);
            for method in ["hover", "completion", "definition", "prepareRename", "documentHighlight"] {
                e.at(&format!("textDocument/{method}"), &doc, &at);
            }
            let document = json!({ "uri": doc });
            e.result("textDocument/documentSymbol", json!({ "textDocument": document }));
            e.result("textDocument/semanticTokens/full", json!({ "textDocument": document }));
            let all = json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 999, "character": 0 } });
            e.result("textDocument/inlayHint", json!({ "textDocument": document, "range": all }));
            let here = json!({ "start": at, "end": at });
            let params = json!({ "textDocument": document, "range": here, "context": { "diagnostics": [] } });
            e.result("textDocument/codeAction", params);
            let new = json!({ "textDocument": document, "position": at, "newName": "other" });
            let answer = e.ask("textDocument/rename", new);
            assert_ne!(answer["error"]["code"], -32603, "a fault in the server:\n{text}");
        }
        e.diagnostics(&doc, Some(version));
    }
    assert_eq!(e.goodbye(), Some(0));
}
