//! Printer of YAML texts: imports, parameters, ranges, repetitions.

use super::hq_reuse;
use super::yaml::{block, double_quoted, key, one_line, plain_or_quoted, sections, value, yaml_text};
use super::yaml_levels::{members, one_line_members};
use super::{Lines, OneLine, WIDTH, no_comments};
use crate::Spanned;
use crate::tree::{
    Block, Call, Comments, Entry, Import, Param, Parameter, RepeatItems, RepeatMembers, Value, ValueKind, Values,
};

/// Prints `path: [deck, canopies as robot]`.
pub(super) fn import(it: &Import, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    lines.out.push_str(&format!("{}:", yaml_text(&it.path)));
    let names: Vec<String> = it.names.iter().map(|n| plain(&hq_reuse::import_name(n))).collect();
    let quiet = no_comments(&it.closing_comments) && it.names.iter().all(|n| no_comments(&n.comments));
    let line = format!(" [{}]", names.join(", "));
    if quiet && lines.column() + line.len() <= WIDTH {
        lines.out.push_str(&line);
        return lines.end(behind);
    }
    if it.names.is_empty() {
        // Only a flow sequence can be empty and contain comments.
        lines.out.push_str(" [");
        lines.end(behind);
        lines.before(&it.closing_comments.before, indent + 2);
        lines.indent(indent + 2);
        lines.out.push_str("]\n");
        return;
    }
    lines.end(behind);
    for (name, text) in it.names.iter().zip(&names) {
        lines.before(&name.comments.before, indent + 2);
        lines.indent(indent + 2);
        lines.out.push_str(&format!("- {text}"));
        lines.end(&name.comments.behind);
    }
    lines.before(&it.closing_comments.before, indent + 2);
}

/// Formats a name, or words that contain one.
fn plain(text: &str) -> String {
    if text.contains(' ') { plain_or_quoted(text, true) } else { key(text) }
}

/// Prints `{ value: 0.15 m, min: 0.05 m, max: 0.3 m }`.
pub(super) fn ranged(param: &Param, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    let span = param.value.span;
    let own = Entry {
        key: Spanned::new("value".to_owned(), span),
        value: param.value.clone(),
        comments: Comments::default(),
    };
    let entries = std::iter::once(own).chain(param.range.entries.iter().cloned()).collect();
    block(&Block { entries, ..param.range.clone() }, behind, indent, lines);
}

/// Returns a robot's body with the name of its base robot as `from`.
pub(super) fn with_base(body: &Block, base: &Spanned<String>) -> Block {
    let value = Value { kind: ValueKind::Name(base.value.clone()), span: base.span };
    let own = Entry { key: Spanned::new("from".to_owned(), base.span), value, comments: Comments::default() };
    Block { entries: std::iter::once(own).chain(body.entries.iter().cloned()).collect(), ..body.clone() }
}

/// Formats a name with its parameters as a key: `"reach(side: arm)"`.
pub(super) fn head_key(name: &str, parameters: &[Parameter]) -> String {
    if parameters.is_empty() {
        return key(name);
    }
    double_quoted(&format!("{name}{}", hq_reuse::parameters(parameters)))
}

/// Formats `guarded(left)`.
pub(super) fn call(it: &Call) -> String {
    if it.args.is_empty() && it.named.is_empty() {
        return key(&it.name);
    }
    plain_or_quoted(&hq_reuse::call(it), false)
}

/// Formats `[left, right]` or `1..4` on one line.
fn values(it: &Values, line: &mut OneLine) -> Option<()> {
    match it {
        Values::List(list) => one_line(list, false, line),
        Values::Range(..) => line.push(&plain_or_quoted(&hq_reuse::values(it), true)),
    }
}

/// Prints `- name: side`, `in: [left, right]`, and the sections below.
pub(super) fn repeat(it: &RepeatItems, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    lines.out.push_str(&format!("- name: {}", key(&it.variable)));
    lines.end(behind);
    over(&it.values, indent + 2, lines);
    sections(&it.body, indent + 2, lines);
    lines.before(&it.closing_comments.before, indent + 2);
}

/// Prints `in: [left, right]`.
pub(super) fn over(it: &Values, indent: usize, lines: &mut Lines) {
    lines.indent(indent);
    lines.out.push_str("in:");
    match it {
        Values::List(list) => value(list, &None, indent, false, lines),
        Values::Range(..) => {
            lines.out.push_str(&format!(" {}", plain_or_quoted(&hq_reuse::values(it), false)));
            lines.end(&None);
        }
    }
}

/// Formats `{ for: { name: side, in: [left, right], tasks: [..] } }`.
pub(super) fn one_line_repeat(it: &RepeatMembers, line: &mut OneLine) -> Option<()> {
    if !no_comments(&it.closing_comments) {
        return None;
    }
    line.push(&format!("{{ for: {{ name: {}, in: ", key(&it.variable)))?;
    values(&it.values, line)?;
    line.push(", tasks: ")?;
    one_line_members(&it.body, line)?;
    line.push(" } }")
}

/// Prints a repetition of members on several lines, after the dash.
pub(super) fn member_repeat(it: &RepeatMembers, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    lines.out.push_str(" for:");
    lines.end(behind);
    lines.indent(indent + 2);
    lines.out.push_str(&format!("name: {}\n", key(&it.variable)));
    over(&it.values, indent + 2, lines);
    members(&it.body, &None, indent + 2, lines);
    lines.before(&it.closing_comments.before, indent + 2);
}
