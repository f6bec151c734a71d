//! Resolves names on a robot, and builds the diagnostics for unknown names.

use std::collections::{BTreeMap, BTreeSet};

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Help, Snippet, Span};
use names::{list, suggest};
use robot::{Drive, Model};
use stdlib_tasks::bound::{Arm, Geometry};

use super::JointGroups;
use crate::forms::text_of;

/// Matches a pattern: `*` matches any sequence of characters, `?` one character.
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

/// True for a name that contains `*` or `?`.
pub fn is_pattern(name: &str) -> bool {
    name.contains(['*', '?'])
}

/// Diagnostic for an unknown joint, or for one that does not move. `offered` are names other than joints to suggest,
/// `locked` are the joints that the spec locks.
pub fn unknown_joint(model: &Model, name: &str, span: Span, offered: &[&str], locked: &BTreeSet<String>) -> Diagnostic {
    if let Some(j) = model.joint(name) {
        let joint = model.joint_ref(j);
        let (why, help) = match joint.drive {
            Drive::Fixed => ("it is fixed", "leave it out"),
            Drive::Mimic { .. } => ("it mimics another joint", "name the joint that it follows"),
            Drive::Locked(_) if locked.contains(name) => {
                ("the robot's `lock` holds it still", "take it out of `lock`, or leave it out here")
            }
            Drive::Locked(_) if joint.lower == joint.upper => (
                "its lower and upper limit in the URDF are equal",
                "leave it out, or write the `<limit>` of a joint that moves into the URDF",
            ),
            Drive::Locked(_) => ("it mimics a joint that does not move", "leave it out"),
            Drive::Dof(_) => ("it cannot be named here", "leave it out"),
        };
        let text = format!("joint `{name}` does not move by itself: {why}");
        return Diagnostic::unknown_name(span, text).help(help);
    }
    if is_pattern(name) {
        return unmatched(model, name, span, offered, locked);
    }
    let mut known: Vec<&str> = model.dofs.iter().map(|d| d.name.as_str()).collect();
    known.extend(offered);
    let d = Diagnostic::unknown_name(span, lacks(model, "joint", name));
    match suggest(name, known.iter().copied()) {
        _ if !of_robots(model, name, &known).is_empty() => d.help(which_robot(&of_robots(model, name, &known))),
        _ if model.link(name).is_some() => d.help("this is a link; name the joint that moves it"),
        Some(near) => d.meant(near),
        None => d.help(format!("it has {}", list(known, 8))),
    }
}

/// Words for a joint or a link that does not exist. The model of several robots has no name of its own.
fn lacks(model: &Model, what: &str, name: &str) -> String {
    match model.roots.len() {
        0 | 1 => format!("robot `{}` has no {what} `{name}`", model.name),
        _ => format!("no robot has a {what} `{name}`"),
    }
}

/// Those of the known names that are this one with the name of a robot before it, if there are several robots.
fn of_robots<'n>(model: &Model, name: &str, known: &[&'n str]) -> Vec<&'n str> {
    let of_one = |known: &&&str| known.strip_suffix(name).is_some_and(|robot| robot.len() > 1 && robot.ends_with('_'));
    if model.roots.len() > 1 { known.iter().filter(of_one).copied().collect() } else { Vec::new() }
}

/// Help for a name without that of its robot.
fn which_robot(names: &[&str]) -> String {
    format!("write the name of the robot before it: {}", list(names.iter().copied(), 8))
}

