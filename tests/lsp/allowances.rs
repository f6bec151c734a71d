//! Language server: warnings that a spec allows.

use serde_json::json;

use super::common;
use super::document::Document;
use super::editor::{Editor, edited, uri};

const ALLOWED: &str = r#"hierarq 1

robot arm { urdf "robots/arm7.urdf"  rate 100 Hz  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad } }

stack carry {
  level limits hard { joint_position_limits  joint_velocity_limits }
  level tray { hold(tool) }
  level gentle hard { allow HQ0606 "soft on purpose"  joint_acceleration_limits }
}
"#;

#[test]
fn codes_are_offered_and_explained() {
    let mut doc = Document::open("lsp_allowed.hq", ALLOWED);
    assert!(doc.diagnostics().is_empty());
    doc.hovers(&[
        ("al|low HQ", "allow", "Every block has this key"),
        ("HQ06|06", "HQ0606", "soft level above a hard one"),
    ]);
    doc.completions(&[
        ("allow HQ0606 \"soft on purpose\"", "allow |", &["HQ0606", "HQ0203"], &["HQ0201", "joint_position_limits"]),
        ("allow HQ0606 \"soft on purpose\"", "allow HQ06|", &["HQ0606"], &[]),
        ("rate 100 Hz", "rate 100 Hz  |", &["allow"], &[]),
    ]);
    let yaml = in_yaml(ALLOWED);
    let mut doc = Document::open("lsp_allowed.yaml", &yaml);
    assert!(doc.diagnostics().is_empty(), "{yaml}");
    doc.hovers(&[("HQ06|06", "HQ0606", "soft level above a hard one")]);
    doc.completions(&[("allow: { HQ0606: soft on purpose }", "allow: { | }", &["HQ0606"], &["HQ0201"])]);
}

/// The fix leaves the reason to the author, and nothing but its lack is reported then.
#[test]
fn a_warning_is_allowed_by_a_fix() {
    let blocks = "hierarq: 1\nrobots:\n  arm: { urdf: robots/arm7.urdf, rate: 100 Hz, home: { joint_4: 1.6 rad } }\nstacks:\n  carry:\n    levels:\n      - name: tray\n        tasks: [hold(tool)]\n      - name: gentle\n        hard: true\n        tasks: [joint_velocity_limits, joint_acceleration_limits]\n";
    let native = ALLOWED.replace("allow HQ0606 \"soft on purpose\"  ", "");
    for (name, text, wanted) in [
        ("lsp_fix.hq", native.clone(), "level gentle hard { allow HQ0606 \"\""),
        ("lsp_fix.yaml", in_yaml(&native), "allow: { HQ0606: \"\" }"),
        ("lsp_fix_2.yaml", blocks.to_string(), "allow: { HQ0606: \"\" }"),
    ] {
        let mut e = Editor::ready();
        let doc = uri(name);
        e.open(&doc, if name.ends_with(".hq") { "hierarq" } else { "yaml" }, &text);
        let end = json!({ "line": text.lines().count(), "character": 0 });
        let range = json!({ "start": { "line": 0, "character": 0 }, "end": end });
        let params = json!({ "textDocument": { "uri": doc }, "range": range, "context": { "diagnostics": [] } });
        let actions = e.result("textDocument/codeAction", params);
        let fix = actions.as_array().expect("a list").iter().find(|a| a["title"] == "Allow HQ0606 with a reason");
        let fix = fix.unwrap_or_else(|| panic!("{name}: {actions}"));
        assert_eq!(fix["isPreferred"], false);
        let after = edited(&text, &fix["edit"]["changes"][&doc]);
        assert!(after.contains(wanted), "{after}");
        assert_eq!(codes(name, &after), ["HQ0222"], "{after}");
        assert!(codes(name, &after.replace("\"\"", "\"soft on purpose\"")).is_empty(), "{after}");
        assert_eq!(e.goodbye(), Some(0));
    }
}

fn codes(name: &str, text: &str) -> Vec<&'static str> {
    let folder = common::example("");
    let syntax = dsl::Syntax::of_path(name.as_ref()).expect("a spec");
    let input = compiler::Input { name, text, syntax, folder: &folder, set: &[], package_paths: &[] };
    compiler::compile(&input).report.diagnostics.iter().map(|d| d.code).collect()
}

fn in_yaml(text: &str) -> String {
    let (tree, diagnostics) = dsl::parse(dsl::SourceId(0), text, dsl::Syntax::Native);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    dsl::print(&tree, dsl::Syntax::Yaml)
}
