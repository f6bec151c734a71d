//! Names in a URDF with their positions, for completion and "go to definition".

use std::collections::BTreeMap;
use std::fmt::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::text::Text;

/// A link or a joint.
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// Range of the start tag (bytes).
    pub place: Range<usize>,
    /// Description in Markdown.
    pub about: String,
    /// False for fixed and mimic joints, which a spec cannot name.
    pub moves: bool,
}

/// URDF of a spec.
#[derive(Debug)]
pub(super) struct Urdf {
    /// Path.
    pub path: PathBuf,
    /// Modification time, if known.
    pub changed: Option<SystemTime>,
    /// Text.
    pub text: Text,
    /// Links by name.
    pub links: BTreeMap<String, Part>,
    /// Joints by name.
    pub joints: BTreeMap<String, Part>,
}

/// Modification time of a file.
pub(super) fn changed(path: &Path) -> Option<SystemTime> {
    std::fs::metadata(path).ok()?.modified().ok()
}

/// Reads a URDF. Returns `None` if the file is missing or is not XML; the compiler's diagnostics report the reason.
pub(super) fn read(path: &Path) -> Option<Urdf> {
    let changed = changed(path);
    let text = String::from_utf8(files::read(path, 64 << 20).ok()?).ok()?;
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
            let mut part = Part { place: start..end, about: String::new(), moves: true };
            match node.tag_name().name() {
                "link" => {
                    part.about = format!("link `{name}`");
                    links.entry(name.to_string()).or_insert(part);
                }
                "joint" => {
                    let ty = node.attribute("type").unwrap_or("?");
                    let mimic = attribute("mimic", "joint");
                    part.moves = ty != "fixed" && mimic.is_none();
                    part.about = format!("joint `{name}`, {ty}");
                    if let (Some(parent), Some(child)) = (attribute("parent", "link"), attribute("child", "link")) {
                        let _ = write!(part.about, ", from `{parent}` to `{child}`");
                    }
                    if let Some(other) = mimic {
                        let _ = write!(part.about, ", mimics `{other}`");
                    }
                    let unit = if ty == "prismatic" { "m" } else { "rad" };
                    if let (Some(lower), Some(upper)) = (attribute("limit", "lower"), attribute("limit", "upper")) {
                        let _ = write!(part.about, "\n\nfrom {lower} to {upper} {unit}");
                    }
                    if let Some(v) = attribute("limit", "velocity") {
                        let _ = write!(part.about, "\n\nat most {v} {unit}/s");
                    }
                    joints.entry(name.to_string()).or_insert(part);
                }
                _ => {}
            }
        }
    }
    Some(Urdf { path: path.to_path_buf(), changed, text: Text::new(text), links, joints })
}
