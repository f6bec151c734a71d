//! The printer of YAML texts: declarations grouped by kind, short mappings and sequences on one line.

use super::{Lines, OneLine, WIDTH, expr, no_comments};
use crate::tree::{
    Block, Entry, Item, ItemKind, Level, Member, MemberTask, Spec, Stack, TaskDefinition, Value, ValueKind,
};
use crate::words::{is_glob, is_pattern, is_text_key};

/// Writes a tree.
pub(crate) fn print(spec: &Spec) -> String {
    let mut lines = Lines::new('#');
    lines.before(&spec.opening_comments.before, 0);
    if let Some(version) = &spec.version {
        lines.out.push_str(&format!("hierarq: {}", version.value));
        lines.end(&spec.opening_comments.behind);
    }
    section(spec, "params:\n", |kind| matches!(kind, ItemKind::Param(_)), &mut lines);
    section(spec, "robots:\n", |kind| matches!(kind, ItemKind::Robot(_)), &mut lines);
    section(spec, "tasks:\n", |kind| matches!(kind, ItemKind::Task(_)), &mut lines);
    section(spec, "stacks:\n", |kind| matches!(kind, ItemKind::Stack(_)), &mut lines);
    for item in &spec.items {
        if let ItemKind::Run(run) = &item.kind {
            blank(&mut lines);
            lines.before(&item.comments.before, 0);
            lines.out.push_str("run:");
            block(&run.body, &item.comments.behind, 0, &mut lines);
        }
    }
    if !spec.closing_comments.before.is_empty() {
        blank(&mut lines);
        lines.before(&spec.closing_comments.before, 0);
    }
    lines.out
}

fn blank(lines: &mut Lines) {
    if !lines.out.is_empty() {
        lines.out.push('\n');
    }
}

fn section(spec: &Spec, title: &str, of_kind: fn(&ItemKind) -> bool, lines: &mut Lines) {
    let mut first = true;
    for item in spec.items.iter().filter(|item| of_kind(&item.kind)) {
        if first {
            blank(lines);
            lines.out.push_str(title);
        }
        first = false;
        declaration(item, lines);
    }
}

fn declaration(item: &Item, lines: &mut Lines) {
    lines.before(&item.comments.before, 2);
    lines.indent(2);
    let behind = &item.comments.behind;
    match &item.kind {
        ItemKind::Param(param) => {
            lines.out.push_str(&format!("{}:", key(&param.name)));
            value(&param.value, behind, 2, false, lines);
        }
        ItemKind::Robot(robot) => {
            lines.out.push_str(&format!("{}:", key(&robot.name)));
            block(&robot.body, behind, 2, lines);
        }
        ItemKind::Task(task) => {
            lines.out.push_str(&format!("{}:", key(&task.name)));
            definition(&task.definition, behind, 2, lines);
        }
        ItemKind::Stack(it) => stack(it, behind, lines),
        ItemKind::Run(_) => {}
    }
}

/// A key: names need no quotes, except those that YAML reads as something else; patterns have them.
fn key(name: &str) -> String {
    let lower = name.to_ascii_lowercase();
    let other = matches!(lower.as_str(), "null" | "true" | "false" | "yes" | "no" | "on" | "off" | "y" | "n");
    if other || is_pattern(name) { format!("\"{name}\"") } else { name.to_owned() }
}

/// A value behind `key:` that ends its line.
fn value(it: &Value, behind: &Option<String>, indent: usize, text_key: bool, lines: &mut Lines) {
    if let ValueKind::Block(body) = &it.kind {
        return block(body, behind, indent, lines);
    }
    if let ValueKind::List(items) = &it.kind {
        let mut line = OneLine::new(WIDTH.saturating_sub(lines.column() + 1));
        if one_line(it, text_key, &mut line).is_none() {
            lines.end(behind);
            for item in items {
                lines.indent(indent + 2);
                lines.out.push('-');
                match &item.kind {
                    // A mapping or sequence inside a sequence stands on its own lines below the dash.
                    ValueKind::Block(_) | ValueKind::List(_) => value(item, &None, indent + 2, text_key, lines),
                    _ => {
                        lines.out.push_str(&format!(" {}", scalar(item, text_key, false)));
                        lines.end(&None);
                    }
                }
            }
            return;
        }
        lines.out.push_str(&format!(" {}", line.text));
        return lines.end(behind);
    }
    lines.out.push_str(&format!(" {}", scalar(it, text_key, false)));
    lines.end(behind);
}

