//! Numbers with their units, and text literals.

use super::{Place, missing};
use crate::Diagnostic;
use crate::grammar::{Pair, Rule};
use crate::tree::{Number, Unit, Value, ValueKind};

pub(super) fn with_unit(of: Value, unit: Unit) -> Value {
    let span = of.span.to(unit.span);
    Value { kind: ValueKind::Unit(Box::new(of), unit), span }
}

/// Converts a node `quantity`: a number, and its unit if it has one.
pub(crate) fn quantity(pair: Pair<'_>, place: Place, diags: &mut Vec<Diagnostic>) -> Value {
    let mut value = missing(place.of(&pair));
    for part in pair.into_inner() {
        if part.as_rule() == Rule::number {
            value = number(&part, place, diags);
        } else {
            value = with_unit(value, unit(part, place, diags));
        }
    }
    value
}

/// Converts a number; reports one beyond the range of `f64`.
fn number(pair: &Pair<'_>, place: Place, diags: &mut Vec<Diagnostic>) -> Value {
    let span = place.of(pair);
    let text = pair.as_str();
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => {
            Value { kind: ValueKind::Number(Number { value, text: text.to_owned() }), span }
        }
        _ => {
            diags.push(
                Diagnostic::error("HQ0111", span, "this number is too large")
                    .note("numbers go up to about 1.8e308")
                    .help("check the exponent"),
            );
            missing(span)
        }
    }
}

/// Converts a unit; reports powers beyond 99.
pub(super) fn unit(pair: Pair<'_>, place: Place, diags: &mut Vec<Diagnostic>) -> Unit {
    let span = place.of(&pair);
    let mut factors = Vec::new();
    for factor in pair.into_inner() {
        let sign = if factor.as_rule() == Rule::unit_over { -1 } else { 1 };
        let (mut symbol, mut power) = (String::new(), 1i32);
        for part in factor.into_inner() {
            if part.as_rule() == Rule::unit_symbol {
                symbol = part.as_str().to_owned();
            } else {
                power = part.as_str().parse().ok().filter(|p: &i32| p.abs() <= 99).unwrap_or_else(|| {
                    diags.push(
                        Diagnostic::error("HQ0112", place.of(&part), "the power of a unit is at most 99")
                            .help("write a small whole number, as in `m^2`"),
                    );
                    1
                });
            }
        }
        factors.push((symbol, sign * power));
    }
    Unit { factors, span }
}

/// Returns the content of a text literal; reports unknown escapes, and keeps them as written.
pub(crate) fn unescape(pair: &Pair<'_>, place: Place, diags: &mut Vec<Diagnostic>) -> String {
    let raw = pair.as_str();
    let base = pair.as_span().start() + 1;
    let body = raw.get(1..raw.len().saturating_sub(1)).unwrap_or("");
    let mut out = String::with_capacity(body.len());
    let mut chars = body.char_indices().peekable();
    while let Some((at, c)) = chars.next() {
        if c != '\\' {
            out.push(c);
            continue;
        }
        match chars.next() {
            Some((_, 'n')) => out.push('\n'),
            Some((_, 't')) => out.push('\t'),
            Some((_, 'r')) => out.push('\r'),
            Some((_, c @ ('"' | '\\'))) => out.push(c),
            Some((next, c)) => {
                let code = body[next..].strip_prefix("u{").and_then(|r| r.split_once('}')).map(|r| r.0);
                let decoded = code
                    .filter(|hex| hex.len() <= 6)
                    .and_then(|hex| Some((hex.len(), char::from_u32(u32::from_str_radix(hex, 16).ok()?)?)));
                if let (true, Some((digits, decoded))) = (c == 'u', decoded) {
                    out.push(decoded);
                    for _ in 0..digits + 2 {
                        chars.next();
                    }
                } else {
                    out.push('\\');
                    out.push(c);
                    let span = place.span(base + at, base + next + c.len_utf8());
                    diags.push(
                        Diagnostic::error("HQ0120", span, format!("`\\{c}` means nothing in a text"))
                            .here("unknown escape")
                            .help("a backslash itself is written `\\\\`"),
                    );
                }
            }
            None => out.push('\\'),
        }
    }
    out
}
