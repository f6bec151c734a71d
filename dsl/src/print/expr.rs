//! Printer of expressions for both syntaxes: sums with spaces, products without, parentheses if necessary.

use crate::tree::{BinaryOp, Unit, Value, ValueKind};
use crate::vocabulary::UNITS;
use crate::words::{is_atom, takes_unit};

/// Formats an expression on one line. `and`, `or` and `not` are put in brackets.
pub(crate) fn text(value: &Value) -> String {
    let mut out = String::new();
    grouped(value, worded(value), &mut out);
    out
}

/// Formats an expression without outer brackets, for places that allow `and`, `or` and `not` without them.
pub(super) fn open(value: &Value) -> String {
    let mut out = String::new();
    grouped(value, false, &mut out);
    out
}

/// Returns true if one pair of brackets encloses the whole text.
pub(super) fn is_grouped(text: &str) -> bool {
    let mut depth = 0usize;
    let mut at = 0;
    if !text.starts_with('(') {
        return false;
    }
    while let Some(byte) = text.as_bytes().get(at) {
        match byte {
            b'"' => {
                at = crate::limits::text_end(text, at).unwrap_or(at + 1);
                continue;
            }
            b'(' => depth += 1,
            b')' => depth = depth.saturating_sub(1),
            _ => {}
        }
        at += 1;
        if depth == 0 {
            break;
        }
    }
    at == text.len()
}

/// Returns true if a value, written without brackets, has `and`, `or` or `not` outside all brackets.
fn worded(value: &Value) -> bool {
    match &value.kind {
        ValueKind::Not(_) => true,
        ValueKind::Binary(op, ..) => op.value.is_word(),
        _ => false,
    }
}

/// Formats a text literal.
pub(super) fn quoted(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + 2);
    out.push('"');
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            '\n' => out.push_str("\\n"),
            '\t' => out.push_str("\\t"),
            '\r' => out.push_str("\\r"),
            c if unprintable(c) => out.push_str(&format!("\\u{{{:x}}}", c as u32)),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

/// Returns true for characters that an editor would not show, or that YAML interprets otherwise.
pub(super) fn unprintable(c: char) -> bool {
    c.is_control() || matches!(c, '\u{2028}' | '\u{2029}' | '\u{feff}' | '\u{fffe}' | '\u{ffff}')
}

/// Returns true if `key` after `value` would be parsed as a unit, `a 5  m 3`, or the last unit of `value` as a key,
/// `a (5) min  b 3`; or if `key` is `in`, the operator after a value. `next` is the value after the key.
pub(super) fn swallows(value: &Value, key: &str, next: Option<&Value>) -> bool {
    let word = key == "in" && !matches!(value.kind, ValueKind::Block(_));
    let unit = (takes_unit(value) || worded(value)) && UNITS.contains(&key);
    (unit && !next.is_some_and(|next| key == "min" && limits(value, next)))
        || (ends_with_minutes(value) && !worded(value))
        || word
}

