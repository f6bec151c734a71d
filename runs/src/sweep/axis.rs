//! Parses the values of `--vary`, and draws values.

use twox_hash::XxHash3_64;

/// Maximum number of values of one param in `A..B:N`.
pub const MAX_SPREAD: usize = 100_000;

/// A varied param. Values are texts of the language, as for `--set`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Axis {
    /// Name of the param.
    pub name: String,
    /// Text after the name.
    pub written: String,
    /// Values.
    pub values: Values,
}

/// Values of a varied param.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Values {
    /// `A..B`: a new value in each run, uniformly distributed.
    Drawn(String, String),
    /// `A..B:N`: N values in equal steps from A to B.
    Spread(String, String, usize),
    /// `A,B,C`: exactly these values.
    Listed(Vec<String>),
}

impl Values {
    /// Texts of the values, each of which must be valid for the param.
    pub fn texts(&self) -> Vec<&str> {
        match self {
            Values::Drawn(low, high) | Values::Spread(low, high, _) => vec![low, high],
            Values::Listed(all) => all.iter().map(String::as_str).collect(),
        }
    }
}

/// Parses `A..B`, `A..B:N` or `A,B,C` for a param.
///
/// # Errors
/// The text has another form; the message describes the valid ones.
pub fn axis(name: &str, written: &str) -> Result<Axis, String> {
    let text = |t: &str| match t.trim() {
        "" => Err(format!("`{name}={written}` lacks a value: write `A..B`, `A..B:N` or `A,B,C`")),
        t => Ok(t.to_string()),
    };
    let values = match written.split_once("..") {
        Some((low, rest)) => match rest.split_once(':') {
            Some((high, count)) => {
                let steps = count.trim().parse().ok().filter(|n| (2..=MAX_SPREAD).contains(n));
                let steps = steps.ok_or_else(|| {
                    let count = count.trim();
                    format!("`{count}` is no number of values from 2 to {MAX_SPREAD}: write for instance `A..B:11`")
                })?;
                Values::Spread(text(low)?, text(high)?, steps)
            }
            None => Values::Drawn(text(low)?, text(rest)?),
        },
        None => Values::Listed(items(written).into_iter().map(text).collect::<Result<_, _>>()?),
    };
    Ok(Axis { name: name.to_string(), written: written.to_string(), values })
}

/// Splits a list at commas outside of brackets.
fn items(text: &str) -> Vec<&str> {
    let (mut depth, mut from, mut all) = (0_i32, 0, Vec::new());
    for (i, c) in text.char_indices() {
        match c {
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth -= 1,
            ',' if depth == 0 => {
                all.push(&text[from..i]);
                from = i + 1;
            }
            _ => {}
        }
    }
    all.push(&text[from..]);
    all
}

/// Draws a uniformly distributed number for a param. The result depends only on the arguments.
pub fn drawn(seed: u64, name: &str, low: f64, high: f64) -> f64 {
    // Upper 53 of 64 hashed bits, as a fraction below 1.
    let share = (XxHash3_64::oneshot_with_seed(seed, name.as_bytes()) >> 11) as f64 / (1_u64 << 53) as f64;
    between(low, high, share)
}

/// Number `i` of `count` equidistant numbers; `count` is at least two.
pub fn spread(low: f64, high: f64, i: usize, count: usize) -> f64 {
    if i + 1 == count { high } else { between(low, high, i as f64 / (count - 1) as f64) }
}

fn between(low: f64, high: f64, share: f64) -> f64 {
    // This form cannot overflow, and the clamp removes rounding errors.
    (low * (1.0 - share) + high * share).clamp(low, high)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(written: &str) -> Result<Values, String> {
        axis("x", written).map(|a| a.values)
    }

    #[test]
    fn ranges_steps_and_lists() {
        let s = |t: &str| t.to_string();
        assert_eq!(values("0.1m..0.3 m"), Ok(Values::Drawn(s("0.1m"), s("0.3 m"))));
        assert_eq!(values("-1..1:5"), Ok(Values::Spread(s("-1"), s("1"), 5)));
        assert_eq!(values("1, 2,5"), Ok(Values::Listed(vec![s("1"), s("2"), s("5")])));
        assert_eq!(values("7 cm"), Ok(Values::Listed(vec![s("7 cm")])));
        assert_eq!(values("[0, 0, 1] m,rpy(0, 0, 1)"), Ok(Values::Listed(vec![s("[0, 0, 1] m"), s("rpy(0, 0, 1)")])));
        for bad in ["", "1,,2", "..2", "1..", "1..2:", "1..2:1", "1..2:1e9", "1..2:x", ","] {
            assert!(values(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn drawn_numbers_are_even_and_know_nothing_of_each_other() {
        let n = 20_000_u64;
        let all = |name: &str| (0..n).map(|seed| drawn(seed, name, 0.0, 1.0)).collect::<Vec<f64>>();
        let (a, b) = (all("a"), all("approach"));
        for x in [&a, &b] {
            // Kolmogorov-Smirnov test: one in a thousand uniform samples exceeds 1.95/sqrt(n).
            let mut sorted = x.clone();
            sorted.sort_by(f64::total_cmp);
            let off = |(i, x): (usize, &f64)| (x - i as f64 / n as f64).abs();
            let most = sorted.iter().enumerate().map(off).fold(0.0, f64::max);
            assert!(most < 1.95 / (n as f64).sqrt(), "{most}");
        }
        let correlation = |a: &[f64], b: &[f64]| {
            let sum: f64 = a.iter().zip(b).map(|(a, b)| (a - 0.5) * (b - 0.5)).sum();
            12.0 * sum / a.len() as f64
        };
        let bound = 4.0 / (n as f64).sqrt();
        assert!(correlation(&a, &b).abs() < bound, "two params");
        assert!(correlation(&a[1..], &a[..a.len() - 1]).abs() < bound, "a seed and the next");
    }

    #[test]
    fn values_stay_inside_and_steps_meet_both_ends() {
        let (low, high) = (0.1, 0.3);
        assert!((0..5000).all(|s| (low..=high).contains(&drawn(s, "x", low, high))));
        assert_eq!(drawn(3, "x", 0.7, 0.7), 0.7);
        assert!(drawn(3, "x", -1.7e308, 1.7e308).is_finite());
        let steps: Vec<f64> = (0..5).map(|i| spread(-1.0, 1.0, i, 5)).collect();
        assert_eq!(steps, [-1.0, -0.5, 0.0, 0.5, 1.0]);
        assert_eq!((spread(low, high, 0, 3), spread(low, high, 2, 3)), (low, high));
    }
}
