//! Files that specs import, and other specs of the workspace: read once, and again after a change. Texts that are open
//! in the editor take precedence over the disk.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::SystemTime;

use dsl::tree::{ItemKind, Spec, ValueKind};
use dsl::{Sources, Syntax};

use super::mentions::{self, Mentions};
use super::text::Text;
use super::urdf::{self, Urdf};
use super::{uri, walk, walk_runs};

/// Maximum number of files visited for one query; the compiler rejects more.
const MOST_FILES: usize = 400;

/// Maximum depth of imports, the same as in the compiler.
const MOST_DEPTH: usize = 64;

/// A text with its path, to which declarations in other files refer.
#[derive(Debug)]
pub(super) struct Source {
    /// Path.
    pub path: PathBuf,
    /// Text.
    pub text: Text,
    /// Syntax.
    pub syntax: Syntax,
}

/// A spec that other specs refer to.
#[derive(Debug)]
pub(super) struct File {
    /// Source of the spec.
    pub source: Rc<Source>,
    /// Meaning of its words.
    pub mentions: Mentions,
    /// Files that it imports, followed by the specs that workers of its missions run.
    pub imports: Vec<Imported>,
    /// URDF of its robot, or of the first one that it imports.
    pub urdf: Option<Rc<Urdf>>,
    /// Paths of all directly and indirectly imported files.
    below: BTreeSet<PathBuf>,
    stamp: Stamp,
}

/// An import of a file.
#[derive(Clone, Debug)]
pub(super) struct Imported {
    /// Path as written in the import.
    pub written: String,
    /// Path to the file.
    path: PathBuf,
    /// The file; `None` if it cannot be read.
    pub file: Option<Rc<File>>,
}

impl File {
    /// True if this file, or one that it imports, has the given path.
    pub fn reaches(&self, path: &Path) -> bool {
        self.source.path == path || self.below.contains(path)
    }
}

/// Paths of all directly and indirectly imported files.
pub(super) fn below(imports: &[Imported]) -> BTreeSet<PathBuf> {
    let further = imports.iter().filter_map(|i| i.file.as_ref()).flat_map(|f| f.below.iter());
    imports.iter().map(|i| &i.path).chain(further).cloned().collect()
}

/// Version of a text, to detect changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stamp {
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

/// Texts of the session, with their cached analyses.
#[derive(Debug, Default)]
pub(super) struct Library {
    open: RefCell<BTreeMap<PathBuf, Open>>,
    count: RefCell<u64>,
    known: RefCell<BTreeMap<PathBuf, Rc<File>>>,
    urdfs: RefCell<BTreeMap<PathBuf, Rc<Urdf>>>,
}

/// Results of one query, with the stack of files being read, to detect cycles.
#[derive(Default)]
struct Visit {
    done: BTreeMap<PathBuf, Option<Rc<File>>>,
    reading: Vec<PathBuf>,
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
    pub fn texts(&self) -> compiler::Texts {
        let place = |path: &PathBuf| path.canonicalize().unwrap_or_else(|_| path.clone());
        self.open.borrow().iter().map(|(path, open)| (place(path), open.text.clone())).collect()
    }

    /// Returns a copy of the library with other texts at some paths.
    pub fn imagined(&self, texts: &BTreeMap<PathBuf, (String, Syntax)>) -> Library {
        let copy = Library {
            open: RefCell::new(self.open.borrow().clone()),
            count: RefCell::new(*self.count.borrow()),
            known: RefCell::new(self.known.borrow().clone()),
            urdfs: RefCell::new(self.urdfs.borrow().clone()),
        };
        for (path, (text, syntax)) in texts {
            copy.open(path.clone(), text, *syntax);
        }
        copy
    }

    /// Returns the spec at a path; `None` if there is none.
    pub fn file(&self, path: &Path) -> Option<Rc<File>> {
        self.visit(path, &mut Visit::default())
    }

    /// Returns the files that a spec imports, followed by the specs that workers of its missions run. `own` is the
    /// spec's path, which these may not import again.
    pub fn imports(&self, spec: &Spec, own: &Path) -> Vec<Imported> {
        let mut visit = Visit { reading: vec![own.to_path_buf()], ..Visit::default() };
        self.imported(spec, own, &mut visit)
    }