/// Diagnostic for a pattern that matches no movable joint.
fn unmatched(model: &Model, pattern: &str, span: Span, offered: &[&str], locked: &BTreeSet<String>) -> Diagnostic {
    let text = match model.roots.len() {
        0 | 1 => format!("no joint of robot `{}` that moves by itself fits `{pattern}`", model.name),
        _ => format!("no joint of the robots that moves by itself fits `{pattern}`"),
    };
    let d = Diagnostic::unknown_name(span, text);
    if locked.iter().any(|n| glob(pattern, n)) {
        return d.help("the robot's `lock` holds those that fit; take them out of `lock`, or leave them out here");
    }
    let names: Vec<&str> = model.dofs.iter().map(|d| d.name.as_str()).collect();
    let patterns = common_patterns(&names);
    match suggest(pattern, patterns.iter().map(String::as_str).chain(offered.iter().copied())) {
        Some(near) if is_pattern(near) => d.meant(format!("\"{near}\"")),
        Some(near) => d.meant_as("the group", near),
        None => d.help(format!("it has {}", list(names.into_iter().chain(offered.iter().copied()), 8))),
    }
}

/// Patterns that match at least two joints, built from parts of their names: `arm_*`, `*_joint`.
fn common_patterns(names: &[&str]) -> Vec<String> {
    let mut patterns: Vec<String> = Vec::new();
    for name in names {
        for (i, _) in name.match_indices('_') {
            for p in [format!("{}*", &name[..=i]), format!("*{}", &name[i..])] {
                if !patterns.contains(&p) && names.iter().filter(|n| glob(&p, n)).count() > 1 {
                    patterns.push(p);
                }
            }
        }
    }
    patterns
}

/// Diagnostic for an unknown link.
pub fn unknown_link(model: &Model, name: &str, span: Span, arms: &[Arm]) -> Diagnostic {
    let known = arms.iter().map(|a| a.name.as_str()).chain(model.links.iter().map(|l| l.name.as_str()));
    let d = Diagnostic::unknown_name(span, lacks(model, "link", name));
    let names: Vec<&str> = known.clone().collect();
    match suggest(name, known.clone()) {
        _ if !of_robots(model, name, &names).is_empty() => d.help(which_robot(&of_robots(model, name, &names))),
        _ if model.joint(name).is_some() => d.help("this is a joint; frames are named by their links"),
        Some(near) => d.meant(near),
        None => d.help(format!("it has {}", list(known, 8))),
    }
}

/// Diagnostic for an unknown point, segment, link or group.
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
    let d = Diagnostic::undeclared("point, segment, group or link", name, span);
    let example = Snippet::block("points", [Snippet::entry("left_elbow", "arm_left_4_link")]);
    let d = match known.is_empty() {
        true => d.help(Help::with("declare it in the robot: {}", [example])),
        false => d.help(format!("declared are {}", list(known.iter().copied(), 12))),
    };
    d.nearest(name, known.into_iter().chain(links))
}

/// Degrees of freedom of names, groups and patterns, in source order.
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
                diagnostics.push(no_name(item));
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
            (0..model.nv()).filter(|&i| is_pattern(name) && glob(name, &model.dofs[i].name)).collect()
        };
        if found.is_empty() {
            let names: Vec<&str> = groups.members.keys().map(String::as_str).collect();
            diagnostics.push(if groups.members.contains_key(name) {
                Diagnostic::unknown_name(item.span, format!("no joint of group `{name}` moves"))
                    .note("the robot's `lock` holds all of them still")
                    .help("take them out of `lock`, or leave the group out here")
            } else {
                unknown_joint(model, name, item.span, &names, &groups.locked)
            });
            good = false;
        }
        dofs.extend(found.into_iter().filter(|d| !dofs.contains(d)).collect::<Vec<_>>());
    }
    good.then_some(dofs)
}

/// Help for a pattern without quotes.
pub(super) fn pattern_in_quotes() -> Help {
    Help::each(
        "write the name pattern in quotes, as in `\"arm_*_joint\"`",
        "write the name pattern as one word, as in `\"arm_*_joint\"`",
    )
}

/// Diagnostic for a value that is not a name; `arm_*_joint` without quotes is parsed as a product.
fn no_name(item: &Value) -> Diagnostic {
    let d = Diagnostic::error("HQ0304", item.span, "the name of a joint or group is needed here");
    match &item.kind {
        ValueKind::Binary(..) => d.help(pattern_in_quotes()),
        _ => d.help("write names and patterns, as in `[joint_1, \"arm_*\"]`"),
    }
}
