//! Inlay hints: behind a quantity in another unit, its value in SI.

use std::ops::Range;

use compiler::units;
use dsl::tree::{Block, ItemKind, MemberTask, Spec, TaskDefinition, Unit, Value, ValueKind};
use lsp_types::{InlayHint, InlayHintLabel};

use super::document::Document;

/// Most numbers of a list that a hint shows.
const MOST: usize = 8;

/// The hints for a part of a document, in bytes.
pub(super) fn of(document: &Document, part: Range<usize>) -> Option<Vec<InlayHint>> {
    let mut hints = Vec::new();
    for (end, label) in quantities(&document.analysis()?.spec) {
        if part.contains(&end) || part.end == end {
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

/// For each quantity that is not in SI, the byte behind it and its value.
fn quantities(spec: &Spec) -> Vec<(usize, String)> {
    let mut out = Vec::new();
    for item in &spec.items {
        match &item.kind {
            ItemKind::Param(p) => value(&p.value, &mut out),
            ItemKind::Robot(r) => block(&r.body, &mut out),
            ItemKind::Task(t) => definition(&t.definition, &mut out),
            ItemKind::Run(r) => block(&r.body, &mut out),
            ItemKind::Stack(s) => {
                block(&s.settings, &mut out);
                for level in &s.levels {
                    block(&level.settings, &mut out);
                    for member in &level.members {
                        if let MemberTask::Inline(d) = &member.task {
                            definition(d, &mut out);
                        }
                        if let Some(weight) = &member.weight {
                            value(weight, &mut out);
                        }
                    }
                }
            }
        }
    }
    out
}

fn definition(d: &TaskDefinition, out: &mut Vec<(usize, String)>) {
    d.args.iter().for_each(|v| value(v, out));
    block(&d.body, out);
}

fn block(b: &Block, out: &mut Vec<(usize, String)>) {
    b.entries.iter().for_each(|e| value(&e.value, out));
}

fn value(v: &Value, out: &mut Vec<(usize, String)>) {
    match &v.kind {
        ValueKind::Unit(inner, unit) => {
            if let Some(label) = in_si(inner, unit) {
                out.push((v.span.range().end, label));
            }
            value(inner, out);
        }
        ValueKind::Call(_, all) | ValueKind::List(all) => all.iter().for_each(|v| value(v, out)),
        ValueKind::Block(b) => block(b, out),
        ValueKind::Field(inner, _) | ValueKind::In(inner, _) | ValueKind::Negate(inner) | ValueKind::Not(inner) => {
            value(inner, out)
        }
        ValueKind::Binary(_, a, b) => {
            value(a, out);
            value(b, out);
        }
        ValueKind::Number(_) | ValueKind::Text(_) | ValueKind::Name(_) | ValueKind::Missing => {}
    }
}

/// `= 0.785398 rad` for `45 deg`; nothing where the unit is one of SI or the value no number.
fn in_si(inner: &Value, unit: &Unit) -> Option<String> {
    let (factor, dimension) = units::meaning(unit).ok().filter(|(factor, _)| *factor != 1.0)?;
    let shown = numbers(inner, factor)?;
    let unit = units::written(dimension);
    Some(if unit.is_empty() { format!("= {shown}") } else { format!("= {shown} {unit}") })
}

/// A number, or a list of them, times a factor.
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
