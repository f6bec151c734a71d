//! What can be said about a URDF, and where in its text.

use std::fmt;
use std::ops::Range;

use serde::{Deserialize, Serialize};

macro_rules! codes {
    ($($(#[$doc:meta])* $name:ident = $text:literal,)*) => {
        /// What kind of complaint a [`UrdfMessage`] is. Stable: tools may match on it.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum UrdfCode { $($(#[$doc])* $name,)* }

        impl UrdfCode {
            /// All codes, in the order of declaration.
            pub const ALL: &[UrdfCode] = &[$(UrdfCode::$name,)*];

            /// The code as written in messages, in kebab case.
            pub const fn as_str(self) -> &'static str {
                match self { $(UrdfCode::$name => $text,)* }
            }
        }
    };
}

codes! {
    /// The text is longer than 64 MiB, or has too many elements or links.
    TooLarge = "too-large",
    /// Not well-formed XML, or with a document type definition.
    BrokenXml = "broken-xml",
    /// The root element is not `<robot>`.
    NoRobot = "no-robot",
    /// Macros that were not expanded.
    Xacro = "xacro",
    /// No link at all.
    NoLinks = "no-links",
    /// An element or an attribute that must be there is missing.
    Missing = "missing",
    /// Two links, or two joints, of one name.
    DuplicateName = "duplicate-name",
    /// A joint names a link that does not exist.
    UnknownLink = "unknown-link",
    /// A mimic, `lock` or `keep` names a joint that does not exist.
    UnknownJoint = "unknown-joint",
    /// A joint type this program does not have.
    UnknownJointType = "unknown-joint-type",
    /// A planar or floating joint inside the tree.
    FreeJoint = "free-joint",
    /// A link is the child of two joints.
    TwoParents = "two-parents",
    /// Links that hang on each other in a circle.
    Cycle = "cycle",
    /// More than one link without a parent.
    SeveralRoots = "several-roots",
    /// A joint that mimics itself, directly or through others.
    MimicCycle = "mimic-cycle",
    /// Not a number, or not a finite one.
    BadNumber = "bad-number",
    /// The axis of a moving joint has no direction.
    ZeroAxis = "zero-axis",
    /// A size that must be greater than zero is not.
    BadSize = "bad-size",
    /// The lower limit is above the upper one.
    CrossedLimits = "crossed-limits",
    /// Warning: a moving joint without limits of position.
    NoLimits = "no-limits",
    /// Warning: the limits leave the joint one position.
    Immovable = "immovable",
    /// Warning: the limit of speed is missing, or is none.
    NoVelocityLimit = "no-velocity-limit",
    /// Too many moving joints.
    TooManyJoints = "too-many-joints",
    /// A name is taken by a degree of freedom of the base.
    ReservedName = "reserved-name",
    /// A `lock` that cannot be: no number, or (as a warning) outside the limits or without effect.
    BadLock = "bad-lock",
    /// Warning: a mesh file was not found.
    MeshMissing = "mesh-missing",
    /// Warning: a mesh file could not be understood.
    MeshUnreadable = "mesh-unreadable",
    /// Warning: collision meshes were left out because reading them was not asked for.
    MeshNotRead = "mesh-not-read",
    /// Warning: a part that has no effect.
    Ignored = "ignored",
}

impl fmt::Display for UrdfCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// A complaint about a URDF. Whether it is an error or a warning is said by where it stands in
/// the result of [`crate::Model::from_urdf`].
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[error("{text}")]
pub struct UrdfMessage {
    /// What kind it is.
    pub code: UrdfCode,
    /// One sentence, without a full stop.
    pub text: String,
    /// The offending bytes of the URDF text; always in range and on character boundaries.
    pub span: Range<usize>,
    /// What to do about it.
    pub help: Option<String>,
}

impl UrdfMessage {
    /// A message without help.
    pub(crate) fn new(code: UrdfCode, span: Range<usize>, text: impl Into<String>) -> UrdfMessage {
        UrdfMessage { code, text: text.into(), span, help: None }
    }

    /// The same with help.
    pub(crate) fn help(mut self, help: impl Into<String>) -> UrdfMessage {
        self.help = Some(help.into());
        self
    }

    /// Line and column (both from 1, the column in characters) where the span starts in `urdf`,
    /// the text it was read from.
    pub fn line_column(&self, urdf: &str) -> (usize, usize) {
        let before = urdf.get(..self.span.start).unwrap_or(urdf);
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
    }
}
