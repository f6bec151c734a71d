//! Units: symbols with their factor to SI and their dimension.

use dsl::tree::{Unit, Value, ValueKind};
use stdlib_tasks::dimension::{ANGLE, Dimension, LENGTH, MASS, NONE, TIME};

const fn dim(m: i8, kg: i8, s: i8) -> Dimension {
    Dimension { m, kg, s, rad: 0 }
}

/// Symbol, factor to SI, and dimension of each unit.
static UNITS: &[(&str, f64, Dimension)] = &[
    ("m", 1.0, LENGTH),
    ("km", 1e3, LENGTH),
    ("cm", 1e-2, LENGTH),
    ("mm", 1e-3, LENGTH),
    ("um", 1e-6, LENGTH),
    ("rad", 1.0, ANGLE),
    ("mrad", 1e-3, ANGLE),
    ("deg", std::f64::consts::PI / 180.0, ANGLE),
    ("turn", 2.0 * std::f64::consts::PI, ANGLE),
    ("s", 1.0, TIME),
    ("ms", 1e-3, TIME),
    ("us", 1e-6, TIME),
    ("min", 60.0, TIME),
    ("h", 3600.0, TIME),
    ("Hz", 1.0, Dimension { s: -1, ..NONE }),
    ("kHz", 1e3, Dimension { s: -1, ..NONE }),
    ("rpm", 2.0 * std::f64::consts::PI / 60.0, Dimension { s: -1, rad: 1, ..NONE }),
    ("kg", 1.0, MASS),
    ("g", 1e-3, MASS),
    ("N", 1.0, dim(1, 1, -2)),
    ("kN", 1e3, dim(1, 1, -2)),
    ("mN", 1e-3, dim(1, 1, -2)),
    ("Nm", 1.0, dim(2, 1, -2)),
    ("J", 1.0, dim(2, 1, -2)),
    ("W", 1.0, dim(2, 1, -3)),
];

/// Error of a unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum UnitError {
    /// Unknown symbol.
    Unknown(String),
    /// The exponents are too large.
    TooLarge,
}

/// Symbol that marks the unit assumed for a bare number. Users cannot write it.
const ASSUMED: &str = "@";

/// Applies the SI unit of a dimension to a value, which counts only if the value is a bare number.
pub fn assume(value: Value, dimension: Dimension) -> Value {
    let Dimension { m, kg, s, rad } = dimension;
    let powers = [(ASSUMED, 1), ("m", m), ("kg", kg), ("s", s), ("rad", rad)];
    let factors = powers.iter().filter(|p| p.1 != 0).map(|p| (p.0.to_string(), i32::from(p.1))).collect();
    let span = value.span;
    Value { kind: ValueKind::Unit(Box::new(value), Unit { factors, span }), span }
}

/// True for the assumed unit of [`assume`].
pub fn is_assumed(unit: &Unit) -> bool {
    unit.factors.iter().any(|f| f.0 == ASSUMED)
}

/// Returns a value as written, without the unit of [`assume`].
pub fn as_written(value: &Value) -> &Value {
    match &value.kind {
        ValueKind::Unit(of, unit) if is_assumed(unit) => of,
        _ => value,
    }
}

/// Returns the factor to SI and the dimension of a product of powers.
///
/// # Errors
/// A symbol is unknown, or an exponent is too large.
pub fn meaning(unit: &Unit) -> Result<(f64, Dimension), UnitError> {
    let (mut factor, mut dimension) = (1.0, NONE);
    for (symbol, exponent) in unit.factors.iter().filter(|f| f.0 != ASSUMED) {
        let Some((_, f, d)) = UNITS.iter().find(|u| u.0 == symbol) else {
            return Err(UnitError::Unknown(symbol.clone()));
        };
        factor *= f.powi(*exponent);
        let power = d.power(*exponent).ok_or(UnitError::TooLarge)?;
        dimension = dimension.times(power).ok_or(UnitError::TooLarge)?;
    }
    if factor.is_finite() && factor > 0.0 { Ok((factor, dimension)) } else { Err(UnitError::TooLarge) }
}

/// Factor from a unit of time to seconds; 1 without a unit.
pub fn time(symbol: &str) -> Option<f64> {
    if symbol.is_empty() {
        return Some(1.0);
    }
    UNITS.iter().find(|u| u.0 == symbol && u.2 == TIME).map(|u| u.1)
}

/// SI unit of a dimension in the syntax of a spec: `m`, `/s`, `rad/s`, `N`; empty for a bare number.
pub fn written(dimension: Dimension) -> String {
    let named = UNITS.iter().find(|u| u.2 == dimension && u.1 == 1.0 && u.0 != "Hz");
    match named {
        Some((symbol, ..)) => (*symbol).to_string(),
        None if dimension == NONE => String::new(),
        None => dimension.to_string().trim_start_matches('1').to_string(),
    }
}

/// Formats a number in SI with its unit, to six digits; angles in degrees too, as most users write them.
pub fn shown(x: f64, dimension: Dimension) -> String {
    let unit = written(dimension);
    let behind =
        |x: f64, unit: &str| format!("{}{}{unit}", runtime::text::number(x), if unit.is_empty() { "" } else { " " });
    if dimension.rad == 1 && x != 0.0 && unit.starts_with("rad") {
        let degrees = behind(rounded(x.to_degrees()), &unit.replacen("rad", "deg", 1));
        format!("{degrees} ({})", behind(x, &unit))
    } else {
        behind(x, &unit)
    }
}

/// Formats a range in SI with its unit; angles in degrees too.
pub fn shown_range(low: f64, high: f64, dimension: Dimension) -> String {
    let unit = written(dimension);
    let of = |f: fn(f64) -> f64| format!("{} to {}", runtime::text::number(f(low)), runtime::text::number(f(high)));
    match (unit.as_str(), dimension.rad) {
        ("", _) => of(|x| x),
        (_, 1) if unit.starts_with("rad") => {
            let degrees = unit.replacen("rad", "deg", 1);
            format!("{} {degrees} ({} {unit})", of(|x| rounded(x.to_degrees())), of(|x| x))
        }
        _ => format!("{} {unit}", of(|x| x)),
    }
}

/// Removes the rounding error of the conversion to degrees: `179.999999` for 180.
fn rounded(x: f64) -> f64 {
    if x.abs() < 1e9 { (x * 1e4).round() / 1e4 } else { x }
}

/// Symbols of all units.
pub fn symbols() -> impl Iterator<Item = &'static str> {
    UNITS.iter().map(|u| u.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_readers_know_the_same_symbols() {
        let mut ours: Vec<&str> = symbols().collect();
        let mut theirs: Vec<&str> = dsl::vocabulary::UNITS.to_vec();
        ours.sort_unstable();
        theirs.sort_unstable();
        assert_eq!(ours, theirs);
    }

    #[test]
    fn products_of_powers() {
        let unit = |f: &[(&str, i32)]| Unit {
            factors: f.iter().map(|(s, e)| ((*s).to_string(), *e)).collect(),
            span: dsl::Span::default(),
        };
        let (f, d) = meaning(&unit(&[("N", 1), ("s", 1), ("m", -1)])).unwrap();
        assert_eq!((f, d), (1.0, dim(0, 1, -1)));
        let (f, d) = meaning(&unit(&[("deg", 1), ("ms", -1)])).unwrap();
        assert!((f - std::f64::consts::PI / 180.0 * 1e3).abs() < 1e-12);
        assert_eq!(d.to_string(), "rad/s");
        assert!(meaning(&unit(&[("km", 200)])).is_err());
    }
}