/// A block behind `key:`.
fn block(body: &Block, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    let mut line = OneLine::new(WIDTH.saturating_sub(lines.column() + 1));
    if one_line_block(body, &mut line).is_some() {
        lines.out.push_str(&format!(" {}", line.text));
        return lines.end(behind);
    }
    if body.entries.is_empty() {
        // Only a flow mapping can be empty and hold comments.
        lines.out.push_str(" {");
        lines.end(behind);
        lines.before(&body.closing_comments.before, indent + 2);
        lines.indent(indent + 2);
        lines.out.push_str("}\n");
        return;
    }
    lines.end(behind);
    entries(body, indent + 2, lines);
    lines.before(&body.closing_comments.before, indent + 2);
}

fn entries(body: &Block, indent: usize, lines: &mut Lines) {
    for it in &body.entries {
        entry(it, indent, lines);
    }
}

fn entry(it: &Entry, indent: usize, lines: &mut Lines) {
    lines.before(&it.comments.before, indent);
    lines.indent(indent);
    lines.out.push_str(&format!("{}:", key(&it.key)));
    value(&it.value, &it.comments.behind, indent, is_text_key(&it.key), lines);
}

fn one_line(it: &Value, text_key: bool, line: &mut OneLine) -> Option<()> {
    match &it.kind {
        ValueKind::Block(body) => one_line_block(body, line),
        ValueKind::List(items) => {
            line.push("[")?;
            for (i, item) in items.iter().enumerate() {
                line.push(if i > 0 { ", " } else { "" })?;
                one_line(item, text_key, line)?;
            }
            line.push("]")
        }
        _ => line.push(&scalar(it, text_key, true)),
    }
}

fn one_line_block(body: &Block, line: &mut OneLine) -> Option<()> {
    if !no_comments(&body.closing_comments) {
        return None;
    }
    if body.entries.is_empty() {
        return line.push("{}");
    }
    line.push("{ ")?;
    for (i, it) in body.entries.iter().enumerate() {
        if !no_comments(&it.comments) {
            return None;
        }
        line.push(if i > 0 { ", " } else { "" })?;
        line.push(&key(&it.key))?;
        line.push(": ")?;
        one_line(&it.value, is_text_key(&it.key), line)?;
    }
    line.push(" }")
}

/// A value without structure as a YAML scalar.
fn scalar(it: &Value, text_key: bool, flow: bool) -> String {
    match &it.kind {
        ValueKind::Missing => "null".to_owned(),
        ValueKind::Text(text) if text_key => yaml_text(text),
        ValueKind::Text(text) if is_glob(text) => format!("\"{text}\""),
        ValueKind::Text(text) => format!("'{}'", expr::quoted(text).replace('\'', "''")),
        _ => plain_or_quoted(&expr::text(it), flow),
    }
}

/// The text itself, for keys whose value is text.
fn yaml_text(text: &str) -> String {
    let tame = |c: char| c.is_ascii_alphanumeric() || "_./- ".contains(c);
    let plain = text.chars().all(tame)
        && text.starts_with(|c: char| c.is_ascii_alphanumeric() || "_./".contains(c))
        && !text.ends_with(' ')
        && !text.starts_with("..")
        && !is_null(text);
    if plain { text.to_owned() } else { double_quoted(text) }
}

fn is_null(text: &str) -> bool {
    matches!(text, "null" | "Null" | "NULL" | "~" | "")
}

fn plain_or_quoted(text: &str, flow: bool) -> String {
    let first = text.chars().next().is_some_and(|c| c.is_ascii_alphanumeric() || "_-(".contains(c));
    let inside = !text.contains(": ")
        && !text.contains(" #")
        && !text.ends_with(':')
        && !text.contains(['"', '\\'])
        && !text.starts_with("- ")
        && !text.starts_with("---")
        && !(flow && text.contains([',', '[', ']', '{', '}']));
    if first && inside && !is_null(text) { text.to_owned() } else { double_quoted(text) }
}

fn double_quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            '\n' => out.push_str("\\n"),
            '\t' => out.push_str("\\t"),
            '\r' => out.push_str("\\r"),
            c if expr::unprintable(c) => out.push_str(&format!("\\u{:04x}", c as u32)),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

/// `kind` or `kind(args)` as a YAML scalar.
fn head(it: &TaskDefinition, flow: bool) -> String {
    if it.args.is_empty() {
        return key(&it.kind);
    }
    let args: Vec<String> = it.args.iter().map(expr::text).collect();
    plain_or_quoted(&format!("{}({})", it.kind.value, args.join(", ")), flow)
}

