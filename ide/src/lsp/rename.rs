//! Renaming: changes a word where it was chosen and in all its uses, in all specs at once. The result is parsed again
//! before it is offered: the new name must have the same meaning in the same places, and no other word may change its
//! meaning.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use dsl::{Severity, Syntax};
use lsp_types::{PrepareRenameResponse, TextEdit, Uri};

use super::document::Document;
use super::library::Library;
use super::mentions::{Class, Mention, Mentions, What};
use super::origin::{self, Origin};
use super::vocabulary;
use super::walk_machines::outcome_of;
use super::workspace::{self, Specs, Uses, Workspace};

/// Maximum number of specs that are compiled to verify the result.
const MOST_COMPILED: usize = 64;

/// Name at a byte, with the place where it was chosen.
fn chosen(document: &Document, byte: usize) -> Option<(&Mention, Origin)> {
    let mentions = &document.analysis()?.mentions;
    let mention = mentions.at(byte)?;
    let target = origin::word(&document.place(), mentions, &mention.what)?;
    Some((mention, target))
}

/// Range and current text of the name to be renamed.
pub(super) fn prepare(document: &Document, byte: usize) -> Option<PrepareRenameResponse> {
    let (mention, _) = chosen(document, byte).filter(|(m, _)| m.exact)?;
    let placeholder = document.text.as_str().get(mention.place.clone())?.to_string();
    Some(PrepareRenameResponse::RangeWithPlaceholder { range: document.text.range(mention.place.clone()), placeholder })
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
    let (_, target) = chosen(document, byte).ok_or("only names that a spec declares can be renamed")?;
    let plain = new.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_')
        && new.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    if !plain {
        return Err(format!("`{new}` is no name: names have letters, digits and `_`, and begin with a letter"));
    }
    if vocabulary::find(new).is_some() || (target.class == Class::Task && stdlib_tasks::find(new).is_some()) {
        return Err(format!("`{new}` is a word of the language"));
    }
    if let (Class::Event, Some(verb)) = (target.class, outcome_of(&target.name).next()) {
        return Err(format!("`{}` is how `{}` comes out, and keeps its word", target.name, verb.name));
    }
    let (owner, old) = target.name.rsplit_once('.').map_or((None, target.name.as_str()), |(o, n)| (Some(o), n));
    if old == new {
        return Ok(Vec::new());
    }
    let looked_up = owner.map_or(new.to_string(), |owner| format!("{owner}.{new}"));
    let renamed = Origin { name: looked_up, ..target.clone() };
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
    let mut all = workspace::uses(&target, origin::word, &specs, library);
    let mut texts = BTreeMap::new();
    for uses in &all {
        let source = &uses.file.source;
        if uses.words.iter().any(|m| !m.exact) {
            return Err(format!(
                "a use of this name in {} stands in a scalar with escapes or folded lines; rename it by hand",
                short(&source.path)
            ));
        }
        let mut text = source.text.as_str().to_string();
        for m in uses.words.iter().rev() {
            text.replace_range(m.place.clone(), new);
        }
        texts.insert(source.path.clone(), (text, source.syntax));
    }
    let after = library.imagined(&texts);
    // The file in which the word was chosen is checked first.
    all.sort_by_key(|uses| uses.file.source.path != target.path);
    for uses in &all {
        let path = &uses.file.source.path;
        let same = after.file(path).is_some_and(|file| {
            let words = workspace::words(&file, &renamed, origin::word);
            words.len() == uses.words.len() && file.mentions.all.len() == uses.file.mentions.all.len()
        });
        if !same || clashes(uses, &target, new) {
            return Err(format!("`{new}` means something else in {} already", short(path)));
        }
    }
    if let Some(why) = breaks(&specs, library, &after, &texts) {
        return Err(why);
    }
    let edits = |uses: &Uses| {
        let source = &uses.file.source;
        let edit = |m: &Mention| TextEdit::new(source.text.range(m.place.clone()), new.to_string());
        Some((workspace::address(source, w)?, uses.words.iter().map(edit).collect()))
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
    let touched = files.filter(|(_, _, file)| texts.keys().any(|path| file.reaches(path)));
    for (path, old, file) in touched.take(MOST_COMPILED) {
        let new = texts.get(path).map_or(old, |(text, _)| text);
        let now = errors(path, new, file.source.syntax, &after.texts());
        if now.is_empty() {
            continue;
        }
        let before = errors(path, old, file.source.syntax, &library.texts());
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

/// True if a file already declares the new name.
fn clashes(uses: &Uses, target: &Origin, new: &str) -> bool {
    let mentions = &uses.file.mentions;
    uses.words.iter().any(|m| match &m.what {
        What::Declared(class, name) => {
            let key = name.rsplit_once('.').map_or(new.to_string(), |(owner, _)| format!("{owner}.{new}"));
            taken(mentions, *class, &key)
        }
        _ => false,
    }) || (uses.file.source.path == target.path && taken(mentions, target.class, new))
}

/// True if a name is declared in the same name space; values of all classes share one.
fn taken(mentions: &Mentions, class: Class, key: &str) -> bool {
    let classes: &[Class] = match class {
        Class::Param | Class::Let | Class::Signal | Class::Human | Class::Field | Class::Event | Class::Raised => {
            &[Class::Param, Class::Let, Class::Signal, Class::Human, Class::Field, Class::Event, Class::Raised]
        }
        Class::Point | Class::Segment | Class::Group => &[Class::Point, Class::Segment, Class::Group],
        _ => &[class],
    };
    classes.iter().any(|c| mentions.declared.contains_key(&(*c, key.to_string())))
}

/// Formats a path for a message.
fn short(path: &Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |n| format!("`{}`", n.to_string_lossy()))
}
