//! Specs related to a document: open documents, and files in the folders of the workspace.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use compiler::resolve::{FileId, Meaning, Reference, Resolution, SymbolId, SymbolKind};
use lsp_types::{Location, OneOf, Uri, WorkspaceSymbol};

use super::document::Document;
use super::library::{File, Library, is_spec};
use super::{navigation, uri};

/// Maximum number of files and folders visited by a search for specs.
const MOST_ENTRIES: usize = 20_000;

/// Maximum number of specs read for one query.
const MOST_SPECS: usize = 1_000;

/// Maximum number of bytes read for one query.
const MOST_BYTES: u64 = 32 << 20;

/// Maximum depth of searched folders.
const MOST_DEPTH: usize = 16;

/// Maximum number of symbols in one response.
const MOST_SYMBOLS: usize = 256;

/// Open documents and folders of the editor.
#[derive(Clone, Copy)]
pub(super) struct Workspace<'s> {
    /// The open documents.
    pub documents: &'s [&'s Document],
    /// The folders of the workspace.
    pub roots: &'s [PathBuf],
    /// All texts.
    pub library: &'s Library,
}

/// Specs that may refer to a symbol.
#[derive(Debug, Default)]
pub(super) struct Specs {
    /// Texts by path.
    pub texts: BTreeMap<PathBuf, String>,
    /// False if there were too many to read them all.
    pub whole: bool,
}

/// Finds specs in folders, and adds the open ones. Skips hidden files, symbolic links and build folders.
pub(super) fn specs(folders: &[PathBuf], library: &Library) -> Specs {
    let opened: BTreeMap<PathBuf, String> = library.opened().into_iter().collect();
    let mut found = Specs { texts: BTreeMap::new(), whole: true };
    let (mut entries, mut bytes) = (0, 0);
    let mut open: Vec<(PathBuf, usize)> = folders.iter().map(|f| (f.clone(), 0)).collect();
    while let Some((folder, depth)) = open.pop() {
        let Ok(list) = std::fs::read_dir(&folder) else { continue };
        for entry in list.flatten() {
            entries += 1;
            if entries > MOST_ENTRIES {
                return Specs { whole: false, ..found };
            }
            let (path, name) = (entry.path(), entry.file_name());
            let Ok(about) = entry.metadata() else { continue };
            let passed = [".", "target", "node_modules"].iter().any(|p| match *p {
                "." => name.as_encoded_bytes().starts_with(b"."),
                other => name == other,
            });
            if about.is_dir() && !passed {
                if depth >= MOST_DEPTH {
                    found.whole = false;
                } else {
                    open.push((path, depth + 1));
                }
                continue;
            }
            let Some(syntax) = dsl::Syntax::of_path(&path).filter(|_| about.is_file()) else { continue };
            if found.texts.contains_key(&path) || opened.contains_key(&path) {
                continue;
            }
            if found.texts.len() >= MOST_SPECS || bytes + about.len() > MOST_BYTES {
                found.whole = false;
                continue;
            }
            bytes += about.len();
            let text = files::read(&path, about.len()).ok().and_then(|bytes| String::from_utf8(bytes).ok());
            if let Some(text) = text.filter(|text| is_spec(text, syntax)) {
                found.texts.insert(path, text);
            }
        }
    }
    found.texts.extend(opened);
    found
}

/// Folders to search for references from a document: those of the workspace, or without a workspace those of the
/// document and of the declaring file.
pub(super) fn folders(roots: &[PathBuf], places: &[&Path]) -> Vec<PathBuf> {
    if !roots.is_empty() {
        return roots.to_vec();
    }
    let mut all: Vec<PathBuf> =
        places.iter().filter_map(|p| p.parent()).filter(|p| p.is_absolute()).map(Path::to_path_buf).collect();
    all.sort();
    all.dedup();
    // A nested folder is searched with its parent.
    all.iter().filter(|f| !all.iter().any(|o| o != *f && f.starts_with(o))).cloned().collect()
}

/// A declaration in the workspace: its file, and the start of its name there (bytes).
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Place {
    /// File.
    pub path: PathBuf,
    /// Start of the name.
    pub start: usize,
}

impl Place {
    /// Place of a symbol.
    pub fn of(names: &Resolution, id: SymbolId) -> Option<Place> {
        let path = uri::absolute(&names.file_of(id).path)?;
        Some(Place { path, start: names.symbol(id).place.start })
    }
}

/// Function that returns the symbol whose references are wanted.
pub(super) type Identity = fn(&Resolution, SymbolId) -> SymbolId;

/// A file with the words that refer to a symbol.
#[derive(Debug)]
pub(super) struct Uses {
    /// The file.
    pub file: Rc<File>,
    /// Words, in source order.
    pub words: Vec<Reference>,
}

/// Words of a file that refer to the symbol at a place.
pub(super) fn words(file: &File, target: &Place, identity: Identity) -> Vec<Reference> {
    let names = &file.names;
    let is_target: Vec<bool> = (0..names.symbols.len())
        .map(|i| Place::of(names, identity(names, SymbolId(i))).as_ref() == Some(target))
        .collect();
    let same = |r: &&Reference| matches!(r.meaning, Meaning::Symbol(id) if is_target[id.0]);
    let mut words: Vec<Reference> = names.references.iter().filter(same).cloned().collect();
    // An imported name that several symbols have is one word.
    words.dedup_by(|a, b| a.place == b.place);
    words
}

