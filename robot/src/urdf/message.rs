//! Diagnostics of a URDF, with their location in the text.

use std::fmt;
use std::ops::Range;

use serde::{Deserialize, Serialize};

macro_rules! codes {
    ($($(#[$doc:meta])* $name:ident = $text:literal,)*) => {
        /// Kind of a [`UrdfMessage`]. Stable: tools may match on it.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum UrdfCode { $($(#[$doc])* $name,)* }

        impl UrdfCode {
            /// All codes, in the order of declaration.
            pub const ALL: &[UrdfCode] = &[$(UrdfCode::$name,)*];

            /// Returns the code as written in messages, in kebab case.
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
    /// The file contains xacro macros that were not expanded.
    Xacro = "xacro",
    /// The file is an SRDF.
    Srdf = "srdf",
    /// The robot has no link.
    NoLinks = "no-links",
    /// A required element or attribute is missing.
    Missing = "missing",
    /// Two links, or two joints, have the same name.
    DuplicateName = "duplicate-name",
    /// A joint names a link that does not exist.
    UnknownLink = "unknown-link",
    /// A mimic, `lock` or `keep` names a joint that does not exist.
    UnknownJoint = "unknown-joint",
    /// A joint type that is not supported.
    UnknownJointType = "unknown-joint-type",
    /// A planar or floating joint inside the tree.
    FreeJoint = "free-joint",
    /// A link is the child of two joints.
    TwoParents = "two-parents",
    /// Links that form a cycle.
    Cycle = "cycle",
    /// More than one link without a parent.
    SeveralRoots = "several-roots",
    /// A joint that mimics itself, directly or through others.
    MimicCycle = "mimic-cycle",
    /// Not a number, or not a finite one.
    BadNumber = "bad-number",
    /// The axis of a moving joint has no direction.
    ZeroAxis = "zero-axis",
    /// A size is not greater than zero, or a mass is negative.
    BadSize = "bad-size",
    /// The lower limit is above the upper one.
    CrossedLimits = "crossed-limits",
    /// Warning: a moving joint without limits of position.
    NoLimits = "no-limits",
    /// Warning: the limits leave the joint one position.
    Immovable = "immovable",
    /// Warning: the limit of speed is missing or is not usable.
    NoVelocityLimit = "no-velocity-limit",
    /// Too many moving joints.
    TooManyJoints = "too-many-joints",
    /// A joint has the name of a degree of freedom of the base.
    ReservedName = "reserved-name",
    /// An invalid `lock`: not finite, or (as a warning) outside the limits.
    BadLock = "bad-lock",
    /// Warning: a mesh file was not found.
    MeshMissing = "mesh-missing",
    /// Warning: a mesh file could not be read or has no usable vertices.
    MeshUnreadable = "mesh-unreadable",
    /// Warning: the pieces of a mesh exceed it by more than is allowed.
    MeshPieces = "mesh-pieces",
    /// Warning: an entry of the cache of pieces was damaged.
    MeshEntry = "mesh-entry",
    /// Warning: collision meshes were left out because [`Options::read_meshes`](crate::Options::read_meshes) is off.
    MeshNotRead = "mesh-not-read",
    /// Warning: a number that looks as if it were written in another unit.
    Unit = "unit",
    /// Warning: an element or an option without effect.
    Ignored = "ignored",
}

impl fmt::Display for UrdfCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// A diagnostic of a URDF. The result of [`crate::Model::from_urdf`] separates errors from warnings.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[error("{text}")]
pub struct UrdfMessage {
    /// Kind of the message.
    pub code: UrdfCode,
    /// One sentence, without a full stop.
    pub text: String,
    /// Byte range in the URDF text; always in bounds and on character boundaries.
    pub span: Range<usize>,
    /// Proposed correction.
    pub help: Option<String>,
    /// Name of the joint whose limit is missing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint: Option<String>,
}

impl UrdfMessage {
    /// Creates a message without help.
    pub(crate) fn new(code: UrdfCode, span: Range<usize>, text: impl Into<String>) -> UrdfMessage {
        UrdfMessage { code, text: text.into(), span, help: None, joint: None }
    }

    /// Returns the message with this help.
    pub(crate) fn help(mut self, help: impl Into<String>) -> UrdfMessage {
        self.help = Some(help.into());
        self
    }

    /// Returns the message with the name of the joint whose limit is missing.
    pub(crate) fn joint(mut self, joint: &str) -> UrdfMessage {
        self.joint = Some(joint.to_string());
        self
    }

    /// Returns the line and column of the start of the span (both from 1, the column in characters). `urdf` must be the
    /// text that the message belongs to.
    pub fn line_column(&self, urdf: &str) -> (usize, usize) {
        let before = urdf.get(..self.span.start).unwrap_or(urdf);
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
    }
}
