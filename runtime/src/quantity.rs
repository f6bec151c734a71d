//! Quantities as text for people: three significant digits, an SI prefix that fits, angles in degrees.

/// Magnitude below which an SI value counts as the rounding error of a zero.
const NOISE: f64 = 1e-12;

/// Formats a number in an SI unit: `3.10 mm`, `0.250 m`, `8.69 um`, `45.0 deg`, `2.30 mdeg/s`. A number that is not
/// finite is `-`; the rounding error of a zero is `0` with its unit.
pub fn quantity(x: f64, unit: &str) -> String {
    if !x.is_finite() {
        return "-".to_string();
    }
    let unit = if unit == "1" { "" } else { unit };
    let (x, unit) = match unit.strip_prefix("rad") {
        Some("") if x.abs() >= NOISE => (x.to_degrees(), "deg".to_string()),
        Some("/s") if x.abs() >= NOISE => (x.to_degrees(), "deg/s".to_string()),
        Some("") => (0.0, "deg".to_string()),
        Some("/s") => (0.0, "deg/s".to_string()),
        _ => (x, unit.to_string()),
    };
    if x.abs() < NOISE {
        return format!("0 {unit}").trim_end().to_string();
    }
    let prefixed = ["m", "m/s", "deg", "deg/s", "s"].contains(&unit.as_str());
    if !prefixed {
        return format!("{} {unit}", digits(x)).trim_end().to_string();
    }
    // 0.35 m reads better than 350 mm: the plain unit is used from a tenth on. Prefixes are chosen by the rounded
    // value.
    let a = rounded(x).abs();
    let prefixes = [(0.1, "", 1.0), (1e-3, "m", 1e3), (1e-6, "u", 1e6), (1e-9, "n", 1e9)];
    let (_, prefix, factor) = prefixes.into_iter().find(|p| a >= p.0).unwrap_or((0.0, "p", 1e12));
    format!("{} {prefix}{unit}", significant(rounded(x) * factor))
}

/// Rounds to three significant digits.
fn rounded(x: f64) -> f64 {
    format!("{x:.2e}").parse().unwrap_or(x)
}

/// Formats three significant digits, without an exponent: `0.350`, `8.69`, `123`.
fn significant(x: f64) -> String {
    let x = rounded(x);
    let magnitude = if x == 0.0 { 0.0 } else { x.abs().log10().floor() };
    let decimals = (2.0 - magnitude).clamp(0.0, 12.0) as usize;
    format!("{x:.decimals$}")
}

/// Formats a number whose unit takes no prefix, with an exponent if it is very small or very large.
fn digits(x: f64) -> String {
    if (1e-3..1e6).contains(&x.abs()) { significant(x) } else { format!("{x:.2e}") }
}

#[cfg(test)]
mod tests {
    use super::quantity;

    #[test]
    fn quantities_read_well() {
        assert_eq!(quantity(0.0031, "m"), "3.10 mm");
        assert_eq!(quantity(-0.25, "m"), "-0.250 m");
        assert_eq!(quantity(2e-5, "m"), "20.0 um");
        assert_eq!(quantity(8.694e-6, "m"), "8.69 um");
        assert_eq!(quantity(5e-7, "m"), "500 nm");
        assert_eq!(quantity(3e-12, "m"), "3.00 pm");
        assert_eq!(quantity(0.0999996, "m"), "0.100 m");
        assert_eq!(quantity(9.996e-4, "m"), "1.00 mm");
        assert_eq!(quantity(12.345, "m"), "12.3 m");
        assert_eq!(quantity(0.0421, "m/s"), "42.1 mm/s");
        assert_eq!(quantity(1234.5, "m"), "1230 m");
        assert_eq!(quantity(std::f64::consts::PI, "rad"), "180 deg");
        assert_eq!(quantity(1e-10, "rad"), "5.73 ndeg");
        assert_eq!(quantity(1e-5, "rad"), "573 udeg");
        assert_eq!(quantity(1e-3, "rad"), "57.3 mdeg");
        assert_eq!(quantity(-0.5, "rad/s"), "-28.6 deg/s");
        assert_eq!(quantity(0.5, "rad or m"), "0.500 rad or m");
        assert_eq!(quantity(5e-7, "rad or m"), "5.00e-7 rad or m");
        assert_eq!(quantity(0.25, ""), "0.250");
        assert_eq!(quantity(0.25, "1"), "0.250");
        assert_eq!(quantity(-1e-17, "m"), "0 m");
        assert_eq!(quantity(0.0, "rad"), "0 deg");
        assert_eq!(quantity(f64::NAN, "m"), "-");
        assert_eq!(quantity(f64::INFINITY, "rad"), "-");
    }

    #[test]
    fn what_is_shown_is_what_is_there() {
        let factors = [("p", 1e-12), ("n", 1e-9), ("u", 1e-6), ("m", 1e-3), ("", 1.0)];
        for k in 0..240 {
            let x = 1.01e-11 * 1.17_f64.powi(k);
            let text = quantity(x, "m");
            let (number, unit) = text.split_once(' ').unwrap();
            let factor = factors.iter().find(|f| format!("{}m", f.0) == unit).unwrap().1;
            let shown = number.parse::<f64>().unwrap() * factor;
            assert!((shown / x - 1.0).abs() <= 0.005 + 1e-9, "{x} is shown as {text}");
        }
    }
}
