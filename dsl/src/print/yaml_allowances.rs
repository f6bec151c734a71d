//! Printer of YAML texts: allowed warnings.

use super::yaml::{key, yaml_text};
use super::{Lines, OneLine, WIDTH, no_comments};
use crate::tree::{Block, Entry, Value, ValueKind};
use crate::vocabulary::ALLOW;

/// Returns the codes of the entry `allow` of a block.
pub(super) fn of(entry: &Entry) -> Option<&Block> {
    entry.value.block().filter(|_| entry.key.value == ALLOW)
}

/// Formats a reason.
pub(super) fn reason(it: &Value) -> String {
    match &it.kind {
        ValueKind::Text(text) => yaml_text(text),
        _ => "null".to_owned(),
    }
}

/// Prints the codes after `allow:`.
pub(super) fn block(allowed: &Block, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    let mut line = OneLine::new(WIDTH.saturating_sub(lines.column() + 1));
    if one_line(allowed, &mut line).is_some() || allowed.entries.is_empty() {
        let text = if allowed.entries.is_empty() { "{}" } else { &line.text };
        lines.out.push_str(&format!(" {text}"));
        return lines.end(behind);
    }
    lines.end(behind);
    for it in &allowed.entries {
        lines.before(&it.comments.before, indent + 2);
        lines.indent(indent + 2);
        lines.out.push_str(&format!("{}: {}", key(&it.key), reason(&it.value)));
        lines.end(&it.comments.behind);
    }
    lines.before(&allowed.closing_comments.before, indent + 2);
}

pub(super) fn one_line(allowed: &Block, line: &mut OneLine) -> Option<()> {
    if !no_comments(&allowed.closing_comments) {
        return None;
    }
    line.push("{ ")?;
    for (i, it) in allowed.entries.iter().enumerate() {
        if !no_comments(&it.comments) {
            return None;
        }
        line.push(if i > 0 { ", " } else { "" })?;
        line.push(&format!("{}: {}", key(&it.key), reason(&it.value)))?;
    }
    line.push(" }")
}
