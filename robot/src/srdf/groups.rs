//! Members of the groups of an SRDF: joints, links, chains between two links, and other groups.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use roxmltree::Node;

use super::read::{ALL, Reader};
use super::{Group, SrdfCode, SrdfMessage};
use crate::urdf::cx::{self, Spanned, attribute, children, list};
use crate::{JointId, LinkId, Model};

/// A group as written, without its subgroups.
pub(super) struct RawGroup {
    pub name: String,
    span: Range<usize>,
    tag: Range<usize>,
    members: Members,
    subgroups: Vec<Spanned<String>>,
    /// The tip, if the group is one chain and nothing else.
    tip: Option<LinkId>,
    /// True if a part could not be read.
    broken: bool,
}

/// Joints and links of a group; true if it contains the joint that carries the root link.
#[derive(Clone, Default)]
struct Members {
    joints: BTreeSet<JointId>,
    links: BTreeSet<LinkId>,
    base: bool,
}

impl Members {
    fn joint(&mut self, model: &Model, joint: JointId) {
        self.joints.insert(joint);
        self.links.insert(model.joint_ref(joint).child);
    }

    fn add(&mut self, other: &Members) {
        self.joints.extend(&other.joints);
        self.links.extend(&other.links);
        self.base |= other.base;
    }
}

/// Links from one to the root.
fn ancestors(model: &Model, link: LinkId) -> Vec<LinkId> {
    std::iter::successors(Some(link), |link| model.parent(*link)).collect()
}

impl Reader<'_, '_> {
    /// Reads a group without its subgroups.
    pub(super) fn group(&mut self, node: Node) -> Option<RawGroup> {
        let name = self.need(node, "name")?;
        let mut members = Members::default();
        let mut broken = false;
        let (links, joints): (Vec<Node>, Vec<Node>) =
            (children(node, "link").collect(), children(node, "joint").collect());
        for element in &joints {
            let Some(written) = self.need(*element, "name") else {
                broken = true;
                continue;
            };
            match (self.joint(&written), self.virtual_joints.get(&written.value)) {
                (Some(joint), _) => members.joint(self.model, joint),
                (None, Some(carries_the_root)) => members.base |= *carries_the_root,
                (None, None) => broken = true,
            }
        }
        for element in &links {
            match self.link(*element, "name") {
                Some(link) => {
                    members.links.insert(link);
                    members.joints.extend(self.model.link_ref(link).parent_joint);
                }
                None => broken = true,
            }
        }
        let chains: Vec<Node> = children(node, "chain").collect();
        let mut tip = None;
        for element in &chains {
            match self.chain(*element, &mut members) {
                Some(of) => tip = of.filter(|_| chains.len() == 1),
                None => broken = true,
            }
        }
        let subgroups: Vec<Spanned<String>> = children(node, "group")
            .filter_map(|element| {
                let span = cx::tag(self.text, element);
                let found =
                    attribute(element, "name").map(|a| Spanned { value: a.value.trim().to_string(), span: a.span });
                if found.is_none() {
                    self.error(SrdfMessage::new(SrdfCode::Missing, span, "`<group>` has no `name`"));
                }
                found
            })
            .collect();
        let only_a_chain = links.is_empty() && joints.is_empty() && subgroups.is_empty();
        let tag = cx::tag(self.text, node);
        let tip = tip.filter(|_| only_a_chain);
        Some(RawGroup { name: name.value, span: name.span, tag, members, subgroups, tip, broken })
    }

    /// Adds the joints between two links: from the base down to the tip, or up from the base to a link before both, and
    /// down to the tip. Returns the tip if it is behind the base; `None` after an error.
    fn chain(&mut self, node: Node, members: &mut Members) -> Option<Option<LinkId>> {
        let (base, tip) = (self.link(node, "base_link"), self.link(node, "tip_link"));
        let (base, tip) = (base?, tip?);
        if base == tip {
            let text = format!("this chain has no joint: it begins and ends at `{}`", self.model.link_ref(tip).name);
            let message = SrdfMessage::new(SrdfCode::BrokenChain, cx::tag(self.text, node), text);
            self.error(message.help("name the link before the first joint, and the last link"));
            return None;
        }
        let (up, down) = (ancestors(self.model, base), ancestors(self.model, tip));
        // The model is one tree: both lists end at its root.
        let common = *up.iter().find(|link| down.contains(link))?;
        for way in [&up, &down] {
            for link in way.iter().take_while(|link| **link != common) {
                if let Some(joint) = self.model.link_ref(*link).parent_joint {
                    members.joint(self.model, joint);
                }
            }
        }
        Some((common == base).then_some(tip))
    }

