//! The files that specs import, and other specs of the workspace: read once, and again where they have changed. What is
//! open in the editor counts as it stands there.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::SystemTime;

use dsl::tree::{ItemKind, Spec, ValueKind};
use dsl::{Sources, Spelling};

use super::mentions::{self, Mentions};
use super::text::Text;
use super::urdf::{self, Urdf};
use super::{uri, walk, walk_runs};

/// Most files that are looked into for one question; the compiler refuses more.
const MOST_FILES: usize = 400;

/// How deep imports are followed; the compiler follows as many.
const MOST_DEPTH: usize = 64;

/// A text with its place, to which declarations of other files point.
#[derive(Debug)]
pub(super) struct Source {
    /// Where it lies.
    pub path: PathBuf,
    /// What stands there.
    pub text: Text,
    /// How it is spelt.
    pub spelling: Spelling,
}

/// A spec that is not looked at for its own sake.
#[derive(Debug)]
pub(super) struct File {
    /// Its text.
    pub source: Rc<Source>,
    /// The meaning of its words.
    pub mentions: Mentions,
    /// The files that it imports, then those that workers of its missions run.
    pub imports: Vec<Imported>,
    /// The URDF of its robot, or of the first one that it imports.
    pub urdf: Option<Rc<Urdf>>,
    /// Where all files lie that it imports, and those that these import.
    below: BTreeSet<PathBuf>,
    stamp: Stamp,
}

/// An import of a file.
#[derive(Clone, Debug)]
pub(super) struct Imported {
    /// As the import writes it.
    pub written: String,
    /// Where it should lie.
    path: PathBuf,
    /// The file; `None` where it cannot be read.
    pub file: Option<Rc<File>>,
}

impl File {
    /// True where this file, or one that it imports, lies at a path.
    pub fn reaches(&self, path: &Path) -> bool {
        self.source.path == path || self.below.contains(path)
    }
}

/// Where the files lie that are imported, and those that these import.
pub(super) fn below(imports: &[Imported]) -> BTreeSet<PathBuf> {
    let further = imports.iter().filter_map(|i| i.file.as_ref()).flat_map(|f| f.below.iter());
    imports.iter().map(|i| &i.path).chain(further).cloned().collect()
}

/// By what a text is known to be the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stamp {
    /// The text of the editor that came as this one.
    Open(u64),
    /// The state of the file.
    Disk(Option<SystemTime>, u64),
}

/// What the editor has open.
#[derive(Clone, Debug)]
struct Open {
    count: u64,
    text: String,
    spelling: Spelling,
}

/// The texts, and what is known of them.
#[derive(Debug, Default)]
pub(super) struct Library {
    open: RefCell<BTreeMap<PathBuf, Open>>,
    count: RefCell<u64>,
    known: RefCell<BTreeMap<PathBuf, Rc<File>>>,
    urdfs: RefCell<BTreeMap<PathBuf, Rc<Urdf>>>,
}

/// What one question has found, and the files that are being read for it.
#[derive(Default)]
struct Visit {
    done: BTreeMap<PathBuf, Option<Rc<File>>>,
    reading: Vec<PathBuf>,
}

/// True for a text that is a spec: YAML may be anything else.
pub(super) fn is_spec(text: &str, spelling: Spelling) -> bool {
    let header = |l: &str| l.trim_start_matches('\u{feff}').starts_with("hierarq:");
    spelling == Spelling::Hq || text.lines().any(header)
}

impl Library {
    /// From now on the text of a path is this one.
    pub fn open(&self, path: PathBuf, text: &str, spelling: Spelling) {
        let mut count = self.count.borrow_mut();
        *count += 1;
        self.open.borrow_mut().insert(path, Open { count: *count, text: text.to_string(), spelling });
    }

    /// From now on the text of a path is that of the disk.
    pub fn close(&self, path: &Path) {
        self.open.borrow_mut().remove(path);
    }

    /// Paths and texts of what is open.
    pub fn opened(&self) -> Vec<(PathBuf, String)> {
        self.open.borrow().iter().map(|(path, open)| (path.clone(), open.text.clone())).collect()
    }

    /// What is open, as the compiler takes it.
    pub fn texts(&self) -> compiler::Texts {
        let place = |path: &PathBuf| path.canonicalize().unwrap_or_else(|_| path.clone());
        self.open.borrow().iter().map(|(path, open)| (place(path), open.text.clone())).collect()
    }

    /// The same library, with other texts at some paths.
    pub fn imagined(&self, texts: &BTreeMap<PathBuf, (String, Spelling)>) -> Library {
        let copy = Library {
            open: RefCell::new(self.open.borrow().clone()),
            count: RefCell::new(*self.count.borrow()),
            known: RefCell::new(self.known.borrow().clone()),
            urdfs: RefCell::new(self.urdfs.borrow().clone()),
        };
        for (path, (text, spelling)) in texts {
            copy.open(path.clone(), text, *spelling);
        }
        copy
    }

    /// The spec at a path; `None` where there is none.
    pub fn file(&self, path: &Path) -> Option<Rc<File>> {
        self.visit(path, &mut Visit::default())
    }

    /// The files that a spec imports, then those that workers of its missions run. `own` is its path, which they may not import again.
    pub fn imports(&self, spec: &Spec, own: &Path) -> Vec<Imported> {
        let mut visit = Visit { reading: vec![own.to_path_buf()], ..Visit::default() };
        self.imported(spec, own, &mut visit)
    }

    /// The URDF that a spec names, or one of its imports.
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

    fn text(&self, path: &Path) -> Option<(String, Spelling)> {
        if let Some(open) = self.open.borrow().get(path) {
            return Some((open.text.clone(), open.spelling));
        }
        let spelling = Spelling::of_path(path)?;
        let bytes = files::read(path, dsl::limits::MAX_BYTES as u64).ok()?;
        Some((String::from_utf8(bytes).ok()?, spelling))
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

    /// The file as it is now: what is known of it, or what is read.
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
        let (text, spelling) = self.text(path)?;
        if !is_spec(&text, spelling) {
            return None;
        }
        let (spec, _) = dsl::parse(Sources::default().add("", ""), &text, spelling);
        let imports = self.imported(&spec, path, visit);
        let urdf = self.urdf(&spec, path, &imports);
        let mentions = mentions::of(&spec, &text, spelling, urdf.as_deref(), &imports);
        let source = Rc::new(Source { path: path.to_path_buf(), text: Text::new(text), spelling });
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
