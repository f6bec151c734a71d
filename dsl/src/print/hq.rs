//! Printer of `*.hq` texts.

use super::hq_allowances as allowances;
use super::hq_levels as levels;
use super::hq_machines as machines;
use super::hq_missions as missions;
use super::hq_reuse as reuse;
use super::{Lines, OneLine, WIDTH, expr, has_block, no_comments};
use crate::tree::{Block, Entry, Item, ItemKind, Spec, TaskDefinition, Value, ValueKind};
use crate::words::is_quoted_key;

/// Prints a tree.
pub(crate) fn print(spec: &Spec) -> String {
    let mut lines = Lines::new('/');
    lines.before(&spec.opening_comments.before, 0);
    if let Some(version) = &spec.version {
        lines.out.push_str(&format!("hierarq {}", version.value));
        lines.end(&spec.opening_comments.behind);
    }
    items(&spec.items, 0, &mut lines);
    if !spec.closing_comments.before.is_empty() {
        if !lines.out.is_empty() {
            lines.out.push('\n');
        }
        lines.before(&spec.closing_comments.before, 0);
    }
    lines.out
}

/// Prints declarations one below the other: short ones of a kind together, the others separated by empty lines.
pub(super) fn items(items: &[Item], indent: usize, lines: &mut Lines) {
    let group = |kind: &ItemKind| match kind {
        ItemKind::Param(_) => Some(0),
        ItemKind::Let(_) => Some(1),
        ItemKind::Import(_) => Some(2),
        ItemKind::Signal(_) => Some(3),
        ItemKind::Variable(_) => Some(4),
        ItemKind::Allow(_) => Some(5),
        _ => None,
    };
    let mut last = None;
    for (i, item) in items.iter().enumerate() {
        let own = group(&item.kind);
        let grouped = own.is_some() && own == last;
        // The first declaration of a block follows its brace.
        let first = if indent == 0 { lines.out.is_empty() } else { i == 0 };
        if !grouped && !first {
            lines.out.push('\n');
        }
        last = own;
        lines.before(&item.comments.before, indent);
        lines.indent(indent);
        let behind = &item.comments.behind;
        match &item.kind {
            ItemKind::Import(it) => reuse::import(it, behind, indent, lines),
            ItemKind::Allow(it) => {
                lines.out.push_str(&allowances::line(&it.code, &it.reason));
                lines.end(behind);
            }
            ItemKind::Param(param) => {
                lines.out.push_str(&format!("param {} = ", param.name.value));
                if empty(&param.range) {
                    value(&param.value, behind, indent, lines);
                } else {
                    value(&param.value, &None, indent, lines);
                    lines.out.truncate(lines.out.len() - 1);
                    lines.out.push(' ');
                    block(&param.range, behind, indent, false, lines);
                }
            }
            ItemKind::Let(it) => {
                lines.out.push_str(&format!("let {} = ", it.name.value));
                value(&it.value, behind, indent, lines);
            }
            ItemKind::Robot(robot) => {
                lines.out.push_str(&format!("robot {} ", robot.name.value));
                if let Some(base) = &robot.base {
                    lines.out.push_str(&format!("from {} ", base.value));
                }
                block(&robot.body, behind, indent, robot.body.entries.len() > 2, lines);
            }
            ItemKind::Task(task) => {
                let parameters = reuse::parameters(&task.parameters);
                lines.out.push_str(&format!("task {}{parameters} = ", task.name.value));
                definition(&task.definition, behind, indent, false, lines);
            }
            ItemKind::Stack(it) => levels::stack(it, behind, indent, lines),
            ItemKind::Signal(it) => machines::signal(it, behind, indent, lines),
            ItemKind::Block(it) => {
                lines.out.push_str(&format!("{} {} ", it.kind.keyword(), it.name.value));
                block(&it.body, behind, indent, it.body.entries.len() > 2, lines);
            }
            ItemKind::Variable(it) => {
                let mark = if it.optional.is_some() { "?" } else { "" };
                lines.out.push_str(&format!("variable {} : {}{mark}", it.name.value, it.ty.value));
                match &it.value {
                    Some(held) => {
                        lines.out.push_str(" = ");
                        value(held, behind, indent, lines);
                    }
                    None => lines.end(behind),
                }
            }
            ItemKind::Machine(it) => machines::machine(it, behind, indent, lines),
            ItemKind::Mission(it) => missions::mission(it, behind, indent, lines),
            ItemKind::Scenario(it) => machines::scenario(it, behind, indent, lines),
            ItemKind::For(it) => {
                lines.out.push_str(&reuse::repeat_head(&it.variable, &it.values));
                lines.out.push_str(" {");
                lines.end(behind);
                self::items(&it.body, indent + 2, lines);
                lines.before(&it.closing_comments.before, indent + 2);
                lines.indent(indent);
                lines.out.push_str("}\n");
            }
            ItemKind::Coverage(it) => {
                lines.out.push_str("coverage ");
                block(&it.body, behind, indent, it.body.entries.len() > 2, lines);
            }
            ItemKind::Run(run) => {
                lines.out.push_str("run ");
                block(&run.body, behind, indent, false, lines);
            }
        }
    }
}

