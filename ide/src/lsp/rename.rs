//! Renaming: changes a word where it was chosen and in all its uses, in all specs at once. The result is parsed again
//! before it is offered: the new name must have the same meaning in the same places, and no other word may change its
//! meaning.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use compiler::resolve::{Meaning, Reference, Resolution, Symbol, SymbolId, SymbolKind, built_in};
use dsl::{Severity, Syntax};
use lsp_types::{PrepareRenameResponse, TextEdit, Uri};

use super::document::Document;
use super::hover::verbs_with;
use super::library::Library;
use super::workspace::{self, Place, Specs, Uses, Workspace};

/// Maximum number of specs that are compiled to verify the result.
const MOST_COMPILED: usize = 64;

/// Word at a byte, with its symbol if a spec declares it.
fn chosen(document: &Document, byte: usize) -> Option<(&Reference, SymbolId)> {
    let names = document.names()?;
    let reference = names.at(byte)?;
    match reference.meaning {
        Meaning::Symbol(id) if names.file_of(id).syntax.is_some() && names.symbol(id).kind != SymbolKind::Outcome => {
            Some((reference, id))
        }
        _ => None,
    }
}

/// Identity of a renamed symbol: an import that renames a symbol chooses a word of its own.
fn itself(_: &Resolution, id: SymbolId) -> SymbolId {
    id
}

/// Range and current text of the name to be renamed.
pub(super) fn prepare(document: &Document, byte: usize) -> Option<PrepareRenameResponse> {
    let (reference, _) = chosen(document, byte).filter(|(r, _)| r.exact)?;
    let placeholder = document.text.as_str().get(reference.place.clone())?.to_string();
    Some(PrepareRenameResponse::RangeWithPlaceholder {
        range: document.text.range(reference.place.clone()),
        placeholder,
    })
}

/// Returns the edits of all files that rename the symbol at a byte.
///
/// # Errors
/// Reason why the symbol cannot be renamed.
pub(super) fn rename(
    w: Workspace,
    (document, byte): (&Document, usize),
    new: &str,
) -> Result<Vec<(Uri, Vec<TextEdit>)>, String> {
    let (_, id) = chosen(document, byte).ok_or("only names that a spec declares can be renamed")?;
    let names = document.names().ok_or("this document is no spec")?;
    let symbol = names.symbol(id).clone();
    let old = symbol.name.as_str();
    let plain = new.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_')
        && new.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    if !plain {
        return Err(format!("`{new}` is no name: names have letters, digits and `_`, and begin with a letter"));
    }
    if built_in(new).is_some() || (symbol.kind == SymbolKind::Task && stdlib_tasks::find(new).is_some()) {
        return Err(format!("`{new}` is a word of the language"));
    }
    if let (SymbolKind::Event, Some(verb)) = (symbol.kind, verbs_with(old).next()) {
        return Err(format!("`{old}` is how `{}` comes out, and keeps its word", verb.name));
    }
    if old.contains("${") {
        return Err(format!("a repetition makes several names of `{old}`; rename it by hand"));
    }
    if old == new {
        return Ok(Vec::new());
    }
    let target = Place::of(names, id).ok_or("the file of this name has no path")?;
    let own = document.place();
    let here = |path: &Path| path == own || w.documents.iter().any(|d| d.place() == path);
    if !w.roots.is_empty() && !here(&target.path) && !w.roots.iter().any(|r| target.path.starts_with(r)) {
        let file = target.path.display();
        return Err(format!("`{old}` is declared in {file}, which lies outside of the workspace"));
    }
    let library = w.library;
    let specs = workspace::specs(&workspace::folders(w.roots, &[&own, &target.path]), library);
    if !specs.whole {
        return Err("there are too many files to know all that speak of this name".to_string());
    }
    let mut all = workspace::uses(&target, itself, &specs, library);
    let mut texts = BTreeMap::new();
    let mut renamed = target.clone();
    for uses in &all {
        let file = &uses.file;
        if uses.words.iter().any(|r| !r.exact) {
            return Err(format!(
                "a use of this name in {} stands in a scalar with escapes or folded lines; rename it by hand",
                short(&file.path)
            ));
        }
        if file.path == target.path {
            let before = uses.words.iter().filter(|r| r.place.start < target.start).count();
            renamed.start = target.start + before * new.len() - before * old.len();
        }
        let mut text = file.text.as_str().to_string();
        for r in uses.words.iter().rev() {
            text.replace_range(r.place.clone(), new);
        }
        texts.insert(file.path.clone(), (text, file.syntax));
    }
    let after = library.imagined(&texts);
    // The file in which the word was chosen is checked first.
    all.sort_by_key(|uses| uses.file.path != target.path);
    for uses in &all {
        let path = &uses.file.path;
        let same = after.file(path).is_some_and(|file| {
            let words = workspace::words(&file, &renamed, itself);
            words.len() == uses.words.len() && file.names.references.len() == uses.file.names.references.len()
        });
        if !same || clashes(uses, new) {
            return Err(format!("`{new}` means something else in {} already", short(path)));
        }
    }
    if let Some(why) = breaks(&specs, library, &after, &texts) {
        return Err(why);
    }
    let edits = |uses: &Uses| {
        let file = &uses.file;
        let edit = |r: &Reference| TextEdit::new(file.text.range(r.place.clone()), new.to_string());
        Some((workspace::address(file, w)?, uses.words.iter().map(edit).collect()))
    };
    Ok(all.iter().filter(|u| !u.words.is_empty()).filter_map(edits).collect())
}

