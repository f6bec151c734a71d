//! Printer of YAML texts: declarations grouped by kind, short mappings and sequences on one line.

use super::hq::takes_arguments;
use super::yaml_allowances as allowances;
use super::yaml_levels as levels;
use super::yaml_machines as machines;
use super::yaml_missions as missions;
use super::yaml_reuse as reuse;
use super::{Lines, OneLine, WIDTH, expr, no_comments};
use crate::tree::{Block, BlockKind, Entry, Item, ItemKind, Spec, TaskDefinition, Value, ValueKind};
use crate::words::{is_glob, is_quoted_key, is_text_key};

/// Prints a tree.
pub(crate) fn print(spec: &Spec) -> String {
    let mut lines = Lines::new('#');
    lines.before(&spec.opening_comments.before, 0);
    if let Some(version) = &spec.version {
        lines.out.push_str(&format!("hierarq: {}", version.value));
        lines.end(&spec.opening_comments.behind);
    }
    sections(&spec.items, 0, &mut lines);
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

/// Returns true if a declaration belongs to a section.
type OfKind = fn(&ItemKind) -> bool;

/// Prints the declarations of one kind below their title.
fn group(title: &str, of_kind: impl Fn(&ItemKind) -> bool, items: &[Item], indent: usize, lines: &mut Lines) {
    for (i, item) in items.iter().filter(|item| of_kind(&item.kind)).enumerate() {
        if i == 0 {
            if indent == 0 {
                blank(lines);
            }
            lines.indent(indent);
            lines.out.push_str(&format!("{title}:\n"));
        }
        declaration(item, indent + 2, lines);
    }
}

/// Prints declarations grouped by kind, each group below its title, with empty lines between top-level groups.
pub(super) fn sections(items: &[Item], indent: usize, lines: &mut Lines) {
    let before: [(&str, OfKind); 9] = [
        ("import", |kind| matches!(kind, ItemKind::Import(_))),
        ("allow", |kind| matches!(kind, ItemKind::Allow(_))),
        ("params", |kind| matches!(kind, ItemKind::Param(_))),
        ("lets", |kind| matches!(kind, ItemKind::Let(_))),
        ("robots", |kind| matches!(kind, ItemKind::Robot(_))),
        ("tasks", |kind| matches!(kind, ItemKind::Task(_))),
        ("stacks", |kind| matches!(kind, ItemKind::Stack(_))),
        ("signals", |kind| matches!(kind, ItemKind::Signal(_))),
        ("variables", |kind| matches!(kind, ItemKind::Variable(_))),
    ];
    let after: [(&str, OfKind); 4] = [
        ("machines", |kind| matches!(kind, ItemKind::Machine(_))),
        ("missions", |kind| matches!(kind, ItemKind::Mission(_))),
        ("scenarios", |kind| matches!(kind, ItemKind::Scenario(_))),
        ("for", |kind| matches!(kind, ItemKind::For(_))),
    ];
    for (title, of_kind) in before {
        group(title, of_kind, items, indent, lines);
    }
    for block in BlockKind::ALL {
        let of_kind = |kind: &ItemKind| matches!(kind, ItemKind::Block(it) if it.kind == block);
        group(block.section(), of_kind, items, indent, lines);
    }
    for (title, of_kind) in after {
        group(title, of_kind, items, indent, lines);
    }
    coverage(items, indent, lines);
    for item in items {
        if let ItemKind::Run(run) = &item.kind {
            blank(lines);
            lines.before(&item.comments.before, indent);
            lines.out.push_str("run:");
            block(&run.body, &item.comments.behind, indent, lines);
        }
    }
}

/// Prints the demands on limits: a mapping, or a sequence of several.
fn coverage(items: &[Item], indent: usize, lines: &mut Lines) {
    let all = items.iter().filter_map(|item| match &item.kind {
        ItemKind::Coverage(it) => Some((it, &item.comments)),
        _ => None,
    });
    let all: Vec<_> = all.collect();
    if indent == 0 && !all.is_empty() {
        blank(lines);
    }
    if let [(one, comments)] = all.as_slice() {
        lines.before(&comments.before, indent);
        lines.indent(indent);
        lines.out.push_str("coverage:");
        return block(&one.body, &comments.behind, indent, lines);
    }
    if !all.is_empty() {
        lines.indent(indent);
        lines.out.push_str("coverage:\n");
    }
    for (it, comments) in all {
        lines.before(&comments.before, indent + 2);
        // Behind the dash of a mapping on several lines there is no place for a comment.
        lines.before(comments.behind.as_slice(), indent + 2);
        // Nor is there one between the dash and the first key.
        let mut body = it.body.clone();
        if let Some(first) = body.entries.first_mut() {
            lines.before(&std::mem::take(&mut first.comments.before), indent + 2);
        }
        lines.indent(indent + 2);
        lines.out.push('-');
        listed(&body, indent + 2, lines);
    }
}

fn declaration(item: &Item, indent: usize, lines: &mut Lines) {
    lines.before(&item.comments.before, indent);
    lines.indent(indent);
    let behind = &item.comments.behind;
    match &item.kind {
        ItemKind::Import(it) => reuse::import(it, behind, indent, lines),
        ItemKind::Allow(it) => {
            lines.out.push_str(&format!("{}: {}", key(&it.code), allowances::reason(&it.reason)));
            lines.end(behind);
        }
        ItemKind::Param(param) => {
            lines.out.push_str(&format!("{}:", key(&param.name)));
            if super::hq::empty(&param.range) {
                value(&param.value, behind, indent, false, lines);
            } else {
                reuse::ranged(param, behind, indent, lines);
            }
        }
        ItemKind::Let(it) => {
            lines.out.push_str(&format!("{}:", key(&it.name)));
            value(&it.value, behind, indent, false, lines);
        }
        ItemKind::Robot(robot) => {
            lines.out.push_str(&format!("{}:", key(&robot.name)));
            match &robot.base {
                None => block(&robot.body, behind, indent, lines),
                Some(base) => block(&reuse::with_base(&robot.body, base), behind, indent, lines),
            }
        }
        ItemKind::Task(task) => {
            lines.out.push_str(&format!("{}:", reuse::head_key(&task.name, &task.parameters)));
            definition(&task.definition, behind, indent, lines);
        }
        ItemKind::Stack(it) => levels::stack(it, behind, indent, lines),
        ItemKind::Signal(it) => machines::signal(it, behind, indent, lines),
        ItemKind::Block(it) => {
            lines.out.push_str(&format!("{}:", key(&it.name)));
            block(&it.body, behind, indent, lines);
        }
        ItemKind::Variable(it) => machines::variable(it, behind, indent, lines),
        ItemKind::Machine(it) => machines::machine(it, behind, indent, lines),
        ItemKind::Mission(it) => missions::mission(it, behind, indent, lines),
        ItemKind::Scenario(it) => machines::scenario(it, behind, indent, lines),
        ItemKind::For(it) => reuse::repeat(it, behind, indent, lines),
        ItemKind::Coverage(_) | ItemKind::Run(_) => {}
    }
}

/// Formats a key. Names need no quotes, except those that YAML interprets otherwise; patterns are quoted.
pub(super) fn key(name: &str) -> String {
    let lower = name.to_ascii_lowercase();
    let other = matches!(lower.as_str(), "null" | "true" | "false" | "yes" | "no" | "on" | "off" | "y" | "n");
    if other || is_quoted_key(name) || name.contains('$') { format!("\"{name}\"") } else { name.to_owned() }
}

/// Prints a value that follows `key:` and ends its line.
pub(super) fn value(it: &Value, behind: &Option<String>, indent: usize, text_key: bool, lines: &mut Lines) {
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
                    // A mapping or sequence inside a sequence is on its own lines below the dash.
                    ValueKind::Block(body) => listed(body, indent + 2, lines),
                    ValueKind::List(_) => value(item, &None, indent + 2, text_key, lines),
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

/// Prints a block after a dash. The comment after it is printed at its end if it takes several lines.
fn listed(body: &Block, indent: usize, lines: &mut Lines) {
    let mut body = body.clone();
    let behind = body.closing_comments.behind.take();
    let mut line = OneLine::new(WIDTH.saturating_sub(lines.column() + 1));
    if one_line_block(&body, &mut line).is_some() {
        return block(&body, &behind, indent, lines);
    }
    body.closing_comments.before.extend(behind);
    block(&body, &None, indent, lines);
}

/// Prints a block after `key:`.
pub(super) fn block(body: &Block, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    let mut line = OneLine::new(WIDTH.saturating_sub(lines.column() + 1));
    if one_line_block(body, &mut line).is_some() {
        lines.out.push_str(&format!(" {}", line.text));
        return lines.end(behind);
    }
    if body.entries.is_empty() {
        // Only a flow mapping can be empty and contain comments.
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

pub(super) fn entries(body: &Block, indent: usize, lines: &mut Lines) {
    for it in &body.entries {
        entry(it, indent, lines);
    }
}

fn entry(it: &Entry, indent: usize, lines: &mut Lines) {
    lines.before(&it.comments.before, indent);
    lines.indent(indent);
    lines.out.push_str(&format!("{}:", key(&it.key)));
    if let Some(allowed) = allowances::of(it) {
        return allowances::block(allowed, &it.comments.behind, indent, lines);
    }
    value(&it.value, &it.comments.behind, indent, is_text_key(&it.key), lines);
}

pub(super) fn one_line(it: &Value, text_key: bool, line: &mut OneLine) -> Option<()> {
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

pub(super) fn one_line_block(body: &Block, line: &mut OneLine) -> Option<()> {
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
        match allowances::of(it) {
            Some(allowed) => allowances::one_line(allowed, line)?,
            None => one_line(&it.value, is_text_key(&it.key), line)?,
        }
    }
    line.push(" }")
}

/// Formats a value without structure as a YAML scalar.
fn scalar(it: &Value, text_key: bool, flow: bool) -> String {
    match &it.kind {
        ValueKind::Missing => "null".to_owned(),
        ValueKind::Text(text) if text_key => yaml_text(text),
        ValueKind::Text(text) if is_glob(text) => format!("\"{text}\""),
        ValueKind::Text(text) => format!("'{}'", expr::quoted(text).replace('\'', "''")),
        _ => plain_or_quoted(&expr::text(it), flow),
    }
}

/// Formats a text itself, for keys whose value is text.
pub(super) fn yaml_text(text: &str) -> String {
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

pub(super) fn plain_or_quoted(text: &str, flow: bool) -> String {
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

pub(super) fn double_quoted(text: &str) -> String {
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

/// Formats `kind` or `kind(args)` as a YAML scalar.
pub(super) fn head(it: &TaskDefinition, flow: bool) -> String {
    if !takes_arguments(it) {
        return key(&it.kind);
    }
    plain_or_quoted(&super::hq::head(it, false), flow)
}

/// Formats a definition as a key, quoted if it has arguments.
pub(super) fn head_key(it: &TaskDefinition) -> String {
    let text = head(it, true);
    if !takes_arguments(it) || text.starts_with('"') { text } else { double_quoted(&text) }
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

/// Formats `{ kind: { .. } }`.
pub(super) fn one_line_definition(it: &TaskDefinition, line: &mut OneLine) -> Option<()> {
    line.push("{ ")?;
    line.push(&head_key(it))?;
    line.push(": ")?;
    one_line_block(&it.body, line)?;
    line.push(" }")
}
