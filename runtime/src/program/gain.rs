//! Rule for gains: a row is held for one period.

/// Largest excess of `φ T` over one that counts as rounding.
const ROUNDING: f64 = 1e-12;

/// Returns true if a gain in 1/s overshoots within a period in s.
pub fn overshoots(gain: f64, period: f64) -> bool {
    gain * period > 1.0 + ROUNDING
}
