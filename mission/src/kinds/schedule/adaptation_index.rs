//! How well plans follow what a person asked for, thesis Algorithm 5.
//!
//! The index begins at 1. It grows when the wait or the speed of the next service moved the way the person asked, and
//! falls when it moved the other way. Two things differ from the print.
//!
//! - It falls and grows by `|1/f (z - z') / max(z, z')|`, not `|1/f (z - z') / z|` with `z` the new value. A wait that shrinks
//!   from minutes to the ten seconds of the service would count thirty times as much as one that grows as far, and one that
//!   shrinks to nothing infinitely much: over the 30 runs of thesis 5.7.4 the printed index has a mean between -1.9 and 3.5
//!   and a standard deviation between 4 and 37, with feedback and without. Here a change counts `1/f` at the most.
//! - `z'` and `z` are what the plan says of the person's next service before and after it has taken in the feedback. The
//!   thesis compares the last service with the next. Most of that difference is not an answer to the feedback: waits are long
//!   after the first operations, which all end at the same time, and shorter when the team has spread out, and every
//!   duration is random. In the same runs the index of last and next has a standard deviation of 1.2 and a mean of 0.93 to
//!   1.04 without feedback, 1.05 to 1.25 with it. Without feedback the index of before and after is exactly 1.
//!
//! So measured (`examples/adaptation.rs`), waits have an index of 1.75 and speeds one of 1.3 where all feedback is answered
//! by a new plan; with a threshold of 0.1 waits have 1.31 with two people, falling to 1.1 with six, and speeds 1.2. The
//! thesis prints 3.5 falling to 2.3, of its own index, and no threshold.
//!
//! A wait that was zero before and after, because the robot is there in time, leaves the index as it is.

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

/// Changes of less than this share are rounding.
const SAME: f64 = 1e-6;

/// The index after a feedback of -1 to 1; `before` and `after` are the quantity at the person's next service in the plan
/// before and after the feedback was taken in, zero or more. Unchanged if the person asked for nothing or nothing changed.
pub fn adaptation_index(index: f64, quantity: Quantity, feedback: f64, before: f64, after: f64) -> f64 {
    let (change, scale) = (after - before, before.max(after));
    if feedback == 0.0 || change.abs() <= SAME * scale {
        return index;
    }
    let size = (change / scale / feedback).abs();
    let asked = match quantity {
        Quantity::Wait => -feedback,
        Quantity::Speed => feedback,
    };
    if (asked > 0.0) == (change > 0.0) { index + size } else { index - size }
}
