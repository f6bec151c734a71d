//! Reader of the elements of an SRDF: names become indices of the model, and each mistake a message.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use roxmltree::Node;

use super::groups::RawGroup;
use super::{
    EndEffector, PassiveJoint, Position, Posture, Read, Srdf, SrdfCode, SrdfMessage, VirtualJoint, VirtualMotion,
};
use crate::urdf::cx::{self, Spanned, attribute, children, list, parse_numbers};
use crate::urdf::xml;
use crate::{JointId, JointKind, LinkId, Model};

/// Maximum number of elements of one kind.
const MAX_ELEMENTS: usize = 100_000;

/// Maximum number of groups: each can contain all others.
const MAX_GROUPS: usize = 1_000;

/// Name that Pinocchio gives to the joint of the base, which no `<virtual_joint>` has to declare.
const ROOT_JOINT: &str = "root_joint";

/// Group of the postures that name none: all joints.
pub(super) const ALL: &str = "all";

/// Maximum number of messages: a file that is wrong throughout is read no better with more.
const MAX_MESSAGES: usize = 50;

/// Number of unknown names from which on the file describes another robot, even if it has the same name.
const MANY: usize = 8;

/// Known and unknown names of one kind.
#[derive(Default)]
pub(super) struct Names<I> {
    known: BTreeMap<String, I>,
    used: BTreeSet<String>,
    unknown: BTreeMap<String, usize>,
}

impl<I: Copy> Names<I> {
    fn of(known: impl Iterator<Item = (String, I)>) -> Names<I> {
        Names { known: known.collect(), used: BTreeSet::new(), unknown: BTreeMap::new() }
    }

    /// Index of a name; counts how often an unknown one is used.
    fn find(&mut self, name: &str) -> Option<I> {
        let found = self.known.get(name).copied();
        match found {
            Some(_) => {
                self.used.insert(name.to_string());
            }
            None => *self.unknown.entry(name.to_string()).or_insert(0) += 1,
        }
        found
    }
}

/// The state of a reading.
pub(super) struct Reader<'m, 't> {
    pub text: &'t str,
    pub model: &'m Model,
    links: Names<LinkId>,
    joints: Names<JointId>,
    /// Virtual joints; true for those that carry the root link.
    pub virtual_joints: BTreeMap<String, bool>,
    errors: Vec<SrdfMessage>,
    warnings: Vec<SrdfMessage>,
    name: Option<Spanned<String>>,
    tag: Range<usize>,
}

impl<'m, 't> Reader<'m, 't> {
    pub(super) fn new(text: &'t str, model: &'m Model) -> Reader<'m, 't> {
        let links = model.links.iter().enumerate().map(|(i, l)| (l.name.clone(), LinkId(i as u32)));
        let joints = model.joints.iter().enumerate().map(|(i, j)| (j.name.clone(), JointId(i as u32)));
        let root = model.joint(ROOT_JOINT).is_none().then(|| (ROOT_JOINT.to_string(), true));
        Reader {
            text,
            model,
            links: Names::of(links),
            joints: Names::of(joints),
            virtual_joints: root.into_iter().collect(),
            errors: Vec::new(),
            warnings: Vec::new(),
            name: None,
            tag: 0..0,
        }
    }

    pub(super) fn error(&mut self, message: SrdfMessage) {
        self.errors.push(message);
    }

    pub(super) fn warn(&mut self, message: SrdfMessage) {
        self.warnings.push(message);
    }

    /// Returns the description, unless there are errors.
    pub(super) fn finish(mut self, srdf: Option<Srdf>) -> Result<Read, Vec<SrdfMessage>> {
        if let Some(other) = self.other_robot() {
            return Err(vec![other]);
        }
        let cut = |all: &mut Vec<SrdfMessage>| {
            all.sort_by_key(|m| m.span.start);
            all.truncate(MAX_MESSAGES);
        };
        cut(&mut self.errors);
        cut(&mut self.warnings);
        match srdf {
            Some(srdf) if self.errors.is_empty() => Ok((srdf, self.warnings)),
            _ => Err(self.errors),
        }
    }

