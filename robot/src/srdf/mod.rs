//! SRDF reader: the semantic description that MoveIt puts beside a URDF. Groups of joints and links, named postures, end
//! effectors, passive and virtual joints, and pairs of links whose collisions are not checked.
//!
//! Stages: XML and names (`read`), members of groups (`groups`), pairs (`pairs`). The order of joints and links is that
//! of the model, from the root outwards.
//!
//! Format: <https://wiki.ros.org/srdf> and the reader of MoveIt, `srdfdom`.

use std::collections::BTreeMap;
use std::ops::Range;

use crate::urdf::xml;
use crate::{JointId, LinkId, Model};

mod groups;
mod merge;
mod message;
mod pairs;
mod read;

pub use message::{SrdfCode, SrdfMessage};

use read::Reader;

/// The content of an SRDF, with names resolved on a model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Srdf {
    /// Name of the robot.
    pub name: String,
    /// Groups, in file order.
    pub groups: Vec<Group>,
    /// End effectors, in file order.
    pub end_effectors: Vec<EndEffector>,
    /// Named postures, in file order.
    pub postures: Vec<Posture>,
    /// Joints without a motor.
    pub passive: Vec<PassiveJoint>,
    /// Joints between the robot and the world.
    pub virtual_joints: Vec<VirtualJoint>,
    /// Pairs of links that are not checked for collisions, each once, ordered by their links.
    pub disabled: Vec<DisabledPair>,
}

/// A group of joints, with the links that they move.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Name.
    pub name: String,
    /// Location of the name in the text.
    pub span: Range<usize>,
    /// Location of the opening tag in the text.
    pub tag: Range<usize>,
    /// Joints, fixed and mimicking ones included.
    pub joints: Vec<JointId>,
    /// Links that the joints carry, and those that the file names.
    pub links: Vec<LinkId>,
    /// True if the joint that carries the root link belongs to the group.
    pub base: bool,
    /// The last link, if the group is one chain from a link to one behind it.
    pub tip: Option<LinkId>,
}

/// A tool at the end of a group.
#[derive(Clone, Debug, PartialEq)]
pub struct EndEffector {
    /// Name.
    pub name: String,
    /// Group of the tool.
    pub group: String,
    /// Link to which the tool is mounted.
    pub parent_link: LinkId,
    /// Group that carries the tool.
    pub parent_group: Option<String>,
}

/// A named posture of a group.
#[derive(Clone, Debug, PartialEq)]
pub struct Posture {
    /// Name.
    pub name: String,
    /// Location of the name in the text.
    pub span: Range<usize>,
    /// Location of the opening tag in the text.
    pub tag: Range<usize>,
    /// Group; `all` for all joints.
    pub group: String,
    /// Positions of its joints, in file order.
    pub positions: Vec<Position>,
}

/// Position of a joint in a posture.
#[derive(Clone, Debug, PartialEq)]
pub struct Position {
    /// Joint.
    pub joint: JointId,
    /// Position \[rad or m\].
    pub value: f64,
    /// Location of the number in the text.
    pub span: Range<usize>,
}

/// A joint without a motor.
#[derive(Clone, Debug, PartialEq)]
pub struct PassiveJoint {
    /// Joint.
    pub joint: JointId,
    /// Location of the name in the text.
    pub span: Range<usize>,
}

/// Motion that a virtual joint permits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VirtualMotion {
    /// None.
    Fixed,
    /// In the plane.
    Planar,
    /// Free.
    Floating,
}

/// A joint between the world and a link.
#[derive(Clone, Debug, PartialEq)]
pub struct VirtualJoint {
    /// Name.
    pub name: String,
    /// Location of the type in the text.
    pub span: Range<usize>,
    /// Permitted motion.
    pub motion: VirtualMotion,
    /// Link that it carries.
    pub child: LinkId,
}

/// A pair of links that is not checked for collisions.
#[derive(Clone, Debug, PartialEq)]
pub struct DisabledPair {
    /// The two links, the one with the smaller index first.
    pub links: [LinkId; 2],
    /// Reason as written; empty without one.
    pub reason: String,
    /// Location of the element in the text.
    pub span: Range<usize>,
}

/// A description with the warnings about its file.
pub type Read = (Srdf, Vec<SrdfMessage>);

impl Srdf {
    /// Reads an SRDF that describes `model`, whose name must be that of its URDF. Returns the description with warnings,
    /// or the errors; both are sorted by their location in the text.
    ///
    /// Choices that the format leaves open:
    /// - A pair of links whose name is unknown is left out (a warning): it would have taken away a check, and takes away none.
    /// - An end effector on an unknown link is left out (a warning): nothing is computed with it.
    /// - An unknown joint of a posture is left out (a warning): the posture does not move it.
    /// - A posture without a group counts for `all` joints (a warning); `all` needs no declaration.
    /// - `root_joint`, the name of Pinocchio for the joint of the base, needs no declaration.
    /// - The numbers that a posture gives to virtual, fixed and mimicking joints are skipped.
    /// - Another name of the robot is a warning, or the only error if most names in the file are unknown.
    /// - Elements that are not part of the format are skipped.
    ///
    /// # Errors
    /// All codes of [`SrdfCode`] that are not marked as a warning.
    pub fn read(text: &str, model: &Model) -> Result<Read, Vec<SrdfMessage>> {
        let document = xml::parse(text).map_err(|message| {
            let code = match message.code {
                crate::UrdfCode::TooLarge => SrdfCode::TooLarge,
                _ => SrdfCode::BrokenXml,
            };
            let help = message.help;
            vec![SrdfMessage { help, ..SrdfMessage::new(code, message.span, message.text) }]
        })?;
        let mut reader = Reader::new(text, model);
        let srdf = reader.robot(document.root_element());
        reader.finish(srdf)
    }

    /// Returns the group with this name.
    pub fn group(&self, name: &str) -> Option<&Group> {
        self.groups.iter().find(|g| g.name == name)
    }

    /// Returns the postures with this name, of all groups.
    pub fn postures_named<'s>(&'s self, name: &'s str) -> impl Iterator<Item = &'s Posture> {
        self.postures.iter().filter(move |p| p.name == name)
    }

    /// Returns the disabled pairs with their reasons.
    pub fn disabled_pairs(&self) -> BTreeMap<[LinkId; 2], &str> {
        self.disabled.iter().map(|pair| (pair.links, pair.reason.as_str())).collect()
    }
}
