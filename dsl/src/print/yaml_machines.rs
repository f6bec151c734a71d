//! Printer of YAML texts: signals, machines and their states, scenarios.

use super::hq::empty;
use super::yaml::{block, double_quoted, entries, key, one_line, plain_or_quoted, yaml_text};
use super::yaml_reuse as reuse;
use super::{Lines, OneLine, WIDTH, formulas, no_comments};
use crate::Spanned;
use crate::tree::{
    Block, Comments, Entry, Expect, Machine, Moment, Scenario, Signal, State, StateBody, Transition, Value, ValueKind,
    Variable,
};
use crate::words::is_name;

/// Prints `peduncle: point?` or `peduncle: { type: point?, timeout: 0.5 s }`.
pub(super) fn signal(it: &Signal, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    lines.out.push_str(&format!("{}:", key(&it.name)));
    let ty = format!("{}{}", it.ty.value, if it.optional.is_some() { "?" } else { "" });
    if empty(&it.settings) {
        let plain = key(&it.ty);
        let ty = if plain.starts_with('"') { double_quoted(&ty) } else { ty };
        lines.out.push_str(&format!(" {ty}"));
        return lines.end(behind);
    }
    let value = Value { kind: ValueKind::Name(ty), span: it.ty.span };
    let own = Entry { key: Spanned::new("type".to_owned(), it.ty.span), value, comments: Comments::default() };
    let entries = std::iter::once(own).chain(it.settings.entries.iter().cloned()).collect();
    block(&Block { entries, ..it.settings.clone() }, behind, indent, lines);
}

/// Prints `goal: point?` or `attempts: { type: number, value: 0 }`.
pub(super) fn variable(it: &Variable, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    let held = it.value.iter().map(|value| Entry {
        key: Spanned::new("value".to_owned(), value.span),
        value: value.clone(),
        comments: Comments::default(),
    });
    let settings = Block { entries: held.collect(), span: it.ty.span, ..Block::default() };
    let Variable { name, ty, optional, .. } = it.clone();
    signal(&Signal { name, ty, optional, settings }, behind, indent, lines);
}

/// Prints `harvest:` with its parts below it.
pub(super) fn machine(it: &Machine, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    lines.out.push_str(&format!("{}:", key(&it.name)));
    body(&it.body, false, behind, indent, lines);
}

/// Prints the text after the name of a machine or state.
fn body(it: &StateBody, is_final: bool, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    let mut line = OneLine::new(WIDTH.saturating_sub(lines.column() + 1));
    if short(it, is_final, &mut line).is_some() {
        lines.out.push_str(&format!(" {}", line.text));
        return lines.end(behind);
    }
    let inner = indent + 2;
    let nothing = !is_final
        && it.stack.is_none()
        && it.settings.entries.is_empty()
        && it.actions.is_empty()
        && it.transitions.is_empty()
        && it.properties.is_empty()
        && it.states.is_empty();
    if nothing {
        // Only a flow mapping can be empty and contain comments.
        lines.out.push_str(" {");
        lines.end(behind);
        lines.before(&it.closing_comments.before, inner);
        lines.indent(inner);
        lines.out.push_str("}\n");
        return;
    }
    lines.end(behind);
    if is_final {
        lines.indent(inner);
        lines.out.push_str("final: true\n");
    }
    if let Some(stack) = &it.stack {
        lines.before(&it.stack_comments.before, inner);
        lines.indent(inner);
        lines.out.push_str(&format!("stack: {}", reuse::call(stack)));
        lines.end(&it.stack_comments.behind);
    }
    entries(&it.settings, inner, lines);
    for moment in Moment::ALL {
        actions(it, moment, inner, lines);
    }
    title("transitions", it.transitions.is_empty(), inner, lines);
    for transition in &it.transitions {
        self::transition(transition, inner + 2, lines);
    }
    expects("check", &it.properties, inner, lines);
    for (word, region) in [("states", false), ("regions", true)] {
        title(word, it.inner(region).next().is_none(), inner, lines);
        for state in it.inner(region) {
            self::state(state, inner + 2, lines);
        }
    }
    lines.before(&it.closing_comments.before, inner);
}

fn title(word: &str, left_out: bool, indent: usize, lines: &mut Lines) {
    if !left_out {
        lines.indent(indent);
        lines.out.push_str(&format!("{word}:\n"));
    }
}

/// Prints `{ final: true, stack: rest }`; `None` if the body contains anything else.
fn short(it: &StateBody, is_final: bool, line: &mut OneLine) -> Option<()> {
    let quiet = no_comments(&it.stack_comments)
        && empty(&it.settings)
        && it.actions.is_empty()
        && it.transitions.is_empty()
        && it.properties.is_empty()
        && it.states.is_empty()
        && no_comments(&it.closing_comments);
    if !quiet {
        return None;
    }
    let mut parts = Vec::new();
    if is_final {
        parts.push("final: true".to_owned());
    }
    if let Some(stack) = &it.stack {
        let call = reuse::call(stack);
        let call = if call.starts_with('"') { call } else { plain_or_quoted(&call, true) };
        parts.push(format!("stack: {call}"));
    }
    line.push(&if parts.is_empty() { "{}".to_owned() } else { format!("{{ {} }}", parts.join(", ")) })
}

