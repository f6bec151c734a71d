//! Libraries whose manifest leaves out their unit tests or their doctests have none. Each of them is compiled once more for its
//! unit tests, and read once more for its doctests, even if there are none: `test = false` and `doctest = false` save both.

use std::path::Path;

use toml_edit::Document;

use crate::common::sources;

/// Returns true if documentation in this text has a block of code that is compiled as Rust.
fn has_doctest(text: &str) -> bool {
    let mut open = false;
    let docs = text.lines().filter_map(|line| line.trim_start().strip_prefix("//")?.strip_prefix(['/', '!']));
    for language in docs.filter_map(|line| line.trim_start().strip_prefix("```")) {
        let words = ["", "rust", "should_panic", "no_run", "compile_fail", "ignore"];
        let is_rust = |word: &str| words.contains(&word) || word.starts_with("edition");
        if !open && language.trim().split(',').all(is_rust) {
            return true;
        }
        open = !open;
    }
    false
}

#[test]
fn what_is_left_out_has_no_tests() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let manifest = |folder: &Path| -> Document<String> {
        std::fs::read_to_string(folder.join("Cargo.toml")).expect("a manifest").parse().expect("TOML")
    };
    let workspace = manifest(root);
    let members = workspace["workspace"]["members"].as_array().expect("a list");
    let members = members.iter().map(|member| root.join(member.as_str().expect("a folder")));
    let mut left_out = 0;
    for folder in members.chain([root.to_path_buf()]) {
        let manifest = manifest(&folder);
        let is_off =
            |key: &str| manifest.get("lib").and_then(|lib| lib.get(key)).and_then(|v| v.as_bool()) == Some(false);
        let mut all = Vec::new();
        sources::below(&folder.join("src"), &mut all);
        for file in all {
            let text = std::fs::read_to_string(&file).expect("text");
            let tests = ["#[test]", "#[cfg(test)]", "proptest!"].iter().any(|mark| text.contains(mark));
            assert!(!is_off("test") || !tests, "{}: remove `test = false` from the manifest", file.display());
            assert!(
                !is_off("doctest") || !has_doctest(&text),
                "{}: remove `doctest = false` from the manifest",
                file.display()
            );
        }
        left_out += usize::from(is_off("test")) + usize::from(is_off("doctest"));
    }
    assert!(left_out > 20, "{left_out}");
}

#[test]
fn doctests_are_recognised() {
    for (text, expected) in [
        ("/// ```\n/// let x = 1;\n/// ```\n", true),
        ("//! ```rust,no_run\n//! ```\n", true),
        ("    /// ```text\n    /// a\n    /// ```\n", false),
        ("// ```\n", false),
    ] {
        assert_eq!(has_doctest(text), expected, "{text}");
    }
}
