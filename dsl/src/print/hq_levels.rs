//! Printer of `*.hq` texts: stacks, levels, members.

use super::hq::{definition, empty, entries, head, one_line_block, takes_arguments};
use super::hq_allowances as allowances;
use super::hq_reuse as reuse;
use super::{Lines, OneLine, WIDTH, expr, no_comments};
use crate::tree::{Beside, Block, Change, Comments, Entry, Level, Member, MemberTask, Stack, Value};

pub(super) fn stack(it: &Stack, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    let from = it.base.as_ref().map_or_else(String::new, reuse::from);
    lines.out.push_str(&format!("stack {}{}{from} {{", it.name.value, reuse::parameters(&it.parameters)));
    let closing = &it.settings.closing_comments.before;
    if it.base.is_some() && it.settings.entries.is_empty() && it.changes.is_empty() && closing.is_empty() {
        lines.out.push('}');
        return lines.end(behind);
    }
    lines.end(behind);
    entries(&it.settings, indent + 2, lines);
    for item in &it.levels {
        level(item, "level", None, indent + 2, lines);
    }
    for change in &it.changes {
        match change {
            Change::Replace(item) => level(item, "replace", None, indent + 2, lines),
            Change::Add(item, beside) => level(item, "add", beside.as_ref(), indent + 2, lines),
            Change::Remove(removal) => {
                lines.before(&removal.comments.before, indent + 2);
                lines.indent(indent + 2);
                lines.out.push_str(&format!("remove {}", removal.level.value));
                lines.end(&removal.comments.behind);
            }
        }
    }
    lines.before(closing, indent + 2);
    lines.indent(indent);
    lines.out.push_str("}\n");
}

/// Prints a level after the keyword `word`.
fn level(it: &Level, word: &str, beside: Option<&Beside>, indent: usize, lines: &mut Lines) {
    let place = beside.map_or_else(String::new, |beside| {
        format!(" {} {}", if beside.before { "before" } else { "after" }, beside.level.value)
    });
    lines.before(&it.comments.before, indent);
    let allowed = it.settings.entries.iter().find_map(|entry| Some((entry, allowances::of(entry)?)));
    let head = || it.settings.entries.iter().filter(|entry| allowances::of(entry).is_none());
    // Comments on the settings of a level exist in YAML only; here they precede the level.
    for entry in head() {
        lines.before(&entry.comments.before, indent);
        lines.before(entry.comments.behind.as_slice(), indent);
    }
    lines.indent(indent);
    lines.out.push_str(&format!("{word} {}", it.name.value));
    if it.hard.is_some() {
        lines.out.push_str(" hard");
    }
    let mut last: Option<&Value> = None;
    for entry in head() {
        lines.out.push_str(if last.is_some_and(|v| expr::swallows(v, &entry.key.value, Some(&entry.value))) {
            ", "
        } else {
            " "
        });
        lines.out.push_str(&format!("{} {}", entry.key.value, expr::text(&entry.value)));
        last = Some(&entry.value);
    }
    lines.out.push(' ');
    members((allowed, &it.members), &it.settings.closing_comments, (&it.comments.behind, &place), indent, lines);
}

/// The entry with the warnings that a level allows, and its codes.
type Allowed<'t> = Option<(&'t Entry, &'t Block)>;

/// Prints members in braces, after the warnings that are allowed there, and the text after the closing brace. Other text
/// may follow the last member on its line.
fn members(
    (allowed, all): (Allowed, &[Member]),
    closing: &Comments,
    (behind, place): (&Option<String>, &str),
    indent: usize,
    lines: &mut Lines,
) {
    let mut line = OneLine::new(WIDTH.saturating_sub(lines.column() + place.len()));
    if one_line_members(allowed, all, closing, &mut line).is_some() {
        lines.out.push_str(&line.text);
        lines.out.push_str(place);
        lines.end(behind);
        return;
    }
    lines.out.push('{');
    lines.end(behind);
    if let Some((entry, allowed)) = allowed {
        allowances::lines(entry, allowed, indent + 2, lines);
    }
    for (i, member) in all.iter().enumerate() {
        let next = all.get(i + 1);
        lines.before(&member.comments.before, indent + 2);
        lines.indent(indent + 2);
        member_line(member, next, indent + 2, lines);
    }
    lines.before(&closing.before, indent + 2);
    lines.indent(indent);
    lines.out.push_str(&format!("}}{place}\n"));
}

