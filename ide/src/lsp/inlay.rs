//! Inlay hints: the value in SI after a quantity in another unit.

use std::ops::Range;

use compiler::resolve::Meaning;
use compiler::units;
use dsl::tree::{Unit, Value, ValueKind};
use lsp_types::{InlayHint, InlayHintLabel};

use super::document::Document;

/// Maximum number of list items in a hint.
const MOST: usize = 8;

/// Hints for a range of bytes of a document.
pub(super) fn of(document: &Document, part: Range<usize>) -> Option<Vec<InlayHint>> {
    let quantities = document.names()?.references.iter().filter_map(|r| match &r.meaning {
        Meaning::Unit(unit, quantity) => Some((unit, quantity)),
        _ => None,
    });
    let mut hints = Vec::new();
    for (unit, quantity) in quantities {
        let ValueKind::Unit(inner, _) = &quantity.kind else { continue };
        let end = quantity.span.range().end;
        if let Some(label) = in_si(inner, unit).filter(|_| part.contains(&end) || part.end == end) {
            hints.push(InlayHint {
                position: document.text.position(end),
                label: InlayHintLabel::String(label),
                kind: None,
                text_edits: None,
                tooltip: None,
                padding_left: Some(true),
                padding_right: None,
                data: None,
            });
        }
    }
    Some(hints)
}

/// Formats a quantity in SI: `= 0.785398 rad` for `45 deg`; `None` if the unit has factor 1, or without a number.
fn in_si(inner: &Value, unit: &Unit) -> Option<String> {
    let (factor, dimension) = units::meaning(unit).ok().filter(|(factor, _)| *factor != 1.0)?;
    let shown = numbers(inner, factor)?;
    let unit = units::written(dimension);
    Some(if unit.is_empty() { format!("= {shown}") } else { format!("= {shown} {unit}") })
}

/// Formats a number, or a list of numbers, times a factor.
fn numbers(v: &Value, factor: f64) -> Option<String> {
    match &v.kind {
        ValueKind::Number(n) => Some(runtime::text::number(n.value * factor)),
        ValueKind::Negate(inner) => match &inner.kind {
            ValueKind::Number(n) => Some(runtime::text::number(-n.value * factor)),
            _ => None,
        },
        ValueKind::List(items) if items.len() <= MOST => {
            let all: Option<Vec<String>> = items.iter().map(|i| numbers(i, factor)).collect();
            Some(format!("[{}]", all?.join(", ")))
        }
        _ => None,
    }
}
