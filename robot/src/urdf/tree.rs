//! Construction of the tree: the parent of each joint, and the order of the joints.

use std::collections::BTreeMap;

use super::cx::{Cx, list};
use super::read::RawRobot;
use super::{UrdfCode, UrdfMessage};

/// The structure of a valid tree.
pub(super) struct Tree {
    /// Index of the root in the list of links as written.
    pub root: usize,
    /// Indices of the joints as written, depth first, children in file order.
    pub joints: Vec<usize>,
    /// Parent and child of each joint as written, as indices of links.
    pub ends: Vec<(usize, usize)>,
}

/// Checks that the joints connect the links to one tree. Returns `None` if errors were reported.
pub(super) fn grow(cx: &mut Cx, robot: &RawRobot) -> Option<Tree> {
    let before = cx.errors.len();
    let mut index = BTreeMap::new();
    for (i, link) in robot.links.iter().enumerate() {
        index.entry(link.name.value.as_str()).or_insert(i);
    }
    let mut above: Vec<Option<usize>> = vec![None; robot.links.len()];
    let mut below: Vec<Vec<usize>> = vec![Vec::new(); robot.links.len()];
    let mut ends = Vec::with_capacity(robot.joints.len());
    for (j, joint) in robot.joints.iter().enumerate() {
        let mut find = |end: &super::cx::Spanned<String>| {
            let found = index.get(end.value.as_str()).copied();
            if found.is_none() {
                let text = format!("there is no link `{}`", end.value);
                cx.error(UrdfMessage::new(UrdfCode::UnknownLink, end.span.clone(), text));
            }
            found
        };
        let (parent, child) = (find(&joint.parent), find(&joint.child));
        let (Some(parent), Some(child)) = (parent, child) else {
            ends.push((0, 0));
            continue;
        };
        ends.push((parent, child));
        match above[child] {
            Some(first) => {
                let text = format!("link `{}` already has a parent", joint.child.value);
                let first = &robot.joints[first];
                let help = format!("joint `{}` on line {}", first.name.value, cx.line(&first.tag));
                let span = joint.child.span.clone();
                cx.error(UrdfMessage::new(UrdfCode::TwoParents, span, text).help(help));
            }
            None => {
                above[child] = Some(j);
                below[parent].push(j);
            }
        }
    }
    cycles(cx, robot, &above, &ends);
    free_joints(cx, robot, &above, &ends);
    if cx.errors.len() > before {
        return None;
    }
    let roots: Vec<usize> = (0..robot.links.len()).filter(|&i| above[i].is_none()).collect();
    if let [_, second, ..] = roots[..] {
        // Several roots may only follow from an earlier error, and are not reported again.
        if cx.errors.is_empty() {
            let names = list(roots.iter().map(|&i| robot.links[i].name.value.as_str()));
            let text = format!("only one link may be without a parent, {} are: {names}", roots.len());
            let span = robot.links[second].name.span.clone();
            cx.error(UrdfMessage::new(UrdfCode::SeveralRoots, span, text).help("join them by a joint of type `fixed`"));
        }
        return None;
    }
    let root = *roots.first()?;
    let mut joints = Vec::with_capacity(robot.joints.len());
    let mut stack: Vec<usize> = below[root].iter().rev().copied().collect();
    while let Some(j) = stack.pop() {
        joints.push(j);
        stack.extend(below[ends[j].1].iter().rev());
    }
    Some(Tree { root, joints, ends })
}

/// Reports each cycle once, at its first joint in the file.
fn cycles(cx: &mut Cx, robot: &RawRobot, above: &[Option<usize>], ends: &[(usize, usize)]) {
    // 0: not visited; n: visited on the walk from link n - 1.
    let mut walk = vec![0; above.len()];
    for start in 0..above.len() {
        let mut at = start;
        while walk[at] == 0 {
            walk[at] = start + 1;
            match above[at] {
                Some(j) => at = ends[j].0,
                None => break,
            }
        }
        if walk[at] != start + 1 || above[at].is_none() {
            continue;
        }
        let mut round = Vec::new();
        let mut link = at;
        while let Some(j) = above[link] {
            round.push(j);
            link = ends[j].0;
            if link == at {
                break;
            }
        }
        round.reverse();
        if let Some(&first) = round.iter().min() {
            let names = list(round.iter().map(|&j| robot.joints[j].name.value.as_str()));
            let text = format!("the links hang on each other in a circle, through {names}");
            let span = robot.joints[first].child.span.clone();
            cx.error(UrdfMessage::new(UrdfCode::Cycle, span, text));
        }
    }
}

fn free_joints(cx: &mut Cx, robot: &RawRobot, above: &[Option<usize>], ends: &[(usize, usize)]) {
    for (joint, &(parent, _)) in robot.joints.iter().zip(ends) {
        let Some(free) = &joint.free else { continue };
        let kind = &free.value;
        let help = if above.get(parent).is_some_and(Option::is_none) {
            format!(
                "the base is set outside the URDF: delete this joint and link `{}`, and write \
                 `base: {kind}`",
                joint.parent.value
            )
        } else {
            format!("only the base can move freely: make this link the root and write `base: {kind}`")
        };
        let text = format!("joint `{}` is {kind}, which is not possible inside the tree", joint.name.value);
        cx.error(UrdfMessage::new(UrdfCode::FreeJoint, free.span.clone(), text).help(help));
    }
}
