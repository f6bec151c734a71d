//! Groups of joints.

use std::collections::BTreeSet;

use dsl::tree::Block;
use dsl::{Diagnostic, Spanned};
use robot::srdf::Group;
use robot::{Drive, Model, Srdf};

use super::JointGroups;
use super::lookup::{is_pattern, joints};

/// Groups among all joints of a robot; [`JointGroups::without`] removes locked joints.
/// Groups of the SRDF count unless the spec, or a joint, has the same name.
pub(super) fn joint_groups(
    block: Option<&Block>,
    srdf: Option<&Srdf>,
    model: &Model,
    diagnostics: &mut Vec<Diagnostic>,
) -> JointGroups {
    let mut groups = JointGroups::default();
    if !model.bases.is_empty() {
        groups.members.insert("base".to_string(), of_bases(model).collect());
    }
    groups.members.insert("all".to_string(), (0..model.nv()).collect());
    let mut replaceable: BTreeSet<&str> = BTreeSet::new();
    for group in srdf.iter().flat_map(|srdf| &srdf.groups) {
        if model.dof(&group.name).is_none() && !groups.members.contains_key(&group.name) {
            groups.members.insert(group.name.clone(), dofs_of(group, model));
            replaceable.insert(&group.name);
        }
    }
    for e in block.iter().flat_map(|b| &b.entries) {
        let name = e.key.value.as_str();
        if is_pattern(name) {
            diagnostics.push(pattern_as_name(&e.key));
            continue;
        }
        let taken = groups.members.contains_key(name) && !replaceable.remove(name);
        if model.dof(name).is_some() || taken {
            let text = format!("`{name}` is already the name of a joint or group");
            diagnostics.push(Diagnostic::error("HQ0202", e.key.span, text).help("choose another name for the group"));
            continue;
        }
        match joints(e.value.items(), model, &groups, diagnostics) {
            Some(dofs) => {
                groups.members.insert(name.to_string(), dofs);
            }
            None => {
                groups.members.remove(name);
                groups.failed.insert(name.to_string());
            }
        }
    }
    groups
}

/// Degrees of freedom of a group of the SRDF: those of the base, if its joint belongs to the group, then those of joints.
fn dofs_of(group: &Group, model: &Model) -> Vec<usize> {
    let of_joint = |joint: &robot::JointId| match model.joint_ref(*joint).drive {
        Drive::Dof(dof) => Some(dof),
        _ => None,
    };
    of_bases(model).filter(|_| group.base).chain(group.joints.iter().filter_map(of_joint)).collect()
}

/// Degrees of freedom of all bases.
fn of_bases(model: &Model) -> impl Iterator<Item = usize> {
    model.bases.iter().flat_map(|base| base.dofs())
}

/// Diagnostic for a pattern as the name of a declaration.
pub(super) fn pattern_as_name(key: &Spanned<String>) -> Diagnostic {
    Diagnostic::error("HQ0202", key.span, format!("`{}` is a pattern, and a declaration needs a name", key.value))
        .help("choose a name without `*` and `?`; its value can be a pattern")
}

impl JointGroups {
    /// Returns the groups for the robot without its locked joints.
    pub(super) fn without(self, locked: BTreeSet<String>, whole: &Model, model: &Model) -> JointGroups {
        let kept = |dofs: Vec<usize>| dofs.into_iter().filter_map(|d| model.dof(&whole.dofs[d].name)).collect();
        let members = self.members.into_iter().map(|(name, dofs)| (name, kept(dofs))).collect();
        JointGroups { members, locked, ..self }
    }
}
