//! Names in a URDF with their positions.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::ops::Range;
use std::path::Path;

/// Maximum length of a URDF (bytes).
const MAX_BYTES: u64 = 64 << 20;

/// A link or a joint.
#[derive(Clone, Debug)]
pub struct UrdfPart {
    /// Range of the name in the `name` attribute (bytes).
    pub place: Range<usize>,
    /// Range of the start tag (bytes).
    pub whole: Range<usize>,
    /// Description in Markdown.
    pub doc: String,
    /// Type of a joint, `mimic` if it follows another one; empty for a link.
    pub ty: String,
}

/// URDF of a spec.
#[derive(Debug)]
pub struct Urdf {
    /// Text.
    pub text: String,
    /// Links by name.
    pub links: BTreeMap<String, UrdfPart>,
    /// Joints by name.
    pub joints: BTreeMap<String, UrdfPart>,
}

/// Reads a URDF. Returns `None` if the file is missing or is not XML; the compiler's diagnostics report the reason.
pub fn read_urdf(path: &Path) -> Option<Urdf> {
    let text = String::from_utf8(files::read(path, MAX_BYTES).ok()?).ok()?;
    if robot::markup::crowded(&text).is_some() {
        return None;
    }
    let (mut links, mut joints) = (BTreeMap::new(), BTreeMap::new());
    {
        let document = roxmltree::Document::parse(&text).ok()?;
        let children = document.root_element().children();
        for node in children.filter(|n| n.is_element()) {
            let Some(name) = node.attribute("name") else { continue };
            let start = node.range().start;
            let end = text[start..].find('>').map_or(node.range().end, |n| start + n + 1);
            let attribute = |tag: &str, key: &str| {
                let child = node.children().find(|c| c.has_tag_name(tag))?;
                child.attribute(key).map(str::to_string)
            };
            let value = node.attribute_node("name").map_or(start..end, |a| a.range_value());
            let mut part = UrdfPart { place: value, whole: start..end, doc: String::new(), ty: String::new() };
            match node.tag_name().name() {
                "link" => {
                    part.doc = format!("link `{name}`");
                    links.entry(name.to_string()).or_insert(part);
                }
                "joint" => {
                    let ty = node.attribute("type").unwrap_or("?");
                    let mimic = attribute("mimic", "joint");
                    part.ty = if mimic.is_some() { "mimic".to_string() } else { ty.to_string() };
                    part.doc = format!("joint `{name}`, {ty}");
                    if let (Some(parent), Some(child)) = (attribute("parent", "link"), attribute("child", "link")) {
                        let _ = write!(part.doc, ", from `{parent}` to `{child}`");
                    }
                    if let Some(other) = mimic {
                        let _ = write!(part.doc, ", mimics `{other}`");
                    }
                    let unit = if ty == "prismatic" { "m" } else { "rad" };
                    if let (Some(lower), Some(upper)) = (attribute("limit", "lower"), attribute("limit", "upper")) {
                        let _ = write!(part.doc, "\n\nfrom {lower} to {upper} {unit}");
                    }
                    if let Some(v) = attribute("limit", "velocity") {
                        let _ = write!(part.doc, "\n\nat most {v} {unit}/s");
                    }
                    joints.entry(name.to_string()).or_insert(part);
                }
                _ => {}
            }
        }
    }
    Some(Urdf { text, links, joints })
}
