//! The rule for gains: a row is held for one period.

/// `φ T` above one by no more than this is rounding.
const ROUNDING: f64 = 1e-12;

/// Whether a gain in 1/s overshoots within a period in s.
pub fn overshoots(gain: f64, period: f64) -> bool {
    gain * period > 1.0 + ROUNDING
}
