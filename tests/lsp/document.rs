//! A document in an editor, with table-driven checks of the server's responses about its places. A place is a piece of
//! the text that occurs once, with `|` at the cursor.

use serde_json::{Value as Json, json};

use super::editor::{Editor, edited, find, labels, position, under, uri};

/// An open document.
pub struct Document {
    pub editor: Editor,
    pub uri: String,
    /// The text as opened, to which tables refer.
    pub text: String,
    version: i64,
}

/// A case of completion: replaced text, replacement with `|` at the cursor, required items, forbidden items.
pub type Completion<'a> = (&'a str, &'a str, &'a [&'a str], &'a [&'a str]);

impl Document {
    /// Opens a document in the folder of the examples. The extension of its name determines the syntax.
    pub fn open(name: &str, text: &str) -> Document {
        let (mut editor, uri) = (Editor::ready(), uri(name));
        editor.open(&uri, if name.ends_with(".yaml") { "yaml" } else { "hierarq" }, text);
        Document { editor, uri, text: text.to_string(), version: 1 }
    }

    /// Opens the same spec in YAML, under this name.
    pub fn open_in_yaml(name: &str, text: &str) -> Document {
        let (tree, diagnostics) = dsl::parse(dsl::SourceId(0), text, dsl::Syntax::Native);
        assert!(diagnostics.is_empty(), "{diagnostics:?}");
        Document::open(name, &dsl::print(&tree, dsl::Syntax::Yaml))
    }

    /// Returns the diagnostics of the present text.
    pub fn diagnostics(&mut self) -> Vec<Json> {
        self.editor.diagnostics(&self.uri, Some(self.version))
    }

    /// Sends a request about the whole document.
    pub fn whole(&mut self, method: &str) -> Json {
        self.editor.result(method, json!({ "textDocument": { "uri": self.uri } }))
    }

    /// Sends a request about a place.
    pub fn at(&mut self, method: &str, place: &str) -> Json {
        self.editor.at(method, &self.uri, &find(&self.text, place))
    }

    /// Replaces the whole text on the server only.
    pub fn change(&mut self, text: &str) {
        self.version += 1;
        self.editor.change(&self.uri, self.version, json!([{ "text": text }]));
    }

    /// Checks the text of the hover at a place, and returns the hover.
    pub fn says(&mut self, place: &str, says: &str) -> Json {
        let hover = self.at("textDocument/hover", place);
        assert!(hover["contents"]["value"].as_str().is_some_and(|v| v.contains(says)), "{place}: {hover}");
        hover
    }

    /// Checks the range and the text of the hover at each place.
    pub fn hovers(&mut self, table: &[(&str, &str, &str)]) {
        for (place, range, says) in table {
            let hover = self.says(place, says);
            assert_eq!(under(&self.text, &hover["range"]), *range, "{place}: {hover}");
        }
    }

    /// Checks that the definition of each place is another one in the document.
    pub fn definitions(&mut self, table: &[(&str, &str)]) {
        for (from, to) in table {
            let there = self.at("textDocument/definition", from);
            assert_eq!(there["uri"], self.uri, "{from}: {there}");
            assert_eq!(there["range"]["start"], find(&self.text, to), "{from}: {there}");
        }
    }

    /// Returns the items after `old` is replaced by `new`. An inserted item replaces the word before the cursor.
    pub fn offered(&mut self, old: &str, new: &str) -> Json {
        assert_eq!(self.text.matches(old).count(), 1, "{old}");
        let marked = self.text.replacen(old, new, 1);
        let cursor = marked.find('|').expect("a cursor");
        let text = marked.replacen('|', "", 1);
        self.change(&text);
        let items = self.editor.at("textDocument/completion", &self.uri, &position(&text, cursor));
        let word = text[..cursor].trim_end_matches(|c: char| c.is_ascii_alphanumeric() || c == '_');
        for item in items.as_array().expect("a list") {
            assert_eq!(under(&text, &item["textEdit"]["range"]), &text[word.len()..cursor], "{new}: {item}");
        }
        items
    }

    /// Checks the required and forbidden items.
    pub fn completions(&mut self, table: &[Completion]) {
        for (old, new, has, has_not) in table {
            let offered = labels(&self.offered(old, new));
            for label in *has {
                assert!(offered.iter().any(|o| o == label), "{new}: no `{label}` in {offered:?}");
            }
            for label in *has_not {
                assert!(!offered.iter().any(|o| o == label), "{new}: `{label}` in {offered:?}");
            }
        }
    }

    /// Returns the number of references of the name at a place, with or without its declaration.
    pub fn references(&mut self, place: &str, declaration: bool) -> usize {
        let params = json!({
            "textDocument": { "uri": self.uri }, "position": find(&self.text, place),
            "context": { "includeDeclaration": declaration },
        });
        self.editor.result("textDocument/references", params).as_array().map_or(0, Vec::len)
    }

    fn rename(&mut self, place: &str, new: &str) -> Json {
        let position = find(&self.text, place);
        let params = json!({ "textDocument": { "uri": self.uri }, "position": position, "newName": new });
        self.editor.ask("textDocument/rename", params)
    }

    /// Returns the text after a rename, and the number of edits. No word is `old` any more.
    pub fn renamed(&mut self, place: &str, old: &str, new: &str) -> (String, usize) {
        let answer = self.rename(place, new);
        let edits = &answer["result"]["changes"][&self.uri];
        let renamed = edited(&self.text, edits);
        let words: Vec<&str> = renamed.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).collect();
        assert!(!words.contains(&old), "{place}: {answer}\n{renamed}");
        (renamed, edits.as_array().map_or(0, Vec::len))
    }

    /// Checks that renames of these places are rejected.
    pub fn refused(&mut self, table: &[(&str, &str)]) {
        for (place, new) in table {
            assert_eq!(self.rename(place, new)["error"]["code"], -32803, "{place} -> {new:?}");
        }
    }
}
