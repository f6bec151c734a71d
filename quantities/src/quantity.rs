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
}

impl Quantity {
    /// Any finite value of a dimension.
    pub const fn any(dimension: Dimension) -> Self {
        Quantity { dimension, min: f64::NEG_INFINITY, min_included: true, max: f64::INFINITY, constant: false }
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
