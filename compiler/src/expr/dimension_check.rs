//! Checks the dimension of a value, and builds the help for a mismatch.

use dsl::tree::{BinaryOp, Unit, Value, ValueKind};
use dsl::{Diagnostic, Fix, Span, Spanned, Topic};
use stdlib_tasks::dimension::{Dimension, NONE, RATE, TIME};

use crate::expr::{Graph, Kind, Typed, bracketed};
use crate::units;

/// Checks that a value has a dimension. Returns an error for another dimension, and a warning for a bare number that is
/// read as an angle; in all other dimensions a bare number is in SI. `what` is the parameter in backquotes, or empty.
pub fn check_dimension(graph: &Graph, typed: &Typed, wanted: Dimension, what: &str) -> Option<Diagnostic> {
    let zero = typed.nodes.iter().all(|&n| graph.constant(n) == Some(0.0));
    if matches!(typed.kind, Kind::Rotation | Kind::Pose)
        || wanted == typed.dimension
        || (zero && typed.dimension == NONE)
    {
        return None;
    }
    if typed.bare {
        return (wanted.rad != 0).then(|| bare_angle(graph, typed, wanted));
    }
    if wanted.accepts(typed.dimension) { None } else { Some(wrong_dimension(typed, wanted, what)) }
}

/// Diagnostic for a value of a wrong dimension. `what` is the parameter in backquotes, or empty.
pub fn wrong_dimension(typed: &Typed, wanted: Dimension, what: &str) -> Diagnostic {
    let (is, needed) = (typed.dimension.describe(), wanted.describe());
    let message = if what.is_empty() {
        format!("{needed} is needed here, and this is {is}")
    } else {
        format!("{what} is {needed}, and this is {is}")
    };
    let d = Diagnostic::error("HQ0301", typed.span, message).about(Topic::Dimension).here(is);
    let unit = units::written(wanted);
    if wanted == NONE {
        d.help("leave the unit out, or divide by a value of the same unit")
    } else if typed.dimension == NONE {
        d.help(format!("give it a unit, such as `{unit}`")).fix(Fix::unit(typed.span, unit.as_ref()))
    } else if wanted == RATE && typed.dimension == TIME {
        d.help("a time T is the rate 1/T: write `100 Hz` for 10 ms")
    } else {
        d.help(format!("write a number in `{unit}`"))
    }
}

/// Help for a wrong dimension that a misplaced unit explains: a unit that belongs to a divisor alone, or two units of which one
/// is enough.
pub fn misplaced_unit(value: &Value, wanted: Dimension) -> Option<String> {
    unit_of_divisor(value, wanted).or_else(|| doubled_unit(value, wanted))
}

/// Help for `[0, 0, 5 cm] m`, in which two units are multiplied, if either would have the right dimension.
fn doubled_unit(value: &Value, wanted: Dimension) -> Option<String> {
    let ValueKind::Unit(inner, outer) = &value.kind else { return None };
    let items = match &inner.kind {
        ValueKind::List(items) => items.as_slice(),
        _ => std::slice::from_ref(&**inner),
    };
    let own = items.iter().find_map(own_unit)?;
    let fits = |unit: &Unit| units::meaning(unit).is_ok_and(|(_, dimension)| wanted.accepts(dimension));
    (wanted != NONE && !units::is_assumed(outer) && fits(own) && fits(outer))
        .then(|| format!("the units `{own}` and `{outer}` are multiplied: leave out one of the two"))
}

/// The unit that one number of a list has and another has not, as in `[0.4, 0, 500 mm]`.
pub(crate) fn unit_of_some(items: &[Value]) -> Option<&Unit> {
    items.iter().any(|item| own_unit(item).is_none()).then(|| items.iter().find_map(own_unit))?
}

/// The unit of `5 cm` or `-5 cm`.
fn own_unit(value: &Value) -> Option<&Unit> {
    match &value.kind {
        ValueKind::Unit(_, unit) => Some(unit),
        ValueKind::Negate(inner) => own_unit(inner),
        _ => None,
    }
}

