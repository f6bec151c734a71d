//! The printer of `*.hq` texts: missions and their members.

use super::Lines;
use super::hq::{block, empty, entries};
use super::hq_reuse as reuse;
use crate::tree::{Block, Mission, MissionMember, MissionRepeat};

/// What stands between braces.
type Body<'t> = (&'t Block, &'t [MissionMember], &'t [MissionRepeat]);

/// `mission vineyard : schedule { .. }`
pub(super) fn mission(it: &Mission, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    lines.out.push_str(&format!("mission {} : {} ", it.name.value, it.kind.value));
    body((&it.settings, &it.members, &it.repeats), behind, indent, true, lines);
}

/// A body that ends its line; one of settings alone stands on one line where it fits and is not `tall`.
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

/// Members and repetitions, behind what was written from byte `start` on: those of one role that take one line stand
/// together, the others apart.
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

/// True where what was written from byte `at` on is one line.
fn is_short(lines: &Lines, at: usize) -> bool {
    lines.out[at..].bytes().filter(|&b| b == b'\n').count() < 2
}

/// An empty line before what was written from byte `at` on, where something stands before it that it is not `joined` to.
fn apart(at: usize, start: usize, joined: bool, lines: &mut Lines) {
    if at > start && !joined {
        lines.out.insert(at, '\n');
    }
}

/// `robot m1 { .. }`, `task left_foot = pick_and_place { .. }`
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

/// `for i in 1..4 { .. }`
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
