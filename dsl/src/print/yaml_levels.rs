//! Printer of YAML texts: stacks, levels, members.

use super::hq::{empty, takes_arguments};
use super::yaml::{block, entries, head, head_key, key, one_line, one_line_definition, value};
use super::yaml_reuse as reuse;
use super::{Lines, OneLine, WIDTH, no_comments};
use crate::tree::{Beside, Change, Level, Member, MemberTask, Stack, TaskDefinition};

pub(super) fn stack(it: &Stack, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    lines.out.push_str(&format!("{}:", reuse::head_key(&it.name, &it.parameters)));
    let inner = indent + 2;
    lines.end(behind);
    if let Some(base) = &it.base {
        lines.indent(inner);
        lines.out.push_str(&format!("from: {}\n", reuse::call(base)));
    }
    entries(&it.settings, inner, lines);
    let title = if it.base.is_some() { "changes" } else { "levels" };
    let empty = it.levels.is_empty() && it.changes.is_empty();
    if !empty || it.base.is_none() {
        lines.indent(inner);
        lines.out.push_str(&format!("{title}:{}\n", if empty { " []" } else { "" }));
    }
    for item in &it.levels {
        level(item, ("name", None), inner + 2, lines);
    }
    for change in &it.changes {
        match change {
            Change::Replace(item) => level(item, ("replace", None), inner + 2, lines),
            Change::Add(item, beside) => level(item, ("add", beside.as_ref()), inner + 2, lines),
            Change::Remove(removal) => {
                lines.before(&removal.comments.before, inner + 2);
                lines.indent(inner + 2);
                lines.out.push_str(&format!("- remove: {}", key(&removal.level)));
                lines.end(&removal.comments.behind);
            }
        }
    }
    lines.before(&it.settings.closing_comments.before, inner);
}

/// Prints a level; `word` is the key of its name.
fn level(it: &Level, (word, beside): (&str, Option<&Beside>), indent: usize, lines: &mut Lines) {
    let inner = indent + 2;
    lines.before(&it.comments.before, indent);
    lines.indent(indent);
    lines.out.push_str(&format!("- {word}: {}", key(&it.name)));
    lines.end(&it.comments.behind);
    if let Some(beside) = beside {
        lines.indent(inner);
        let place = if beside.before { "before" } else { "after" };
        lines.out.push_str(&format!("{place}: {}\n", key(&beside.level)));
    }
    if it.hard.is_some() {
        lines.indent(inner);
        lines.out.push_str("hard: true\n");
    }
    entries(&it.settings, inner, lines);
    members(&it.members, &None, inner, lines);
    lines.before(&it.settings.closing_comments.before, inner);
}

/// Prints `tasks: [..]`, with one member per line if it is long.
pub(super) fn members(all: &[Member], behind: &Option<String>, indent: usize, lines: &mut Lines) {
    lines.indent(indent);
    lines.out.push_str("tasks:");
    let mut line = OneLine::new(WIDTH.saturating_sub(lines.column() + 1));
    if one_line_members(all, &mut line).is_some() {
        lines.out.push_str(&format!(" {}", line.text));
        return lines.end(behind);
    }
    lines.end(behind);
    for member in all {
        member_lines(member, indent + 2, lines);
    }
}

pub(super) fn one_line_members(all: &[Member], line: &mut OneLine) -> Option<()> {
    line.push("[")?;
    for (i, member) in all.iter().enumerate() {
        if !no_comments(&member.comments) {
            return None;
        }
        line.push(if i > 0 { ", " } else { "" })?;
        one_line_member(member, line)?;
    }
    line.push("]")
}

fn one_line_member(member: &Member, line: &mut OneLine) -> Option<()> {
    if let MemberTask::For(it) = &member.task {
        return reuse::one_line_repeat(it, line);
    }
    if needs_wrapper(member) {
        line.push("{ task: ")?;
        one_line_task(&member.task, line)?;
        if let Some(weight) = &member.weight {
            line.push(", weight: ")?;
            one_line(weight, false, line)?;
        }
        return line.push(" }");
    }
    one_line_task(&member.task, line)
}

/// Returns true if a member is written as `{ task: .., weight: .. }`.
fn needs_wrapper(member: &Member) -> bool {
    let confusing = match &member.task {
        MemberTask::Inline(it) => matches!(it.kind.value.as_str(), "task" | "weight"),
        MemberTask::Name(_) | MemberTask::For(_) => false,
    };
    member.weight.is_some() || confusing
}

fn one_line_task(task: &MemberTask, line: &mut OneLine) -> Option<()> {
    match task {
        MemberTask::Name(name) => line.push(&key(name)),
        MemberTask::Inline(it) if takes_arguments(it) && empty(&it.body) => line.push(&head(it, true)),
        MemberTask::Inline(it) => one_line_definition(it, line),
        MemberTask::For(it) => reuse::one_line_repeat(it, line),
    }
}

fn member_lines(member: &Member, indent: usize, lines: &mut Lines) {
    lines.before(&member.comments.before, indent);
    lines.indent(indent);
    lines.out.push('-');
    let behind = &member.comments.behind;
    let mut line = OneLine::new(WIDTH.saturating_sub(lines.column() + 1));
    if one_line_member(member, &mut line).is_some() {
        lines.out.push_str(&format!(" {}", line.text));
        return lines.end(behind);
    }
    if needs_wrapper(member) {
        lines.out.push_str(" task:");
        match &member.task {
            MemberTask::Name(name) => {
                lines.out.push_str(&format!(" {}", key(name)));
                lines.end(behind);
            }
            MemberTask::Inline(it) => inline_task(it, behind, indent + 2, lines),
            MemberTask::For(_) => {}
        }
        if let Some(weight) = &member.weight {
            lines.indent(indent + 2);
            lines.out.push_str("weight:");
            value(weight, &None, indent + 2, false, lines);
        }
        return;
    }
    match &member.task {
        MemberTask::Inline(it) => {
            lines.out.push_str(&format!(" {}:", head_key(it)));
            block(&it.body, behind, indent + 2, lines);
        }
        MemberTask::For(it) => reuse::member_repeat(it, behind, indent + 2, lines),
        MemberTask::Name(_) => {}
    }
}

fn inline_task(it: &TaskDefinition, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    if takes_arguments(it) && empty(&it.body) {
        lines.out.push_str(&format!(" {}", head(it, false)));
        return lines.end(behind);
    }
    lines.end(behind);
    lines.indent(indent + 2);
    lines.out.push_str(&format!("{}:", head_key(it)));
    block(&it.body, &None, indent + 2, lines);
}
