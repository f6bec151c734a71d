//! An open document, and what is known of it; worked out when it is first asked for after a change.

use std::cell::{OnceCell, RefCell};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use dsl::tree::Spec;
use dsl::{Diagnostic, Severity, Sources, Spelling};
use lsp_types::{TextDocumentItem, Uri};

use super::library::{self, Imported, Library};
use super::mentions::{self, Mentions};
use super::text::Text;
use super::urdf::Urdf;
use super::uri;

/// A tree with the meaning of its words.
#[derive(Debug)]
pub(super) struct Analysis {
    /// The tree.
    pub spec: Spec,
    /// Mistakes of form.
    pub diagnostics: Vec<Diagnostic>,
    /// The meaning of its words.
    pub mentions: Mentions,
    /// The URDF, where it can be read.
    pub urdf: Option<Rc<Urdf>>,
    /// The files that it imports, as far as they can be read.
    pub imports: Vec<Imported>,
}

/// An open document.
#[derive(Debug)]
pub(super) struct Document {
    /// Its address.
    pub uri: Uri,
    /// Its path, where it lies on this machine.
    pub path: Option<PathBuf>,
    /// The version that the editor gave it last.
    pub version: i32,
    /// Its text.
    pub text: Text,
    spelling: Spelling,
    library: Rc<Library>,
    analysis: OnceCell<Analysis>,
    /// The files that it imported when it was looked at last, and those that these import.
    below: RefCell<Option<BTreeSet<PathBuf>>>,
}

impl Document {
    /// Takes a document in. The ending of its name says how it is spelt; without one, the editor does.
    pub fn open(item: TextDocumentItem, library: Rc<Library>) -> Document {
        let path = uri::path(&item.uri);
        let by_name = Spelling::of_path(path.as_deref().unwrap_or(Path::new(item.uri.as_str())));
        let by_language = if item.language_id == "yaml" { Spelling::Yaml } else { Spelling::Hq };
        let document = Document {
            uri: item.uri,
            path,
            version: item.version,
            text: Text::new(item.text),
            spelling: by_name.unwrap_or(by_language),
            library,
            analysis: OnceCell::new(),
            below: RefCell::new(None),
        };
        document.library.open(document.place(), document.text.as_str(), document.spelling);
        document
    }

    /// Where it lies for the library: its path, or its address where it has none.
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
        self.library.open(self.place(), self.text.as_str(), self.spelling);
    }

    /// Forgets what was read from other files.
    pub fn refresh(&mut self) {
        self.analysis = OnceCell::new();
    }

    /// True where what is known of it rests on the file at a path. What others import is remembered until it is looked
    /// at again, so that typing in a file costs those that import from it nothing.
    pub fn rests_on(&self, path: &Path) -> bool {
        if self.below.borrow().is_none() {
            self.analysis();
        }
        self.below.borrow().as_ref().is_some_and(|below| below.contains(path))
    }

    /// How it is spelt; `None` for YAML that is no spec, of which an editor may open many.
    pub fn spelling(&self) -> Option<Spelling> {
        library::is_spec(self.text.as_str(), self.spelling).then_some(self.spelling)
    }

    /// The folder that relative paths start from.
    pub fn folder(&self) -> &Path {
        self.path.as_deref().and_then(Path::parent).unwrap_or(Path::new(""))
    }

    /// What is known of it; `None` where it is no spec.
    pub fn analysis(&self) -> Option<&Analysis> {
        let spelling = self.spelling()?;
        Some(self.analysis.get_or_init(|| {
            let text = self.text.as_str();
            let source = Sources::default().add("", "");
            let (spec, diagnostics) = dsl::parse(source, text, spelling);
            let place = self.place();
            let imports = self.library.imports(&spec, &place);
            *self.below.borrow_mut() = Some(library::below(&imports));
            let urdf = self.library.urdf(&spec, &place, &imports);
            let mentions = mentions::of(&spec, text, spelling, urdf.as_deref(), &imports);
            Analysis { spec, diagnostics, mentions, urdf, imports }
        }))
    }

    /// What the words of a text would mean that stood in this document.
    pub fn imagine(&self, text: &str) -> Option<Mentions> {
        let source = Sources::default().add("", "");
        let (spec, _) = dsl::parse(source, text, self.spelling()?);
        let analysis = self.analysis();
        let urdf = analysis.and_then(|a| a.urdf.clone());
        let imports = analysis.map_or(&[][..], |a| &a.imports);
        Some(mentions::of(&spec, text, self.spelling()?, urdf.as_deref(), imports))
    }

    /// The whole text as the formatter writes it; `None` where it cannot be read in full.
    pub fn formatted(&self) -> Option<String> {
        let analysis = self.analysis()?;
        let broken = analysis.diagnostics.iter().any(|d| d.severity == Severity::Error);
        (!broken).then(|| dsl::print(&analysis.spec, self.spelling))
    }
}
