//! The files in `editors/` contain all words of the language.

use std::path::Path;

use super::editor::{Editor, uri};
use serde_json::{Value as Json, json};

fn file(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("editors").join(name);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Returns the words of a text.
fn words(text: &str) -> Vec<&str> {
    text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).collect()
}

#[test]
fn highlighting_knows_the_words_of_the_language() {
    let (grammar, syntax) = (file("vscode/syntaxes/hq.tmLanguage.json"), file("nvim/hierarq.vim"));
    let declarations = [
        "hierarq", "import", "param", "let", "robot", "task", "stack", "signal", "variable", "machine", "mission",
        "scenario", "for", "coverage", "run",
    ];
    let states = ["state", "final", "initial", "blend", "timeout", "enter", "do", "exit", "on", "when", "expect"];
    let formulas = ["always", "eventually", "never", "within", "to", "until", "implies"];
    let inside = ["level", "hard", "weight", "from", "replace", "add", "remove", "before", "after", "as", "in"];
    let roles = dsl::vocabulary::ROLES.iter().copied();
    let operators = ["and", "or", "not", "pi", "t", "time"];
    let units = dsl::vocabulary::UNITS.iter().copied();
    for word in
        declarations.into_iter().chain(inside).chain(states).chain(formulas).chain(operators).chain(units).chain(roles)
    {
        assert!(words(&grammar).contains(&word), "the grammar of VS Code lacks `{word}`");
        assert!(words(&syntax).contains(&word), "the syntax of Neovim lacks `{word}`");
    }
    for name in compiler::parameter_types().map(|t| t.0).chain(["event", "flag", "wrench"]) {
        assert!(words(&syntax).contains(&name), "the syntax of Neovim lacks the type `{name}`");
    }
}

#[test]
fn the_file_of_all_words_is_a_good_spec() {
    let mut e = Editor::ready();
    let (text, doc) = (file("words.hq"), uri("../editors/words.hq"));
    e.open(&doc, "hierarq", &text);
    assert_eq!(e.diagnostics(&doc, Some(1)), Vec::<Json>::new());
    let params = json!({ "textDocument": { "uri": doc }, "options": { "tabSize": 2, "insertSpaces": true } });
    assert_eq!(e.result("textDocument/formatting", params), json!([]), "it is formatted");
    let reuse =
        ["import", "let", "for", "in", "from", "replace", "add", "remove", "before", "after", "and", "or", "not"];
    let signals =
        ["signal", "event", "flag", "wrench", "timeout", "present", "stale", "frame", "bias", "low_pass", "variable"];
    let machines = [
        "machine", "initial", "blend", "state", "region", "ended", "final", "stack", "enter", "do", "exit", "on",
        "when",
    ];
    let scenarios = [
        "mission",
        "robot",
        "human",
        "worker",
        "scenario",
        "expect",
        "always",
        "eventually",
        "never",
        "within",
        "to",
        "until",
        "implies",
    ];
    let triggers = ["fault", "reached", "any", "infeasible", "emit", "say", "capture", "gripper", "set", "tare"];
    for word in reuse.into_iter().chain(signals).chain(machines).chain(triggers).chain(scenarios) {
        assert!(words(&text).contains(&word), "`{word}` is not shown");
    }
}
