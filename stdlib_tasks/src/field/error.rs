//! Errors of the parts of the safety planner: invalid settings, and numbers that are not finite.

/// Reason why something cannot be built, or a tick cannot be planned. After an error in a tick, its decisions must not
/// be used; the state (clock, deviations) is unchanged.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SafetyError {
    /// A setting lies outside its range.
    #[error("`{name}` is {value}, and must be {must}")]
    Setting {
        /// Its name.
        name: &'static str,
        /// The given value.
        value: f64,
        /// Its requirement.
        must: &'static str,
    },
    /// A gain times the period is above one: it would overshoot within one tick.
    #[error("`{name}` times the control period is {product}, above 1: it overshoots within one tick")]
    Overshoot {
        /// The gain's name.
        name: &'static str,
        /// Gain times period.
        product: f64,
    },
    /// A list of links or segments is empty, contains one twice, or names one that the robot does not have.
    #[error("the links of the safety field are none, or repeated, or not the robot's")]
    Body,
    /// More points of people than there is storage for.
    #[error("{given} points of people, and storage for {capacity}")]
    TooManyPoints {
        /// Number of points that were passed.
        given: usize,
        /// Number of points that there is storage for.
        capacity: usize,
    },
    /// A point of a person is not finite, or so far away that its distance is not.
    #[error("point {point} of the people is not finite")]
    Human {
        /// Its index.
        point: usize,
    },
    /// Slices do not fit together.
    #[error("`{name}` has another length than the rest")]
    Shape {
        /// Name of the slice.
        name: &'static str,
    },
    /// A number that was passed in, or one that was computed from it, is not finite.
    #[error("`{name}` is not finite")]
    NotFinite {
        /// Name of the number.
        name: &'static str,
    },
}

/// Checks a setting.
pub fn setting(name: &'static str, value: f64, holds: bool, must: &'static str) -> Result<(), SafetyError> {
    if holds { Ok(()) } else { Err(SafetyError::Setting { name, value, must }) }
}

/// Checks that a gain is positive and does not overshoot within a period.
pub fn gain(name: &'static str, value: f64, period: f64) -> Result<(), SafetyError> {
    setting(name, value, value > 0.0 && value.is_finite(), "positive and finite")?;
    let product = value * period;
    if product <= 1.0 { Ok(()) } else { Err(SafetyError::Overshoot { name, product }) }
}

/// Checks that all numbers are finite.
pub fn finite(name: &'static str, values: &[f64]) -> Result<(), SafetyError> {
    if values.iter().all(|x| x.is_finite()) { Ok(()) } else { Err(SafetyError::NotFinite { name }) }
}