    /// Completes the groups by their subgroups, and reports duplicates, unknown names, circles and groups without members.
    pub(super) fn groups(&mut self, raw: &[RawGroup]) -> Vec<Group> {
        let mut names: BTreeMap<&str, usize> = BTreeMap::new();
        for (i, group) in raw.iter().enumerate() {
            if names.insert(&group.name, i).is_some() {
                let text = format!("there is already a group `{}`", group.name);
                let message = SrdfMessage::new(SrdfCode::DuplicateName, group.span.clone(), text);
                self.error(message.help("join the two, or choose another name"));
            }
        }
        let inner: Vec<Vec<Option<usize>>> = raw
            .iter()
            .map(|group| group.subgroups.iter().map(|written| self.group_named(written, &names)).collect())
            .collect();
        let Some(order) = self.order(raw, &inner) else { return Vec::new() };
        let mut members: Vec<Members> = raw.iter().map(|group| group.members.clone()).collect();
        let mut broken: Vec<bool> = raw.iter().map(|group| group.broken).collect();
        for i in order {
            for sub in &inner[i] {
                let Some(sub) = *sub else {
                    broken[i] = true;
                    continue;
                };
                let part = members[sub].clone();
                members[i].add(&part);
                broken[i] |= broken[sub];
            }
        }
        let mut all = Vec::with_capacity(raw.len());
        for ((group, members), broken) in raw.iter().zip(members).zip(broken) {
            let is_empty = members.joints.is_empty() && members.links.is_empty() && !members.base && !broken;
            // Some tools declare the group of all joints without saying so.
            if is_empty && group.name == ALL {
                continue;
            }
            if is_empty {
                let text = format!("group `{}` is empty", group.name);
                self.warn(SrdfMessage::new(SrdfCode::Ignored, group.span.clone(), text));
            }
            all.push(Group {
                name: group.name.clone(),
                span: group.span.clone(),
                tag: group.tag.clone(),
                joints: members.joints.into_iter().collect(),
                links: members.links.into_iter().collect(),
                base: members.base,
                tip: group.tip,
            });
        }
        all
    }

    /// Order in which each group comes after its subgroups; `None` for a circle, which is reported.
    fn order(&mut self, raw: &[RawGroup], inner: &[Vec<Option<usize>>]) -> Option<Vec<usize>> {
        let mut waiting: Vec<usize> = inner.iter().map(|subs| subs.iter().flatten().count()).collect();
        let mut outer: Vec<Vec<usize>> = vec![Vec::new(); raw.len()];
        for (i, subs) in inner.iter().enumerate() {
            subs.iter().flatten().for_each(|&sub| outer[sub].push(i));
        }
        let mut order: Vec<usize> = (0..raw.len()).filter(|&i| waiting[i] == 0).collect();
        let mut next = 0;
        while let Some(&done) = order.get(next) {
            next += 1;
            for &i in &outer[done] {
                waiting[i] -= 1;
                if waiting[i] == 0 {
                    order.push(i);
                }
            }
        }
        // A group in a circle waits for one that waits too: following these leads into the circle.
        let Some(start) = (0..raw.len()).find(|&i| waiting[i] > 0) else { return Some(order) };
        let waits = |i: usize| inner[i].iter().flatten().copied().find(|&sub| waiting[sub] > 0);
        let mut way = vec![start];
        let circle = loop {
            let at = waits(*way.last()?)?;
            if let Some(first) = way.iter().position(|&i| i == at) {
                break way.split_off(first);
            }
            way.push(at);
        };
        let first = &raw[*circle.iter().min()?];
        let text = match circle.len() {
            1 => format!("group `{}` contains itself", first.name),
            _ => {
                let names = list(circle.iter().map(|&i| raw[i].name.as_str()));
                format!("these groups contain each other in a circle: {names}")
            }
        };
        let message = SrdfMessage::new(SrdfCode::GroupCycle, first.span.clone(), text);
        self.error(message.help("take one `<group>` out of the circle"));
        None
    }
}