/// Returns the reason why the specs would not compile any more with the new texts. This finds uses that are not words:
/// `arm_${side}` may form a name, and some tasks expect arms with the names `left` and `right`.
fn breaks(
    specs: &Specs,
    library: &Library,
    after: &Library,
    texts: &BTreeMap<PathBuf, (String, Syntax)>,
) -> Option<String> {
    let files = specs.texts.iter().filter_map(|(path, text)| Some((path, text, after.file(path)?)));
    let touched = files.filter(|(_, _, file)| texts.keys().any(|path| file.rests_on(path)));
    for (path, old, file) in touched.take(MOST_COMPILED) {
        let new = texts.get(path).map_or(old, |(text, _)| text);
        let now = errors(path, new, file.syntax, &after.texts());
        if now.is_empty() {
            continue;
        }
        let before = errors(path, old, file.syntax, &library.texts());
        if now.len() > before.len() {
            let first = now.iter().find(|m| !before.contains(m)).or(now.first())?;
            return Some(format!("{} would not compile any more: {first}", short(path)));
        }
    }
    None
}

/// Messages of the errors of a spec.
fn errors(path: &Path, text: &str, syntax: Syntax, texts: &compiler::Texts) -> Vec<String> {
    let name = path.display().to_string();
    let folder = path.parent().unwrap_or(Path::new(""));
    let input = compiler::Input { name: &name, text, syntax, folder, set: &[], package_paths: &[] };
    let report = compiler::compile_among(&input, texts).report;
    let errors = report.diagnostics.into_iter().filter(|d| d.severity == Severity::Error);
    errors.map(|d| d.message).collect()
}

/// True if a file already declares the new name in the name space of a word.
fn clashes(uses: &Uses, new: &str) -> bool {
    let names = &uses.file.names;
    uses.words.iter().any(|r| match r.meaning {
        Meaning::Symbol(id) => taken(names, names.symbol(id), new),
        _ => false,
    })
}

/// True if a name is declared in the name space of a symbol. Values of all kinds share one.
fn taken(names: &Resolution, symbol: &Symbol, new: &str) -> bool {
    use SymbolKind as K;
    const VALUES: &[K] = &[
        K::Param,
        K::Let,
        K::Signal,
        K::Variable,
        K::Human,
        K::SafetyField,
        K::Obstacle,
        K::Event,
        K::RaisedEvent,
        K::Outcome,
    ];
    const GEOMETRY: &[K] = &[K::Point, K::Segment, K::Group];
    let own = [symbol.kind];
    let kinds = match symbol.kind {
        kind if VALUES.contains(&kind) => VALUES,
        kind if GEOMETRY.contains(&kind) => GEOMETRY,
        _ => &own,
    };
    let of_robot = symbol.container.is_some_and(|outer| names.symbol(outer).kind == K::Robot);
    match symbol.container {
        Some(_) if !of_robot => {
            let beside = |s: &Symbol| s.container == symbol.container && kinds.contains(&s.kind) && s.name == new;
            names.symbols.iter().any(beside)
        }
        _ => kinds.iter().any(|kind| names.named(*kind, new).is_some()),
    }
}

/// Formats a path for a message.
fn short(path: &Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |n| format!("`{}`", n.to_string_lossy()))
}
