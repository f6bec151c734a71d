//! Formulas, actions and triggers on one line, for both syntaxes.

use super::expr;
use super::hq_reuse::arguments;
use crate::tree::{Action, Formula, FormulaKind, Transition, Trigger, Value, ValueKind, Window};
use crate::vocabulary::begins_part;

/// Formats a formula, with brackets if necessary.
pub(crate) fn text(it: &Formula) -> String {
    let mut out = String::new();
    write(it, &mut out);
    out
}

fn write(it: &Formula, out: &mut String) {
    use FormulaKind::{After, Always, And, Eventually, Implies, Never, Not, Or, Until, Value};
    match &it.kind {
        Value(value) => out.push_str(&atom(value)),
        Not(inner) => {
            out.push_str("not ");
            grouped(inner, !matches!(inner.kind, Value(_) | Not(_)), out);
        }
        And(left, right) => {
            grouped(left, is_loose(left) || matches!(left.kind, Or(..)), out);
            out.push_str(" and ");
            grouped(right, is_loose(right) || matches!(right.kind, Or(..) | And(..)), out);
        }
        Or(left, right) => {
            grouped(left, is_loose(left), out);
            out.push_str(" or ");
            grouped(right, is_loose(right) || matches!(right.kind, Or(..)), out);
        }
        Implies(left, right) => {
            grouped(left, is_loose(left), out);
            out.push_str(" implies ");
            grouped(right, matches!(right.kind, Until(..)), out);
        }
        Until(left, window, right) => {
            grouped(left, is_loose(left) || matches!(left.kind, And(..) | Or(..)), out);
            out.push_str(" until");
            windowed(window, out);
            grouped(right, matches!(right.kind, And(..) | Or(..) | Until(..) | Implies(..)), out);
        }
        After(first, then) => {
            out.push_str("after ");
            grouped(first, is_loose(first), out);
            out.push_str(" : ");
            match &then.kind {
                // `after in(ask) : within 25 s : in(grasp)`
                Eventually(window, inner)
                    if window.from.is_none()
                        && window.to.is_some()
                        && !matches!(inner.kind, Always(..) | Eventually(..) | Never(..)) =>
                {
                    out.push_str(windowed_text(window).trim_start());
                    operand(inner, out);
                }
                _ => operand(then, out),
            }
        }
        Always(window, inner) => temporal("always", window, inner, out),
        Eventually(window, inner) => temporal("eventually", window, inner, out),
        Never(window, inner) => temporal("never", window, inner, out),
        FormulaKind::Missing => {}
    }
}

/// Returns true for a formula that would extend over a following operator: it needs brackets before one.
fn is_loose(it: &Formula) -> bool {
    use FormulaKind::{After, Always, Eventually, Implies, Never, Until};
    matches!(it.kind, After(..) | Always(..) | Eventually(..) | Never(..) | Until(..) | Implies(..))
}

fn grouped(it: &Formula, brackets: bool, out: &mut String) {
    if brackets {
        out.push('(');
    }
    write(it, out);
    if brackets {
        out.push(')');
    }
}

fn temporal(word: &str, window: &Window, inner: &Formula, out: &mut String) {
    out.push_str(word);
    windowed(window, out);
    let mut text = String::new();
    operand(inner, &mut text);
    // In brackets, because `(always -x)` looks like a difference.
    let unclear = window.is_open() && text.starts_with('-');
    out.push_str(&if unclear { format!("({text})") } else { text });
}

/// Formats the operand of a temporal operator.
fn operand(it: &Formula, out: &mut String) {
    grouped(it, matches!(it.kind, FormulaKind::Until(..) | FormulaKind::Implies(..)), out);
}

fn windowed(window: &Window, out: &mut String) {
    out.push_str(&windowed_text(window));
}

/// Formats ` within 25 s : `, or a space.
fn windowed_text(window: &Window) -> String {
    match (&window.from, &window.to) {
        (None, None) => " ".to_owned(),
        (None, Some(to)) => format!(" within {} : ", before_word(to)),
        (Some(from), None) => format!(" from {} : ", before_word(from)),
        (Some(from), Some(to)) => format!(" from {} to {} : ", before_word(from), before_word(to)),
    }
}

/// Formats a value that is followed by a word.
fn before_word(value: &Value) -> String {
    in_brackets_if(expr::text(value), expr::ends_with_minutes(value))
}

fn in_brackets_if(text: String, brackets: bool) -> String {
    if brackets && !expr::is_grouped(&text) { format!("({text})") } else { text }
}

fn first_word(text: &str) -> &str {
    text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).next().unwrap_or("")
}

/// Formats a value as a formula.
fn atom(value: &Value) -> String {
    let text = expr::text(value);
    let unclear = first_word(&text) == "expect" || text.starts_with('"') || expr::ends_with_minutes(value);
    in_brackets_if(text, unclear)
}

/// Formats a value, in brackets if its first word would begin a part of a state.
pub(super) fn guarded(value: &Value) -> String {
    let text = expr::text(value);
    let unclear = begins_part(first_word(&text)) || expr::ends_with_minutes(value);
    in_brackets_if(text, unclear)
}

/// Formats a condition: `and`, `or` and `not` need no brackets.
pub(super) fn condition(value: &Value) -> String {
    let text = expr::open(value);
    let unclear = begins_part(first_word(&text)) || expr::ends_with_minutes(value);
    in_brackets_if(text, unclear)
}

/// Returns the keyword of a trigger and its value.
pub(super) fn trigger(it: &Transition) -> Option<(&'static str, &Value)> {
    match &it.trigger {
        Trigger::On(value) => Some(("on", value)),
        Trigger::When { condition, .. } => Some(("when", condition)),
        Trigger::After(value) => Some(("after", value)),
        Trigger::Missing => None,
    }
}

/// Formats `when norm(right_ft.force) < 3 N for 3 s`.
pub(crate) fn trigger_text(it: &Transition) -> String {
    let mut out = match trigger(it) {
        Some((word, value)) => format!("{word} {}", condition(value)),
        None => "on".to_owned(),
    };
    if let Some(hold) = hold(it) {
        out.push_str(&format!(" for {}", guarded(hold)));
    }
    out
}

/// Returns the duration for which a condition must be true.
pub(super) fn hold(it: &Transition) -> Option<&Value> {
    match &it.trigger {
        Trigger::When { hold, .. } => hold.as_ref(),
        _ => None,
    }
}

/// Formats `say "text"`, `gripper close`, `capture(head_camera)`.
pub(super) fn action(it: &Action) -> String {
    let quiet = it.args.is_empty() && it.named.is_empty();
    if quiet {
        return it.verb.value.clone();
    }
    let one_text = matches!(it.args.as_slice(), [Value { kind: ValueKind::Text(_), .. }]);
    let bare = it.named.is_empty()
        && (it.bare || one_text)
        && it.args.iter().enumerate().all(|(i, arg)| stands_bare(arg, i + 1 == it.args.len()));
    if !bare {
        return format!("{}{}", it.verb.value, arguments(&it.args, &it.named));
    }
    let mut out = it.verb.value.clone();
    for arg in &it.args {
        out.push(' ');
        out.push_str(&expr::text(arg));
    }
    out
}

/// Returns true for an argument that needs no parentheses; after a number, a name could be its unit.
fn stands_bare(arg: &Value, last: bool) -> bool {
    match &arg.kind {
        ValueKind::Text(_) => true,
        ValueKind::Name(name) => !begins_part(name),
        ValueKind::Number(_) => last,
        ValueKind::Unit(of, _) => last && matches!(of.kind, ValueKind::Number(_)),
        _ => false,
    }
}
