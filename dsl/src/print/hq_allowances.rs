//! Printer of `*.hq` texts: allowed warnings.

use super::{Lines, OneLine, expr, no_comments};
use crate::tree::{Block, Entry, Value, ValueKind};
use crate::vocabulary::ALLOW;

/// Returns the codes of the entry `allow` of a block, if there is at least one.
pub(super) fn of(entry: &Entry) -> Option<&Block> {
    entry.value.block().filter(|block| entry.key.value == ALLOW && !block.entries.is_empty())
}

/// Formats `allow HQ0606 "the tray is soft on purpose"`.
pub(super) fn line(code: &str, reason: &Value) -> String {
    match &reason.kind {
        ValueKind::Missing => format!("{ALLOW} {code}"),
        _ => format!("{ALLOW} {code} {}", expr::text(reason)),
    }
}

/// Prints one line for each code. Comments on the entry itself exist in YAML only; here they precede the first line.
pub(super) fn lines(entry: &Entry, allowed: &Block, indent: usize, lines: &mut Lines) {
    lines.before(&entry.comments.before, indent);
    lines.before(entry.comments.behind.as_slice(), indent);
    for it in &allowed.entries {
        lines.before(&it.comments.before, indent);
        lines.indent(indent);
        lines.out.push_str(&line(&it.key.value, &it.value));
        lines.end(&it.comments.behind);
    }
    lines.before(&allowed.closing_comments.before, indent);
}

pub(super) fn one_line(allowed: &Block, out: &mut OneLine) -> Option<()> {
    if !no_comments(&allowed.closing_comments) {
        return None;
    }
    for (i, it) in allowed.entries.iter().enumerate() {
        if !no_comments(&it.comments) {
            return None;
        }
        out.push(if i > 0 { "  " } else { "" })?;
        out.push(&line(&it.key.value, &it.value))?;
    }
    Some(())
}
