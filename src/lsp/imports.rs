//! The files that a spec imports: what they declare, and where.

use std::path::{Path, PathBuf};

use dsl::tree::{ItemKind, Spec, ValueKind};
use dsl::{Sources, Spelling};

use super::mentions::{self, Class, Mentions};
use super::text::Text;
use super::walk::word;

/// Most files that are looked into; the compiler reads them all.
const MOST: usize = 50;

/// An imported file.
#[derive(Debug)]
pub(super) struct Imported {
    /// As the import writes it.
    pub written: String,
    /// Where it lies.
    pub path: PathBuf,
    /// Its text.
    pub text: Text,
    /// How it is spelt.
    pub spelling: Spelling,
    /// What it declares.
    pub mentions: Mentions,
    /// The URDF of its robot.
    pub urdf: Option<PathBuf>,
}

/// What a spec can see of a file, class by class.
pub(super) const VISIBLE: [Class; 5] = [Class::Param, Class::Let, Class::Robot, Class::Task, Class::Stack];

/// What comes with a robot.
pub(super) const PARTS: [Class; 5] = [Class::Arm, Class::Point, Class::Segment, Class::Group, Class::JointGroup];

/// Reads the files that a spec in a folder imports, as far as they can be read.
pub(super) fn read(spec: &Spec, folder: &Path) -> Vec<Imported> {
    let paths = spec.items.iter().filter_map(|item| match &item.kind {
        ItemKind::Import(import) => Some(&import.path.value),
        _ => None,
    });
    paths.take(MOST).filter_map(|written| one(written, folder)).collect()
}

fn one(written: &str, folder: &Path) -> Option<Imported> {
    let path = folder.join(written);
    let spelling = Spelling::of_path(&path)?;
    let size = std::fs::metadata(&path).ok().filter(std::fs::Metadata::is_file)?.len();
    if size > dsl::limits::MAX_BYTES as u64 {
        return None;
    }
    let text = std::fs::read_to_string(&path).ok()?;
    let (spec, _) = dsl::parse(Sources::default().add("", ""), &text, spelling);
    let mentions = mentions::of(&spec, &text, spelling, None, &[]);
    let urdf = spec.items.iter().find_map(|item| match &item.kind {
        ItemKind::Robot(robot) => match &robot.body.get("urdf")?.value {
            value if matches!(value.kind, ValueKind::Text(_)) => Some(path.parent()?.join(word(value)?)),
            _ => None,
        },
        _ => None,
    });
    Some(Imported { written: written.to_string(), path, text: Text::new(text), spelling, mentions, urdf })
}
