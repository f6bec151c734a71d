//! What names mean on a robot, and the diagnostics for those that mean nothing.

use std::collections::BTreeMap;

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Span};
use robot::Model;
use stdlib_tasks::bound::{Arm, Geometry};

use super::JointGroups;
use crate::forms::text_of;
use crate::names::{list, suggest};

/// `*` stands for any run of characters, `?` for one.
pub fn glob(pattern: &str, name: &str) -> bool {
    let (p, n): (Vec<char>, Vec<char>) = (pattern.chars().collect(), name.chars().collect());
    let (mut i, mut k, mut star) = (0, 0, None);
    while k < n.len() {
        if i < p.len() && (p[i] == '?' || (p[i] == n[k] && p[i] != '*')) {
            i += 1;
            k += 1;
        } else if i < p.len() && p[i] == '*' {
            star = Some((i, k));
            i += 1;
        } else if let Some((si, sk)) = star {
            i = si + 1;
            k = sk + 1;
            star = Some((si, sk + 1));
        } else {
            return false;
        }
    }
    p[i..].iter().all(|&c| c == '*')
}

/// The diagnostic for a joint that is not there, with the reason if it is there and does not move.
pub fn unknown_joint(model: &Model, name: &str, span: Span, groups: &[&str]) -> Diagnostic {
    if let Some(j) = model.joint(name) {
        let why = match model.joint_ref(j).drive {
            robot::Drive::Fixed => "it is fixed",
            robot::Drive::Mimic { .. } => "it mimics another joint",
            robot::Drive::Locked(_) => "the robot's `lock` holds it still",
            robot::Drive::Dof(_) => "it cannot be named here",
        };
        let d = Diagnostic::error("HQ0201", span, format!("joint `{name}` does not move by itself: {why}"));
        return match model.joint_ref(j).drive {
            robot::Drive::Locked(_) => d.help("take it out of `lock`, or leave it out here"),
            robot::Drive::Mimic { .. } => d.help("name the joint that it follows"),
            _ => d.help("leave it out"),
        };
    }
    let mut known: Vec<&str> = model.dofs.iter().map(|d| d.name.as_str()).collect();
    known.extend(groups);
    let d = Diagnostic::error("HQ0201", span, format!("robot `{}` has no joint `{name}`", model.name));
    match suggest(name, known.iter().copied()) {
        _ if model.link(name).is_some() => d.help("this is a link; name the joint that moves it"),
        Some(near) => d.help(format!("did you mean `{near}`?")),
        None => d.help(format!("it has {}", list(known, 8))),
    }
}

/// The diagnostic for a link that is not there.
pub fn unknown_link(model: &Model, name: &str, span: Span, arms: &[Arm]) -> Diagnostic {
    let known = arms.iter().map(|a| a.name.as_str()).chain(model.links.iter().map(|l| l.name.as_str()));
    let d = Diagnostic::error("HQ0201", span, format!("robot `{}` has no link `{name}`", model.name));
    match suggest(name, known.clone()) {
        _ if model.joint(name).is_some() => d.help("this is a joint; frames are named by their links"),
        Some(near) => d.help(format!("did you mean `{near}`?")),
        None => d.help(format!("it has {}", list(known, 8))),
    }
}

/// The diagnostic for a point, segment, link or group that is not there.
pub fn unknown_geometry(
    model: &Model,
    geometries: &[Geometry],
    groups: &BTreeMap<String, Vec<String>>,
    name: &str,
    span: Span,
) -> Diagnostic {
    let mut known: Vec<&str> = geometries.iter().map(|g| g.name.as_str()).collect();
    known.extend(groups.keys().map(String::as_str));
    let links: Vec<&str> = model.links.iter().map(|l| l.name.as_str()).collect();
    let d = Diagnostic::error("HQ0201", span, format!("there is no point, segment, group or link `{name}`"));
    match suggest(name, known.iter().chain(&links).copied()) {
        Some(near) => d.help(format!("did you mean `{near}`?")),
        None if !known.is_empty() => d.help(format!("declared are {}", list(known, 10))),
        None => d.help("declare it in the robot: `points { left_elbow arm_left_4_link }`"),
    }
}

/// Degrees of freedom that names, groups and patterns mean, in the order written.
pub fn joints(
    items: &[Value],
    model: &Model,
    groups: &JointGroups,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Vec<usize>> {
    let mut dofs: Vec<usize> = Vec::new();
    let mut good = true;
    for item in items {
        let Some(name) = text_of(item) else {
            if !matches!(item.kind, ValueKind::Missing) {
                diagnostics.push(Diagnostic::error("HQ0304", item.span, "the name of a joint or group is needed here"));
            }
            good = false;
            continue;
        };
        let found: Vec<usize> = if let Some(d) = model.dof(name) {
            vec![d]
        } else if groups.failed.contains(name) {
            good = false;
            continue;
        } else if let Some(g) = groups.members.get(name) {
            g.clone()
        } else {
            (0..model.nv()).filter(|&i| name.contains(['*', '?']) && glob(name, &model.dofs[i].name)).collect()
        };
        if found.is_empty() {
            let names: Vec<&str> = groups.members.keys().map(String::as_str).collect();
            diagnostics.push(unknown_joint(model, name, item.span, &names));
            good = false;
        }
        dofs.extend(found.into_iter().filter(|d| !dofs.contains(d)).collect::<Vec<_>>());
    }
    good.then_some(dofs)
}
