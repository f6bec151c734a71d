//! Specs of the session with their symbols and references: read once, and again after a change. Texts that are open in
//! the editor take precedence over the disk.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::SystemTime;

use compiler::resolve::{Resolution, Urdf, read_urdf, resolve};
use compiler::{Input, Texts};
use dsl::Syntax;

use super::text::Text;
use super::uri;

/// A spec with the meaning of its words.
#[derive(Debug)]
pub(super) struct File {
    /// Path.
    pub path: PathBuf,
    /// Text.
    pub text: Text,
    /// Syntax.
    pub syntax: Syntax,
    /// Symbols and references.
    pub names: Resolution,
    /// Versions of this text and of the files that the names depend on.
    versions: BTreeMap<PathBuf, Option<Version>>,
}

impl File {
    /// True if the names depend on the file at a path.
    pub fn rests_on(&self, path: &Path) -> bool {
        self.versions.contains_key(path)
    }
}

/// Version of a text, to detect changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Version {
    /// Number of the editor's text.
    Open(u64),
    /// Modification time and length of the file.
    Disk(Option<SystemTime>, u64),
}

/// A text that is open in the editor.
#[derive(Clone, Debug)]
struct Open {
    count: u64,
    text: String,
    syntax: Syntax,
}

/// A URDF that was read, with its version.
type KnownUrdf = (Option<Version>, Option<Rc<Urdf>>);

/// Texts of the session, with their cached names.
#[derive(Clone, Debug, Default)]
pub(super) struct Library {
    open: RefCell<BTreeMap<PathBuf, Open>>,
    count: RefCell<u64>,
    known: RefCell<BTreeMap<PathBuf, Rc<File>>>,
    urdfs: RefCell<BTreeMap<PathBuf, KnownUrdf>>,
}

/// True if a text is a spec. YAML files can have any other contents.
pub(super) fn is_spec(text: &str, syntax: Syntax) -> bool {
    let header = |l: &str| l.trim_start_matches('\u{feff}').starts_with("hierarq:");
    syntax == Syntax::Native || text.lines().any(header)
}

impl Library {
    /// Replaces the text of a path by one of the editor.
    pub fn open(&self, path: PathBuf, text: &str, syntax: Syntax) {
        let mut count = self.count.borrow_mut();
        *count += 1;
        self.open.borrow_mut().insert(path, Open { count: *count, text: text.to_string(), syntax });
    }

    /// Reverts the text of a path to that of the disk.
    pub fn close(&self, path: &Path) {
        self.open.borrow_mut().remove(path);
    }

    /// Paths and texts of the open documents.
    pub fn opened(&self) -> Vec<(PathBuf, String)> {
        self.open.borrow().iter().map(|(path, open)| (path.clone(), open.text.clone())).collect()
    }

    /// Texts of the open documents, as input of the compiler.
    pub fn texts(&self) -> Texts {
        let place = |path: &PathBuf| path.canonicalize().unwrap_or_else(|_| path.clone());
        self.open.borrow().iter().map(|(path, open)| (place(path), open.text.clone())).collect()
    }

    /// Returns a copy of the library with other texts at some paths.
    pub fn imagined(&self, texts: &BTreeMap<PathBuf, (String, Syntax)>) -> Library {
        let copy = self.clone();
        for (path, (text, syntax)) in texts {
            copy.open(path.clone(), text, *syntax);
        }
        copy
    }

    /// Returns the spec at a path; `None` if there is none.
    pub fn file(&self, path: &Path) -> Option<Rc<File>> {
        let known = self.known.borrow().get(path).cloned();
        if let Some(known) = known.filter(|k| k.versions.iter().all(|(path, version)| self.version(path) == *version)) {
            return Some(known);
        }
        let (text, syntax) = self.text(path).filter(|(text, syntax)| is_spec(text, *syntax))?;
        let names = self.resolved(path, &text, syntax);
        let others = names.files.iter().map(|f| &f.path).chain(&names.missing).filter_map(|path| uri::absolute(path));
        let versions = others.chain([path.to_path_buf()]).map(|path| (path.clone(), self.version(&path))).collect();
        let file = Rc::new(File { path: path.to_path_buf(), text: Text::new(text), syntax, names, versions });
        self.known.borrow_mut().insert(path.to_path_buf(), file.clone());
        Some(file)
    }

    /// Resolves the names of a text at a path.
    pub fn resolved(&self, path: &Path, text: &str, syntax: Syntax) -> Resolution {
        let (name, folder) = (path.display().to_string(), path.parent().unwrap_or(Path::new("")));
        let input = Input { name: &name, text, syntax, folder, set: &[], package_paths: &[] };
        resolve(&input, &self.texts(), &|path| self.urdf(path))
    }

    fn urdf(&self, path: &Path) -> Option<Rc<Urdf>> {
        let version = self.version(path);
        let known = self.urdfs.borrow().get(path).filter(|known| known.0 == version).cloned();
        known.map_or_else(
            || {
                let urdf = read_urdf(path).map(Rc::new);
                self.urdfs.borrow_mut().insert(path.to_path_buf(), (version, urdf.clone()));
                urdf
            },
            |known| known.1,
        )
    }

    fn version(&self, path: &Path) -> Option<Version> {
        if let Some(open) = self.open.borrow().get(path) {
            return Some(Version::Open(open.count));
        }
        let about = std::fs::metadata(path).ok().filter(std::fs::Metadata::is_file)?;
        Some(Version::Disk(about.modified().ok(), about.len()))
    }

    fn text(&self, path: &Path) -> Option<(String, Syntax)> {
        if let Some(open) = self.open.borrow().get(path) {
            return Some((open.text.clone(), open.syntax));
        }
        let syntax = Syntax::of_path(path)?;
        let bytes = files::read(path, dsl::limits::MAX_BYTES as u64).ok()?;
        Some((String::from_utf8(bytes).ok()?, syntax))
    }
}
