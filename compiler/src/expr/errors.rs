//! Diagnostics that are common to several kinds of expressions.

use dsl::{Diagnostic, Span};

use super::{Kind, Typed};
use crate::units::{self, UnitError};

/// Diagnostic for an invalid unit.
pub(crate) fn unit_error(error: &UnitError, span: Span) -> Diagnostic {
    match error {
        UnitError::Unknown(symbol) => {
            let d = Diagnostic::error("HQ0303", span, format!("there is no unit `{symbol}`"));
            d.help("`hierarq explain HQ0303` lists the units").nearest(symbol, units::symbols())
        }
        UnitError::TooLarge => {
            Diagnostic::error("HQ0303", span, "the exponents of this unit are beyond anything meant")
                .help("exponents go from -127 to 127; check the powers")
        }
    }
}

/// Diagnostic for two values of different dimensions that should have the same.
pub(crate) fn different(a: &Typed, b: &Typed, why: &str, span: Span) -> Diagnostic {
    let what = |x: &Typed| {
        if x.kind == Kind::Scalar {
            x.dimension.describe()
        } else {
            format!("{} ({})", x.kind.describe(), x.dimension.describe())
        }
    };
    Diagnostic::error("HQ0302", span, format!("{} and {} do not go together", what(a), what(b)))
        .label(a.span, what(a))
        .label(b.span, what(b))
        .note(why)
}