    /// One error in place of many, if the file describes another robot. Warns of another name.
    fn other_robot(&mut self) -> Option<SrdfMessage> {
        let name = self.name.as_ref()?;
        let of = &self.model.name;
        let same = name.value == *of || of.is_empty();
        let known = self.links.used.len() + self.joints.used.len();
        let unknown = self.links.unknown.len() + self.joints.unknown.len();
        if unknown > known && (!same || unknown >= MANY) {
            let missing = self.links.unknown.keys().chain(self.joints.unknown.keys()).map(String::as_str);
            let text = format!("this SRDF describes another robot: the URDF does not know {}", list(missing));
            let help = match same {
                true => "name the SRDF that belongs to the URDF".to_string(),
                false => {
                    format!("it is of the robot `{}`, and the URDF of `{of}`; name those of one robot", name.value)
                }
            };
            return Some(SrdfMessage::new(SrdfCode::OtherRobot, name.span.clone(), text).help(help));
        }
        if !same {
            let text = format!("the SRDF calls the robot `{}`, and the URDF `{of}`", name.value);
            let message = SrdfMessage::new(SrdfCode::OtherName, name.span.clone(), text);
            self.warnings.push(message.help("make sure that both describe one robot"));
        }
        None
    }

    pub(super) fn robot(&mut self, root: Node) -> Option<Srdf> {
        self.tag = xml::first_line(self.text, cx::tag(self.text, root));
        let tag = self.tag.clone();
        if root.tag_name().name() != "robot" {
            let text = format!("`<robot>` expected, `<{}>` found", root.tag_name().name());
            self.error(SrdfMessage::new(SrdfCode::NoRobot, tag, text));
            return None;
        }
        let is_xacro = |n: &Node| n.tag_name().namespace().is_some_and(|ns| ns.contains("xacro"));
        if let Some(node) = root.descendants().filter(Node::is_element).find(is_xacro) {
            let text = "this is a xacro file, not an SRDF";
            let message = SrdfMessage::new(SrdfCode::Xacro, cx::tag(self.text, node), text);
            self.error(message.help("expand it first: `xacro robot.srdf.xacro > robot.srdf`"));
            return None;
        }
        if let Some(node) = ["link", "joint"].into_iter().find_map(|element| children(root, element).next()) {
            let text = "this is a URDF, which describes links and joints, not an SRDF";
            let message = SrdfMessage::new(SrdfCode::Urdf, cx::tag(self.text, node), text);
            self.error(message.help("name it behind `urdf`, and the SRDF of the robot behind `srdf`"));
            return None;
        }
        for element in ["group", "group_state", "end_effector", "passive_joint", "virtual_joint", "disable_collisions"]
        {
            let (count, most) =
                (children(root, element).count(), if element == "group" { MAX_GROUPS } else { MAX_ELEMENTS });
            if count > most {
                let text = format!("{count} elements `<{element}>`, at most {most} are read");
                self.error(SrdfMessage::new(SrdfCode::TooLarge, tag, text));
                return None;
            }
        }
        let name = attribute(root, "name").filter(|a| !a.value.trim().is_empty());
        self.name = name.map(|a| Spanned { value: a.value.trim().to_string(), span: a.span });
        let virtual_joints: Vec<VirtualJoint> =
            children(root, "virtual_joint").filter_map(|node| self.virtual_joint(node)).collect();
        let raw: Vec<RawGroup> = children(root, "group").filter_map(|node| self.group(node)).collect();
        let names: BTreeMap<&str, usize> = raw.iter().enumerate().map(|(i, g)| (g.name.as_str(), i)).collect();
        let states: Vec<Node> = children(root, "group_state").collect();
        let postures = states.into_iter().filter_map(|node| self.posture(node, &names)).collect();
        let effectors: Vec<Node> = children(root, "end_effector").collect();
        let end_effectors = effectors.into_iter().filter_map(|node| self.end_effector(node, &names)).collect();
        let passive = children(root, "passive_joint").filter_map(|node| self.passive(node)).collect();
        let disabled = self.disabled(root);
        let groups = self.groups(&raw);
        let name = self.name.as_ref().map(|name| name.value.clone()).unwrap_or_default();
        let mut srdf = Srdf { name, groups, end_effectors, postures, passive, virtual_joints, disabled };
        self.twice(&mut srdf);
        Some(srdf)
    }