fn state(it: &State, indent: usize, lines: &mut Lines) {
    lines.before(&it.comments.before, indent);
    lines.indent(indent);
    lines.out.push_str(&format!("{}:", key(&it.name)));
    body(&it.body, it.final_.is_some(), &it.comments.behind, indent, lines);
}

/// Prints `enter: 'say "text"'`, or a sequence of several actions.
fn actions(it: &StateBody, moment: Moment, indent: usize, lines: &mut Lines) {
    let all: Vec<_> = it.actions_at(moment).collect();
    match all.as_slice() {
        [] => {}
        [one] => {
            lines.before(&one.comments.before, indent);
            lines.indent(indent);
            lines.out.push_str(&format!("{}: {}", moment.word(), scalar(&formulas::action(one), false)));
            lines.end(&one.comments.behind);
        }
        several => {
            lines.indent(indent);
            lines.out.push_str(&format!("{}:\n", moment.word()));
            for one in several {
                lines.before(&one.comments.before, indent + 2);
                lines.indent(indent + 2);
                lines.out.push_str(&format!("- {}", scalar(&formulas::action(one), false)));
                lines.end(&one.comments.behind);
            }
        }
    }
}

/// Formats words with texts in double quotes among them: the YAML quotes are then single ones.
fn scalar(text: &str, flow: bool) -> String {
    if text.contains('"') { format!("'{}'", text.replace('\'', "''")) } else { plain_or_quoted(text, flow) }
}

/// Prints `- { on: found, to: pre_grasp }`.
fn transition(it: &Transition, indent: usize, lines: &mut Lines) {
    lines.before(&it.comments.before, indent);
    lines.indent(indent);
    let behind = &it.comments.behind;
    let parts = |flow: bool| {
        let mut parts = Vec::new();
        if let Some((word, value)) = formulas::trigger(it) {
            parts.push((word.to_owned(), scalar(&formulas::condition(value), flow)));
        }
        if let Some(hold) = formulas::hold(it) {
            parts.push(("for".to_owned(), scalar(&formulas::guarded(hold), flow)));
        }
        let plain = it.target.split('.').all(|part| key(part) == part);
        parts.push(("to".to_owned(), if plain { it.target.value.clone() } else { format!("\"{}\"", it.target.value) }));
        parts
    };
    let mut line = OneLine::new(WIDTH.saturating_sub(lines.column() + 2));
    if one_line_transition(&parts(true), &it.settings, &mut line).is_some() {
        lines.out.push_str(&format!("- {}", line.text));
        return lines.end(behind);
    }
    for (i, (word, text)) in parts(false).iter().enumerate() {
        if i > 0 {
            lines.indent(indent);
        }
        lines.out.push_str(&format!("{}{word}: {text}", if i == 0 { "- " } else { "  " }));
        lines.end(if i == 0 { behind } else { &None });
    }
    entries(&it.settings, indent + 2, lines);
    lines.before(&it.settings.closing_comments.before, indent + 2);
}

fn one_line_transition(parts: &[(String, String)], settings: &Block, line: &mut OneLine) -> Option<()> {
    if !no_comments(&settings.closing_comments) {
        return None;
    }
    line.push("{ ")?;
    for (i, (word, text)) in parts.iter().enumerate() {
        line.push(&format!("{}{word}: {text}", if i > 0 { ", " } else { "" }))?;
    }
    for entry in &settings.entries {
        if !no_comments(&entry.comments) {
            return None;
        }
        line.push(&format!(", {}: ", key(&entry.key)))?;
        one_line(&entry.value, crate::words::is_text_key(&entry.key), line)?;
    }
    line.push(" }")
}

/// Prints a name with its parts below it, the expectations last.
pub(super) fn scenario(it: &Scenario, behind: &Option<String>, indent: usize, lines: &mut Lines) {
    let name = if is_name(&it.name) { key(&it.name) } else { yaml_text(&it.name) };
    lines.out.push_str(&format!("{name}:"));
    if it.expects.is_empty() {
        return block(&it.body, behind, indent, lines);
    }
    lines.end(behind);
    entries(&it.body, indent + 2, lines);
    expects("expect", &it.expects, indent + 2, lines);
    lines.before(&it.body.closing_comments.before, indent + 2);
}

/// Prints a sequence of formulas below a key.
fn expects(key: &str, all: &[Expect], indent: usize, lines: &mut Lines) {
    title(key, all.is_empty(), indent, lines);
    for expect in all {
        lines.before(&expect.comments.before, indent + 2);
        lines.indent(indent + 2);
        let formula = scalar(&formulas::text(&expect.formula), false);
        match &expect.label {
            Some(label) => lines.out.push_str(&format!("- {}: {formula}", yaml_text(label))),
            None => lines.out.push_str(&format!("- {formula}")),
        }
        lines.end(&expect.comments.behind);
    }
}