/// All words with this identity in the specs. A file can contain such words only if it names another file that does.
pub(super) fn uses(target: &Place, identity: Identity, specs: &Specs, library: &Library) -> Vec<Uses> {
    let mut found: BTreeMap<PathBuf, Uses> = BTreeMap::new();
    let mut open = vec![target.path.clone()];
    while let Some(path) = open.pop() {
        let Some(name) = path.file_name().and_then(|n| n.to_str()) else { continue };
        for (other, text) in &specs.texts {
            let near = *other == path || text.contains(name);
            let Some(file) = (near && !found.contains_key(other)).then(|| library.file(other)).flatten() else {
                continue;
            };
            let words = words(&file, target, identity);
            if !words.is_empty() {
                open.push(other.clone());
                found.insert(other.clone(), Uses { file, words });
            }
        }
        // The file itself may be outside of the searched folders.
        if !found.contains_key(&path)
            && let Some(file) = library.file(&path)
        {
            let words = words(&file, target, identity);
            found.insert(path, Uses { file, words });
        }
    }
    found.into_values().collect()
}

/// Address of a file; that of the editor if the file is open.
pub(super) fn address(file: &File, w: Workspace) -> Option<Uri> {
    let opened = w.documents.iter().find(|d| d.place() == file.path);
    opened.map(|d| d.uri.clone()).or_else(|| uri::of(&file.path))
}

/// References to the symbol at a byte, in all specs; with its declaration if `declaration`.
pub(super) fn references(
    w: Workspace,
    (document, byte): (&Document, usize),
    declaration: bool,
) -> Option<Vec<Location>> {
    let names = document.names()?;
    let meaning = &names.at(byte)?.meaning;
    let place = document.place();
    let declared = match meaning {
        Meaning::Symbol(id) => Some(names.origin(*id)).filter(|id| names.file_of(*id).syntax.is_some()),
        _ => None,
    };
    let Some(target) = declared.and_then(|id| Place::of(names, id)) else {
        // Links and joints are declared in the URDF of this document.
        let all = names.references.iter().filter(|r| navigation::same(&r.meaning, meaning));
        return Some(all.map(|r| Location::new(document.uri.clone(), document.text.range(r.place.clone()))).collect());
    };
    let specs = specs(&folders(w.roots, &[&place, &target.path]), w.library);
    let mut out = Vec::new();
    for uses in uses(&target, Resolution::origin, &specs, w.library) {
        let file = &uses.file;
        let Some(uri) = address(file, w) else { continue };
        // An import that renames a symbol is a reference to it.
        let declares = |r: &Reference| match r.meaning {
            Meaning::Symbol(id) => r.declares && file.names.symbol(id).imported.is_none(),
            _ => false,
        };
        for r in uses.words.iter().filter(|r| declaration || !declares(r)) {
            out.push(Location::new(uri.clone(), file.text.range(r.place.clone())));
        }
    }
    Some(out)
}

/// Declarations of all specs whose names contain the letters of a query in order.
pub(super) fn symbols(w: Workspace, query: &str) -> Vec<WorkspaceSymbol> {
    let specs = specs(w.roots, w.library);
    let mut out = Vec::new();
    for path in specs.texts.keys() {
        let Some(file) = w.library.file(path) else { continue };
        let Some(uri) = address(&file, w) else { continue };
        for (i, symbol) in file.names.symbols.iter().enumerate() {
            let name = shown(&file.names, SymbolId(i));
            let own = symbol.file == FileId(0) && symbol.imported.is_none();
            let Some(kind) = kind_of(symbol.kind).filter(|_| own && matches(&name, query)) else { continue };
            if out.len() >= MOST_SYMBOLS {
                return out;
            }
            out.push(WorkspaceSymbol {
                name,
                kind,
                tags: None,
                container_name: path.file_name().map(|n| n.to_string_lossy().into_owned()),
                location: OneOf::Left(Location::new(uri.clone(), file.text.range(symbol.place.clone()))),
                data: None,
            });
        }
    }
    out
}

/// Name of a symbol in a list: that of a part of the robot alone, and others with their containers.
fn shown(names: &Resolution, id: SymbolId) -> String {
    let symbol = names.symbol(id);
    match symbol.container {
        Some(outer) if names.symbol(outer).kind == SymbolKind::Robot => symbol.name.clone(),
        _ => names.path(id),
    }
}

/// True if a name contains the letters of a query in order.
fn matches(name: &str, query: &str) -> bool {
    let mut letters = name.chars().map(|c| c.to_ascii_lowercase());
    query.chars().all(|q| letters.any(|c| c == q.to_ascii_lowercase()))
}

fn kind_of(kind: SymbolKind) -> Option<lsp_types::SymbolKind> {
    use lsp_types::SymbolKind as L;
    Some(match kind {
        SymbolKind::Param | SymbolKind::Let => L::CONSTANT,
        SymbolKind::Robot | SymbolKind::Human | SymbolKind::Machine | SymbolKind::Member => L::CLASS,
        SymbolKind::Task | SymbolKind::SafetyField => L::FUNCTION,
        SymbolKind::Obstacle => L::OBJECT,
        SymbolKind::Stack | SymbolKind::Mission => L::MODULE,
        SymbolKind::Level => L::NAMESPACE,
        SymbolKind::Arm => L::OBJECT,
        SymbolKind::Point | SymbolKind::Segment | SymbolKind::HumanPoint => L::FIELD,
        SymbolKind::Group | SymbolKind::JointGroup | SymbolKind::Posture => L::ARRAY,
        SymbolKind::Signal | SymbolKind::Event => L::EVENT,
        SymbolKind::Variable => L::VARIABLE,
        SymbolKind::State => L::ENUM_MEMBER,
        SymbolKind::Parameter
        | SymbolKind::RaisedEvent
        | SymbolKind::Outcome
        | SymbolKind::Link
        | SymbolKind::Joint => return None,
    })
}