    /// Reports postures of a group that have the same name.
    fn twice(&mut self, srdf: &mut Srdf) {
        let mut seen: BTreeSet<(&str, &str)> = BTreeSet::new();
        for posture in &srdf.postures {
            if !seen.insert((&posture.group, &posture.name)) {
                let text = format!("group `{}` has two states `{}`", posture.group, posture.name);
                let message = SrdfMessage::new(SrdfCode::DuplicateName, posture.span.clone(), text);
                self.errors.push(message.help("keep one of the two, or give it another name"));
            }
        }
    }

    /// Returns a required attribute; reports an error if it is missing or empty.
    pub(super) fn need(&mut self, node: Node, name: &str) -> Option<Spanned<String>> {
        match attribute(node, name) {
            Some(found) if !found.value.trim().is_empty() => {
                Some(Spanned { value: found.value.trim().to_string(), span: found.span })
            }
            found => {
                let span = found.map_or_else(|| cx::tag(self.text, node), |f| f.span);
                let text = format!("`<{}>` has no `{name}`", node.tag_name().name());
                self.error(SrdfMessage::new(SrdfCode::Missing, span, text));
                None
            }
        }
    }

    /// Returns the link of a required attribute.
    pub(super) fn link(&mut self, node: Node, name: &str) -> Option<LinkId> {
        let written = self.need(node, name)?;
        let found = self.links.find(&written.value);
        if found.is_none() {
            let text = format!("the URDF has no link `{}`", written.value);
            self.error(SrdfMessage::new(SrdfCode::UnknownLink, written.span, text).unknown(&written.value));
        }
        found
    }

    /// Returns a link whose absence has no effect; `first` is true at the first use of an unknown name.
    pub(super) fn link_or_none(&mut self, name: &str) -> Result<LinkId, FirstUse> {
        self.links.find(name).ok_or_else(|| FirstUse(self.links.unknown.get(name) == Some(&1)))
    }

    /// Returns the joint of a required attribute. `None` also for a virtual joint, which is no error.
    pub(super) fn joint(&mut self, written: &Spanned<String>) -> Option<JointId> {
        if self.virtual_joints.contains_key(&written.value) {
            return None;
        }
        let found = self.joints.find(&written.value);
        if found.is_none() {
            let text = format!("the URDF has no joint `{}`", written.value);
            let message = SrdfMessage::new(SrdfCode::UnknownJoint, written.span.clone(), text);
            self.error(message.unknown(&written.value));
        }
        found
    }

    /// Returns the index of a group that an attribute names.
    pub(super) fn group_named(&mut self, written: &Spanned<String>, names: &BTreeMap<&str, usize>) -> Option<usize> {
        let found = names.get(written.value.as_str()).copied();
        if found.is_none() {
            let text = format!("there is no group `{}`", written.value);
            let message = SrdfMessage::new(SrdfCode::UnknownGroup, written.span.clone(), text);
            self.error(message.unknown(&written.value));
        }
        found
    }

    fn virtual_joint(&mut self, node: Node) -> Option<VirtualJoint> {
        let name = self.need(node, "name");
        let ty = self.need(node, "type");
        let child = self.link(node, "child_link");
        let name = name?;
        let root = child == Some(self.model.root());
        self.virtual_joints.insert(name.value.clone(), root);
        let ty = ty?;
        let motion = match ty.value.as_str() {
            "fixed" => VirtualMotion::Fixed,
            "planar" => VirtualMotion::Planar,
            "floating" => VirtualMotion::Floating,
            other => {
                let text = format!("there is no virtual joint of type `{other}`");
                let message = SrdfMessage::new(SrdfCode::UnknownJointType, ty.span, text);
                self.error(message.help("use `fixed`, `planar` or `floating`"));
                return None;
            }
        };
        Some(VirtualJoint { name: name.value, span: ty.span, motion, child: child? })
    }