fn one_line_members(allowed: Allowed, all: &[Member], closing: &Comments, line: &mut OneLine) -> Option<()> {
    if !no_comments(closing) {
        return None;
    }
    if all.is_empty() && allowed.is_none() {
        return line.push("{}");
    }
    line.push("{ ")?;
    if let Some((entry, codes)) = allowed {
        if !no_comments(&entry.comments) {
            return None;
        }
        allowances::one_line(codes, line)?;
        line.push(if all.is_empty() { "" } else { "  " })?;
    }
    for (i, member) in all.iter().enumerate() {
        if !no_comments(&member.comments) {
            return None;
        }
        if i > 0 {
            line.push(if needs_comma(&all[i - 1], member, true) { ", " } else { "  " })?;
        }
        match &member.task {
            MemberTask::Name(name) => line.push(name)?,
            MemberTask::Inline(it) => {
                line.push(&head(it, false))?;
                if !empty(&it.body) || !takes_arguments(it) {
                    line.push(" ")?;
                    one_line_block(&it.body, line)?;
                }
            }
            MemberTask::For(it) => {
                line.push(&reuse::repeat_head(&it.variable, &it.values))?;
                line.push(" ")?;
                one_line_members(None, &it.body, &it.closing_comments, line)?;
            }
        }
        if let Some(weight) = &member.weight {
            line.push(" weight ")?;
            line.push(&expr::text(weight))?;
        }
    }
    line.push(" }")
}

/// Returns true if a member would be parsed as a part of the one before it.
fn needs_comma(last: &Member, next: &Member, same_line: bool) -> bool {
    let name = |member: &Member| match &member.task {
        MemberTask::Name(name) => name.value.clone(),
        MemberTask::Inline(it) => it.kind.value.clone(),
        MemberTask::For(_) => "for".to_owned(),
    };
    let next = name(next);
    next == "weight"
        || (name(last) == "level" && last.weight.is_none())
        || (same_line && last.weight.as_ref().is_some_and(|w| expr::swallows(w, &next, None)))
}

fn member_line(member: &Member, next: Option<&Member>, indent: usize, lines: &mut Lines) {
    let start = lines.out.len();
    let quiet = Comments::default();
    let comma = next.is_some_and(|next| needs_comma(member, next, false));
    let suffix = match &member.weight {
        Some(weight) => format!(" weight {}", expr::text(weight)),
        None => String::new(),
    } + if comma { "," } else { "" };
    match &member.task {
        MemberTask::Name(name) => {
            lines.out.push_str(name);
            lines.out.push_str(&suffix);
            lines.end(&member.comments.behind);
        }
        MemberTask::Inline(it) => {
            definition(it, &quiet.behind, indent, true, lines);
            let tall = lines.out[start..].trim_end().contains('\n');
            lines.out.truncate(lines.out.len() - 1);
            if tall && let Some(text) = &member.comments.behind {
                let first = start + lines.out[start..].find('\n').unwrap_or(0);
                let mut note = Lines::new('/');
                note.out.push_str("  ");
                note.comment(text);
                lines.out.insert_str(first, &note.out);
                lines.out.push_str(&suffix);
                lines.out.push('\n');
            } else {
                lines.out.push_str(&suffix);
                lines.end(&member.comments.behind);
            }
        }
        MemberTask::For(it) => {
            lines.out.push_str(&reuse::repeat_head(&it.variable, &it.values));
            lines.out.push(' ');
            members((None, &it.body), &it.closing_comments, (&member.comments.behind, ""), indent, lines);
        }
    }
}