/// Prints a value that ends its line.
fn value(value: &Value, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    match &value.kind {
        ValueKind::Block(body) => tagged_or_block(body, behind, indent, lines),
        ValueKind::List(_) => {
            list(value, "", indent, lines);
            lines.end(behind);
        }
        ValueKind::Unit(of, unit) if matches!(of.kind, ValueKind::List(_)) => {
            list(of, &format!(" {unit}"), indent, lines);
            lines.end(behind);
        }
        _ => {
            lines.out.push_str(&expr::text(value));
            lines.end(behind);
        }
    }
}

/// Prints a list, on one line if it fits.
fn list(value: &Value, suffix: &str, indent: usize, lines: &mut Lines) {
    let ValueKind::List(items) = &value.kind else { return };
    let mut line = OneLine::new(WIDTH.saturating_sub(lines.column() + suffix.len()));
    if items.is_empty() || one_line_value(value, &mut line).is_some() {
        lines.out.push_str(if items.is_empty() { "[]" } else { &line.text });
        lines.out.push_str(suffix);
        return;
    }
    lines.out.push_str("[\n");
    for item in items {
        lines.indent(indent + 2);
        match &item.kind {
            ValueKind::List(_) => list(item, "", indent + 2, lines),
            ValueKind::Block(body) => {
                let mut body = body.clone();
                let behind = body.closing_comments.behind.take();
                tagged_or_block(&body, &None, indent + 2, lines);
                lines.out.truncate(lines.out.trim_end().len());
                lines.out.push(',');
                lines.end(&behind);
                continue;
            }
            _ => lines.out.push_str(&expr::text(item)),
        }
        lines.out.push_str(",\n");
    }
    lines.indent(indent);
    lines.out.push(']');
    lines.out.push_str(suffix);
}

/// Returns the single entry of a block that is written `tag { .. }`.
fn tag(body: &Block) -> Option<(&Entry, &Block)> {
    match body.entries.as_slice() {
        [entry] if body.tagged && no_comments(&entry.comments) && no_comments(&body.closing_comments) => {
            match &entry.value.kind {
                ValueKind::Block(_) if is_quoted_key(&entry.key.value) => None,
                ValueKind::Block(inner) if !inner.tagged || tag(inner).is_none() => Some((entry, inner)),
                _ => None,
            }
        }
        _ => None,
    }
}

/// Formats a key: a name as it is, anything else in quotes.
fn key(text: &str) -> String {
    if is_quoted_key(text) { format!("\"{text}\"") } else { text.to_owned() }
}

fn tagged_or_block(body: &Block, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    match tag(body) {
        Some((entry, inner)) => {
            lines.out.push_str(&entry.key.value);
            lines.out.push(' ');
            block(inner, behind, indent, false, lines);
        }
        None => block(body, behind, indent, false, lines),
    }
}

