//! Definition of a name, and its other occurrences in the document.

use std::collections::BTreeMap;

use lsp_types::{DocumentHighlight, Location, Range};

use super::document::Document;
use super::mentions::{Class, Mention, What};
use super::origin::Elsewhere;
use super::urdf::Part;
use super::uri;

/// Location of the declaration of the word at a byte: in this document, in an imported one, or in the URDF.
pub(super) fn definition(document: &Document, byte: usize) -> Option<Location> {
    let analysis = document.analysis()?;
    let part = |parts: &BTreeMap<String, Part>, name: &str| {
        let urdf = analysis.urdf.as_ref()?;
        let place = parts.get(name)?.place.clone();
        Some(Location::new(uri::of(&urdf.path)?, urdf.text.range(place)))
    };
    match &analysis.mentions.at(byte)?.what {
        What::Declared(Class::Raised, name) => {
            let place = analysis.mentions.raised.get(name)?.clone();
            Some(Location::new(document.uri.clone(), document.text.range(place)))
        }
        What::Declared(class, name) => {
            let declared = analysis.mentions.declared.get(&(*class, name.clone()))?;
            if let Some(there) = &declared.elsewhere {
                return elsewhere(there);
            }
            Some(Location::new(document.uri.clone(), document.text.range(declared.name.clone())))
        }
        What::Brought(_, there) => elsewhere(there),
        What::Link(name) => part(&analysis.urdf.as_ref()?.links, name),
        What::Joint(name) => part(&analysis.urdf.as_ref()?.joints, name),
        What::Spec(written) => {
            let file = analysis.imports.iter().find(|i| i.written == *written)?.file.as_ref()?;
            Some(Location::new(uri::of(&file.source.path)?, Range::default()))
        }
        What::File => {
            let urdf = analysis.urdf.as_ref()?;
            Some(Location::new(uri::of(&urdf.path)?, Range::default()))
        }
        _ => None,
    }
}

/// Location of a declaration in another file.
fn elsewhere(there: &Elsewhere) -> Option<Location> {
    Some(Location::new(uri::of(&there.source.path)?, there.source.text.range(there.place.clone())))
}

/// All occurrences in this document of the symbol at a byte, for highlighting.
pub(super) fn highlights(document: &Document, byte: usize) -> Option<Vec<DocumentHighlight>> {
    let mentions = &document.analysis()?.mentions;
    let what = &mentions.at(byte)?.what;
    let highlight = |m: &Mention| DocumentHighlight { range: document.text.range(m.place.clone()), kind: None };
    Some(mentions.same(what).map(highlight).collect())
}
