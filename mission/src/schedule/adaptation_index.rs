//! How well plans follow what a person asked for, thesis Algorithm 5.
//!
//! The index begins at 1. It grows when the wait or the speed of the next service moved the way the person asked, and
//! falls when it moved the other way, by `|1/f (z_i - z_{i-1}) / z_i|`.

use serde::{Deserialize, Serialize};

/// What feedback is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// A wait (s): positive feedback asks for a shorter one.
    Wait,
    /// Speed of an approach (m/s): positive feedback asks for a faster one.
    Speed,
}

/// The index after the service that followed a feedback of -1 to 1; `before` and `after` are the quantity at the service
/// that the feedback was about and at the next. Unchanged if the person asked for nothing or nothing changed. Where the
/// new wait is 0 the thesis divides by 0; we divide by the old one.
pub fn adaptation_index(index: f64, quantity: Quantity, feedback: f64, before: f64, after: f64) -> f64 {
    let change = after - before;
    if feedback == 0.0 || change == 0.0 {
        return index;
    }
    let scale = if after == 0.0 { before } else { after };
    let size = (change / scale / feedback).abs();
    let asked = match quantity {
        Quantity::Wait => -feedback,
        Quantity::Speed => feedback,
    };
    if (asked > 0.0) == (change > 0.0) { index + size } else { index - size }
}
