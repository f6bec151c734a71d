//! Gains against the control period.

use dsl::{Diagnostic, Span};
use stdlib_tasks::task::RowKind;

/// Diagnostic for a gain that overshoots within one control period, given as `(length in s, span)`.
pub(crate) fn overshoot(at: Span, gain: f64, period: (f64, Span), row_kind: RowKind) -> Diagnostic {
    let why = if row_kind == RowKind::Inequality {
        "a barrier function is broken by a single step"
    } else {
        "the error changes its sign at every tick, and grows above 2"
    };
    let (period, rate) = period;
    Diagnostic::error("HQ0501", at, format!("this gain overshoots: {gain} /s times {period} s is {:.3}", gain * period))
        .here(format!("gain × period = {:.3}", gain * period))
        .label(rate, format!("a period of {period} s"))
        .note(format!("above 1, {why}"))
        .help(format!("keep the gain at or below {} /s, or raise the rate", 1.0 / period))
}
