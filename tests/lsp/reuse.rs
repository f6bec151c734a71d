//! Language server: imports, parameters and repetition.

use super::common;
use super::document::Document;
use super::editor::{Editor, edited, find, text, under, uri};
use serde_json::{Value as Json, json};

/// Returns the definition of a marked place: its URI, and the text there.
fn leads(doc: &mut Document, from: &str) -> (String, String) {
    let place = doc.at("textDocument/definition", from);
    let address = place["uri"].as_str().unwrap_or("nowhere").to_string();
    let path = address.trim_start_matches("file://").to_string();
    let there = std::fs::read_to_string(path).unwrap_or_default();
    let there = if there.is_empty() { doc.text.clone() } else { there };
    (address, under(&there, &place["range"]).to_string())
}

#[test]
fn definitions_lead_into_imported_files() {
    let mut doc = Document::open("both_arms.hq", &text("both_arms.hq"));
    assert_eq!(doc.diagnostics(), Vec::<Json>::new());
    let library = uri("common/canopies.hq");
    for (from, name) in [
        ("hard { torso_cl|ear", "torso_clear"),
        ("import \"common/canopies.hq\" {\n  canop|ies", "canopies"),
        ("limits hard { position|_limits", "position_limits"),
    ] {
        assert_eq!(leads(&mut doc, from), (library.clone(), name.to_string()), "{from}");
    }
    assert_eq!(leads(&mut doc, "import \"common/|canopies.hq").0, library);
    doc.says("hard { torso_cl|ear", "between arms  and [column, chest]");
    doc.definitions(&[
        ("offset*swi|ng", "let |swing"),
        ("frame_position(si|de)", "swing_out(|side: arm"),
        ("gain ga|in\n", "point, |gain: rate"),
        ("swing_out(right, off|set:", "arm, |offset: point"),
        ("motion { swing|_out(left, [reach, 0, 0])  swing", "task |swing_out"),
        ("left_only from bo|th", "stack |both {"),
        ("replace mot|ion", "level |motion"),
        ("[re|ach, 0, 0])  swing", "param |reach"),
    ]);
}

#[test]
fn a_file_that_others_import_from_is_no_mistake() {
    let mut e = Editor::ready();
    let robotless = "hierarq 1\nparam gap = 0.1 m\nlet twice = 2*gap\n";
    let unfinished = "hierarq 1\nstack s { level l { joint_velocity_limits } }\n";
    for (name, text, code, severity) in [
        ("common/canopies.hq", text("common/canopies.hq").as_str(), "HQ0601", 3),
        ("common/params.hq", robotless, "HQ0206", 3),
        ("unfinished.hq", unfinished, "HQ0206", 1),
    ] {
        let doc = uri(name);
        e.open(&doc, "hierarq", text);
        let found = e.diagnostics(&doc, Some(1));
        let d = found.iter().find(|d| d["code"] == code).unwrap_or_else(|| panic!("{name}: {found:?}"));
        assert_eq!(d["severity"], severity, "{d}");
        assert!(found.iter().all(|d| d["severity"] == severity || d["severity"] != 1), "{name}: {found:?}");
    }
}

#[test]
fn hover_knows_ranges_and_tasks_that_are_given_to_others() {
    for (name, place) in [("both_arms.hq", "m  ma|x 0.1 m"), ("both_arms.yaml", "m, ma|x: 0.1 m")] {
        Document::open(name, &text(name)).says(place, "largest value");
    }
    let spec = text("both_arms.hq").replacen("stack both {", "stack both(what: task) {", 1).replacen(
        "from both ",
        "from both(hold(right)) ",
        1,
    );
    Document::open("other_arms.hq", &spec).hovers(&[("both(ho|ld(right))", "hold", "**hold**")]);
}

#[test]
fn completion_knows_what_could_be_imported() {
    let mut doc = Document::open("both_arms.hq", &text("both_arms.hq"));
    doc.completions(&[
        ("head_clear\n  arms_apart", "|\n  arms_apart", &["deck"], &[]),
        ("side: arm", "side: |", &["angular_speed"], &[]),
        ("from both", "from |", &["both"], &[]),
        ("replace motion", "replace |", &["posture"], &[]),
        ("stack left_only", "le|\n\nstack left_only", &["let"], &[]),
        ("hold(right)", "hold(|)", &["left"], &[]),
        ("head_clear  arms_apart }", "|  arms_apart }", &["torso_clear"], &[]),
    ]);
}

#[test]
fn what_is_declared_here_is_renamed_and_what_is_not_stays() {
    let mut e = Editor::ready();
    let (spec, doc) = (text("both_arms.hq"), uri("both_arms.hq"));
    e.open(&doc, "hierarq", &spec);
    let mut rename = |from: &str, new: &str| {
        let params = json!({ "textDocument": { "uri": doc }, "position": find(&spec, from), "newName": new });
        let answer = e.result("textDocument/rename", params);
        let edits = &answer["changes"][&doc];
        edits.is_array().then(|| edited(&spec, edits))
    };
    for (from, old, new) in [
        ("offset*swi|ng", "swing", "wave"),
        ("swing_out(right, off|set:", "offset", "way"),
        ("task swing|_out", "swing_out", "wave_out"),
    ] {
        let word =
            |t: &str, w: &str| t.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).filter(|x| *x == w).count();
        let after = rename(from, new).expect("edits");
        // The comment mentions one of them.
        let left = word(&after, old);
        assert!(left <= 1 && word(&after, new) + left == word(&spec, old), "{after}");
    }
    let _ = common::example("");
}

#[test]
fn mistakes_in_imported_files_are_shown_at_the_import() {
    let folder = std::env::temp_dir().join(format!("hierarq lsp imports {}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join("lib.hq"), "hierarq 1\ntask still = joint_velocity { velosity 0 rad/s }\n")
        .expect("written");
    let robot = common::example("robots/arm7.urdf");
    let spec = format!(
        "hierarq 1\nimport \"lib.hq\" {{ still }}\nrobot r {{ urdf \"{}\"  rate 100 Hz  home {{ joint_4 1 rad }} }}\nstack s {{ level l {{ still }} }}\n",
        robot.display()
    );
    let doc = format!("file://{}", folder.join("a.hq").display().to_string().replace(' ', "%20"));
    let mut e = Editor::ready();
    e.open(&doc, "hierarq", &spec);
    let found = e.diagnostics(&doc, Some(1));
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!((found[0]["code"].as_str(), under(&spec, &found[0]["range"])), (Some("HQ0205"), "\"lib.hq\""));
    let place = &found[0]["relatedInformation"][0]["location"];
    assert_eq!((&place["uri"], &place["range"]["start"]["line"]), (&json!(doc.replace("a.hq", "lib.hq")), &json!(1)));
    let _ = std::fs::remove_dir_all(folder);
}
