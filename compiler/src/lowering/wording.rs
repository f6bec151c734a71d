//! Formats triggers in the syntax of the spec, for users who inspect a program.

use dsl::tree::{Transition, Trigger, Value, ValueKind};

use crate::expr::REACHED;
use crate::forms::written;

/// Formats a trigger as the formatter does, equally for both syntaxes: `when x < 3 N for 3 s`.
pub(super) fn trigger(t: &Transition) -> String {
    let mut t = t.clone();
    match &mut t.trigger {
        Trigger::On(value) => {
            tasks(value);
            names(value);
        }
        Trigger::When { condition, hold } => {
            targets(condition);
            names(condition);
            hold.iter_mut().for_each(names);
        }
        Trigger::After(value) => names(value),
        Trigger::Missing => {}
    }
    dsl::trigger_text(&t)
}

/// Formats a call of a condition in the same way: `reached(reach, 5 mm)`.
pub(super) fn call(value: &Value) -> String {
    let mut value = value.clone();
    targets(&mut value);
    names(&mut value);
    dsl::expression_text(&value)
}

/// Restores the names of tasks in all calls of `reached` in a condition.
fn targets(value: &mut Value) {
    match &mut value.kind {
        ValueKind::Call(function, _) if function.value == REACHED => tasks(value),
        ValueKind::Not(inner) | ValueKind::Negate(inner) => targets(inner),
        ValueKind::Binary(_, left, right) => {
            targets(left);
            targets(right);
        }
        ValueKind::Call(_, all) => all.iter_mut().for_each(targets),
        _ => {}
    }
}

/// Restores the names of tasks, which the expansion stores as texts.
fn tasks(value: &mut Value) {
    let ValueKind::Call(_, args) = &mut value.kind else { return };
    match args.first_mut() {
        Some(Value { kind, .. }) if matches!(kind, ValueKind::Text(_)) => {
            if let ValueKind::Text(name) = kind {
                *kind = ValueKind::Name(std::mem::take(name));
            }
        }
        Some(inner) => tasks(inner),
        None => {}
    }
}

/// Restores the source text of names that the expansion changed.
fn names(value: &mut Value) {
    match &mut value.kind {
        ValueKind::Name(name) => *name = written(name).to_string(),
        ValueKind::Call(_, all) | ValueKind::List(all) => all.iter_mut().for_each(names),
        ValueKind::Unit(inner, _)
        | ValueKind::Field(inner, _)
        | ValueKind::In(inner, _)
        | ValueKind::Named(_, inner)
        | ValueKind::Negate(inner)
        | ValueKind::Not(inner) => names(inner),
        ValueKind::Binary(_, left, right) => {
            names(left);
            names(right);
        }
        ValueKind::Block(_) | ValueKind::Number(_) | ValueKind::Text(_) | ValueKind::Missing => {}
    }
}
