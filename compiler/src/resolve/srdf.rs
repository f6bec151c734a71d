//! Names in an SRDF with their positions: groups, which are also arms if they are one chain, and postures.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

/// Maximum length of an SRDF (bytes).
const MAX_BYTES: u64 = 64 << 20;

/// A name of an SRDF.
pub(super) struct SrdfPart {
    /// Range of the name (bytes).
    pub place: Range<usize>,
    /// Range of the start tag (bytes).
    pub whole: Range<usize>,
    /// Description in Markdown.
    pub doc: String,
}

/// SRDF of a spec.
pub(super) struct SrdfNames {
    /// Text.
    pub text: String,
    /// Groups by name.
    pub groups: BTreeMap<String, SrdfPart>,
    /// Those of them that are one chain.
    pub chains: BTreeMap<String, SrdfPart>,
    /// Postures by name; the first of each name.
    pub postures: BTreeMap<String, SrdfPart>,
}

/// Reads an SRDF. Returns `None` if the file is missing or is not XML; the compiler's diagnostics report the reason.
pub(super) fn read_srdf(path: &Path) -> Option<SrdfNames> {
    let text = String::from_utf8(files::read(path, MAX_BYTES).ok()?).ok()?;
    if robot::markup::crowded(&text).is_some() {
        return None;
    }
    let mut names =
        SrdfNames { text: String::new(), groups: BTreeMap::new(), chains: BTreeMap::new(), postures: BTreeMap::new() };
    let document = roxmltree::Document::parse(&text).ok()?;
    for node in document.root_element().children().filter(|n| n.is_element()) {
        let Some(name) = node.attribute_node("name") else { continue };
        let start = node.range().start;
        let end = text[start..].find('>').map_or(node.range().end, |n| start + n + 1);
        let part = |doc: String| SrdfPart { place: name.range_value(), whole: start..end, doc };
        let elements = || node.children().filter(|n| n.is_element());
        let called = name.value().to_string();
        match node.tag_name().name() {
            "group" => {
                let members: Vec<&str> = elements().filter_map(|n| n.attribute("name")).take(12).collect();
                let chain = elements().find(|n| n.has_tag_name("chain"));
                let ends = chain.and_then(|n| Some((n.attribute("base_link")?, n.attribute("tip_link")?)));
                let mut doc = format!("group `{called}` of the SRDF");
                if let Some((base, tip)) = ends {
                    doc += &format!(", a chain from `{base}` to `{tip}`");
                }
                if !members.is_empty() {
                    doc += &format!(", with {}", members.join(", "));
                }
                if ends.is_some() && elements().count() == 1 {
                    names.chains.entry(called.clone()).or_insert(part(doc.clone()));
                }
                names.groups.entry(called).or_insert(part(doc));
            }
            "group_state" => {
                let group = node.attribute("group").unwrap_or("?");
                let positions: Vec<String> = elements()
                    .filter_map(|n| Some(format!("{} {}", n.attribute("name")?, n.attribute("value")?)))
                    .take(20)
                    .collect();
                let doc = format!("posture `{called}` of `{group}`: {}", positions.join(", "));
                names.postures.entry(called).or_insert(part(doc));
            }
            _ => {}
        }
    }
    Some(SrdfNames { text, ..names })
}
