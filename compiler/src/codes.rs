//! The compiler's diagnostic codes with their pages for `hierarq explain`, and messages that several places share.
//!
//! Families: `HQ01` form (in `dsl`), `HQ02` names, `HQ03` types and units, `HQ04` robot, `HQ05` safety,
//! `HQ06` hierarchy and run.

use dsl::{Diagnostic, Span};

use crate::expr::Typed;
use crate::units::{self, UnitError};

/// Code, title, explanation in Markdown.
pub static CODES: &[(&str, &str, &str)] = &[
    (
        "HQ0201",
        "unknown name",
        "Nothing of this name was declared, or the robot has no such link or joint.\n\nA controller that silently ignored the name would run without the task, limit or frame that you meant.\n\n```hq\nlevel motion { reech }   // error: no task `reech`; did you mean `reach`?\n```",
    ),
    (
        "HQ0202",
        "declared twice",
        "Two declarations share a name, and it would be unclear which one a stack means. Rename one of them.",
    ),
    (
        "HQ0203",
        "never used",
        "A declaration that nothing uses usually means that a stack forgot it. A forgotten safety task is not a small thing: add it to a level, or remove it.",
    ),
    ("HQ0204", "unknown task type", "The task library has no type of this name. `hierarq tasks` lists all types."),
    (
        "HQ0205",
        "unknown parameter",
        "This key has no meaning here. `hierarq tasks TYPE` shows the parameters of a task type; the language reference those of other blocks.",
    ),
    ("HQ0206", "missing parameter", "A parameter that has no default was left out. Nothing is guessed: write it."),
    ("HQ0207", "given twice", "The same parameter or joint is given in two places, and they might disagree. Keep one."),
    (
        "HQ0301",
        "wrong unit",
        "The value has another physical dimension than the parameter. Units are checked so that a length in place of a rate, or degrees in place of metres, is found before anything moves.\n\n```hq\ngain 5 cm   // error: a length, and a rate is needed: write 5 /s\n```",
    ),
    (
        "HQ0302",
        "unlike quantities",
        "Only quantities of one dimension can be added, compared or stand in one vector. Adding metres to radians has no meaning.",
    ),
    (
        "HQ0303",
        "unknown unit",
        "The unit is none that the language knows. Lengths: m, cm, mm, um, km. Angles: rad, mrad, deg, turn. Times: s, ms, us, min, h. Rates: Hz, kHz, rpm, /s. Masses: kg, g. Forces and torques: N, kN, mN, Nm.",
    ),
    (
        "HQ0304",
        "wrong type",
        "A value of another type is needed here: a number, a vector `[x, y, z]`, an orientation such as `rpy(..)`, a name, a list, or a block in braces.",
    ),
    (
        "HQ0305",
        "bare number for an angle",
        "The number is read as radians. Degrees that are taken for radians are a classic: 45 instead of 0.785. Write the unit, `0.5 rad` or `30 deg`, and the doubt is gone. This is a warning.",
    ),
    (
        "HQ0306",
        "wrong argument",
        "A function was given something that it is not defined for, such as the sine of a length.",
    ),
    (
        "HQ0307",
        "must not move",
        "This value is needed before the robot starts and cannot depend on time or on captured values.",
    ),
    (
        "HQ0308",
        "out of range",
        "The value lies outside the range that has a meaning, such as a negative distance or a gain of zero.",
    ),
    (
        "HQ0309",
        "undefined value",
        "The expression has no value: a division by zero, the root of a negative number, a result that is not finite.",
    ),
    (
        "HQ0310",
        "wrong number of values",
        "A list has too few or too many values, or a function was given the wrong number of arguments.",
    ),
    (
        "HQ0311",
        "nothing to capture",
        "`initial(..)` captures a value at the moment the stack becomes active: `frame(LINK).position`, `frame(LINK).orientation`, `joint(NAME)`, or a value of the task itself, named like the parameter that it is the target of, such as `initial(position)` or `initial(absolute.position)`.",
    ),
    (
        "HQ0401",
        "file not found",
        "A file that the spec names cannot be read. Paths are relative to the file that names them.",
    ),
    ("HQ0402", "broken URDF", "The URDF cannot be used; the message points into the URDF itself."),
    (
        "HQ0403",
        "doubtful URDF",
        "The URDF loads, and something in it was ignored or is probably not meant. Limits that are missing, zero or absurd are never guessed: the joint counts as unlimited until the spec gives a limit.",
    ),
    ("HQ0404", "home outside limits", "The home configuration, where the robot starts, lies outside a joint's limits."),
    (
        "HQ0405",
        "joint not at home",
        "The home configuration leaves out joints that move. They start at zero, or at the limit nearest to it.",
    ),
    (
        "HQ0501",
        "overshoots in one step",
        "A gain K with control period T moves the error by `K T` of itself in one tick. Above 1 it overshoots, above 2 it diverges; a barrier function is broken already above 1 (mathematics, sampled time). Lower the gain or raise the rate.",
    ),
    (
        "HQ0502",
        "starts outside the safe set",
        "At the home configuration a limit is already violated, so no barrier function can promise anything. Move the home configuration or the limit.",
    ),
    (
        "HQ0503",
        "cannot be built",
        "The parameters of the task are each well formed but make no sense together, such as three points on one line that should span a plane.",
    ),
    (
        "HQ0504",
        "hard limits not met at the start",
        "A hard level has no solution at the home configuration, so the very first tick would be a fault.",
    ),
    ("HQ0601", "empty", "A stack without levels, or a level without tasks, asks for nothing."),
    (
        "HQ0602",
        "task twice in a stack",
        "The task already stands in this stack. At the lower place it would only repeat what the higher one has settled.",
    ),
    (
        "HQ0603",
        "no run",
        "The spec declares no `run`, so `hierarq run` has nothing to do. `hierarq check` and `compile` need none if there is exactly one stack.",
    ),
    (
        "HQ0604",
        "no freedom left",
        "The levels above leave no degree of freedom for this level at the home configuration: its tasks will never have any influence there. Lower the demands above, or unlock joints.",
    ),
    ("HQ0605", "more than a run can be", "The run has more ticks than the tool will count."),
    (
        "HQ0606",
        "soft level above a hard one",
        "A hard level that stands below a soft one must live with whatever the soft one has taken; it can become infeasible through it, which is a fault. Put hard levels first.",
    ),
    (
        "HQ0607",
        "not a compiled program",
        "The file is not a program as `hierarq compile --format json` writes it, or it was written by another version, or edited in a way that makes no sense. Compile the spec again.",
    ),
];

/// The page of a code of any family.
pub fn explain(code: &str) -> Option<(&'static str, &'static str)> {
    let all = CODES.iter().chain(dsl::codes::CODES);
    all.clone().find(|c| c.0.eq_ignore_ascii_case(code)).map(|c| (c.1, c.2))
}

/// All codes of all families, in order.
pub fn all() -> impl Iterator<Item = &'static (&'static str, &'static str, &'static str)> {
    dsl::codes::CODES.iter().chain(CODES)
}

/// A unit has no meaning.
pub fn unit_error(error: &UnitError, span: Span) -> Diagnostic {
    match error {
        UnitError::Unknown(symbol) => {
            let d = Diagnostic::error("HQ0303", span, format!("there is no unit `{symbol}`"));
            match crate::names::suggest(symbol, units::symbols()) {
                Some(near) => d.help(format!("did you mean `{near}`?")),
                None => d.help("`hierarq explain HQ0303` lists the units"),
            }
        }
        UnitError::TooLarge => {
            Diagnostic::error("HQ0303", span, "the exponents of this unit are beyond anything meant")
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
