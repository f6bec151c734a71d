//! An open document with its analysis, which is computed on the first request after a change.

use std::cell::{OnceCell, RefCell};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use dsl::tree::Spec;
use dsl::{Diagnostic, Severity, Sources, Syntax};
use lsp_types::{TextDocumentItem, Uri};

use super::library::{self, Imported, Library};
use super::mentions::{self, Mentions};
use super::text::Text;
use super::urdf::Urdf;
use super::uri;

/// A syntax tree with the meaning of its words.
#[derive(Debug)]
pub(super) struct Analysis {
    /// Syntax tree.
    pub spec: Spec,
    /// Syntax errors.
    pub diagnostics: Vec<Diagnostic>,
    /// Meaning of the words.
    pub mentions: Mentions,
    /// URDF, if it can be read.
    pub urdf: Option<Rc<Urdf>>,
    /// Imported files that can be read.
    pub imports: Vec<Imported>,
}

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
    analysis: OnceCell<Analysis>,
    /// Files that the document imported at its last analysis, directly and indirectly.
    below: RefCell<Option<BTreeSet<PathBuf>>>,
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
            analysis: OnceCell::new(),
            below: RefCell::new(None),
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
        self.analysis = OnceCell::new();
        self.below = RefCell::new(None);
        self.library.open(self.place(), self.text.as_str(), self.syntax);
    }

    /// Discards the analysis, because other files may have changed.
    pub fn refresh(&mut self) {
        self.analysis = OnceCell::new();
    }

    /// True if the analysis depends on the file at a path. The set of imported files is kept between analyses, so
    /// typing in a file does not cost a new analysis of the files that import it.
    pub fn rests_on(&self, path: &Path) -> bool {
        if self.below.borrow().is_none() {
            self.analysis();
        }
        self.below.borrow().as_ref().is_some_and(|below| below.contains(path))
    }

    /// Syntax; `None` for YAML that is not a spec, since an editor may open many such files.
    pub fn syntax(&self) -> Option<Syntax> {
        library::is_spec(self.text.as_str(), self.syntax).then_some(self.syntax)
    }

    /// Base folder of relative paths.
    pub fn folder(&self) -> &Path {
        self.path.as_deref().and_then(Path::parent).unwrap_or(Path::new(""))
    }

    /// Analysis; `None` if the document is not a spec.
    pub fn analysis(&self) -> Option<&Analysis> {
        let syntax = self.syntax()?;
        Some(self.analysis.get_or_init(|| {
            let text = self.text.as_str();
            let source = Sources::default().add("", "");
            let (spec, diagnostics) = dsl::parse(source, text, syntax);
            let place = self.place();
            let imports = self.library.imports(&spec, &place);
            *self.below.borrow_mut() = Some(library::below(&imports));
            let urdf = self.library.urdf(&spec, &place, &imports);
            let mentions = mentions::of(&spec, text, syntax, urdf.as_deref(), &imports);
            Analysis { spec, diagnostics, mentions, urdf, imports }
        }))
    }

    /// Meaning of the words of a text in place of this document's.
    pub fn imagine(&self, text: &str) -> Option<Mentions> {
        let source = Sources::default().add("", "");
        let (spec, _) = dsl::parse(source, text, self.syntax()?);
        let analysis = self.analysis();
        let urdf = analysis.and_then(|a| a.urdf.clone());
        let imports = analysis.map_or(&[][..], |a| &a.imports);
        Some(mentions::of(&spec, text, self.syntax()?, urdf.as_deref(), imports))
    }

    /// Formatted text; `None` if the document has syntax errors.
    pub fn formatted(&self) -> Option<String> {
        let analysis = self.analysis()?;
        let broken = analysis.diagnostics.iter().any(|d| d.severity == Severity::Error);
        (!broken).then(|| dsl::print(&analysis.spec, self.syntax))
    }
}
