//! Triggers in the words of the spec, for people who look at a program.

use dsl::tree::{Transition, Trigger, Value, ValueKind};

use crate::forms::written;

/// A trigger as the formatter writes it, the same from both spellings: `when x < 3 N for 3 s`.
pub(super) fn trigger(t: &Transition) -> String {
    let mut t = t.clone();
    match &mut t.trigger {
        Trigger::On(value) => {
            tasks(value);
            names(value);
        }
        Trigger::When { condition, hold } => {
            names(condition);
            hold.iter_mut().for_each(names);
        }
        Trigger::After(value) => names(value),
        Trigger::Missing => {}
    }
    dsl::trigger_text(&t)
}

/// Gives tasks, which an expansion names by texts, their place as names.
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

/// Gives names that an expansion has changed what stands in the text.
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