/// A definition as a key: quoted where it has arguments.
fn head_key(it: &TaskDefinition) -> String {
    let text = head(it, true);
    if it.args.is_empty() || text.starts_with('"') { text } else { double_quoted(&text) }
}

fn definition(it: &TaskDefinition, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    if super::hq::empty(&it.body) {
        lines.out.push_str(&format!(" {}", head(it, false)));
        return lines.end(behind);
    }
    let mut line = OneLine::new(WIDTH.saturating_sub(lines.column() + 1));
    if one_line_definition(it, &mut line).is_some() {
        lines.out.push_str(&format!(" {}", line.text));
        return lines.end(behind);
    }
    lines.end(behind);
    lines.indent(indent + 2);
    lines.out.push_str(&format!("{}:", head_key(it)));
    block(&it.body, &None, indent + 2, lines);
}

/// `{ kind: { .. } }`
fn one_line_definition(it: &TaskDefinition, line: &mut OneLine) -> Option<()> {
    line.push("{ ")?;
    line.push(&head_key(it))?;
    line.push(": ")?;
    one_line_block(&it.body, line)?;
    line.push(" }")
}

fn stack(it: &Stack, behind: &Option<String>, lines: &mut Lines) {
    lines.out.push_str(&format!("{}:", key(&it.name)));
    lines.end(behind);
    entries(&it.settings, 4, lines);
    if it.levels.is_empty() {
        lines.out.push_str("    levels: []\n");
    } else {
        lines.out.push_str("    levels:\n");
    }
    for item in &it.levels {
        level(item, lines);
    }
    lines.before(&it.settings.closing_comments.before, 4);
}

fn level(it: &Level, lines: &mut Lines) {
    lines.before(&it.comments.before, 6);
    lines.out.push_str(&format!("      - name: {}", key(&it.name)));
    lines.end(&it.comments.behind);
    if it.hard.is_some() {
        lines.out.push_str("        hard: true\n");
    }
    entries(&it.settings, 8, lines);
    lines.out.push_str("        tasks:");
    let mut line = OneLine::new(WIDTH.saturating_sub(lines.column() + 1));
    if one_line_members(it, &mut line).is_some() {
        lines.out.push_str(&format!(" {}\n", line.text));
    } else {
        lines.out.push('\n');
        for member in &it.members {
            member_lines(member, lines);
        }
    }
    lines.before(&it.settings.closing_comments.before, 8);
}

fn one_line_members(it: &Level, line: &mut OneLine) -> Option<()> {
    line.push("[")?;
    for (i, member) in it.members.iter().enumerate() {
        if !no_comments(&member.comments) {
            return None;
        }
        line.push(if i > 0 { ", " } else { "" })?;
        one_line_member(member, line)?;
    }
    line.push("]")
}

fn one_line_member(member: &Member, line: &mut OneLine) -> Option<()> {
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

/// True where a member is written `{ task: .., weight: .. }`.
fn needs_wrapper(member: &Member) -> bool {
    let confusing = match &member.task {
        MemberTask::Inline(it) => matches!(it.kind.value.as_str(), "task" | "weight"),
        MemberTask::Name(_) => false,
    };
    member.weight.is_some() || confusing
}

fn one_line_task(task: &MemberTask, line: &mut OneLine) -> Option<()> {
    match task {
        MemberTask::Name(name) => line.push(&key(name)),
        MemberTask::Inline(it) if !it.args.is_empty() && super::hq::empty(&it.body) => line.push(&head(it, true)),
        MemberTask::Inline(it) => one_line_definition(it, line),
    }
}

fn member_lines(member: &Member, lines: &mut Lines) {
    lines.before(&member.comments.before, 10);
    lines.out.push_str("          -");
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
            MemberTask::Inline(it) => inline_task(it, behind, 12, lines),
        }
        if let Some(weight) = &member.weight {
            lines.out.push_str("            weight:");
            value(weight, &None, 12, false, lines);
        }
        return;
    }
    if let MemberTask::Inline(it) = &member.task {
        lines.out.push_str(&format!(" {}:", head_key(it)));
        block(&it.body, behind, 12, lines);
    }
}

fn inline_task(it: &TaskDefinition, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    if !it.args.is_empty() && super::hq::empty(&it.body) {
        lines.out.push_str(&format!(" {}", head(it, false)));
        return lines.end(behind);
    }
    lines.end(behind);
    lines.indent(indent + 2);
    lines.out.push_str(&format!("{}:", head_key(it)));
    block(&it.body, &None, indent + 2, lines);
}
