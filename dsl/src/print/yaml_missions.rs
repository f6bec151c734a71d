//! Printer of YAML texts: missions and their members, below the plurals of their roles.

use super::hq::empty;
use super::yaml::{block, entries, key, one_line_block};
use super::{Lines, OneLine, WIDTH, yaml_reuse as reuse};
use crate::tree::{Block, Mission, MissionMember, MissionRepeat};
use crate::vocabulary::ROLES;

/// Settings, members and repetitions below a name.
type Body<'t> = (&'t Block, &'t [MissionMember], &'t [MissionRepeat]);

/// Prints `vineyard:`, its kind below it, and its parts below the kind.
pub(super) fn mission(it: &Mission, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    lines.out.push_str(&format!("{}:", key(&it.name)));
    lines.end(behind);
    lines.indent(indent + 2);
    lines.out.push_str(&format!("{}:", key(&it.kind)));
    body((&it.settings, &it.members, &it.repeats), &None, indent + 2, lines);
}

/// Prints the text after `name:`.
fn body((settings, members, repeats): Body<'_>, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    if members.is_empty() && repeats.is_empty() {
        return block(settings, behind, indent, lines);
    }
    lines.end(behind);
    entries(settings, indent + 2, lines);
    parts(members, repeats, indent + 2, lines);
    lines.before(&settings.closing_comments.before, indent + 2);
}

/// Prints members by role, then repetitions.
fn parts(members: &[MissionMember], repeats: &[MissionRepeat], indent: usize, lines: &mut Lines) {
    for role in ROLES {
        let mut title = Some(format!("{role}s:\n"));
        for it in members.iter().filter(|it| it.role.value == **role) {
            if let Some(title) = title.take() {
                lines.indent(indent);
                lines.out.push_str(&title);
            }
            member(it, indent + 2, lines);
        }
    }
    if !repeats.is_empty() {
        lines.indent(indent);
        lines.out.push_str("for:\n");
    }
    for it in repeats {
        repeat(it, indent + 2, lines);
    }
}

/// Prints `m1: { .. }` or `left_foot: { pick_and_place: { .. } }`.
fn member(it: &MissionMember, indent: usize, lines: &mut Lines) {
    lines.before(&it.comments.before, indent);
    lines.indent(indent);
    lines.out.push_str(&format!("{}:", key(&it.name)));
    let (behind, all) = (&it.comments.behind, (&it.settings, &it.members[..], &it.repeats[..]));
    let Some(action) = &it.action else { return body(all, behind, indent, lines) };
    let flat = it.members.is_empty() && it.repeats.is_empty();
    if flat && empty(&it.settings) {
        lines.out.push_str(&format!(" {}", key(action)));
        return lines.end(behind);
    }
    let mut line = OneLine::new(WIDTH.saturating_sub(lines.column() + 1));
    if flat && one_line(action, &it.settings, &mut line).is_some() {
        lines.out.push_str(&format!(" {}", line.text));
        return lines.end(behind);
    }
    lines.end(behind);
    lines.indent(indent + 2);
    lines.out.push_str(&format!("{}:", key(action)));
    body(all, &None, indent + 2, lines);
}

/// Formats `{ pick_and_place: { .. } }`.
fn one_line(action: &str, settings: &Block, line: &mut OneLine) -> Option<()> {
    line.push(&format!("{{ {}: ", key(action)))?;
    one_line_block(settings, line)?;
    line.push(" }")
}

/// Prints `- name: i`, `in: 1..4`, and the members below.
fn repeat(it: &MissionRepeat, indent: usize, lines: &mut Lines) {
    lines.before(&it.comments.before, indent);
    lines.indent(indent);
    lines.out.push_str(&format!("- name: {}", key(&it.variable)));
    lines.end(&it.comments.behind);
    reuse::over(&it.values, indent + 2, lines);
    parts(&it.members, &it.repeats, indent + 2, lines);
    lines.before(&it.closing_comments.before, indent + 2);
}