/// Prints a block that ends its line.
pub(super) fn block(body: &Block, behind: &Option<String>, indent: usize, tall: bool, lines: &mut Lines) {
    let mut line = OneLine::new(WIDTH.saturating_sub(lines.column()));
    if !tall && one_line_block(body, &mut line).is_some() {
        lines.out.push_str(&line.text);
        lines.end(behind);
        return;
    }
    lines.out.push('{');
    lines.end(behind);
    entries(body, indent + 2, lines);
    lines.before(&body.closing_comments.before, indent + 2);
    lines.indent(indent);
    lines.out.push_str("}\n");
}

pub(super) fn entries(body: &Block, indent: usize, lines: &mut Lines) {
    for entry in &body.entries {
        if let Some(allowed) = allowances::of(entry) {
            allowances::lines(entry, allowed, indent, lines);
            continue;
        }
        lines.before(&entry.comments.before, indent);
        lines.indent(indent);
        lines.out.push_str(&key(&entry.key.value));
        if matches!(entry.value.kind, ValueKind::Missing) {
            lines.out.push(',');
        } else {
            lines.out.push(' ');
        }
        value(&entry.value, &entry.comments.behind, indent, lines);
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
    for (i, entry) in body.entries.iter().enumerate() {
        if !no_comments(&entry.comments) {
            return None;
        }
        if i > 0 {
            let last = &body.entries[i - 1].value;
            line.push(separator(last, entry))?;
        }
        if let Some(allowed) = allowances::of(entry) {
            allowances::one_line(allowed, line)?;
            continue;
        }
        line.push(&key(&entry.key.value))?;
        if !matches!(entry.value.kind, ValueKind::Missing) {
            line.push(" ")?;
        }
        one_line_value(&entry.value, line)?;
    }
    if body.entries.last().is_some_and(|e| matches!(e.value.kind, ValueKind::Missing)) {
        line.push(",")?;
    }
    line.push(" }")
}

/// Returns the separator between a value and the next entry on the same line.
fn separator(last: &Value, next: &Entry) -> &'static str {
    let swallowed = expr::swallows(last, &next.key.value, Some(&next.value));
    if matches!(last.kind, ValueKind::Missing) || swallowed { ", " } else { "  " }
}

fn one_line_value(value: &Value, line: &mut OneLine) -> Option<()> {
    match &value.kind {
        ValueKind::Block(body) => match tag(body) {
            Some((entry, inner)) => {
                line.push(&entry.key.value)?;
                line.push(" ")?;
                one_line_block(inner, line)
            }
            None => one_line_block(body, line),
        },
        ValueKind::List(items) if has_block(value) => {
            line.push("[")?;
            for (i, item) in items.iter().enumerate() {
                line.push(if i > 0 { ", " } else { "" })?;
                one_line_value(item, line)?;
            }
            line.push("]")
        }
        ValueKind::Unit(of, unit) if has_block(value) => {
            one_line_value(of, line)?;
            line.push(" ")?;
            line.push(&unit.to_string())
        }
        _ => line.push(&expr::text(value)),
    }
}

/// Returns true if a definition has arguments in parentheses.
pub(super) fn takes_arguments(definition: &TaskDefinition) -> bool {
    !definition.args.is_empty() || !definition.named.is_empty()
}

pub(super) fn head(definition: &TaskDefinition, parentheses: bool) -> String {
    let mut text = definition.kind.value.clone();
    if takes_arguments(definition) || parentheses {
        text.push_str(&reuse::arguments(&definition.args, &definition.named));
    }
    text
}

/// Returns true if a block is empty.
pub(super) fn empty(body: &Block) -> bool {
    body.entries.is_empty() && no_comments(&body.closing_comments)
}

/// Prints `kind(args) { .. }` at the end of a line. A member without arguments keeps its braces, which distinguish it
/// from a name.
pub(super) fn definition(it: &TaskDefinition, behind: &Option<String>, indent: usize, member: bool, lines: &mut Lines) {
    lines.out.push_str(&head(it, false));
    if !empty(&it.body) || (member && !takes_arguments(it)) {
        lines.out.push(' ');
        block(&it.body, behind, indent, false, lines);
    } else {
        lines.end(behind);
    }
}
