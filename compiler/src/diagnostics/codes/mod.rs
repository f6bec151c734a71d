//! The compiler's diagnostic codes with their pages for `hierarq explain`, and messages that several places share.
//!
//! Families: `HQ01` form (in `dsl`), `HQ02` names, `HQ03` types and units, `HQ04` robot, `HQ05` safety,
//! `HQ06` hierarchy and run, `HQ07` machines, `HQ08` scenarios, `HQ09` missions. Their pages are the `*.md` files beside this one;
//! [`dsl::codes`] says how they are read.

use std::sync::LazyLock;

use dsl::codes::read;
pub use dsl::codes::{Page, Part};
use dsl::{Diagnostic, Span};
use stdlib_tasks::task::Nature;

use crate::expr::Typed;
use crate::units::{self, UnitError};

/// The pages of this crate, in rising order of their codes.
pub static PAGES: LazyLock<Vec<Page>> = LazyLock::new(|| {
    let families = [
        include_str!("names.md"),
        include_str!("types.md"),
        include_str!("robot.md"),
        include_str!("safety.md"),
        include_str!("hierarchy.md"),
        include_str!("machine.md"),
        include_str!("scenarios.md"),
        include_str!("missions.md"),
        include_str!("mission_scenarios.md"),
        include_str!("mission_workers.md"),
    ];
    families.into_iter().flat_map(read).collect()
});

/// The robot of the examples that show none, in the native spelling.
pub const EXAMPLE_ROBOT: &str = include_str!("robot.hq");

/// The same robot in YAML.
pub const EXAMPLE_ROBOT_YAML: &str = include_str!("robot.yaml");

/// A gain that overshoots within one control period, `(its length in s, where it was written)`.
pub(crate) fn overshoot(at: Span, gain: f64, period: (f64, Span), nature: Nature) -> Diagnostic {
    let why = if nature == Nature::Limit {
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

/// The page of a code of any family, whatever the case of its letters.
pub fn explain(code: &str) -> Option<Page> {
    all().find(|p| p.code.eq_ignore_ascii_case(code)).copied()
}

/// The pages of all families, in order.
pub fn all() -> impl Iterator<Item = &'static Page> {
    dsl::codes::PAGES.iter().chain(PAGES.iter())
}

/// A unit has no meaning.
pub fn unit_error(error: &UnitError, span: Span) -> Diagnostic {
    match error {
        UnitError::Unknown(symbol) => {
            let d = Diagnostic::error("HQ0303", span, format!("there is no unit `{symbol}`"));
            match crate::diagnostics::names::suggest(symbol, units::symbols()) {
                Some(near) => d.help(format!("did you mean `{near}`?")),
                None => d.help("`hierarq explain HQ0303` lists the units"),
            }
        }
        UnitError::TooLarge => {
            Diagnostic::error("HQ0303", span, "the exponents of this unit are beyond anything meant")
                .help("exponents go from -127 to 127; check the powers")
        }
    }
}

/// Two values that should have one dimension do not.
pub fn different(a: &Typed, b: &Typed, why: &str, span: Span) -> Diagnostic {
    let what = |x: &Typed| {
        if x.kind == crate::expr::Kind::Scalar {
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
