//! Printer of `*.hq` texts: imports, parameters and arguments, heads of repetitions. The YAML printer shares some of
//! it.

use super::{Lines, OneLine, WIDTH, expr, no_comments};
use crate::tree::{Call, Entry, Import, ImportName, Parameter, Value, Values};

pub(super) fn import(it: &Import, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    lines.out.push_str(&format!("import {} ", expr::quoted(&it.path)));
    let mut line = OneLine::new(WIDTH.saturating_sub(lines.column()));
    if one_line_import(it, &mut line).is_some() {
        lines.out.push_str(&line.text);
        return lines.end(behind);
    }
    lines.out.push('{');
    lines.end(behind);
    for (i, name) in it.names.iter().enumerate() {
        lines.before(&name.comments.before, indent + 2);
        lines.indent(indent + 2);
        lines.out.push_str(&import_name(name));
        if it.names.get(i + 1).is_some_and(|next| next.name.value == "as") {
            lines.out.push(',');
        }
        lines.end(&name.comments.behind);
    }
    lines.before(&it.closing_comments.before, indent + 2);
    lines.indent(indent);
    lines.out.push_str("}\n");
}

fn one_line_import(it: &Import, line: &mut OneLine) -> Option<()> {
    let quiet = no_comments(&it.closing_comments) && it.names.iter().all(|n| no_comments(&n.comments));
    let names: Vec<String> = it.names.iter().map(import_name).collect();
    if !quiet {
        return None;
    }
    line.push(&if names.is_empty() { "{}".to_owned() } else { format!("{{ {} }}", names.join(", ")) })
}

/// Formats `deck` or `deck as table`.
pub(super) fn import_name(it: &ImportName) -> String {
    match &it.alias {
        Some(alias) => format!("{} as {}", it.name.value, alias.value),
        None => it.name.value.clone(),
    }
}

/// Formats `(side: arm, gain: rate = 5 /s)`; empty if there are no parameters.
pub(super) fn parameters(all: &[Parameter]) -> String {
    if all.is_empty() {
        return String::new();
    }
    let one = |p: &Parameter| match &p.default {
        Some(default) => format!("{}: {} = {}", p.name.value, p.ty.value, expr::text(default)),
        None => format!("{}: {}", p.name.value, p.ty.value),
    };
    format!("({})", all.iter().map(one).collect::<Vec<_>>().join(", "))
}

/// Formats `(left, gain: 5 /s)`.
pub(super) fn arguments(args: &[Value], named: &[Entry]) -> String {
    let by_place = args.iter().map(expr::text);
    let by_name = named.iter().map(|e| format!("{}: {}", e.key.value, expr::text(&e.value)));
    format!("({})", by_place.chain(by_name).collect::<Vec<_>>().join(", "))
}

/// Formats ` from guarded(left)`.
pub(super) fn from(it: &Call) -> String {
    format!(" from {}", call(it))
}

/// Formats `guarded(left)`.
pub(super) fn call(it: &Call) -> String {
    let quiet = it.args.is_empty() && it.named.is_empty();
    let arguments = if quiet { String::new() } else { arguments(&it.args, &it.named) };
    format!("{}{arguments}", it.name.value)
}

/// Formats `for side in [left, right]`.
pub(super) fn repeat_head(variable: &str, over: &Values) -> String {
    format!("for {variable} in {}", values(over))
}

/// Formats `[left, right]` or `1..4`.
pub(super) fn values(it: &Values) -> String {
    match it {
        Values::List(list) => expr::text(list),
        Values::Range(first, last) => format!("{}..{}", expr::text(first), expr::text(last)),
    }
}
