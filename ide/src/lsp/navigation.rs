//! Definition of a name, and its other occurrences in the document.

use compiler::resolve::{FileId, Meaning, Reference, Resolution};
use lsp_types::{DocumentHighlight, Location, Range};

use super::document::Document;
use super::text::Text;
use super::uri;

/// Location of the declaration of the word at a byte: in this document, in an imported one, or in the URDF.
pub(super) fn definition(document: &Document, byte: usize) -> Option<Location> {
    let names = document.names()?;
    match &names.at(byte)?.meaning {
        Meaning::Symbol(id) => {
            let symbol = names.symbol(names.origin(*id));
            // The whole tag in a URDF or an SRDF is easier to see than the name in it.
            let is_spec = names.files[symbol.file.0].syntax.is_some();
            let place = if is_spec { &symbol.place } else { &symbol.whole };
            location(document, names, symbol.file, place.clone())
        }
        Meaning::File(file) => {
            let path = &names.files[(*file)?.0].path;
            Some(Location::new(uri::of(path)?, Range::default()))
        }
        _ => None,
    }
}

/// Location of some bytes of a file.
fn location(document: &Document, names: &Resolution, file: FileId, place: std::ops::Range<usize>) -> Option<Location> {
    if file == FileId(0) {
        return Some(Location::new(document.uri.clone(), document.text.range(place)));
    }
    let file = &names.files[file.0];
    let text = Text::new(names.text(file).to_string());
    Some(Location::new(uri::of(&file.path)?, text.range(place)))
}

/// True if two words have the same declared or unknown name.
pub(super) fn same(a: &Meaning, b: &Meaning) -> bool {
    match (a, b) {
        (Meaning::Symbol(a), Meaning::Symbol(b)) => a == b,
        (Meaning::Unknown(kind, name), Meaning::Unknown(other, word)) => kind == other && name == word,
        _ => false,
    }
}

/// All occurrences in this document of the symbol at a byte, for highlighting.
pub(super) fn highlights(document: &Document, byte: usize) -> Option<Vec<DocumentHighlight>> {
    let names = document.names()?;
    let meaning = &names.at(byte)?.meaning;
    let all = names.references.iter().filter(|r| same(&r.meaning, meaning));
    let highlight = |r: &Reference| DocumentHighlight { range: document.text.range(r.place.clone()), kind: None };
    Some(all.map(highlight).collect())
}