    /// Returns the URDF that a spec or one of its imports names.
    pub fn urdf(&self, spec: &Spec, own: &Path, imports: &[Imported]) -> Option<Rc<Urdf>> {
        let named = spec.items.iter().find_map(|item| match &item.kind {
            ItemKind::Robot(robot) => match &robot.body.get("urdf")?.value {
                value if matches!(value.kind, ValueKind::Text(_)) => walk::word(value),
                _ => None,
            },
            _ => None,
        });
        let Some(named) = named else {
            return imports.iter().find_map(|i| i.file.as_ref()?.urdf.clone());
        };
        let path = own.parent().unwrap_or(Path::new("")).join(named);
        let known = self.urdfs.borrow().get(&path).cloned();
        if let Some(known) = known.filter(|u| u.changed == urdf::changed(&path)) {
            return Some(known);
        }
        let read = Rc::new(urdf::read(&path)?);
        self.urdfs.borrow_mut().insert(path, read.clone());
        Some(read)
    }

    fn stamp(&self, path: &Path) -> Option<Stamp> {
        if let Some(open) = self.open.borrow().get(path) {
            return Some(Stamp::Open(open.count));
        }
        let about = std::fs::metadata(path).ok().filter(std::fs::Metadata::is_file)?;
        Some(Stamp::Disk(about.modified().ok(), about.len()))
    }

    fn text(&self, path: &Path) -> Option<(String, Syntax)> {
        if let Some(open) = self.open.borrow().get(path) {
            return Some((open.text.clone(), open.syntax));
        }
        let syntax = Syntax::of_path(path)?;
        let bytes = files::read(path, dsl::limits::MAX_BYTES as u64).ok()?;
        Some((String::from_utf8(bytes).ok()?, syntax))
    }

    fn visit(&self, path: &Path, visit: &mut Visit) -> Option<Rc<File>> {
        if let Some(done) = visit.done.get(path) {
            return done.clone();
        }
        let circle = visit.reading.iter().any(|p| p == path);
        if circle || visit.reading.len() >= MOST_DEPTH || visit.done.len() >= MOST_FILES {
            return None;
        }
        visit.reading.push(path.to_path_buf());
        let found = self.current(path, visit);
        visit.reading.pop();
        visit.done.insert(path.to_path_buf(), found.clone());
        found
    }

    /// Returns the current analysis of a file: from the cache if it is up to date, or from a new reading.
    fn current(&self, path: &Path, visit: &mut Visit) -> Option<Rc<File>> {
        let stamp = self.stamp(path)?;
        let known = self.known.borrow().get(path).cloned();
        if let Some(known) = known.filter(|k| k.stamp == stamp) {
            let same = |i: &Imported, now: Option<Rc<File>>| match (&i.file, &now) {
                (Some(a), Some(b)) => Rc::ptr_eq(a, b),
                (None, None) => true,
                _ => false,
            };
            let robot = known.urdf.as_ref().is_none_or(|u| u.changed == urdf::changed(&u.path));
            if robot && known.imports.iter().all(|i| same(i, self.visit(&i.path, visit))) {
                return Some(known);
            }
        }
        let (text, syntax) = self.text(path)?;
        if !is_spec(&text, syntax) {
            return None;
        }
        let (spec, _) = dsl::parse(Sources::default().add("", ""), &text, syntax);
        let imports = self.imported(&spec, path, visit);
        let urdf = self.urdf(&spec, path, &imports);
        let mentions = mentions::of(&spec, &text, syntax, urdf.as_deref(), &imports);
        let source = Rc::new(Source { path: path.to_path_buf(), text: Text::new(text), syntax });
        let below = below(&imports);
        let file = Rc::new(File { source, mentions, imports, urdf, below, stamp });
        self.known.borrow_mut().insert(path.to_path_buf(), file.clone());
        Some(file)
    }

    fn imported(&self, spec: &Spec, own: &Path, visit: &mut Visit) -> Vec<Imported> {
        let folder = own.parent().unwrap_or(Path::new(""));
        let mut out: Vec<Imported> = Vec::new();
        let imports = spec.items.iter().filter_map(|item| match &item.kind {
            ItemKind::Import(import) => Some(import.path.value.as_str()),
            _ => None,
        });
        for written in imports.chain(walk_runs::specs(spec)) {
            let path = uri::absolute(&folder.join(written));
            let new = out.len() < MOST_FILES && out.iter().all(|i| i.written != written);
            let Some(path) = path.filter(|_| new) else { continue };
            let file = self.visit(&path, visit);
            out.push(Imported { written: written.to_string(), path, file });
        }
        out
    }
}
