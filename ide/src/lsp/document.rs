//! An open document with the meaning of its words, which is computed on the first request after a change.

use std::cell::{OnceCell, RefCell};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use compiler::resolve::Resolution;
use dsl::tree::Spec;
use dsl::{Severity, Syntax};
use lsp_types::{TextDocumentItem, Uri};

use super::library::{self, File, Library};
use super::text::Text;
use super::uri;

/// An open document.
#[derive(Debug)]
pub(super) struct Document {
    /// Address.
    pub uri: Uri,
    /// Path, if the document is on this machine.
    pub path: Option<PathBuf>,
    /// Latest version number from the editor.
    pub version: i32,
    /// Text.
    pub text: Text,
    syntax: Syntax,
    library: Rc<Library>,
    file: OnceCell<Option<Rc<File>>>,
    /// The file at its last analysis.
    last: RefCell<Option<Rc<File>>>,
}

impl Document {
    /// Opens a document. The extension of its name determines the syntax; without one, the editor's language does.
    pub fn open(item: TextDocumentItem, library: Rc<Library>) -> Document {
        let path = uri::path(&item.uri);
        let by_name = Syntax::of_path(path.as_deref().unwrap_or(Path::new(item.uri.as_str())));
        let by_language = if item.language_id == "yaml" { Syntax::Yaml } else { Syntax::Native };
        let document = Document {
            uri: item.uri,
            path,
            version: item.version,
            text: Text::new(item.text),
            syntax: by_name.unwrap_or(by_language),
            library,
            file: OnceCell::new(),
            last: RefCell::new(None),
        };
        document.library.open(document.place(), document.text.as_str(), document.syntax);
        document
    }

    /// Key of the document in the library: its path, or its address if it has none.
    pub fn place(&self) -> PathBuf {
        self.path.as_deref().and_then(uri::absolute).unwrap_or_else(|| PathBuf::from(self.uri.as_str()))
    }

    /// All texts of the session.
    pub fn library(&self) -> &Library {
        &self.library
    }

    /// Replaces the text.
    pub fn change(&mut self, text: Text, version: i32) {
        self.text = text;
        self.version = version;
        self.file = OnceCell::new();
        self.last = RefCell::new(None);
        self.library.open(self.place(), self.text.as_str(), self.syntax);
    }

    /// Discards the analysis, because other files may have changed.
    pub fn refresh(&mut self) {
        self.file = OnceCell::new();
    }

    /// True if the names of the document depend on the file at a path. The files of the last analysis are kept, so
    /// typing in a file does not cost a new analysis of the files that import it.
    pub fn rests_on(&self, path: &Path) -> bool {
        if self.last.borrow().is_none() {
            self.file();
        }
        self.last.borrow().as_ref().is_some_and(|file| file.rests_on(path))
    }

    /// Syntax; `None` for YAML that is not a spec, since an editor may open many such files.
    pub fn syntax(&self) -> Option<Syntax> {
        library::is_spec(self.text.as_str(), self.syntax).then_some(self.syntax)
    }

    /// Base folder of relative paths.
    pub fn folder(&self) -> &Path {
        self.path.as_deref().and_then(Path::parent).unwrap_or(Path::new(""))
    }

    fn file(&self) -> Option<&Rc<File>> {
        let read = || {
            let file = self.library.file(&self.place());
            *self.last.borrow_mut() = file.clone();
            file
        };
        self.file.get_or_init(read).as_ref()
    }

    /// Meaning of the words; `None` if the document is not a spec.
    pub fn names(&self) -> Option<&Resolution> {
        Some(&self.file()?.names)
    }

    /// Syntax tree; `None` if the document is not a spec.
    pub fn spec(&self) -> Option<&Spec> {
        Some(&self.names()?.spec)
    }

    /// Meaning of the words of a text in place of this document's.
    pub fn imagine(&self, text: &str) -> Option<Resolution> {
        Some(self.library.resolved(&self.place(), text, self.syntax()?))
    }

    /// Formatted text; `None` if the document has syntax errors.
    pub fn formatted(&self) -> Option<String> {
        let names = self.names()?;
        let broken = names.diagnostics.iter().any(|d| d.severity == Severity::Error);
        (!broken).then(|| dsl::print(&names.spec, self.syntax))
    }
}
