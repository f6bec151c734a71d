//! The printer of `*.hq` texts.

use super::{Lines, OneLine, WIDTH, expr, has_block, no_comments};
use crate::tree::{
    Block, Comments, Entry, ItemKind, Level, Member, MemberTask, Spec, Stack, TaskDefinition, Value, ValueKind,
};
use crate::words::is_pattern;

/// Writes a tree.
pub(crate) fn print(spec: &Spec) -> String {
    let mut lines = Lines::new('/');
    lines.before(&spec.opening_comments.before, 0);
    if let Some(version) = &spec.version {
        lines.out.push_str(&format!("hierarq {}", version.value));
        lines.end(&spec.opening_comments.behind);
    }
    let mut last_was_param = false;
    for item in &spec.items {
        let is_param = matches!(item.kind, ItemKind::Param(_));
        let grouped = is_param && last_was_param;
        if !grouped && !lines.out.is_empty() {
            lines.out.push('\n');
        }
        last_was_param = is_param;
        lines.before(&item.comments.before, 0);
        let behind = &item.comments.behind;
        match &item.kind {
            ItemKind::Param(param) => {
                lines.out.push_str(&format!("param {} = ", param.name.value));
                value(&param.value, behind, 0, &mut lines);
            }
            ItemKind::Robot(robot) => {
                lines.out.push_str(&format!("robot {} ", robot.name.value));
                block(&robot.body, behind, 0, robot.body.entries.len() > 2, &mut lines);
            }
            ItemKind::Task(task) => {
                lines.out.push_str(&format!("task {} = ", task.name.value));
                definition(&task.definition, behind, 0, false, &mut lines);
            }
            ItemKind::Stack(it) => stack(it, behind, &mut lines),
            ItemKind::Run(run) => {
                lines.out.push_str("run ");
                block(&run.body, behind, 0, false, &mut lines);
            }
        }
    }
    if !spec.closing_comments.before.is_empty() {
        if !lines.out.is_empty() {
            lines.out.push('\n');
        }
        lines.before(&spec.closing_comments.before, 0);
    }
    lines.out
}

/// A value that ends its line.
fn value(value: &Value, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    match &value.kind {
        ValueKind::Block(body) => tagged_or_block(body, behind, indent, lines),
        ValueKind::List(_) => {
            list(value, "", indent, lines);
            lines.end(behind);
        }
        ValueKind::Unit(of, unit) if matches!(of.kind, ValueKind::List(_)) => {
            list(of, &format!(" {}", crate::words::unit_text(unit)), indent, lines);
            lines.end(behind);
        }
        _ => {
            lines.out.push_str(&expr::text(value));
            lines.end(behind);
        }
    }
}

/// A list, on one line where it fits.
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
                tagged_or_block(body, &None, indent + 2, lines);
                lines.out.truncate(lines.out.trim_end().len());
            }
            _ => lines.out.push_str(&expr::text(item)),
        }
        lines.out.push_str(",\n");
    }
    lines.indent(indent);
    lines.out.push(']');
    lines.out.push_str(suffix);
}

/// The single entry of a block that is written `tag { .. }`.
fn tag(body: &Block) -> Option<(&Entry, &Block)> {
    match body.entries.as_slice() {
        [entry] if body.tagged && no_comments(&entry.comments) && no_comments(&body.closing_comments) => {
            match &entry.value.kind {
                ValueKind::Block(_) if is_pattern(&entry.key.value) => None,
                ValueKind::Block(inner) if !inner.tagged || tag(inner).is_none() => Some((entry, inner)),
                _ => None,
            }
        }
        _ => None,
    }
}

