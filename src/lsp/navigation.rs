//! Where a name comes from, where else it stands, and how it is renamed everywhere at once.

use std::collections::BTreeMap;

use lsp_types::{DocumentHighlight, Location, PrepareRenameResponse, Range, TextEdit};

use super::document::Document;
use super::mentions::{Mention, What};
use super::urdf::Part;
use super::uri;

/// The declaration of the word at a byte: in this document, in one that it imports, or in its URDF.
pub(super) fn definition(document: &Document, byte: usize) -> Option<Location> {
    let analysis = document.analysis()?;
    let part = |parts: &BTreeMap<String, Part>, name: &str| {
        let urdf = analysis.urdf.as_ref()?;
        let place = parts.get(name)?.place.clone();
        Some(Location::new(uri::of(&urdf.path)?, urdf.text.range(place)))
    };
    match &analysis.mentions.at(byte)?.what {
        What::Declared(class, name) => {
            let declared = analysis.mentions.declared.get(&(*class, name.clone()))?;
            if let Some((written, place, _)) = &declared.elsewhere {
                let file = analysis.imports.iter().find(|i| i.written == *written)?;
                return Some(Location::new(uri::of(&file.path)?, file.text.range(place.clone())));
            }
            Some(Location::new(document.uri.clone(), document.text.range(declared.name.clone())))
        }
        What::Link(name) => part(&analysis.urdf.as_ref()?.links, name),
        What::Joint(name) => part(&analysis.urdf.as_ref()?.joints, name),
        What::Spec(written) => {
            let file = analysis.imports.iter().find(|i| i.written == *written)?;
            Some(Location::new(uri::of(&file.path)?, Range::default()))
        }
        What::File => {
            let urdf = analysis.urdf.as_ref()?;
            Some(Location::new(uri::of(&urdf.path)?, Range::default()))
        }
        _ => None,
    }
}

/// All places of what stands at a byte, the declaration among them if wanted.
pub(super) fn references(document: &Document, byte: usize, declaration: bool) -> Option<Vec<Location>> {
    let mentions = &document.analysis()?.mentions;
    let what = &mentions.at(byte)?.what;
    let all = mentions.same(what).filter(|m| declaration || !m.declares);
    Some(all.map(|m| Location::new(document.uri.clone(), document.text.range(m.place.clone()))).collect())
}

/// The same, for the editor to highlight.
pub(super) fn highlights(document: &Document, byte: usize) -> Option<Vec<DocumentHighlight>> {
    let mentions = &document.analysis()?.mentions;
    let what = &mentions.at(byte)?.what;
    let highlight = |m: &Mention| DocumentHighlight { range: document.text.range(m.place.clone()), kind: None };
    Some(mentions.same(what).map(highlight).collect())
}

/// The name at a byte, where it can be renamed: it is declared in this document.
fn declared(document: &Document, byte: usize) -> Option<&Mention> {
    let mentions = &document.analysis()?.mentions;
    let mention = mentions.at(byte)?;
    let What::Declared(class, name) = &mention.what else { return None };
    // What another file declares has its name there.
    mentions.declared.get(&(*class, name.clone()))?.elsewhere.is_none().then_some(mention)
}

/// The range and present text of what would be renamed.
pub(super) fn prepare_rename(document: &Document, byte: usize) -> Option<PrepareRenameResponse> {
    let mention = declared(document, byte).filter(|m| m.exact)?;
    let placeholder = document.text.as_str().get(mention.place.clone())?.to_string();
    Some(PrepareRenameResponse::RangeWithPlaceholder { range: document.text.range(mention.place.clone()), placeholder })
}

/// The edits that rename what stands at a byte. The result is read again: the new name must mean the same thing in
/// the same places, and nothing else may.
///
/// # Errors
/// What stands in the way.
pub(super) fn rename(document: &Document, byte: usize, new: &str) -> Result<Vec<TextEdit>, String> {
    let analysis = document.analysis().ok_or("this is no spec")?;
    let mention = declared(document, byte).ok_or("only names that this spec declares can be renamed")?;
    let What::Declared(class, old) = &mention.what else { return Err("this is no name".to_string()) };
    let plain = new.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_')
        && new.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    if !plain {
        return Err(format!("`{new}` is no name: names have letters, digits and `_`, and begin with a letter"));
    }
    let looked_up = match old.rsplit_once('.') {
        Some((owner, _)) => format!("{owner}.{new}"),
        None => new.to_string(),
    };
    if looked_up == *old {
        return Ok(Vec::new());
    }
    let places: Vec<&Mention> = analysis.mentions.same(&mention.what).collect();
    if places.iter().any(|m| !m.exact) {
        return Err("a use of this name stands in a scalar with escapes or folded lines; rename it by hand".to_string());
    }
    let mut text = document.text.as_str().to_string();
    for m in places.iter().rev() {
        text.replace_range(m.place.clone(), new);
    }
    let meant = What::Declared(*class, looked_up.clone());
    let taken = analysis.mentions.same(&meant).next().is_some();
    let after = document.imagine(&text).ok_or("this is no spec")?;
    let same_words = after.all.len() == analysis.mentions.all.len();
    if taken || after.same(&meant).count() != places.len() || !same_words {
        return Err(format!("`{new}` means something else here already"));
    }
    let edit = |m: &&Mention| TextEdit::new(document.text.range(m.place.clone()), new.to_string());
    Ok(places.iter().map(edit).collect())
}
