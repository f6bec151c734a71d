//! Inlay hints: the value in SI after a quantity in another unit.

use std::ops::Range;

use compiler::units;
use dsl::tree::{
    Block, Change, Formula, FormulaKind, Item, ItemKind, Level, Member, MemberTask, MissionMember, MissionRepeat,
    Parameter, Spec, StateBody, TaskDefinition, Trigger, Unit, Value, ValueKind,
};
use lsp_types::{InlayHint, InlayHintLabel};

use super::document::Document;

/// Maximum number of list items in a hint.
const MOST: usize = 8;

/// Hints for a range of bytes of a document.
pub(super) fn of(document: &Document, part: Range<usize>) -> Option<Vec<InlayHint>> {
    let mut hints = Vec::new();
    for (end, label) in quantities(document.spec()?) {
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

/// For each quantity that is not in SI, its end and its value.
fn quantities(spec: &Spec) -> Vec<(usize, String)> {
    let mut out = Vec::new();
    spec.items.iter().for_each(|i| item(i, &mut out));
    out
}

fn item(item: &Item, out: &mut Vec<(usize, String)>) {
    match &item.kind {
        ItemKind::Import(_) => {}
        ItemKind::Signal(s) => block(&s.settings, out),
        ItemKind::Human(h) => block(&h.body, out),
        ItemKind::SafetyField(f) => block(&f.body, out),
        ItemKind::Variable(v) => v.value.iter().for_each(|held| value(held, out)),
        ItemKind::Machine(m) => states(&m.body, out),
        ItemKind::Mission(m) => {
            block(&m.settings, out);
            members(&m.members, &m.repeats, out);
        }
        ItemKind::Scenario(s) => {
            block(&s.body, out);
            s.expects.iter().for_each(|e| formula(&e.formula, out));
        }
        ItemKind::Param(p) => {
            value(&p.value, out);
            block(&p.range, out);
        }
        ItemKind::Let(l) => value(&l.value, out),
        ItemKind::Robot(r) => block(&r.body, out),
        ItemKind::Task(t) => {
            defaults(&t.parameters, out);
            definition(&t.definition, out);
        }
        ItemKind::Run(r) => block(&r.body, out),
        ItemKind::Stack(s) => {
            defaults(&s.parameters, out);
            if let Some(base) = &s.base {
                base.args.iter().chain(base.named.iter().map(|e| &e.value)).for_each(|v| value(v, out));
            }
            block(&s.settings, out);
            s.levels.iter().for_each(|l| level(l, out));
            for change in &s.changes {
                match change {
                    Change::Replace(l) | Change::Add(l, _) => level(l, out),
                    Change::Remove(_) => {}
                }
            }
        }
        ItemKind::For(f) => f.body.iter().for_each(|i| self::item(i, out)),
    }
}

fn formula(f: &Formula, out: &mut Vec<(usize, String)>) {
    use FormulaKind as F;
    match &f.kind {
        F::Always(w, a) | F::Eventually(w, a) | F::Never(w, a) => {
            w.from.iter().chain(&w.to).for_each(|v| value(v, out));
            formula(a, out);
        }
        F::Until(a, w, b) => {
            formula(a, out);
            w.from.iter().chain(&w.to).for_each(|v| value(v, out));
            formula(b, out);
        }
        F::After(a, b) | F::And(a, b) | F::Or(a, b) | F::Implies(a, b) => {
            formula(a, out);
            formula(b, out);
        }
        F::Not(a) => formula(a, out),
        F::Value(v) => value(v, out),
        F::Missing => {}
    }
}

fn states(body: &StateBody, out: &mut Vec<(usize, String)>) {
    if let Some(call) = &body.stack {
        call.args.iter().chain(call.named.iter().map(|e| &e.value)).for_each(|v| value(v, out));
    }
    block(&body.settings, out);
    body.actions.iter().flat_map(|a| &a.args).for_each(|v| value(v, out));
    for t in &body.transitions {
        match &t.trigger {
            Trigger::On(v) | Trigger::After(v) => value(v, out),
            Trigger::When { condition, hold } => {
                value(condition, out);
                hold.iter().for_each(|v| value(v, out));
            }
            Trigger::Missing => {}
        }
        block(&t.settings, out);
    }
    body.states.iter().for_each(|s| states(&s.body, out));
}

fn members(members: &[MissionMember], repeats: &[MissionRepeat], out: &mut Vec<(usize, String)>) {
    for m in members {
        block(&m.settings, out);
        self::members(&m.members, &m.repeats, out);
    }
    repeats.iter().for_each(|r| self::members(&r.members, &r.repeats, out));
}

fn level(level: &Level, out: &mut Vec<(usize, String)>) {
    block(&level.settings, out);
    level.members.iter().for_each(|m| member(m, out));
}

fn member(member: &Member, out: &mut Vec<(usize, String)>) {
    match &member.task {
        MemberTask::Name(_) => {}
        MemberTask::Inline(d) => definition(d, out),
        MemberTask::For(f) => f.body.iter().for_each(|m| self::member(m, out)),
    }
    if let Some(weight) = &member.weight {
        value(weight, out);
    }
}

fn defaults(parameters: &[Parameter], out: &mut Vec<(usize, String)>) {
    parameters.iter().filter_map(|p| p.default.as_ref()).for_each(|v| value(v, out));
}

fn definition(d: &TaskDefinition, out: &mut Vec<(usize, String)>) {
    d.args.iter().chain(d.named.iter().map(|e| &e.value)).for_each(|v| value(v, out));
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
        ValueKind::Field(inner, _)
        | ValueKind::In(inner, _)
        | ValueKind::Named(_, inner)
        | ValueKind::Negate(inner)
        | ValueKind::Not(inner) => value(inner, out),
        ValueKind::Binary(_, a, b) => {
            value(a, out);
            value(b, out);
        }
        ValueKind::Number(_) | ValueKind::Text(_) | ValueKind::Name(_) | ValueKind::Missing => {}
    }
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
