//! Values of an unusual size: legal, and probably written in another unit than the one that was meant. The usual sizes are
//! a column of the tables of keys and parameters; this is the one check that reads it.

use dsl::tree::{Unit, Value, ValueKind};
use dsl::{Diagnostic, Fix, Topic};
use quantities::usual::TURN;
use stdlib_tasks::dimension::{Dimension, LENGTH, MASS, RATE, TIME, VELOCITY};
use stdlib_tasks::params::Quantity;

use crate::units;

/// Units that one is written for by mistake. Others, such as `um`, `turn` and `rpm`, are not written by accident.
static CONFUSED: &[&[&str]] = &[
    &["m", "mm", "cm", "km"],
    &["s", "ms", "us", "min", "h"],
    &["rad", "deg"],
    &["kg", "g"],
    &["N", "kN", "mN"],
    &["Hz", "kHz"],
];

/// Units that are not meant beside others: 5 km/s, 5 m/ms.
static ALONE: &[&str] = &["km", "ms", "us", "min", "h"];

/// Units of more than one symbol that are not a change of one of them.
static SPEEDS: &[&str] = &["km/h"];

/// Warns of a value whose size is unusual. `x` are its numbers, in SI, `subject` its name in a sentence.
pub(crate) fn unusual(value: &Value, subject: &str, x: &[f64], q: &Quantity) -> Option<Diagnostic> {
    let [least, greatest] = q.usual?;
    // Of a vector the largest number counts: the others may be small in any unit.
    let x = x.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs()))?;
    if q.is_usual(x) {
        return None;
    }
    let value = units::as_written(value);
    // A bare angle has a warning of its own.
    if q.dimension.rad == 1 && is_literal(value) {
        return None;
    }
    let hertz = q.dimension == RATE && in_hertz(value);
    let (size, usually) = match x.abs() > greatest {
        true => ("large", format!("usually at most {}", shown(greatest, q.dimension, hertz))),
        false => ("small", format!("usually at least {}", shown(least, q.dimension, hertz))),
    };
    let text = format!("{subject} of {} is unusually {size}", shown(x, q.dimension, hertz));
    let d = Diagnostic::warning("HQ0316", value.span, text).here(usually).about(Topic::UnusualSize);
    Some(match meant(value, x, q) {
        Some(Meant { unit, text, fix }) => {
            let d = d.help(format!("did you mean `{text}`? If not, nothing needs to be changed"));
            match fix {
                Some(fix) => d.fix(fix),
                None => d.note(format!("the unit `{unit}` would make it a usual value")),
            }
        }
        None => d.help("check the number and its unit; if both are meant, nothing needs to be changed"),
    })
}

/// Warns of an angle that is written as a number with a unit. A computed angle may be a phase, of any size.
pub(crate) fn unusual_angle(value: &Value, x: f64) -> Option<Diagnostic> {
    matches!(&value.kind, ValueKind::Unit(number, _) if is_literal(number))
        .then(|| unusual(value, "an angle", &[x], &TURN))
        .flatten()
}

/// A unit that was probably meant.
struct Meant {
    unit: String,
    /// The value with that unit.
    text: String,
    /// The change of the text, if the unit belongs to this value alone.
    fix: Option<Fix>,
}

/// Returns the unit that gives the written number the most usual size, if one does.
fn meant(value: &Value, x: f64, q: &Quantity) -> Option<Meant> {
    let (written, unit) = match &value.kind {
        ValueKind::Unit(inner, unit) => (inner.as_ref(), Some(unit)),
        ValueKind::Negate(inner) => match &inner.kind {
            ValueKind::Unit(number, unit) => (number.as_ref(), Some(unit)),
            _ => (value, None),
        },
        _ => (value, None),
    };
    if !is_literal(written) {
        return None;
    }
    let factors = match unit {
        Some(unit) => unit.factors.clone(),
        None => base(q.dimension)?.iter().map(|(s, p)| ((*s).to_string(), *p)).collect(),
    };
    let (factor, _) = units::meaning(&Unit { factors: factors.clone(), span: value.span }).ok()?;
    let number = x / factor;
    let [least, greatest] = q.usual?;
    // Ratio of a size to the middle of the usual ones.
    let distance = |x: f64| (x.abs().ln() - (least.ln() + greatest.ln()) / 2.0).abs();
    let span = unit.map_or(value.span, |unit| unit.span);
    let mut found: Vec<(f64, Unit)> = Vec::new();
    for factors in others(&factors, q.dimension) {
        let other = Unit { factors, span };
        let Ok((factor, dimension)) = units::meaning(&other) else { continue };
        let size = number * factor;
        if q.dimension.accepts(dimension) && q.contains(size) && q.is_usual(size) {
            found.push((distance(size), other));
        }
    }
    let (_, unit_meant) = found.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
    let spelt = unit_meant.to_string();
    let text = match &written.kind {
        ValueKind::List(_) => format!("[..] {spelt}"),
        _ => format!("{} {spelt}", runtime::text::number(number)),
    };
    let fix = match unit {
        None => Some(Fix::unit(value.span, &spelt)),
        // The unit behind a list belongs to all of its numbers.
        Some(unit) => (value.span.source == unit.span.source && value.span.end >= unit.span.end)
            .then(|| Fix::edit(format!("Write the unit `{spelt}`"), unit.span, spelt.clone())),
    };
    Some(Meant { unit: spelt, text, fix })
}

/// True for a number as it is written, or a list of such. What is computed has no unit of its own.
fn is_literal(value: &Value) -> bool {
    match &value.kind {
        ValueKind::Number(_) => true,
        ValueKind::Negate(inner) => is_literal(inner),
        ValueKind::List(items) => items.iter().all(is_literal),
        _ => false,
    }
}

/// Factors of the SI unit that a bare number has, for dimensions with a unit of their own.
fn base(dimension: Dimension) -> Option<&'static [(&'static str, i32)]> {
    match dimension {
        LENGTH => Some(&[("m", 1)]),
        TIME => Some(&[("s", 1)]),
        MASS => Some(&[("kg", 1)]),
        VELOCITY => Some(&[("m", 1), ("s", -1)]),
        _ => None,
    }
}

/// Units that differ in one symbol.
fn others(factors: &[(String, i32)], dimension: Dimension) -> Vec<Vec<(String, i32)>> {
    let mut out = Vec::new();
    for (i, (symbol, _)) in factors.iter().enumerate() {
        let Some(group) = CONFUSED.iter().find(|group| group.contains(&symbol.as_str())) else { continue };
        for other in group.iter().filter(|other| **other != symbol) {
            if factors.len() > 1 && ALONE.contains(other) {
                continue;
            }
            let mut changed = factors.to_vec();
            changed[i].0 = (*other).to_string();
            out.push(changed);
        }
    }
    if dimension == VELOCITY {
        let speed = |text: &&str| text.split_once('/').map(|(a, b)| vec![(a.to_string(), 1), (b.to_string(), -1)]);
        out.extend(SPEEDS.iter().filter_map(speed));
    }
    out
}

fn in_hertz(value: &Value) -> bool {
    match &value.kind {
        ValueKind::Unit(_, unit) => unit.factors.iter().any(|(symbol, _)| symbol.ends_with("Hz")),
        _ => false,
    }
}

fn shown(x: f64, dimension: Dimension, hertz: bool) -> String {
    if hertz { format!("{} Hz", runtime::text::number(x)) } else { units::shown(x, dimension) }
}