    fn passive(&mut self, node: Node) -> Option<PassiveJoint> {
        let name = self.need(node, "name")?;
        self.joint(&name).map(|joint| PassiveJoint { joint, span: name.span })
    }

    fn end_effector(&mut self, node: Node, names: &BTreeMap<&str, usize>) -> Option<EndEffector> {
        let (name, group) = (self.need(node, "name"), self.need(node, "group"));
        let parent_link = self.need(node, "parent_link")?;
        let Ok(link) = self.link_or_none(&parent_link.value) else {
            let text = format!("the URDF has no link `{}`, and the end effector is left out", parent_link.value);
            let message = SrdfMessage::new(SrdfCode::UnknownLink, parent_link.span, text);
            self.warn(message.unknown(&parent_link.value));
            return None;
        };
        let parent_group = attribute(node, "parent_group").filter(|a| !a.value.trim().is_empty());
        let parent_group = parent_group.map(|a| Spanned { value: a.value.trim().to_string(), span: a.span });
        for written in group.iter().chain(&parent_group) {
            self.group_named(written, names);
        }
        let parent_group = parent_group.map(|written| written.value);
        Some(EndEffector { name: name?.value, group: group?.value, parent_link: link, parent_group })
    }

    fn posture(&mut self, node: Node, names: &BTreeMap<&str, usize>) -> Option<Posture> {
        let name = self.need(node, "name");
        let group = match attribute(node, "group") {
            Some(found) => Spanned { value: found.value.trim().to_string(), span: found.span },
            None => {
                let text = "`<group_state>` has no `group`, and counts for all joints";
                let span = cx::tag(self.text, node);
                self.warn(
                    SrdfMessage::new(SrdfCode::Missing, span.clone(), text).help("write the group of its joints"),
                );
                Spanned { value: ALL.to_string(), span }
            }
        };
        if group.value != ALL || names.contains_key(ALL) {
            self.group_named(&group, names);
        }
        let mut positions: Vec<Position> = Vec::new();
        for element in children(node, "joint") {
            let (joint, value) = (self.need(element, "name"), self.need(element, "value"));
            let (Some(written), Some(value)) = (joint, value) else { continue };
            // A virtual joint has several numbers, and the base has coordinates of its own.
            if self.virtual_joints.contains_key(&written.value) {
                continue;
            }
            let Some(joint) = self.joints.find(&written.value) else {
                let text = format!("the URDF has no joint `{}`, and the posture leaves it out", written.value);
                let message = SrdfMessage::new(SrdfCode::UnknownJoint, written.span, text);
                self.warn(message.unknown(&written.value));
                continue;
            };
            if positions.iter().any(|p| p.joint == joint) {
                let text = format!("joint `{}` is given twice", written.value);
                self.error(SrdfMessage::new(SrdfCode::DuplicateName, written.span, text).help("keep one of the two"));
                continue;
            }
            // Joints of several numbers, which some tools know, are fixed in a URDF.
            let moves = self.model.joint_ref(joint).kind != JointKind::Fixed;
            match parse_numbers::<1>(&value.value) {
                Err(_) if !moves => {}
                Ok([x]) => positions.push(Position { joint, value: x, span: value.span }),
                Err(text) => {
                    self.error(SrdfMessage::new(SrdfCode::BadNumber, value.span, format!("`value` {text}")));
                }
            }
        }
        let name = name?;
        let tag = cx::tag(self.text, node);
        Some(Posture { name: name.value, span: name.span, tag, group: group.value, positions })
    }
}

/// True at the first use of a name that is unknown.
pub(super) struct FirstUse(pub bool);
