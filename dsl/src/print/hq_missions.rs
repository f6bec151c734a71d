//! Printer of `*.hq` texts: missions and their members.

use super::Lines;
use super::hq::{block, empty, entries};
use super::hq_reuse as reuse;
use crate::tree::{Block, Mission, MissionMember, MissionRepeat};

/// Settings, members and repetitions in braces.
type Body<'t> = (&'t Block, &'t [MissionMember], &'t [MissionRepeat]);

/// Prints `mission vineyard : schedule { .. }`.
pub(super) fn mission(it: &Mission, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    lines.out.push_str(&format!("mission {} : {} ", it.name.value, it.kind.value));
    body((&it.settings, &it.members, &it.repeats), behind, indent, true, lines);
}

/// Prints a body that ends its line; one with settings only is on one line if it fits and is not `tall`.
fn body((settings, members, repeats): Body<'_>, behind: &Option<String>, indent: usize, tall: bool, lines: &mut Lines) {
    if members.is_empty() && repeats.is_empty() {
        return block(settings, behind, indent, tall && settings.entries.len() > 2, lines);
    }
    lines.out.push('{');
    lines.end(behind);
    let start = lines.out.len();
    entries(settings, indent + 2, lines);
    parts(members, repeats, indent + 2, start, lines);
    lines.before(&settings.closing_comments.before, indent + 2);
    lines.indent(indent);
    lines.out.push_str("}\n");
}

/// Prints members and repetitions after the text from byte `start` on: members of one role that take one line are kept
/// together, the others are separated by empty lines.
fn parts(members: &[MissionMember], repeats: &[MissionRepeat], indent: usize, start: usize, lines: &mut Lines) {
    let mut last = None;
    for it in members {
        let at = lines.out.len();
        member(it, indent, lines);
        let own = is_short(lines, at).then_some(it.role.value.as_str());
        apart(at, start, own.is_some() && own == last, lines);
        last = own;
    }
    for it in repeats {
        let at = lines.out.len();
        repeat(it, indent, lines);
        apart(at, start, false, lines);
    }
}

/// Returns true if the text from byte `at` on is a single line.
fn is_short(lines: &Lines, at: usize) -> bool {
    lines.out[at..].bytes().filter(|&b| b == b'\n').count() < 2
}

/// Inserts an empty line before the text from byte `at` on, if other text precedes it to which it is not `joined`.
fn apart(at: usize, start: usize, joined: bool, lines: &mut Lines) {
    if at > start && !joined {
        lines.out.insert(at, '\n');
    }
}

/// Prints `robot m1 { .. }`, `task left_foot = pick_and_place { .. }`.
fn member(it: &MissionMember, indent: usize, lines: &mut Lines) {
    lines.before(&it.comments.before, indent);
    lines.indent(indent);
    lines.out.push_str(&format!("{} {}", it.role.value, it.name.value));
    if let Some(action) = &it.action {
        lines.out.push_str(&format!(" = {}", action.value));
        if empty(&it.settings) && it.members.is_empty() && it.repeats.is_empty() {
            return lines.end(&it.comments.behind);
        }
    }
    lines.out.push(' ');
    body((&it.settings, &it.members, &it.repeats), &it.comments.behind, indent, false, lines);
}

/// Prints `for i in 1..4 { .. }`.
fn repeat(it: &MissionRepeat, indent: usize, lines: &mut Lines) {
    lines.before(&it.comments.before, indent);
    lines.indent(indent);
    lines.out.push_str(&reuse::repeat_head(&it.variable, &it.values));
    lines.out.push_str(" {");
    lines.end(&it.comments.behind);
    parts(&it.members, &it.repeats, indent + 2, lines.out.len(), lines);
    lines.before(&it.closing_comments.before, indent + 2);
    lines.indent(indent);
    lines.out.push_str("}\n");
}