/// Returns true if the reader too parses a `min` between two values as the key of a limit.
fn limits(value: &Value, next: &Value) -> bool {
    if matches!(next.kind, ValueKind::Block(_) | ValueKind::Missing) {
        return false;
    }
    let text = text(next);
    let number = text.starts_with(|c: char| c.is_ascii_digit() || "[(-".contains(c));
    number || (text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') && !ends_with_number(value))
}

/// Returns true if a value ends with a number without a unit.
fn ends_with_number(value: &Value) -> bool {
    match &value.kind {
        ValueKind::Number(_) => true,
        ValueKind::Negate(of) | ValueKind::Not(of) | ValueKind::Binary(_, _, of) => ends_with_number(of),
        _ => false,
    }
}

/// Returns true if a value ends with the unit `min` after a bracket.
pub(super) fn ends_with_minutes(value: &Value) -> bool {
    match &value.kind {
        ValueKind::Unit(of, unit) => {
            !matches!(of.kind, ValueKind::Number(_)) && matches!(unit.factors.as_slice(), [(s, 1)] if s == "min")
        }
        ValueKind::Negate(of) | ValueKind::Not(of) | ValueKind::Binary(_, _, of) => ends_with_minutes(of),
        _ => false,
    }
}

fn write(value: &Value, out: &mut String) {
    match &value.kind {
        ValueKind::Number(number) => out.push_str(&number.text),
        ValueKind::Unit(of, unit) => with_unit(of, unit, out),
        ValueKind::Text(text) => out.push_str(&quoted(text)),
        ValueKind::Name(name) => out.push_str(name),
        ValueKind::Call(name, args) => {
            out.push_str(name);
            separated(args, '(', ')', out);
        }
        ValueKind::Named(name, of) => {
            out.push_str(name);
            out.push_str(": ");
            write(of, out);
        }
        ValueKind::Field(of, name) => {
            let bare =
                matches!(of.kind, ValueKind::Name(_) | ValueKind::Call(..) | ValueKind::List(_) | ValueKind::Field(..));
            grouped(of, !bare, out);
            out.push('.');
            out.push_str(name);
        }
        ValueKind::In(of, frame) => {
            grouped(of, !is_atom(of) || ends_with_minutes(of), out);
            out.push_str(" in ");
            out.push_str(frame);
        }
        ValueKind::List(items) => separated(items, '[', ']', out),
        ValueKind::Block(_) => out.push_str("{}"),
        ValueKind::Negate(of) => {
            out.push('-');
            let loose = matches!(&of.kind, ValueKind::Binary(op, ..) if op.value != BinaryOp::Pow);
            grouped(of, loose || matches!(of.kind, ValueKind::Not(_)), out);
        }
        ValueKind::Not(of) => {
            out.push_str("not ");
            grouped(of, matches!(&of.kind, ValueKind::Binary(op, ..) if op.value.is_word()), out);
        }
        ValueKind::Binary(op, left, right) => binary(op.value, left, right, out),
        ValueKind::Missing => {}
    }
}

fn grouped(value: &Value, parentheses: bool, out: &mut String) {
    if parentheses {
        out.push('(');
    }
    write(value, out);
    if parentheses {
        out.push(')');
    }
}

fn separated(items: &[Value], open: char, close: char, out: &mut String) {
    out.push(open);
    for (i, item) in items.iter().enumerate() {
        if i > 0 {
            out.push_str(", ");
        }
        write(item, out);
    }
    out.push(close);
}

fn with_unit(of: &Value, unit: &Unit, out: &mut String) {
    let bare = matches!(of.kind, ValueKind::Number(_) | ValueKind::Call(..) | ValueKind::List(_));
    grouped(of, !bare, out);
    out.push(' ');
    out.push_str(&unit.to_string());
}

fn precedence(op: BinaryOp) -> u8 {
    match op {
        BinaryOp::Or => 1,
        BinaryOp::And => 2,
        BinaryOp::Less | BinaryOp::LessEqual | BinaryOp::Greater | BinaryOp::GreaterEqual => 3,
        BinaryOp::Add | BinaryOp::Sub => 4,
        BinaryOp::Mul | BinaryOp::Div => 5,
        BinaryOp::Pow => 6,
    }
}

fn binary(op: BinaryOp, left: &Value, right: &Value, out: &mut String) {
    let own = precedence(op);
    let left_group = match &left.kind {
        ValueKind::Binary(inner, ..) => {
            precedence(inner.value) < own || op == BinaryOp::Pow || (op.compares() && inner.value.compares())
        }
        ValueKind::Negate(_) | ValueKind::Unit(..) => op == BinaryOp::Pow,
        ValueKind::Not(_) => !op.is_word(),
        _ => false,
    };
    // `1/(4 s)` needs no parentheses, but is misleading without; `[..] m` is clear.
    let right_unit = matches!(&right.kind, ValueKind::Unit(of, _) if matches!(of.kind, ValueKind::Number(_)));
    let right_group = match &right.kind {
        ValueKind::Binary(inner, ..) => {
            if op == BinaryOp::Pow {
                inner.value != BinaryOp::Pow
            } else {
                precedence(inner.value) <= own
            }
        }
        ValueKind::Not(_) => !op.is_word(),
        _ => right_unit && matches!(op, BinaryOp::Div | BinaryOp::Pow),
    };
    let start = out.len();
    grouped(left, left_group, out);
    let left_text = out.split_off(start);
    let mut right_text = String::new();
    grouped(right, right_group, &mut right_text);
    let ends_with_unit = !left_group && ends_with_unit(left);
    let begins_like_unit = right_text
        .split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'))
        .next()
        .is_some_and(|word| UNITS.contains(&word));
    let loose = own < precedence(BinaryOp::Mul);
    let spaced = format!(" {} ", op.text());
    let sign = match op {
        _ if loose => spaced.as_str(),
        BinaryOp::Mul if ends_with_unit || begins_like_unit => " * ",
        BinaryOp::Div if ends_with_unit || begins_like_unit => " / ",
        BinaryOp::Mul => "*",
        BinaryOp::Div => "/",
        _ => "^",
    };
    out.push_str(&left_text);
    out.push_str(sign);
    out.push_str(&right_text);
}

/// Returns true if a value ends with a unit.
fn ends_with_unit(value: &Value) -> bool {
    match &value.kind {
        ValueKind::Unit(..) => true,
        ValueKind::Negate(of) => {
            is_atom(of) && ends_with_unit(of) || matches!(of.kind, ValueKind::Binary(..) | ValueKind::Negate(_))
        }
        ValueKind::Not(of) => ends_with_unit(of),
        ValueKind::Binary(_, _, right) => ends_with_unit(right),
        _ => false,
    }
}