/// Help for `1/2 m`, in which the unit belongs to the 2 alone, if a unit for the whole would have the right dimension.
fn unit_of_divisor(value: &Value, wanted: Dimension) -> Option<String> {
    if let ValueKind::Negate(inner) = &value.kind {
        return unit_of_divisor(inner, wanted);
    }
    let ValueKind::Binary(op, left, right) = &value.kind else { return None };
    let ValueKind::Unit(_, unit) = &right.kind else { return None };
    let (_, dimension) = units::meaning(unit).ok()?;
    let fits = op.value == BinaryOp::Div && wanted.accepts(dimension) && wanted != NONE;
    let meant = bracketed(op.value, left, right).filter(|_| fits)?;
    Some(format!("a unit belongs to the number before it: write `{meant}`"))
}

/// Merges the errors of all items of a list into one, if the unit behind the list is wrong.
pub fn one_unit(diagnostics: &mut Vec<Diagnostic>, before: usize, value: &Value, items: usize) {
    let new = diagnostics.get_mut(before..).unwrap_or_default();
    let all = items == new.len() && new.iter().all(|d| d.topic == Topic::Dimension && d.message == new[0].message);
    if let (ValueKind::Unit(..), true, Some(first)) = (&value.kind, all, new.first_mut()) {
        first.primary.span = value.span;
        diagnostics.truncate(before + 1);
    }
}

/// Warning for a bare number that is read as an angle; with a note if it is more than a turn.
pub fn bare_angle(graph: &Graph, typed: &Typed, wanted: Dimension) -> Diagnostic {
    let unit = units::written(wanted);
    let degrees = unit.replacen("rad", "deg", 1);
    let largest = typed.nodes.iter().filter_map(|&n| graph.constant(n)).fold(0.0_f64, |a, x| a.max(x.abs()));
    let turns = largest / (2.0 * std::f64::consts::PI);
    if turns > 1.0 {
        Diagnostic::warning("HQ0305", typed.span, format!("without a unit this is read as {largest} {unit}"))
            .here(format!("{turns:.1} turns{}", unit.trim_start_matches("rad")))
            .about(Topic::BareAngle)
            .note("angles without a unit are radians, and this one looks like degrees")
            .help(format!("write `{degrees}` after it, or `{unit}` for radians"))
            .fix(Fix::unit(typed.span, &degrees))
            .fix(Fix::unit(typed.span, &unit))
    } else {
        Diagnostic::warning("HQ0305", typed.span, format!("without a unit this is read as `{unit}`"))
            .about(Topic::BareAngle)
            .help(format!("write `{unit}` after it, or `{degrees}` for degrees"))
            .fix(Fix::unit(typed.span, &unit))
            .fix(Fix::unit(typed.span, &degrees))
    }
}

/// Merges the warnings of bare angles since `from` into one, because several in one list or call are one slip.
pub fn merge_bare(diagnostics: &mut Vec<Diagnostic>, from: usize, span: Span) {
    let mut bare: Vec<Diagnostic> = diagnostics.extract_if(from.., |d| d.topic == Topic::BareAngle).collect();
    let most = bare.iter().position(|d| !d.notes.is_empty()).unwrap_or(0);
    if bare.len() > 1 {
        let mut one = bare.swap_remove(most);
        one.primary.span = span;
        one.message = one.message.replace("without a unit this is", "without a unit these numbers are");
        if let Some((start, rest)) = one.message.split_once("read as ").filter(|_| !one.notes.is_empty()) {
            one.message = format!("{start}read as radians, one of them as {rest}");
        }
        one.help = one.help.map(|h| h.replace("after it", "after them").into());
        one.fixes.clear();
        diagnostics.push(one);
    } else {
        diagnostics.append(&mut bare);
    }
}

/// Checks that a value from the command line can replace a parameter's own.
pub(crate) fn replaces(graph: &Graph, new: &Typed, own: &Typed, name: &Spanned<String>) -> Option<Diagnostic> {
    let what = format!("`{}`", name.value);
    let d = if new.kind != own.kind {
        let text = format!("{what} is {}, and this is {}", own.kind.describe(), new.kind.describe());
        Some(Diagnostic::error("HQ0304", new.span, text))
    } else if own.bare {
        None
    } else {
        check_dimension(graph, new, own.dimension, &what)
    };
    d.map(|d| d.label(name.span, "declared here"))
}
