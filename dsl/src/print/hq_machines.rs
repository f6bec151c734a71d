//! Printer of `*.hq` texts: signals, machines and their states, scenarios.

use super::hq::{block, empty, entries};
use super::hq_reuse as reuse;
use super::{Lines, OneLine, WIDTH, expr, formulas, no_comments};
use crate::tree::{Block, Entry, Expect, Machine, Scenario, Signal, State, StateBody, Transition, Value, ValueKind};
use crate::vocabulary::begins_part;
use crate::words::{has_block, is_name};

/// Prints `signal peduncle : point?  timeout 0.5 s`.
pub(super) fn signal(it: &Signal, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    let mark = if it.optional.is_some() { "?" } else { "" };
    lines.out.push_str(&format!("signal {} : {}{mark}", it.name.value, it.ty.value));
    if empty(&it.settings) {
        return lines.end(behind);
    }
    let text = format!("  {}", plain_settings(&it.settings.entries));
    if is_plain(&it.settings) && lines.column() + text.chars().count() <= WIDTH {
        lines.out.push_str(&text);
        return lines.end(behind);
    }
    lines.out.push(' ');
    block(&it.settings, behind, indent, false, lines);
}

/// Returns true if settings can be written on one line without braces.
fn is_plain(settings: &Block) -> bool {
    no_comments(&settings.closing_comments)
        && settings
            .entries
            .iter()
            .all(|e| no_comments(&e.comments) && !has_block(&e.value) && !begins_part(&e.key.value))
}

/// Formats `timeout 0.5 s  rate 10 Hz`.
fn plain_settings(all: &[Entry]) -> String {
    let mut out = String::new();
    let mut last: Option<&Value> = None;
    for entry in all {
        if let Some(last) = last {
            let missing = matches!(last.kind, ValueKind::Missing);
            out.push_str(if missing || expr::swallows(last, &entry.key.value, Some(&entry.value)) {
                ", "
            } else {
                "  "
            });
        }
        out.push_str(&format!("{} {}", entry.key.value, formulas::guarded(&entry.value)));
        last = Some(&entry.value);
    }
    out
}

/// Prints `machine harvest { .. }`.
pub(super) fn machine(it: &Machine, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    lines.out.push_str(&format!("machine {} ", it.name.value));
    body(&it.body, behind, indent, lines);
}

/// Returns true if a body is empty.
fn says_nothing(it: &StateBody) -> bool {
    only_stack(it) && it.stack.is_none()
}

/// Returns true if a body contains at most a stack.
fn only_stack(it: &StateBody) -> bool {
    no_comments(&it.stack_comments)
        && empty(&it.settings)
        && it.actions.is_empty()
        && it.transitions.is_empty()
        && it.properties.is_empty()
        && it.states.is_empty()
        && no_comments(&it.closing_comments)
}

fn body(it: &StateBody, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    if says_nothing(it) {
        lines.out.push_str("{}");
        return lines.end(behind);
    }
    let inner = indent + 2;
    lines.out.push('{');
    lines.end(behind);
    let begin = lines.out.len();
    if let Some(stack) = &it.stack {
        lines.before(&it.stack_comments.before, inner);
        lines.indent(inner);
        lines.out.push_str(&format!("stack {}", reuse::call(stack)));
        lines.end(&it.stack_comments.behind);
    }
    entries(&it.settings, inner, lines);
    for action in &it.actions {
        lines.before(&action.comments.before, inner);
        lines.indent(inner);
        lines.out.push_str(&format!("{} {}", action.moment.value.word(), formulas::action(action)));
        lines.end(&action.comments.behind);
    }
    for it in &it.transitions {
        transition(it, inner, lines);
    }
    it.properties.iter().for_each(|it| expect("check", it, inner, lines));
    let mut last_short = false;
    for (i, it) in it.states.iter().enumerate() {
        let short = no_comments(&it.comments) && one_line(it, inner).is_some();
        if lines.out.len() > begin && (i == 0 || !short || !last_short) {
            lines.out.push('\n');
        }
        last_short = short;
        state(it, inner, lines);
    }
    lines.before(&it.closing_comments.before, inner);
    lines.indent(indent);
    lines.out.push_str("}\n");
}

/// Formats a state with at most a stack on one line.
fn one_line(it: &State, indent: usize) -> Option<String> {
    if !only_stack(&it.body) {
        return None;
    }
    let mut line = OneLine::new(WIDTH.saturating_sub(indent));
    let word = if it.final_.is_some() { "final state" } else { it.word() };
    line.push(&format!("{word} {}", it.name.value))?;
    match &it.body.stack {
        Some(stack) => line.push(&format!(" {{ stack {} }}", reuse::call(stack)))?,
        None if it.final_.is_none() => line.push(" {}")?,
        None => {}
    }
    Some(line.text)
}

fn state(it: &State, indent: usize, lines: &mut Lines) {
    lines.before(&it.comments.before, indent);
    lines.indent(indent);
    if let Some(text) = one_line(it, indent) {
        lines.out.push_str(&text);
        return lines.end(&it.comments.behind);
    }
    let word = if it.final_.is_some() { "final state" } else { it.word() };
    lines.out.push_str(&format!("{word} {} ", it.name.value));
    body(&it.body, &it.comments.behind, indent, lines);
}

/// Prints `when norm(right_ft.force) < 3 N for 3 s -> grasp blend 1 s`.
fn transition(it: &Transition, indent: usize, lines: &mut Lines) {
    lines.before(&it.comments.before, indent);
    // Comments on the settings of a transition exist in YAML only; here they precede the transition.
    for entry in &it.settings.entries {
        lines.before(&entry.comments.before, indent);
        lines.before(entry.comments.behind.as_slice(), indent);
    }
    lines.before(&it.settings.closing_comments.before, indent);
    lines.indent(indent);
    lines.out.push_str(&format!("{} -> {}", formulas::trigger_text(it), it.target.value));
    if !it.settings.entries.is_empty() {
        lines.out.push_str(&format!(" {}", plain_settings(&it.settings.entries)));
    }
    lines.end(&it.comments.behind);
}

/// Prints `scenario "bunch hidden by leaves" { .. }`.
pub(super) fn scenario(it: &Scenario, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    let name = if is_name(&it.name) { it.name.value.clone() } else { expr::quoted(&it.name) };
    lines.out.push_str(&format!("scenario {name} "));
    if it.expects.is_empty() {
        return block(&it.body, behind, indent, false, lines);
    }
    lines.out.push('{');
    lines.end(behind);
    entries(&it.body, indent + 2, lines);
    it.expects.iter().for_each(|it| expect("expect", it, indent + 2, lines));
    lines.before(&it.body.closing_comments.before, indent + 2);
    lines.indent(indent);
    lines.out.push_str("}\n");
}

/// Prints `expect "hands stay" always error(hands) < 0.5 mm`, or another word and its formula.
fn expect(word: &str, it: &Expect, indent: usize, lines: &mut Lines) {
    lines.before(&it.comments.before, indent);
    lines.indent(indent);
    lines.out.push_str(&format!("{word} "));
    if let Some(label) = &it.label {
        lines.out.push_str(&format!("{} ", expr::quoted(label)));
    }
    lines.out.push_str(&formulas::text(&it.formula));
    lines.end(&it.comments.behind);
}
