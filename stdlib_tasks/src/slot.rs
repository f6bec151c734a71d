//! Slots of the table of values, whose numbers may move with time.

use serde::{Deserialize, Serialize};

/// A run of numbers in the table of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Slot {
    /// Index of the first number.
    pub at: usize,
    /// Number of numbers: 1 for a scalar, 3 for a vector, 4 for a rotation as a unit quaternion `w x y z`.
    pub len: usize,
}
