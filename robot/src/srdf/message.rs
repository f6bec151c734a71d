//! Diagnostics of an SRDF, with their location in the text.

use std::fmt;
use std::ops::Range;

/// Kind of an [`SrdfMessage`]. Stable: tools may match on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SrdfCode {
    /// The text is longer than 64 MiB, or has too many elements.
    TooLarge,
    /// Not well-formed XML, or with a document type definition.
    BrokenXml,
    /// The root element is not `<robot>`.
    NoRobot,
    /// The file contains xacro macros that were not expanded.
    Xacro,
    /// The file is a URDF.
    Urdf,
    /// Most of the names in the file are unknown to the URDF.
    OtherRobot,
    /// A required attribute is missing or empty.
    Missing,
    /// Two groups, or two postures of a group, have the same name.
    DuplicateName,
    /// A link that the URDF does not have.
    UnknownLink,
    /// A joint that neither the URDF nor a virtual joint has.
    UnknownJoint,
    /// A group that the SRDF does not have.
    UnknownGroup,
    /// A group that contains itself, directly or through others.
    GroupCycle,
    /// A chain whose links are not joined.
    BrokenChain,
    /// Not a number, or not a finite one.
    BadNumber,
    /// A type of a virtual joint that does not exist.
    UnknownJointType,
    /// Warning: the name of the robot differs from that of the URDF.
    OtherName,
    /// Warning: an element without effect.
    Ignored,
}

impl SrdfCode {
    /// Returns the code as written in messages, in kebab case.
    pub const fn as_str(self) -> &'static str {
        match self {
            SrdfCode::TooLarge => "too-large",
            SrdfCode::BrokenXml => "broken-xml",
            SrdfCode::NoRobot => "no-robot",
            SrdfCode::Xacro => "xacro",
            SrdfCode::Urdf => "urdf",
            SrdfCode::OtherRobot => "other-robot",
            SrdfCode::Missing => "missing",
            SrdfCode::DuplicateName => "duplicate-name",
            SrdfCode::UnknownLink => "unknown-link",
            SrdfCode::UnknownJoint => "unknown-joint",
            SrdfCode::UnknownGroup => "unknown-group",
            SrdfCode::GroupCycle => "group-cycle",
            SrdfCode::BrokenChain => "broken-chain",
            SrdfCode::BadNumber => "bad-number",
            SrdfCode::UnknownJointType => "unknown-joint-type",
            SrdfCode::OtherName => "other-name",
            SrdfCode::Ignored => "ignored",
        }
    }
}

impl fmt::Display for SrdfCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// A diagnostic of an SRDF. The result of [`crate::Srdf::read`] separates errors from warnings.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{text}")]
pub struct SrdfMessage {
    /// Kind of the message.
    pub code: SrdfCode,
    /// One sentence, without a full stop.
    pub text: String,
    /// Byte range in the SRDF text; always in bounds and on character boundaries.
    pub span: Range<usize>,
    /// Proposed correction.
    pub help: Option<String>,
    /// The name that is unknown, for the nearest known one.
    pub unknown: Option<String>,
}

impl SrdfMessage {
    /// Creates a message without help.
    pub(super) fn new(code: SrdfCode, span: Range<usize>, text: impl Into<String>) -> SrdfMessage {
        SrdfMessage { code, text: text.into(), span, help: None, unknown: None }
    }

    /// Returns the message with this help.
    pub(super) fn help(mut self, help: impl Into<String>) -> SrdfMessage {
        self.help = Some(help.into());
        self
    }

    /// Returns the message with the name that is unknown.
    pub(super) fn unknown(mut self, name: &str) -> SrdfMessage {
        self.unknown = Some(name.to_string());
        self
    }
}