/// A key: a name as it is, a pattern in quotes.
fn key(text: &str) -> String {
    if is_pattern(text) { format!("\"{text}\"") } else { text.to_owned() }
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

/// A block that ends its line.
fn block(body: &Block, behind: &Option<String>, indent: usize, tall: bool, lines: &mut Lines) {
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

fn entries(body: &Block, indent: usize, lines: &mut Lines) {
    for entry in &body.entries {
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

fn one_line_block(body: &Block, line: &mut OneLine) -> Option<()> {
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
            line.push(separator(last, &entry.key.value))?;
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

/// What stands between a value and the next key on the same line.
fn separator(last: &Value, key: &str) -> &'static str {
    if matches!(last.kind, ValueKind::Missing) || expr::swallows(last, key) { ", " } else { "  " }
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
            line.push(&crate::words::unit_text(unit))
        }
        _ => line.push(&expr::text(value)),
    }
}

fn head(definition: &TaskDefinition, parentheses: bool) -> String {
    let mut text = definition.kind.value.clone();
    if !definition.args.is_empty() || parentheses {
        let args: Vec<String> = definition.args.iter().map(expr::text).collect();
        text.push_str(&format!("({})", args.join(", ")));
    }
    text
}

/// True where the block of a definition says nothing.
pub(super) fn empty(body: &Block) -> bool {
    body.entries.is_empty() && no_comments(&body.closing_comments)
}

/// `kind(args) { .. }` at the end of a line; a member without arguments needs its braces to be one in place.
fn definition(it: &TaskDefinition, behind: &Option<String>, indent: usize, member: bool, lines: &mut Lines) {
    lines.out.push_str(&head(it, false));
    if !empty(&it.body) || (member && it.args.is_empty()) {
        lines.out.push(' ');
        block(&it.body, behind, indent, false, lines);
    } else {
        lines.end(behind);
    }
}

fn stack(it: &Stack, behind: &Option<String>, lines: &mut Lines) {
    lines.out.push_str(&format!("stack {} {{", it.name.value));
    lines.end(behind);
    entries(&it.settings, 2, lines);
    for item in &it.levels {
        level(item, lines);
    }
    lines.before(&it.settings.closing_comments.before, 2);
    lines.out.push_str("}\n");
}

fn level(it: &Level, lines: &mut Lines) {
    lines.before(&it.comments.before, 2);
    // Comments on the settings of a level exist in YAML only; here they stand before the level.
    for entry in &it.settings.entries {
        lines.before(&entry.comments.before, 2);
        lines.before(entry.comments.behind.as_slice(), 2);
    }
    lines.indent(2);
    lines.out.push_str(&format!("level {}", it.name.value));
    if it.hard.is_some() {
        lines.out.push_str(" hard");
    }
    let mut last: Option<&Value> = None;
    for entry in &it.settings.entries {
        lines.out.push_str(if last.is_some_and(|v| expr::swallows(v, &entry.key.value)) { ", " } else { " " });
        lines.out.push_str(&format!("{} {}", entry.key.value, expr::text(&entry.value)));
        last = Some(&entry.value);
    }
    lines.out.push(' ');
    let mut line = OneLine::new(WIDTH.saturating_sub(lines.column()));
    if one_line_members(it, &mut line).is_some() {
        lines.out.push_str(&line.text);
        lines.end(&it.comments.behind);
        return;
    }
    lines.out.push('{');
    lines.end(&it.comments.behind);
    for (i, member) in it.members.iter().enumerate() {
        let next = it.members.get(i + 1);
        lines.before(&member.comments.before, 4);
        lines.indent(4);
        member_line(member, next, lines);
    }
    lines.before(&it.settings.closing_comments.before, 4);
    lines.indent(2);
    lines.out.push_str("}\n");
}

fn one_line_members(it: &Level, line: &mut OneLine) -> Option<()> {
    if !no_comments(&it.settings.closing_comments) {
        return None;
    }
    if it.members.is_empty() {
        return line.push("{}");
    }
    line.push("{ ")?;
    for (i, member) in it.members.iter().enumerate() {
        if !no_comments(&member.comments) {
            return None;
        }
        if i > 0 {
            line.push(if needs_comma(&it.members[i - 1], member, true) { ", " } else { "  " })?;
        }
        match &member.task {
            MemberTask::Name(name) => line.push(name)?,
            MemberTask::Inline(it) => {
                line.push(&head(it, false))?;
                if !empty(&it.body) || it.args.is_empty() {
                    line.push(" ")?;
                    one_line_block(&it.body, line)?;
                }
            }
        }
        if let Some(weight) = &member.weight {
            line.push(" weight ")?;
            line.push(&expr::text(weight))?;
        }
    }
    line.push(" }")
}

/// True where a member would be read as a part of the one before it.
fn needs_comma(last: &Member, next: &Member, same_line: bool) -> bool {
    let name = |member: &Member| match &member.task {
        MemberTask::Name(name) => name.value.clone(),
        MemberTask::Inline(it) => it.kind.value.clone(),
    };
    let next = name(next);
    next == "weight"
        || (name(last) == "level" && last.weight.is_none())
        || (same_line && last.weight.as_ref().is_some_and(|w| expr::swallows(w, &next)))
}

fn member_line(member: &Member, next: Option<&Member>, lines: &mut Lines) {
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
            definition(it, &quiet.behind, 4, true, lines);
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
    }
}
