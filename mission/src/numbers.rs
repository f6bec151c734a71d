//! Numbers that problems of all kinds of mission are made of: bounds, ranges of speeds, power of moving robots.

use std::fmt;

use quantities::number;
use serde::{Deserialize, Serialize};

/// The largest length (m), time (s), weight or coefficient.
pub const MAX_NUMBER: f64 = 1e6;
/// The most operations or tasks of a batch; a larger one is never faster.
pub const MAX_BATCH: usize = 512;
/// The slowest speed (m/s).
pub const MIN_SPEED: f64 = 1e-3;

/// A closed interval of speeds (m/s). A point is a fixed speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Range {
    /// Lower end, more than 0.
    pub low: f64,
    /// Upper end, not below `low`.
    pub high: f64,
}

impl Range {
    /// From `low` to `high`.
    pub fn new(low: f64, high: f64) -> Range {
        Range { low, high }
    }

    /// One fixed speed.
    pub fn point(speed: f64) -> Range {
        Range { low: speed, high: speed }
    }
}

/// `0.1 to 0.4`; a fixed speed alone.
impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.low == self.high {
            f.pad(&number(self.low))
        } else {
            f.pad(&format!("{} to {}", number(self.low), number(self.high)))
        }
    }
}

/// Power of a moving robot, thesis (5.2): `standby + friction v + drag v^2`. Only ratios between the robots and between
/// the three matter: the cost divides by the largest energy of the team.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Energy {
    /// `rho_1`, what is always drawn (W). Zero or more.
    pub standby: f64,
    /// `rho_2` (W s/m). Zero or more.
    pub friction: f64,
    /// `rho_3` (W s^2/m^2). Zero or more.
    pub drag: f64,
}

impl Energy {
    /// Coefficients for a robot of this physical factor. The numbers are ours, the thesis prints none: with factor 1 a
    /// metre takes least energy at 0.05 m/s, and a heavier robot takes more of what depends on the speed.
    pub fn of_factor(factor: f64) -> Energy {
        Energy { standby: 1.0, friction: 20.0 * factor, drag: 400.0 * factor }
    }
}

/// The power at a speed `v`.
impl fmt::Display for Energy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} + {} v + {} v^2", number(self.standby), number(self.friction), number(self.drag))
    }
}
