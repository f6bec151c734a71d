//! Specs related to a document: open documents, and files in the folders of the workspace.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use lsp_types::{Location, OneOf, SymbolKind, Uri, WorkspaceSymbol};

use super::document::Document;
use super::library::{File, Library, Source, is_spec};
use super::mentions::{Class, Mention, What};
use super::origin::{self, Origin};
use super::uri;

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

/// Function that returns the identity of a word; words of two files are the same if their identities are equal.
pub(super) type Identity = fn(&Path, &super::mentions::Mentions, &What) -> Option<Origin>;

/// A file with the words that refer to a symbol.
#[derive(Debug)]
pub(super) struct Uses {
    /// The file.
    pub file: Rc<File>,
    /// Words, in source order.
    pub words: Vec<Mention>,
}

/// Words of a file with this identity.
pub(super) fn words(file: &File, target: &Origin, identity: Identity) -> Vec<Mention> {
    let same = |m: &&Mention| identity(&file.source.path, &file.mentions, &m.what).as_ref() == Some(target);
    let mut words: Vec<Mention> = file.mentions.all.iter().filter(same).cloned().collect();
    // An imported name that has several classes is one word.
    words.dedup_by(|a, b| a.place == b.place);
    words
}

/// All words with this identity in the specs. A file can contain such words only if it names another file that does.
pub(super) fn uses(target: &Origin, identity: Identity, specs: &Specs, library: &Library) -> Vec<Uses> {
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

/// Address of a source; that of the editor if the source is open.
pub(super) fn address(source: &Source, w: Workspace) -> Option<Uri> {
    let opened = w.documents.iter().find(|d| d.place() == source.path);
    opened.map(|d| d.uri.clone()).or_else(|| uri::of(&source.path))
}

/// References to the symbol at a byte, in all specs; with its declaration if `declaration`.
pub(super) fn references(
    w: Workspace,
    (document, byte): (&Document, usize),
    declaration: bool,
) -> Option<Vec<Location>> {
    let analysis = document.analysis()?;
    let place = document.place();
    let mention = analysis.mentions.at(byte)?;
    let Some(target) = origin::declaration(&place, &analysis.mentions, &mention.what) else {
        // Links and joints are declared in the URDF of this document.
        let all = analysis.mentions.same(&mention.what);
        return Some(all.map(|m| Location::new(document.uri.clone(), document.text.range(m.place.clone()))).collect());
    };
    let specs = specs(&folders(w.roots, &[&place, &target.path]), w.library);
    let mut out = Vec::new();
    for uses in uses(&target, origin::declaration, &specs, w.library) {
        let source = &uses.file.source;
        let Some(uri) = address(source, w) else { continue };
        for m in uses.words.iter().filter(|m| declaration || !m.declares) {
            out.push(Location::new(uri.clone(), source.text.range(m.place.clone())));
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
        let Some(uri) = address(&file.source, w) else { continue };
        for ((class, name), declared) in &file.mentions.declared {
            let Some(kind) = symbol(*class).filter(|_| declared.elsewhere.is_none() && matches(name, query)) else {
                continue;
            };
            if out.len() >= MOST_SYMBOLS {
                return out;
            }
            out.push(WorkspaceSymbol {
                name: name.clone(),
                kind,
                tags: None,
                container_name: path.file_name().map(|n| n.to_string_lossy().into_owned()),
                location: OneOf::Left(Location::new(uri.clone(), file.source.text.range(declared.name.clone()))),
                data: None,
            });
        }
    }
    out
}

/// True if a name contains the letters of a query in order.
fn matches(name: &str, query: &str) -> bool {
    let mut letters = name.chars().map(|c| c.to_ascii_lowercase());
    query.chars().all(|q| letters.any(|c| c == q.to_ascii_lowercase()))
}

fn symbol(class: Class) -> Option<SymbolKind> {
    Some(match class {
        Class::Param | Class::Let => SymbolKind::CONSTANT,
        Class::Robot => SymbolKind::CLASS,
        Class::Task | Class::Field => SymbolKind::FUNCTION,
        Class::Stack | Class::Mission => SymbolKind::MODULE,
        Class::Level => SymbolKind::NAMESPACE,
        Class::Arm => SymbolKind::OBJECT,
        Class::Point | Class::Segment | Class::Tracked => SymbolKind::FIELD,
        Class::Group | Class::JointGroup => SymbolKind::ARRAY,
        Class::Signal | Class::Event => SymbolKind::EVENT,
        Class::Human | Class::Machine | Class::Member => SymbolKind::CLASS,
        Class::State => SymbolKind::ENUM_MEMBER,
        Class::Argument | Class::Raised => return None,
    })
}
