//! Unit, range and default of a number or a key: the parts of a declaration that parameters of tasks and keys of blocks
//! have in common.

use crate::dimension::Dimension;

/// Unit and range of a scalar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    /// Its dimension.
    pub dimension: Dimension,
    /// The smallest value allowed.
    pub min: f64,
    /// True if `min` itself is allowed.
    pub min_included: bool,
    /// The largest value allowed.
    pub max: f64,
    /// True if the value must not move with time.
    pub constant: bool,
    /// Sizes that values usually have, the least and the greatest; `None` if any size is usual.
    pub usual: Option<[f64; 2]>,
}

/// Relative rounding error of a value that is converted from another unit.
const ROUNDING: f64 = 1e-9;

impl Quantity {
    /// Any finite value of a dimension.
    pub const fn any(dimension: Dimension) -> Self {
        Quantity {
            dimension,
            min: f64::NEG_INFINITY,
            min_included: true,
            max: f64::INFINITY,
            constant: false,
            usual: None,
        }
    }

    /// `min` or more.
    pub const fn at_least(dimension: Dimension, min: f64) -> Self {
        Quantity { min, ..Quantity::any(dimension) }
    }

    /// More than `min`.
    pub const fn above(dimension: Dimension, min: f64) -> Self {
        Quantity { min, min_included: false, ..Quantity::any(dimension) }
    }

    /// From `min` to `max`, both included.
    pub const fn between(dimension: Dimension, min: f64, max: f64) -> Self {
        Quantity { min, max, ..Quantity::any(dimension) }
    }

    /// The same quantity, which must not move with time.
    pub const fn constant(self) -> Self {
        Quantity { constant: true, ..self }
    }

    /// The same quantity, whose values are usually of a size from `least` to `greatest`, without regard to their sign.
    pub const fn usually(self, least: f64, greatest: f64) -> Self {
        Quantity { usual: Some([least, greatest]), ..self }
    }

    /// Returns true if a value has a usual size. Zero always has one: it turns off what the value belongs to.
    pub fn is_usual(&self, x: f64) -> bool {
        let Some([least, greatest]) = self.usual else { return true };
        x == 0.0 || (x.abs() >= least * (1.0 - ROUNDING) && x.abs() <= greatest * (1.0 + ROUNDING))
    }

    /// Describes the usual sizes in words, in SI; empty if any size is usual.
    pub fn describe_usual(&self) -> String {
        match self.usual {
            None => String::new(),
            Some([least, greatest]) => {
                // `1e-6` and not its six digits.
                let short = |x: f64| if x < 1e-4 { format!("{x:e}") } else { crate::number(x) };
                format!("usually {} to {}", short(least), short(greatest))
            }
        }
    }

    /// Returns true if the value is in the range. False for NaN.
    pub fn contains(&self, x: f64) -> bool {
        x.is_finite() && (x > self.min || (self.min_included && x == self.min)) && x <= self.max
    }

    /// Describes the range in words; empty if everything is allowed.
    pub fn describe(&self) -> String {
        match (self.min.is_finite(), self.max.is_finite()) {
            (false, false) => String::new(),
            (true, false) if self.min_included => format!("at least {}", self.min),
            (true, false) => format!("more than {}", self.min),
            (false, true) => format!("at most {}", self.max),
            // `9e15` and not its 16 digits.
            (true, true) if self.max.abs() >= 1e9 => format!("from {} to {:e}", self.min, self.max),
            (true, true) => format!("from {} to {}", self.min, self.max),
        }
    }
}

/// Treatment of a parameter that is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Presence {
    /// It must be written.
    Required,
    /// It may be absent.
    Optional,
    /// This text of the language replaces it. For a group it is `{}`, whose parameters have defaults of their own.
    Default(&'static str),
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dimension::TIME;

    #[test]
    fn usual_sizes_ignore_the_sign_and_rounding_errors() {
        let timeout = Quantity::any(TIME).usually(1e-3, 60.0);
        for x in [0.0, 1e-3, 0.2, -0.2, 60.0, 6.0e4 * 1e-3, 60.0 + 1e-9] {
            assert!(timeout.is_usual(x), "{x}");
        }
        for x in [9e-4, 61.0, -61.0, f64::NAN] {
            assert!(!timeout.is_usual(x), "{x}");
        }
        assert!(Quantity::any(TIME).is_usual(1e12));
        assert_eq!(timeout.describe_usual(), "usually 0.001 to 60");
        assert_eq!(Quantity::any(TIME).describe_usual(), "");
    }
}
